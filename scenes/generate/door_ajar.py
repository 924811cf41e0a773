#!/usr/bin/env python3
"""Writes door-ajar.pbrt: a room that is lit only through a door left ajar.

    python3 scenes/generate/door_ajar.py > scenes/door-ajar.pbrt

The camera stands in the front room (z > 0). The back room (z < 0) has the only light, a panel in its ceiling; the door leaf opens into the back
room and hides the panel from nearly everything in front, so most of the picture is light that has bounced at least twice.
"""
import math

from pbrt_writer import GLASS, box, define, diffuse, lamp, lathe, metal, prologue, quad, sphere, use

LEFT, RIGHT, HEIGHT = -2.2, 2.2, 2.6
FRONT, BACK = 4.2, -3.0
WALL = 0.12                      # thickness of the wall between the rooms: z in [-WALL, 0]
DOOR_LEFT, DOOR_RIGHT, DOOR_TOP = 0.35, 1.25, 2.05
AJAR = 42.0                      # degrees


def rooms():
    floor_uv = [(0, 0), (1, 0), (1, 1), (0, 1)]
    yield use("floor")
    yield quad((LEFT, 0, FRONT), (RIGHT, 0, FRONT), (RIGHT, 0, BACK), (LEFT, 0, BACK), floor_uv)
    yield use("plaster")
    yield quad((LEFT, HEIGHT, BACK), (RIGHT, HEIGHT, BACK), (RIGHT, HEIGHT, FRONT), (LEFT, HEIGHT, FRONT))
    yield quad((LEFT, 0, BACK), (RIGHT, 0, BACK), (RIGHT, HEIGHT, BACK), (LEFT, HEIGHT, BACK))
    yield quad((RIGHT, 0, FRONT), (LEFT, 0, FRONT), (LEFT, HEIGHT, FRONT), (RIGHT, HEIGHT, FRONT))
    yield use("ochre")
    yield quad((LEFT, 0, FRONT), (LEFT, 0, BACK), (LEFT, HEIGHT, BACK), (LEFT, HEIGHT, FRONT))
    yield use("plaster")
    yield quad((RIGHT, 0, BACK), (RIGHT, 0, FRONT), (RIGHT, HEIGHT, FRONT), (RIGHT, HEIGHT, BACK))
    # The wall between the rooms, around the opening.
    yield use("slate")
    yield box((LEFT, 0, -WALL), (DOOR_LEFT, HEIGHT, 0))
    yield box((DOOR_RIGHT, 0, -WALL), (RIGHT, HEIGHT, 0))
    yield box((DOOR_LEFT, DOOR_TOP, -WALL), (DOOR_RIGHT, HEIGHT, 0))


def door():
    hinge = (DOOR_LEFT, -WALL / 2)
    yield use("timber")
    yield box((DOOR_LEFT + 0.005, 0.01, -WALL / 2 - 0.02), (DOOR_RIGHT - 0.01, DOOR_TOP - 0.01, -WALL / 2 + 0.02), AJAR, hinge)
    frame = 0.07
    yield box((DOOR_LEFT - frame, 0, 0), (DOOR_LEFT, DOOR_TOP + frame, 0.03))
    yield box((DOOR_RIGHT, 0, 0), (DOOR_RIGHT + frame, DOOR_TOP + frame, 0.03))
    yield box((DOOR_LEFT, DOOR_TOP, 0), (DOOR_RIGHT, DOOR_TOP + frame, 0.03))
    yield use("brass")
    angle = math.radians(AJAR)
    for side in (-1, 1):
        along, off = 0.80, side * 0.065
        x = hinge[0] + math.cos(angle) * along + math.sin(angle) * off
        z = hinge[1] - math.sin(angle) * along + math.cos(angle) * off
        # Not sphere(), which would drop the zero of the 0.9010 that is in the file.
        yield f'AttributeBegin\nTranslate {x:.4f} 1.02 {z:.4f}\nShape "sphere" "float radius" 0.035\nAttributeEnd\n'


def furniture():
    top, leg = 0.72, 0.05
    x0, x1, z0, z1 = -1.55, 0.05, 0.75, 1.55
    yield use("timber")
    yield box((x0, top - 0.04, z0), (x1, top, z1))
    for x in (x0 + 0.04, x1 - 0.04 - leg):
        for z in (z0 + 0.04, z1 - 0.04 - leg):
            yield box((x, 0, z), (x + leg, top - 0.04, z + leg))
    yield use("glass")
    yield sphere(-0.3, top + 0.161, 1.22, 0.16)
    yield use("copper")
    yield sphere(-1.25, top + 0.131, 1.28, 0.13)
    yield use("glaze")
    profile = [(0.0, 0.0), (0.075, 0.0), (0.085, 0.012), (0.105, 0.06), (0.14, 0.14), (0.15, 0.2), (0.135, 0.27), (0.09, 0.33), (0.055, 0.37),
               (0.045, 0.41), (0.05, 0.45), (0.07, 0.48), (0.062, 0.482), (0.042, 0.45), (0.037, 0.41), (0.047, 0.37)]
    yield lathe(profile, (-0.8, top, 1.05))
    yield use("ochre")
    yield box((-1.05, top, 1.28), (-0.87, top + 0.09, 1.46), 28, (-0.96, 1.37))
    # A stack of crates beside the door.
    yield use("crate")
    yield box((1.5, 0, 0.35), (2.05, 0.5, 0.9), -14, (1.78, 0.62))
    yield box((1.58, 0.5, 0.42), (1.95, 0.84, 0.79), 11, (1.76, 0.6))


def main():
    print(prologue("door_ajar", 20, (640, 360), (-0.75, 1.42, 3.95), (-0.02, 0.92, 0), 42, spp=256), end="")
    print('Texture "tiles" "spectrum" "checkerboard" "float uscale" 12 "float vscale" 20 "rgb tex1" [ 0.55 0.5 0.43 ] "rgb tex2" [ 0.3 0.24 0.2 ]')
    print(define({
        "plaster": diffuse(0.76, 0.74, 0.7),
        "ochre": diffuse(0.65, 0.38, 0.13),
        "slate": diffuse(0.42, 0.5, 0.55),
        "floor": '"string type" "diffuse" "texture reflectance" "tiles"',
        "timber": diffuse(0.42, 0.26, 0.14),
        "crate": diffuse(0.2, 0.42, 0.3),
        "glaze": diffuse(0.2, 0.34, 0.62),
        "copper": metal("Cu", 0.12),
        "brass": metal("CuZn", 0.2),
        "glass": GLASS,
    }), end="")
    print("# The only light: a panel in the back room's ceiling.")
    y = HEIGHT - 0.01
    print(lamp((250, 228, 195), quad((0.9, y, -1.9), (2.0, y, -1.9), (2.0, y, -1.0), (0.9, y, -1.0)), "plaster"), end="")
    for part in (rooms(), door(), furniture()):
        print("".join(part))


if __name__ == "__main__":
    main()
