#!/usr/bin/env python3
"""Writes even-room.pbrt: a room whose whole ceiling shines.

    python3 scenes/generate/even_room.py > scenes/even-room.pbrt

Every place sees the light and everything is diffuse: the BSDF and next event estimation are nearly perfect, so guiding can only cost.
"""
from pbrt_writer import box, checkered, define, diffuse, lamp, lathe, prologue, quad, sphere, use
from shapes import cup, room, table, teapot


def chair(x, z, turn):
    place = (x, z)
    text = box((x - 0.22, 0.42, z - 0.22), (x + 0.22, 0.46, z + 0.22), turn, place)
    text += box((x - 0.22, 0.46, z - 0.22), (x + 0.22, 0.95, z - 0.18), turn, place)
    for dx in (-0.2, 0.16):
        for dz in (-0.2, 0.16):
            text += box((x + dx, 0, z + dz), (x + dx + 0.04, 0.42, z + dz + 0.04), turn, place)
    return text


def main():
    print(prologue("even_room", 10, (320, 240), (1.2, 1.55, 3.5), (-0.1, 0.85, 0), 48), end="")
    print(checkered("squares", 2, (0.55, 0.5, 0.42), (0.44, 0.4, 0.35)))
    print(define({
        "floor": '"string type" "diffuse" "texture reflectance" "squares"',
        "plaster": diffuse(0.66, 0.64, 0.6),
        "green": diffuse(0.36, 0.47, 0.36),
        "wood": diffuse(0.42, 0.26, 0.15),
        "red": diffuse(0.52, 0.13, 0.1),
        "china": diffuse(0.72, 0.73, 0.74),
        "cloth": diffuse(0.22, 0.3, 0.48),
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((-2.2, 0, -1.8), (2.2, 2.5, 3.8), floor="floor", back="green", left="plaster", right="plaster", front="plaster"))
    print(lamp((1.15, 1.15, 1.15), quad((-2.2, 2.5, -1.8), (2.2, 2.5, -1.8), (2.2, 2.5, 3.8), (-2.2, 2.5, 3.8))))
    print(use("wood") + table((-0.9, 0, -0.45), (0.7, 0.74, 0.45), 0.04, 0.06))
    print(chair(-0.1, 0.85, 165) + chair(-0.1, -0.85, 0) + chair(1.1, 0.0, -80))
    print(use("china") + teapot((-0.2, 0.74, 0.0), 35, 1.6) + cup((0.2, 0.74, 0.18), 1.5) + cup((-0.55, 0.74, -0.2), 1.5))
    print(use("cloth") + box((-2.1, 0, -1.7), (-0.9, 0.45, -0.9)) + box((-2.1, 0.45, -1.7), (-0.9, 0.85, -1.5)))
    print(use("red") + sphere(-1.15, 0.18, 0.75, 0.18))
    print(use("wood") + box((1.2, 0, -1.8), (2.1, 1.5, -1.45)))
    print(use("red") + lathe([(0.0, 0.0), (0.07, 0.0), (0.11, 0.1), (0.08, 0.22), (0.04, 0.3), (0.06, 0.36)], (1.6, 1.5, -1.62)))


if __name__ == "__main__":
    main()
