#!/usr/bin/env python3
"""Writes corridor.pbrt: a corridor with three open doors; the lamps are around corners in the rooms behind.

    python3 scenes/generate/corridor.py > scenes/corridor.pbrt

Two rooms have a ceiling panel each (0.28 m x 0.6 m), so close to the corridor's wall and so far from the door that no line joins it to the
corridor: what the corridor gets has bounced in a room first.
"""
from pbrt_writer import box, checkered, coated, define, diffuse, lamp, lathe, metal, prologue, quad, sphere, use
from shapes import curve, pierced_wall, room

HALF, HEIGHT, END, NEAR, WALL, TOP = 0.85, 2.5, -5.0, 2.6, 0.15, 2.05


def frame(x, start, end):
    """Around a door in the wall at x, toward the corridor."""
    side = -0.025 if x > 0 else 0.025
    low, high = min(x, x + side), max(x, x + side)
    return (box((low, 0, start - 0.08), (high, TOP + 0.08, start)) + box((low, 0, end), (high, TOP + 0.08, end + 0.08))
            + box((low, TOP, start), (high, TOP + 0.08, end)))


def panel(x0, x1, z0, z1, radiance):
    y = HEIGHT - 0.01
    return lamp(radiance, quad((x0, y, z0), (x1, y, z0), (x1, y, z1), (x0, y, z1)))


def rooms():
    far = HALF + WALL
    text = use("plaster")
    # Left: two rooms (z from END to -1.9, and from -1.8 to NEAR) behind one wall with two doors; right: one room.
    text += pierced_wall((-far, 0, END), (-HALF, HEIGHT, -1.85), (-3.9, -3.0, 0, TOP))
    text += pierced_wall((-far, 0, -1.85), (-HALF, HEIGHT, NEAR), (-0.9, 0.0, 0, TOP))
    text += pierced_wall((HALF, 0, END), (far, HEIGHT, NEAR), (-2.6, -1.7, 0, TOP))
    text += room((-3.6, 0, END), (-far, HEIGHT, -1.9), floor="floor", ceiling="plaster", left="blue", back="blue", front="blue")
    text += room((-3.6, 0, -1.8), (-far, HEIGHT, NEAR), floor="floor", ceiling="plaster", left="ochre", back="ochre", front="ochre")
    text += room((far, 0, END), (3.6, HEIGHT, NEAR), floor="floor", ceiling="plaster", right="rose", back="rose", front="rose")
    text += room((-HALF, 0, END), (HALF, HEIGHT, NEAR), floor="floor", ceiling="plaster", back="plaster", front="plaster")
    # The floors of the doorways.
    text += use("floor") + quad((-far, 0.001, 0), (-HALF, 0.001, 0), (-HALF, 0.001, -0.9), (-far, 0.001, -0.9))
    text += quad((-far, 0.001, -3), (-HALF, 0.001, -3), (-HALF, 0.001, -3.9), (-far, 0.001, -3.9))
    text += quad((HALF, 0.001, -1.7), (far, 0.001, -1.7), (far, 0.001, -2.6), (HALF, 0.001, -2.6))
    text += use("wood") + frame(-HALF, -0.9, 0.0) + frame(-HALF, -3.9, -3.0) + frame(HALF, -2.6, -1.7)
    return text


def main():
    print(prologue("corridor", 20, (320, 240), (0.2, 1.45, 2.3), (-0.05, 1.05, -2), 46), end="")
    print(checkered("squares", 2.5, (0.5, 0.46, 0.4), (0.2, 0.19, 0.19)))
    print(define({
        "floor": coated(0.12, "squares"),
        "plaster": diffuse(0.74, 0.72, 0.68),
        "blue": diffuse(0.4, 0.55, 0.7),
        "ochre": diffuse(0.74, 0.66, 0.48),
        "rose": diffuse(0.74, 0.6, 0.58),
        "wood": coated(0.25, (0.36, 0.2, 0.1)),
        "glaze": coated(0.05, (0.15, 0.35, 0.3)),
        "brass": metal("CuZn", 0.2),
        "steel": metal("Al", 0.1),
        "lamp": diffuse(0, 0, 0),
    }))
    print(rooms())
    print(panel(-1.3, -1.02, 1.9, 2.5, (520, 500, 450)))
    print(panel(1.02, 1.3, 0.2, 0.8, (950, 1000, 1080)))
    print("# A bench, a vase, a lamp that is out, a picture.")
    print(use("wood") + box((0.5, 0.42, -1.3), (0.85, 0.46, -0.1)))
    print(box((0.52, 0, -1.25), (0.84, 0.42, -1.2)) + box((0.52, 0, -0.2), (0.84, 0.42, -0.15)))
    print(use("glaze") + lathe(curve([(0.0, 0.0), (0.1, 0.0), (0.19, 0.25), (0.13, 0.5), (0.07, 0.62), (0.11, 0.74)], 3), (-0.5, 0, -2.4)))
    print(use("brass") + sphere(0.66, 0.56, -0.5, 0.1) + use("steel") + sphere(0.0, 2.25, -1.5, 0.14) + box((-0.01, 2.35, -1.51), (0.01, 2.5, -1.49)))
    print(use("brass") + box((-0.35, 1.2, END), (0.35, 1.9, END + 0.03)) + use("glaze") + box((-0.3, 1.25, END), (0.3, 1.85, END + 0.035)))


if __name__ == "__main__":
    main()
