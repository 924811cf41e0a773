#!/usr/bin/env python3
"""Writes ring-caustic.pbrt: a golden ring on a table top, and the caustic inside it.

    python3 scenes/generate/ring_caustic.py > scenes/ring-caustic.pbrt

The ring (radius 0.32 m inside) is a conductor of alpha 0.02; the light is a ball of radius 40 mm, 1.6 m away.
"""
from pbrt_writer import define, diffuse, lamp, lathe, metal, prologue, sphere, use
from shapes import room

INSIDE, OUTSIDE, HEIGHT, ROUND = 0.32, 0.35, 0.2, 0.008


def ring():
    """From the bottom up along the outside, over the edge and down again; the edges are rounded."""
    outer = [(OUTSIDE - ROUND, 0), (OUTSIDE - 0.3 * ROUND, 0.3 * ROUND), (OUTSIDE, ROUND), (OUTSIDE, ROUND), (OUTSIDE, HEIGHT - ROUND),
             (OUTSIDE, HEIGHT - ROUND), (OUTSIDE - 0.3 * ROUND, HEIGHT - 0.3 * ROUND), (OUTSIDE - ROUND, HEIGHT)]
    inner = [(INSIDE + ROUND, HEIGHT), (INSIDE + 0.3 * ROUND, HEIGHT - 0.3 * ROUND), (INSIDE, HEIGHT - ROUND), (INSIDE, HEIGHT - ROUND), (INSIDE, 0)]
    return lathe(outer + inner, (0, 0, 0), 128)


def main():
    print(prologue("ring_caustic", 12, (320, 240), (0.15, 1.02, 1.18), (0.0, 0.04, 0.03), 38), end="")
    print(define({
        "table": diffuse(0.62, 0.56, 0.48),
        "screen": diffuse(0.55, 0.5, 0.46),
        "gold": metal("Au", 0.02),
        "copper": metal("Cu", 0.15),
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((-1.6, 0, -1.6), (1.6, 2.2, 1.6), floor="table", back="screen", left="screen", right="screen", ceiling="screen", front="screen"))
    print(use("gold") + ring())
    print(use("copper") + sphere(0.52, 0.09, -0.3, 0.09))
    print(lamp((600, 550, 470), sphere(0.95, 1.0, -0.75, 0.04)))


if __name__ == "__main__":
    main()
