#!/usr/bin/env python3
"""Writes glossy-interior.pbrt: tea for two between polished surfaces, lit through one window.

    python3 scenes/generate/glossy_interior.py > scenes/glossy-interior.pbrt

The window (1.4 m x 1.1 m) is in the left wall, with a bright panel outside. Metals of alpha 0.08 to 0.3 and lacquers of 0.05 to 0.2 fill most
of the picture.
"""
from pbrt_writer import (box, checkered, coated, define, diffuse, instance, lamp, lathe, metal, named_object, prologue, quad, sphere, steel,
                         use)
from shapes import cup, curve, pierced_wall, room, table, teapot, torus, tube

TOP = 0.76


def pot():
    """Of radius 1; hangs by its handle from the origin."""
    body = [(0.0, -2.2), (0.75, -2.2), (0.95, -2.1), (1, -1.9), (1, -1.2), (1, -1.2), (0.93, -1.2), (0.93, -2.1)]
    return lathe(body, (0, 0, 0)) + torus((0, -0.75, 0), (1, 0, 0), 0.75, 0.05, 24, 8)


def main():
    print(prologue("glossy_interior", 16, (320, 180), (0.62, 1.42, 1.75), (-0.08, 0.9, -0.45), 36), end="")
    print(checkered("squares", 2.5, (0.5, 0.48, 0.44), (0.12, 0.13, 0.15)))
    print(define({
        "floor": coated(0.15, "squares"),
        "plaster": diffuse(0.7, 0.66, 0.58),
        "wall": coated(0.2, (0.22, 0.42, 0.45)),
        "lacquer": coated(0.08, (0.24, 0.1, 0.05)),
        "china": coated(0.05, (0.72, 0.72, 0.68)),
        "glaze": coated(0.05, (0.1, 0.2, 0.5)),
        "silver": metal("Ag", 0.08),
        "copper": metal("Cu", 0.15),
        "brass": metal("CuZn", 0.2),
        "steel": steel(0.3, 0.62, 0.62, 0.6),
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((-1.9, 0, -1.5), (1.9, 2.5, 2.6), floor="floor", ceiling="plaster", back="wall", right="plaster", front="plaster"))
    print(use("plaster") + pierced_wall((-2.1, 0, -1.5), (-1.9, 2.5, 2.6), (-0.9, 0.5, 1.0, 2.1)))
    print(lamp((12, 13, 14.5), quad((-3, 0, 2), (-3, 0, -2.5), (-3, 3, -2.5), (-3, 3, 2))))
    print(use("lacquer") + table((-0.85, 0, -0.75), (0.75, TOP, 0.25), 0.04, 0.06))
    print(use("brass") + lathe([(0.0, 0.006), (0.3, 0.006), (0.33, 0.03), (0.325, 0.03), (0.295, 0.012), (0.0, 0.012)], (-0.1, TOP, -0.3)))
    print(use("silver") + teapot((-0.12, TOP + 0.012, -0.33), 205, 1.75))
    print(named_object("cup", use("china") + cup((0, 0, 0))) + instance("cup", 0.28, TOP, -0.02, 1.5) + instance("cup", -0.48, TOP, -0.05, 1.5))
    print(use("china") + lathe([(0.0, 0.0), (0.05, 0.0), (0.1, 0.012), (0.098, 0.016), (0.0, 0.004)], (0.5, TOP, -0.4)))
    print(use("glaze") + lathe(curve([(0.0, 0.0), (0.06, 0.0), (0.1, 0.12), (0.07, 0.25), (0.035, 0.32), (0.05, 0.38)], 3), (0.5, TOP, -0.58)))
    print(use("copper") + sphere(-0.62, TOP + 0.07, -0.5, 0.07))
    print("# Cupboards, a steel worktop and a rail of pots along the back wall.")
    print(use("lacquer") + box((-1.9, 0, -1.5), (1.2, 0.86, -0.98)))
    print(use("steel") + box((-1.9, 0.86, -1.5), (1.22, 0.9, -0.95)) + box((-1.9, 0.9, -1.5), (1.2, 1.32, -1.49)))
    print(use("brass") + tube([(-1.5, 1.86, -1.3), (1.1, 1.86, -1.3)], 0.012))
    print(named_object("pot", use("copper") + pot()))
    for x, size in ((-0.8, 0.14), (-0.32, 0.12), (0.1, 0.1), (0.75, 0.16)):
        print(instance("pot", x, 1.86, -1.3, size, 12), end="")
    for x, size in ((-0.95, 2), (0.35, 2.2), (0.9, 2.6)):
        print(instance("cup", x, 0.9, -1.22, size), end="")


if __name__ == "__main__":
    main()
