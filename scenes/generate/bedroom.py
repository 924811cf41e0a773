#!/usr/bin/env python3
"""Writes bedroom.pbrt: a bedroom at night, lit by one lamp whose bulb is behind its shade.

    python3 scenes/generate/bedroom.py > scenes/bedroom.pbrt

The bulb is a ball of radius 30 mm. The shade lets about a third of the light through, scattered; the bulb itself is seen only through the
openings above and below. Next event estimation to the bulb is blocked nearly everywhere; the glowing shade and the spots on wall and ceiling
light the room.
"""
from pbrt_writer import box, checkered, coated, define, diffuse, lamp, lathe, metal, prologue, quad, sphere, use
from shapes import curve, room, tube

LAMP = (0.98, 0.5, -1.2)


def bed():
    text = use("walnut") + box((-0.85, 0.0, -1.5), (0.7, 1.0, -1.42)) + box((-0.82, 0.12, -1.42), (0.67, 0.32, 0.62))
    text += box((-0.85, 0, 0.6), (0.7, 0.5, 0.66))
    text += use("linen") + box((-0.78, 0.32, -1.42), (0.63, 0.5, 0.58))
    # The blanket hangs over both sides in a rounded edge.
    for edge in (-0.8, 0.65):
        text += use("blanket") + tube([(edge, 0.49, -0.75), (edge, 0.49, 0.58)], 0.045, 16)
        text += box((edge - 0.045, 0.25, -0.75), (edge + 0.045, 0.49, 0.58))
    text += box((-0.8, 0.49, -0.75), (0.65, 0.535, 0.58))
    text += use("linen")
    for x in (-0.43, 0.28):
        text += lathe(curve([(0.0, 0.0), (0.2, 0.0), (0.3, 0.07), (0.2, 0.13), (0.0, 0.15)], 3), (x, 0.49, -1.1))
    return text


def bedside():
    x, y, z = LAMP
    text = use("walnut") + box((x - 0.24, 0.1, z - 0.22), (x + 0.24, y, z + 0.22)) + box((x - 0.22, 0.28, z + 0.22), (x + 0.22, 0.46, z + 0.235))
    text += use("brass") + sphere(x, 0.37, z + 0.25, 0.018)
    text += lathe([(0.0, 0.0), (0.085, 0.0), (0.085, 0.012), (0.03, 0.03), (0.012, 0.06), (0.02, 0.12), (0.012, 0.18), (0.01, 0.24)], LAMP)
    text += use("shade") + lathe([(0.17, 0.22), (0.11, 0.46)], LAMP, 48)
    text += lamp((1900, 1530, 1060), sphere(x, y + 0.31, z, 0.03))
    text += use("book") + box((x - 0.2, y, z + 0.06), (x - 0.06, y + 0.035, z + 0.2), 12, (x - 0.13, z + 0.13))
    return text


def main():
    print(prologue("bedroom", 16, (320, 180), (-1.15, 1.45, 2.25), (0.22, 0.68, -0.75), 42), end="")
    print(checkered("boards", 4, (0.36, 0.22, 0.12), (0.3, 0.18, 0.1)))
    print(define({
        "floor": coated(0.15, "boards"),
        "wall": diffuse(0.62, 0.62, 0.6),
        "ceiling": diffuse(0.75, 0.73, 0.7),
        "linen": diffuse(0.76, 0.74, 0.72),
        "blanket": diffuse(0.2, 0.28, 0.45),
        "rug": diffuse(0.5, 0.16, 0.14),
        "walnut": coated(0.12, (0.26, 0.14, 0.08)),
        "lacquer": coated(0.05, (0.5, 0.47, 0.42)),
        "book": diffuse(0.5, 0.12, 0.1),
        "picture": coated(0.05, (0.25, 0.38, 0.42)),
        "shade": '"string type" "diffusetransmission" "rgb reflectance" [ 0.5 0.47 0.42 ] "rgb transmittance" [ 0.36 0.32 0.25 ]',
        "brass": metal("CuZn", 0.15),
        "gold": metal("Au", 0.3),
        "mirror": metal("Ag", 0),
        "lamp": diffuse(0, 0, 0),
    }))
    print(room((-1.9, 0, -1.52), (1.7, 2.4, 2.6), floor="floor", ceiling="ceiling", back="wall", left="wall", right="wall", front="wall"))
    print(use("rug") + box((-0.9, 0.0, 0.8), (1.2, 0.012, 1.7)) + bed() + bedside())
    print("# A wardrobe with a mirror in its door, a chest, pictures.")
    print(use("lacquer") + box((1.15, 0.05, -0.75), (1.7, 2.0, 0.45)))
    print(use("mirror") + quad((1.145, 0.3, -0.6), (1.145, 0.3, -0.2), (1.145, 1.8, -0.2), (1.145, 1.8, -0.6)))
    print(use("brass") + sphere(1.12, 1.0, -0.1, 0.025))
    print(use("walnut") + box((-1.88, 0.05, -1.5), (-1.1, 0.8, -1.0)))
    print(use("brass") + sphere(-1.49, 0.6, -0.985, 0.02) + sphere(-1.49, 0.3, -0.985, 0.02))
    print(use("gold") + lathe(curve([(0.0, 0.0), (0.06, 0.0), (0.09, 0.1), (0.03, 0.22), (0.05, 0.3)], 3), (-1.6, 0.8, -1.25)))
    print(use("gold") + box((-0.55, 1.35, -1.52), (0.35, 1.95, -1.49)) + use("picture") + box((-0.5, 1.4, -1.5), (0.3, 1.9, -1.485)))


if __name__ == "__main__":
    main()
