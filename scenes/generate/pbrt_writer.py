"""Small pieces of pbrt-v4 text: meshes of boxes, quads and lathes. No dependency beyond Python 3.

Units are metres, y is up. Every function returns text; positions are rounded to a tenth of a millimetre so that files stay small and the
generated text does not depend on the machine.
"""
import math


def number(value):
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def mesh(points, triangles, normals=None, uvs=None):
    def flat(rows):
        return " ".join(number(c) for row in rows for c in row)

    lines = ['Shape "trianglemesh"', f'    "point3 P" [ {flat(points)} ]']
    if normals:
        lines.append(f'    "normal N" [ {flat(normals)} ]')
    if uvs:
        lines.append(f'    "point2 uv" [ {flat(uvs)} ]')
    lines.append('    "integer indices" [ ' + " ".join(str(i) for t in triangles for i in t) + " ]")
    return "\n".join(lines) + "\n"


def quad(a, b, c, d, uvs=None):
    """Corners counter-clockwise as seen from the side that the normal points to."""
    return mesh([a, b, c, d], [(0, 1, 2), (0, 2, 3)], uvs=uvs)


def box(low, high, turn=0.0, pivot=(0.0, 0.0)):
    """An axis-aligned box, turned by `turn` degrees about the vertical through pivot = (x, z)."""
    sin, cos = math.sin(math.radians(turn)), math.cos(math.radians(turn))

    def place(x, y, z):
        dx, dz = x - pivot[0], z - pivot[1]
        return (pivot[0] + cos * dx + sin * dz, y, pivot[1] - sin * dx + cos * dz)

    points = [place(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    return mesh(points, triangles)


def lathe(profile, centre, steps=32):
    """Turns a profile of (radius, height), from the bottom up along the outside, about the vertical through `centre`."""
    points, normals, triangles = [], [], []
    for i, (radius, height) in enumerate(profile):
        before, after = profile[max(i - 1, 0)], profile[min(i + 1, len(profile) - 1)]
        # The outward normal of a profile that climbs by (dr, dh) is (dh, -dr).
        dr, dh = after[0] - before[0], after[1] - before[1]
        length = math.hypot(dr, dh) or 1.0
        for k in range(steps):
            angle = 2 * math.pi * k / steps
            points.append((centre[0] + radius * math.cos(angle), centre[1] + height, centre[2] + radius * math.sin(angle)))
            normals.append((dh / length * math.cos(angle), -dr / length, dh / length * math.sin(angle)))
    for i in range(len(profile) - 1):
        for k in range(steps):
            a, b = i * steps + k, i * steps + (k + 1) % steps
            # A ring of radius zero is the axis: its half of each quad would have no area.
            if profile[i][0] > 0:
                triangles.append((a, a + steps, b))
            if profile[i + 1][0] > 0:
                triangles.append((b, a + steps, b + steps))
    return mesh(points, triangles, normals)
