#!/usr/bin/env python3
"""Writes emissive-cornell.pbrt: a box lit by five little glowing balls.

    python3 scenes/generate/emissive_cornell.py > scenes/emissive-cornell.pbrt

For runs without next event estimation: the balls are then found by BSDF sampling alone, about once in a thousand directions each.
"""
from pbrt_writer import box, define, diffuse, lamp, prologue, sphere, use
from shapes import room

BALLS = [  # place, radius, radiance
    ((-0.62, 1.62, -0.55), 0.045, (80, 52, 24)),
    ((0.55, 1.1, -0.7), 0.04, (60, 52, 44)),
    ((0.05, 0.35, 0.62), 0.03, (28, 56, 84)),
    ((-0.72, 0.5, 0.35), 0.03, (96, 40, 24)),
    ((0.72, 1.7, 0.3), 0.04, (56, 52, 48)),
]


def main():
    print(prologue("emissive_cornell", 12, (300, 300), (0, 1, 3.75), (0, 1, 0), 39), end="")
    print(define({
        "white": diffuse(0.73, 0.71, 0.68),
        "red": diffuse(0.63, 0.07, 0.05),
        "green": diffuse(0.14, 0.45, 0.09),
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((-1, 0, -1), (1, 2, 1), floor="white", ceiling="white", back="white", left="red", right="green"))
    print(use("white") + box((-0.68, 0, -0.62), (-0.08, 1.2, -0.02), 17, (-0.38, -0.32)))
    print(box((0.08, 0, 0.0), (0.66, 0.6, 0.58), -18, (0.37, 0.29)))
    for place, radius, radiance in BALLS:
        print(lamp(radiance, sphere(*place, radius)))


if __name__ == "__main__":
    main()
