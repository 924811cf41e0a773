#!/usr/bin/env python3
"""Writes camera-obscura.pbrt: a dark room with a pinhole, and the picture that it throws on the wall.

    python3 scenes/generate/camera_obscura.py > scenes/camera-obscura.pbrt

The wall z = 0 has a round hole of radius 10 mm at (0, 0.9, 0). The dark room (z > 0) is 2.2 m deep; the camera stands in it beside the hole
and sees the wall opposite, where a rabbit outside (2 m before the hole) appears upside down. The outer room's lamps hang on the hole's own
wall, so the hole does not see them. A direction from the picture, drawn by the cosine, meets the hole twice in 100 000 tries.
"""
import math

from implicit import rabbit
from pbrt_writer import box, define, diffuse, lamp, mesh, prologue, quad, sphere, use
from shapes import room, turned

PINHOLE = 0.01
CENTRE = (0, 0.9)
WIDE, TALL, DEEP = 1.3, 1.8, 2.2  # half of the width, height and depth of the dark room
SIDES = 32


def wall():
    """The wall between the rooms: a rectangle around a hole of SIDES corners."""
    turns = [2 * math.pi * k / SIDES for k in range(SIDES)]
    ring = [(CENTRE[0] + PINHOLE * math.cos(t), CENTRE[1] + PINHOLE * math.sin(t), 0) for t in turns]
    corners = [(2.2, 2.6, 0), (-2.2, 2.6, 0), (-2.2, 0, 0), (2.2, 0, 0)]
    triangles = []
    for k in range(SIDES):
        # Each quarter of the ring fans to the corner nearest to it.
        corner, following = (k * 4) // SIDES, ((k + 1) * 4) // SIDES % 4
        triangles.append((k, SIDES + corner, (k + 1) % SIDES))
        if following != corner:
            triangles.append(((k + 1) % SIDES, SIDES + corner, SIDES + following))
    return mesh(ring + corners, triangles)


def main():
    print(prologue("camera_obscura", 8, (320, 240), (0.02, 0.9, 0.12), (0, 0.9, 2), 46), end="")
    print(define({
        "dark": diffuse(0.25, 0.24, 0.23),
        "screen": diffuse(0.8, 0.8, 0.8),
        "sky": diffuse(0.3, 0.45, 0.7),
        "grass": diffuse(0.28, 0.5, 0.16),
        "wall": diffuse(0.5, 0.5, 0.5),
        "rabbit": diffuse(0.75, 0.55, 0.38),
        "carrot": diffuse(0.8, 0.32, 0.06),
        "ball": diffuse(0.7, 0.12, 0.1),
        "lamp": diffuse(0, 0, 0),
    }))
    print("# The dark room, and the wall with the hole that both rooms share.")
    print(room((-WIDE, 0, 0), (WIDE, TALL, DEEP), floor="dark", ceiling="dark", left="dark", right="dark", front="screen"))
    print(use("dark") + wall())
    print("# Outside.")
    print(room((-2.2, 0, -4), (2.2, 2.6, 0), floor="grass", ceiling="wall", left="sky", right="sky", back="sky"))
    print(use("rabbit") + rabbit(lambda p: turned(p, (0.05, 0.15, -2.1), -130, 1.1)))
    print(use("wall") + box((-0.7, 0, -2.7), (0.8, 0.15, -1.6)))
    print(use("carrot") + box((-1.25, 0, -2.6), (-0.85, 0.6, -2.2), 30, (-1.05, -2.4)) + use("ball") + sphere(0.95, 0.3, -2.2, 0.3))
    print(lamp((1300000, 1230000, 1080000), quad((-2.0, 1.0, -0.02), (-2.0, 2.4, -0.02), (-1.2, 2.4, -0.02), (-1.2, 1.0, -0.02))))
    print(lamp((200000, 240000, 310000), quad((1.2, 0.4, -0.02), (1.2, 2.0, -0.02), (2.0, 2.0, -0.02), (2.0, 0.4, -0.02))))


if __name__ == "__main__":
    main()
