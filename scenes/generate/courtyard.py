#!/usr/bin/env python3
"""Writes courtyard.pbrt: an open courtyard under a clear sky.

    python3 scenes/generate/courtyard.py > scenes/courtyard.pbrt

Everything is diffuse and sees the sky: a scene in which guiding should gain nothing, and must lose little.
"""
import math

from pbrt_writer import box, checkered, define, diffuse, lathe, prologue, quad, sphere, use


def arcade():
    """Pillars and a lintel in front of the back wall, under a roof."""
    text = use("stone")
    for i in range(7):
        x = -3.9 + 1.3 * i
        text += box((x - 0.2, 0, -2.85), (x + 0.2, 0.15, -2.45))
        text += lathe([(0.15, 0.15), (0.13, 0.3), (0.12, 2.0), (0.12, 2.0), (0.19, 2.15)], (x, 0, -2.65), 16)
        text += box((x - 0.2, 2.15, -2.85), (x + 0.2, 2.25, -2.45))
    return text + box((-5, 2.25, -2.9), (5, 2.6, -2.4)) + use("tile") + quad((-5, 2.6, -2.2), (5, 2.6, -2.2), (5, 3.3, -4), (-5, 3.3, -4))


def walls():
    text = use("paving") + quad((-5, 0, 5), (5, 0, 5), (5, 0, -4), (-5, 0, -4), [(0, 0), (10, 0), (10, 9), (0, 9)])
    text += use("ochre") + box((-5.3, 0, -4.2), (5.3, 3.3, -4)) + box((-5.3, 0, -4), (-5, 3.3, 5)) + box((5, 0, -4), (5.3, 3.3, 5))
    text += use("door") + box((-0.5, 0, -4), (0.5, 2.1, -3.93))
    text += use("shutter")
    for z in (-2, 0.2, 2.4):
        text += box((-5, 1.2, z - 0.45), (-4.94, 2.4, z + 0.45)) + box((4.94, 1.2, z - 0.45), (5, 2.4, z + 0.45))
    return text


def main():
    print(prologue("courtyard", 8, (400, 225), (1.6, 2.3, 6.6), (0, 1.05, -1), 36), end="")
    print('LightSource "infinite" "rgb L" [ 0.42 0.58 0.86 ]')
    print('LightSource "distant" "rgb L" [ 1.9 1.7 1.35 ] "point3 from" [ -4 6 5 ] "point3 to" [ 0 0 0 ]\n')
    print(checkered("slabs", 2, (0.5, 0.46, 0.4), (0.42, 0.39, 0.35)))
    print(define({
        "paving": '"string type" "diffuse" "texture reflectance" "slabs"',
        "ochre": diffuse(0.66, 0.46, 0.25),
        "stone": diffuse(0.6, 0.56, 0.5),
        "tile": diffuse(0.5, 0.2, 0.12),
        "door": diffuse(0.16, 0.24, 0.3),
        "shutter": diffuse(0.18, 0.32, 0.25),
        "leaf": diffuse(0.16, 0.3, 0.08),
        "bark": diffuse(0.25, 0.17, 0.11),
        "water": diffuse(0.1, 0.2, 0.24),
    }))
    print(walls() + arcade())
    # A basin with a rim to sit on, and water in it.
    print(use("stone") + lathe([(0.9, 0), (0.9, 0.45), (0.9, 0.45), (0.7, 0.45), (0.7, 0.45), (0.7, 0.3)], (0, 0, 0.4), 48))
    print(lathe([(0.12, 0.3), (0.08, 0.8), (0.25, 0.95), (0.27, 1.0), (0.2, 0.97), (0.0, 0.94)], (0, 0, 0.4), 24))
    print(use("water") + lathe([(0.7, 0.3), (0.0, 0.3)], (0, 0, 0.4), 48))
    for x, z, turn in ((-3.6, 1.6, 10), (3.6, 0.4, 35)):
        print(use("tile") + box((x - 0.35, 0, z - 0.35), (x + 0.35, 0.55, z + 0.35), turn, (x, z)))
        print(use("bark") + lathe([(0.06, 0.5), (0.045, 1.6)], (x, 0, z), 12) + use("leaf"))
        print(sphere(x, 1.95, z, 0.5))
        for k in range(7):
            angle = 2 * math.pi * k / 7
            print(sphere(x + 0.4 * math.cos(angle), 1.95 + 0.25 * math.sin(3 * angle), z + 0.4 * math.sin(angle), 0.3), end="")
    for x in (-1.9, 2.1):
        print(use("stone") + lathe([(0.0, 0), (0.2, 0), (0.3, 0.3), (0.28, 0.55), (0.34, 0.6), (0.0, 0.58)], (x, 0, -1.9), 24) + use("leaf")
              + sphere(x, 0.85, -1.9, 0.33))


if __name__ == "__main__":
    main()
