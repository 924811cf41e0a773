#!/usr/bin/env python3
"""Writes torus-in-glass.pbrt: a diffuse torus inside of a block of glass, lit through the glass by a small strong light.

    python3 scenes/generate/torus_in_glass.py > scenes/torus-in-glass.pbrt

The block is 1 m wide; the light is a ball of radius 25 mm. Next event estimation never meets it from inside of the block; what arrives there
comes from a few narrow directions (the light through each face, and its reflections inside), so that directional trees become deep and
concentrated.
"""
from pbrt_writer import GLASS, box, define, diffuse, lamp, prologue, sphere, use
from shapes import room, torus


def main():
    print(prologue("torus_in_glass", 32, (320, 240), (0.75, 1.15, 2.5), (0, 0.5, 0), 30), end="")
    print(define({
        "plaster": diffuse(0.4, 0.5, 0.62),
        "floor": diffuse(0.56, 0.5, 0.44),
        "torus": diffuse(0.72, 0.3, 0.1),
        "glass": GLASS,
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((-2.2, 0, -1.6), (2.2, 2.8, 3.2), floor="floor", ceiling="plaster", back="plaster", left="plaster", right="plaster", front="plaster"))
    print(use("torus") + torus((0, 0.52, 0), (0.35, 0.8, 0.5), 0.27, 0.1, 56, 28))
    print(use("glass") + box((-0.5, 0.02, -0.5), (0.5, 1.02, 0.5), 20))
    print(lamp((4000, 3800, 3400), sphere(0.9, 2.1, 0.9, 0.025)))


if __name__ == "__main__":
    main()
