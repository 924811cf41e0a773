#!/usr/bin/env python3
"""Writes bathroom.pbrt: tiles, chrome and a mirror, lit from behind the mirror and through a high window.

    python3 scenes/generate/bathroom.py > scenes/bathroom.pbrt

A strip of light (0.9 m x 40 mm) behind the mirror shines on the wall alone; a panel (1.2 m x 0.8 m) outside of a high window shines on the ceiling.
"""
from pbrt_writer import GLASS, box, checkered, coated, define, diffuse, lamp, lathe, metal, prologue, quad, sphere, steel, use
from shapes import curve, pierced_wall, room, torus, tube

LEFT, RIGHT, BACK, FRONT, HEIGHT = -1.5, 1.5, -1.3, 2.3, 2.4


def basin():
    """A bowl on a slab, a tap over it, things beside it."""
    bowl = (curve([(0.0, 0.0), (0.12, 0.0), (0.22, 0.08), (0.25, 0.14)], 4) + [(0.235, 0.14)]
            + curve([(0.205, 0.085), (0.11, 0.02), (0.0, 0.015)], 3))
    glass = [(0.0, 0.0), (0.035, 0.0), (0.035, 0.0), (0.038, 0.1), (0.038, 0.1), (0.034, 0.1), (0.034, 0.1), (0.031, 0.008), (0.031, 0.008),
             (0.0, 0.008)]
    text = use("slab") + box((-0.75, 0.78, BACK), (0.75, 0.84, -0.78)) + use("oak") + box((-0.7, 0.3, BACK), (0.7, 0.78, -0.82))
    text += use("china") + lathe(bowl, (0.1, 0.84, -1.03), 40)
    text += use("chrome") + tube(curve([(0.1, 0.84, -1.26), (0.1, 1.1, -1.26), (0.1, 1.16, -1.2), (0.1, 1.14, -1.1), (0.1, 1.1, -1.08)], 5), 0.014)
    text += lathe([(0.0, 0.0), (0.03, 0.0), (0.03, 0.05), (0.0, 0.055)], (0.22, 0.84, -1.24), 20)
    text += use("glass") + lathe(glass, (-0.35, 0.84, -0.98), 28)
    text += use("amber") + lathe(curve([(0.0, 0.0), (0.04, 0.0), (0.045, 0.1), (0.012, 0.15), (0.012, 0.19)], 3), (-0.5, 0.84, -1.1), 24)
    return text + use("chrome") + box((-0.05, 0.55, -0.81), (0.25, 0.565, -0.79))


def bath():
    text = use("china") + box((0.85, 0, -0.6), (0.93, 0.58, 1.5)) + box((0.85, 0, -0.68), (RIGHT, 0.58, -0.6))
    text += box((0.85, 0, 1.5), (RIGHT, 0.58, 1.58))
    text += box((1.42, 0, -0.6), (RIGHT, 0.58, 1.5)) + box((0.93, 0, -0.6), (1.42, 0.15, 1.5))
    return text + use("towel") + box((0.83, 0.2, 0.3), (0.95, 0.6, 0.75))


def main():
    print(prologue("bathroom", 20, (320, 240), (-0.75, 1.5, 1.95), (0.18, 1.0, -0.7), 44), end="")
    print(checkered("mosaic", 5, (0.42, 0.52, 0.52), (0.34, 0.46, 0.48)))
    print(checkered("squares", 3, (0.55, 0.55, 0.52), (0.16, 0.17, 0.18)))
    print(define({
        "floor": coated(0.1, "squares"),
        "tiles": coated(0.06, "mosaic"),
        "plaster": diffuse(0.74, 0.73, 0.7),
        "china": coated(0.05, (0.76, 0.76, 0.74)),
        "slab": coated(0.1, (0.5, 0.46, 0.42)),
        "oak": coated(0.3, (0.42, 0.27, 0.14)),
        "amber": coated(0.1, (0.55, 0.25, 0.05)),
        "towel": diffuse(0.68, 0.36, 0.26),
        "chrome": steel(0.06, 0.66, 0.67, 0.68),
        "brass": metal("CuZn", 0.15),
        "mirror": metal("Ag", 0),
        "glass": GLASS,
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((LEFT, 0, BACK), (RIGHT, HEIGHT, FRONT), floor="floor", ceiling="plaster", back="tiles", left="plaster", front="plaster"))
    print(use("tiles") + pierced_wall((RIGHT, 0, BACK), (RIGHT + 0.15, HEIGHT, FRONT), (-0.3, 0.9, 1.65, 2.2)))
    print(lamp((55, 60, 68), quad((2.0, 1.2, -0.3), (2.0, 1.2, 0.9), (2.5, 1.9, 0.9), (2.5, 1.9, -0.3))))
    print(basin() + bath())
    print("# The mirror stands 60 mm before the wall; the strip is on its back.")
    print(use("brass") + box((-0.52, 1.18, BACK + 0.06), (0.72, 2.02, BACK + 0.07)))
    z = BACK + 0.072
    print(use("mirror") + quad((-0.5, 1.2, z), (0.7, 1.2, z), (0.7, 2.0, z), (-0.5, 2.0, z)))
    z = BACK + 0.058
    print(lamp((420, 370, 290), quad((-0.35, 1.93, z), (-0.35, 1.97, z), (0.55, 1.97, z), (0.55, 1.93, z))))
    print(use("china") + sphere(-1.15, 0.3, -0.95, 0.3) + use("brass") + torus((-0.95, 1.3, BACK + 0.02), (0, 0.1, 1), 0.1, 0.01, 32, 10))
    print(use("towel") + box((-1.48, 0.75, -0.2), (-1.42, 1.35, 0.3)) + use("chrome") + tube([(-1.44, 1.36, -0.3), (-1.44, 1.36, 0.4)], 0.012))


if __name__ == "__main__":
    main()
