#!/usr/bin/env python3
"""Writes flashlight.pbrt: a flashlight that stands on the floor and lights the ceiling.

    python3 scenes/generate/flashlight.py > scenes/flashlight.pbrt

The lit disc (radius 40 mm) lies 150 mm deep in a black tube (inner radius 45 mm, 200 mm long), so nothing but the spot on the ceiling sees it:
all other light is indirect, and comes from that spot.
"""
from pbrt_writer import box, define, diffuse, lamp, lathe, metal, prologue, sphere, use
from shapes import disc, room, table, torus

TORCH = (-0.35, 0.0, -0.1)


def main():
    print(prologue("flashlight", 12, (320, 240), (0.35, 1.25, 2.9), (0.02, 0.98, 0), 49), end="")
    print(define({
        "plaster": diffuse(0.74, 0.71, 0.66),
        "blue": diffuse(0.2, 0.33, 0.55),
        "wood": diffuse(0.48, 0.31, 0.18),
        "tomato": diffuse(0.62, 0.14, 0.09),
        "black": diffuse(0.03, 0.03, 0.03),
        "brass": metal("CuZn", 0.25),
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((-1.6, 0, -1.4), (1.6, 2.1, 3.2), floor="wood", ceiling="plaster", back="plaster", left="blue", right="plaster", front="plaster"))
    x, y, z = TORCH
    print(use("black") + lathe([(0.055, 0), (0.055, 0.2), (0.055, 0.2), (0.045, 0.2), (0.045, 0.2), (0.045, 0.04)], TORCH))
    print(use("brass") + torus((x, y + 0.19, z), (0, 1, 0), 0.056, 0.008))
    print(lamp((17000, 15300, 12800), disc((x, y + 0.05, z), (0, 1, 0), 0.04)))
    print(use("tomato") + sphere(0.35, 0.22, 0.35, 0.22))
    print(use("plaster") + table((-1.35, 0, -1.2), (-0.7, 0.5, -0.6), 0.05, 0.06))
    print(use("blue") + box((0.75, 0, -1.0), (1.25, 0.9, -0.5), 25, (1.0, -0.75)))
    print(use("tomato") + lathe([(0.0, 0.0), (0.06, 0.0), (0.12, 0.1), (0.1, 0.22), (0.04, 0.32), (0.05, 0.4)], (-1.05, 0.5, -0.9)))


if __name__ == "__main__":
    main()
