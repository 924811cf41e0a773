#!/usr/bin/env python3
"""Writes kitchen.pbrt: a kitchen in the morning, lit by a low sun through the slats of a blind.

    python3 scenes/generate/kitchen.py > scenes/kitchen.pbrt

The window (1.5 m x 1.1 m) is in the right wall. The sun is a disc of radius 0.15 m, 8 m away; a panel behind it is the sky. The sun comes in
as stripes on worktop, cupboards and floor, and these stripes light the rest.
"""
from pbrt_writer import box, checkered, coated, define, diffuse, instance, lamp, lathe, metal, named_object, prologue, quad, sphere, steel, use
from shapes import cup, curve, disc, pierced_wall, room, teapot, tube

LEFT, RIGHT, BACK, FRONT, HEIGHT = -2.0, 1.7, -1.7, 2.6, 2.5
WINDOW = (-1.0, 0.5, 1.0, 2.1)  # z from and to, bottom and top


def blind():
    """Level slats of 60 mm, 55 mm apart, and the rods that hold them."""
    text, x = "", RIGHT - 0.05
    start, end, bottom, top = WINDOW
    for i in range(int((top - bottom) / 0.055)):
        y = top - 0.03 - 0.055 * i
        text += quad((x - 0.03, y, start - 0.03), (x - 0.03, y, end + 0.03), (x + 0.03, y, end + 0.03), (x + 0.03, y, start - 0.03))
    for z in (start + 0.2, end - 0.2):
        text += tube([(x, bottom - 0.05, z), (x, top + 0.05, z)], 0.003, 6)
    return text + box((x - 0.035, top, start - 0.05), (x + 0.035, top + 0.06, end + 0.05))


def cupboards():
    """Along the back wall and under the window: bases with doors and knobs, a worktop of stone, cupboards above."""
    text = use("paint") + box((LEFT, 0.1, BACK), (RIGHT, 0.86, -1.1)) + box((1.1, 0.1, -1.1), (RIGHT, 0.86, 1.2))
    text += use("stone") + box((LEFT, 0.86, BACK), (RIGHT, 0.9, -1.07)) + box((1.07, 0.86, -1.07), (RIGHT, 0.9, 1.23))
    text += use("paint") + box((LEFT, 1.5, BACK), (-0.75, 2.25, -1.35)) + box((0.35, 1.5, BACK), (RIGHT, 2.25, -1.35))
    for i in range(6):
        x = LEFT + 0.02 + 0.52 * i
        text += use("paint") + box((x, 0.12, -1.1), (x + 0.5, 0.84, -1.08)) + use("brass") + sphere(x + 0.44, 0.7, -1.06, 0.018)
    for x in (-1.98, -1.36, 0.37, 1.04):
        text += use("paint") + box((x, 1.52, -1.35), (x + 0.59, 2.23, -1.33)) + use("brass") + sphere(x + 0.53, 1.6, -1.315, 0.016)
    return text


def main():
    print(prologue("kitchen", 16, (320, 180), (-0.75, 1.5, 2.35), (0.12, 0.98, -0.8), 44), end="")
    print(checkered("squares", 2, (0.5, 0.42, 0.32), (0.26, 0.17, 0.12)))
    print(checkered("tiles", 6, (0.62, 0.66, 0.66), (0.5, 0.58, 0.6)))
    print(define({
        "floor": coated(0.2, "squares"),
        "tiles": coated(0.1, "tiles"),
        "plaster": diffuse(0.72, 0.69, 0.62),
        "paint": coated(0.3, (0.5, 0.6, 0.54)),
        "stone": coated(0.08, (0.12, 0.12, 0.13)),
        "blind": diffuse(0.6, 0.55, 0.45),
        "china": coated(0.05, (0.74, 0.72, 0.66)),
        "fruit": coated(0.15, (0.62, 0.2, 0.06)),
        "brass": metal("CuZn", 0.2),
        "copper": metal("Cu", 0.12),
        "steel": steel(0.2, 0.62, 0.62, 0.6),
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((LEFT, 0, BACK), (RIGHT, HEIGHT, FRONT), floor="floor", ceiling="plaster", back="tiles", left="plaster", front="plaster"))
    print(use("plaster") + pierced_wall((RIGHT, 0, BACK), (RIGHT + 0.2, HEIGHT, FRONT), WINDOW) + use("blind") + blind())
    print(cupboards())
    print("# Sun and sky.")
    print(lamp((64000, 55000, 42000), disc((8.6, 4.6, 2.2), (-7.3, -3.5, -2.6), 0.15)))
    print(lamp((3, 3.7, 4.8), quad((9.5, -1, -8), (9.5, -1, 8), (9.5, 9, 8), (9.5, 9, -8))))
    print(use("steel") + box((-0.62, 0.02, -1.68), (0.22, 0.905, -1.06)))
    print(box((-0.62, 1.75, BACK), (0.22, 1.95, -1.25)) + box((-0.35, 1.95, BACK), (-0.05, HEIGHT, -1.45)))
    print(use("copper") + teapot((-0.4, 0.905, -1.38), 30, 1.4))
    print(use("steel") + lathe([(0.0, 0.0), (0.1, 0.0), (0.11, 0.02), (0.11, 0.13), (0.115, 0.135), (0.0, 0.15)], (0.02, 0.905, -1.4)))
    print(named_object("cup", use("china") + cup((0, 0, 0))))
    for x, z in ((0.55, -1.35), (0.72, -1.45), (0.68, -1.25)):
        print(instance("cup", x, 0.9, z, 1.5), end="")
    print(use("china") + lathe(curve([(0.0, 0.0), (0.07, 0.0), (0.16, 0.07), (0.19, 0.1)], 3) + [(0.18, 0.1), (0.0, 0.015)], (1.35, 0.9, 0.1)))
    for x, y, z in ((1.3, 0.97, 0.06), (1.4, 0.97, 0.08), (1.35, 0.97, 0.18), (1.36, 1.04, 0.1)):
        print(use("fruit") + sphere(x, y, z, 0.05), end="")
    print(use("china") + lathe(curve([(0.0, 0.0), (0.05, 0.0), (0.08, 0.1), (0.05, 0.2), (0.06, 0.26)], 3), (-1.2, 0.9, -1.4)))


if __name__ == "__main__":
    main()
