#!/usr/bin/env python3
"""Writes emissive-panel.pbrt: a box lit by one small glowing square, above the picture's upper edge.

    python3 scenes/generate/emissive_panel.py [SIDE] > scenes/emissive-panel.pbrt

For runs without next event estimation. SIDE, in metres, is another size of the square, of the same power.
"""
import sys

from pbrt_writer import lamp, prologue, quad
from shapes import box_to_glow_in

SIDE = 0.15
HEIGHT = 1.96  # 40 mm below the ceiling


def main(side=SIDE):
    print(prologue("emissive_panel", 5, (300, 300), (0, 0.86, 3.75), (0, 0.86, 0), 31), end="")
    print(box_to_glow_in())
    half = side / 2
    radiance = [round(c / side**2, 2) for c in (6.0, 5.4, 4.5)]
    print(lamp(radiance, quad((-half, HEIGHT, -half), (half, HEIGHT, -half), (half, HEIGHT, half), (-half, HEIGHT, half))))


if __name__ == "__main__":
    main(*(float(side) for side in sys.argv[1:2]))
