#!/usr/bin/env python3
"""Writes cornell-box.pbrt from the measured data that Cornell University's Program of Computer Graphics published (millimetres).

    python3 scenes/generate/cornell_box.py > scenes/cornell-box.pbrt
"""
from pbrt_writer import mesh, quad

SHORT = [(130, 65), (82, 225), (240, 272), (290, 114)], 165
TALL = [(423, 247), (265, 296), (314, 456), (472, 406)], 330


def block(corners, height):
    points = [(x, 0, z) for x, z in corners] + [(x, height, z) for x, z in corners]
    triangles = [(4, 5, 6), (4, 6, 7)]
    for i in range(4):
        j = (i + 1) % 4
        triangles += [(i, j, j + 4), (i, j + 4, i + 4)]
    return mesh(points, triangles)


def main():
    print("# Written by scenes/generate/cornell_box.py; edit that instead. Apache-2.0. Millimetres, y up.")
    print('Integrator "path" "integer maxdepth" 65')
    print('Sampler "independent" "integer pixelsamples" 64')
    print('PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5')
    print('Film "rgb" "integer xresolution" 512 "integer yresolution" 512 "string filename" "cornell-box.exr"')
    print("LookAt 278 273 -800  278 273 -799  0 1 0")
    print('Camera "perspective" "float fov" 39.3077   # 35 mm lens, 25 mm film')
    print("\nWorldBegin\n")
    for name, rgb in (("white", "0.725 0.71 0.68"), ("red", "0.63 0.065 0.05"), ("green", "0.14 0.45 0.091")):
        print(f'MakeNamedMaterial "{name}" "string type" "diffuse" "rgb reflectance" [ {rgb} ]')
    print('\nNamedMaterial "white"')
    print(quad((552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)))
    print(quad((556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0)))
    print(quad((549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)))
    print(block(*SHORT))
    print(block(*TALL))
    print('NamedMaterial "green"')
    print(quad((0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)))
    print('NamedMaterial "red"')
    print(quad((552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0)))
    print("# The light hangs a tenth of a millimetre below the ceiling and shines down.")
    print('AttributeBegin\nNamedMaterial "white"\nAreaLightSource "diffuse" "rgb L" [ 17 12 4 ]')
    print(quad((343, 548.7, 227), (343, 548.7, 332), (213, 548.7, 332), (213, 548.7, 227)) + "AttributeEnd")


if __name__ == "__main__":
    main()
