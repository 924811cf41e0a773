#!/usr/bin/env python3
"""Writes emissive-panel.pbrt: a box lit by one small glowing square, above the picture's upper edge.

    python3 scenes/generate/emissive_panel.py [SIDE] > scenes/emissive-panel.pbrt

For runs without next event estimation. SIDE, in metres, is another size of the square, of the same power.
"""
import sys

from pbrt_writer import box, define, diffuse, lamp, prologue, quad, use
from shapes import room

SIDE = 0.15
HEIGHT = 1.96  # 40 mm below the ceiling


def main(side=SIDE):
    print(prologue("emissive_panel", 5, (300, 300), (0, 0.86, 3.75), (0, 0.86, 0), 31), end="")
    print(define({
        "white": diffuse(0.73, 0.71, 0.68),
        "red": diffuse(0.63, 0.07, 0.05),
        "green": diffuse(0.14, 0.45, 0.09),
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((-1, 0, -1), (1, 2, 1), floor="white", ceiling="white", back="white", left="red", right="green"))
    print(use("white") + box((-0.68, 0, -0.62), (-0.08, 1.2, -0.02), 17, (-0.38, -0.32)))
    print(box((0.08, 0, 0.0), (0.66, 0.6, 0.58), -18, (0.37, 0.29)))
    half = side / 2
    radiance = [round(c / side**2, 2) for c in (6.0, 5.4, 4.5)]
    print(lamp(radiance, quad((-half, HEIGHT, -half), (half, HEIGHT, -half), (half, HEIGHT, half), (-half, HEIGHT, half))))


if __name__ == "__main__":
    main(*(float(side) for side in sys.argv[1:2]))
