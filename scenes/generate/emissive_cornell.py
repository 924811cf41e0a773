#!/usr/bin/env python3
"""Writes emissive-cornell.pbrt: a box lit by five little glowing balls.

    python3 scenes/generate/emissive_cornell.py > scenes/emissive-cornell.pbrt

For runs without next event estimation: the balls are then found by BSDF sampling alone, about once in a thousand directions each.
"""
from pbrt_writer import lamp, prologue, sphere
from shapes import box_to_glow_in

BALLS = [  # place, radius, radiance
    ((-0.62, 1.62, -0.55), 0.045, (80, 52, 24)),
    ((0.55, 1.1, -0.7), 0.04, (60, 52, 44)),
    ((0.05, 0.35, 0.62), 0.03, (28, 56, 84)),
    ((-0.72, 0.5, 0.35), 0.03, (96, 40, 24)),
    ((0.72, 1.7, 0.3), 0.04, (56, 52, 48)),
]


def main():
    print(prologue("emissive_cornell", 12, (300, 300), (0, 1, 3.75), (0, 1, 0), 39), end="")
    print(box_to_glow_in())
    for place, radius, radiance in BALLS:
        print(lamp(radiance, sphere(*place, radius)))


if __name__ == "__main__":
    main()
