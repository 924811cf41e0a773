#!/usr/bin/env python3
"""Writes lens.pbrt: a biconvex lens above a floor, near its focal length from it.

    python3 scenes/generate/lens.py > scenes/lens.pbrt

Radius of both faces 0.7 m, aperture radius 0.3 m, index 1.5: focal length about 0.7 m. The light, a ball of radius 35 mm, is 1.5 m above the lens, so
its image would lie 1.3 m below; the floor is 0.9 m below and shows a bright disc.
"""
import math

from pbrt_writer import GLASS, box, define, diffuse, lamp, lathe, metal, prologue, sphere, use
from shapes import room, torus, tube

FACE, APERTURE, HEIGHT = 0.7, 0.3, 0.9


def lens(centre, rings=14):
    """Both faces are spherical and meet at a sharp rim."""
    widest = math.asin(APERTURE / FACE)
    drop = FACE * math.cos(widest)
    angles = [widest * (1 - i / rings) for i in range(rings)]
    upper = [(FACE * math.sin(a), FACE * math.cos(a) - drop) for a in angles] + [(0.0, FACE - drop)]
    normals = [(r / FACE, (h + drop) / FACE) for r, h in upper]
    lower, below = ([(r, -h) for r, h in reversed(rows)] for rows in (upper, normals))
    # Each face is a lathe of its own, since they have different normals at the rim.
    return lathe(lower, centre, 72, below) + lathe(upper, centre, 72, normals)


def main():
    print(prologue("lens", 16, (320, 240), (0.8, 1.3, 2.2), (-0.05, 0.55, 0), 42), end="")
    print(define({
        "plaster": diffuse(0.7, 0.68, 0.64),
        "floor": diffuse(0.6, 0.58, 0.55),
        "teal": diffuse(0.12, 0.4, 0.4),
        "orange": diffuse(0.7, 0.33, 0.08),
        "glass": GLASS,
        "brass": metal("CuZn", 0.2),
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((-1.7, 0, -1.3), (1.7, 3.2, 3.0), floor="floor", ceiling="plaster", back="plaster", left="teal", right="plaster", front="plaster"))
    print(use("glass") + lens((0, HEIGHT, 0)))
    print(use("brass") + torus((0, HEIGHT, 0), (0, 1, 0), APERTURE + 0.014, 0.013))
    for k in range(3):
        angle = math.radians(30 + 120 * k)
        x, z = math.cos(angle), math.sin(angle)
        print(tube([(0.325 * x, HEIGHT, 0.325 * z), (0.5 * x, 0, 0.5 * z)], 0.012))
    print(lamp((1150, 1060, 920), sphere(0, HEIGHT + 1.5, 0, 0.035)))
    print(use("orange") + box((-1.0, 0, -0.9), (-0.55, 0.45, -0.45), 33, (-0.78, -0.68)))
    print(use("plaster") + sphere(0.95, 0.25, -0.65, 0.25))


if __name__ == "__main__":
    main()
