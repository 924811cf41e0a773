"""Meshes of implicit surfaces (surface nets), and a rabbit made of one. Only sums, products and square roots, so that every machine agrees."""
import math

from pbrt_writer import mesh


def ellipsoid(centre, radii):
    smallest = min(radii)
    return lambda p: (math.sqrt(sum(((c - m) / r) ** 2 for c, m, r in zip(p, centre, radii))) - 1) * smallest


def limb(start, end, thick, thin):
    """A rod from `start` to `end` whose radius falls from `thick` to `thin`."""
    axis = [b - a for a, b in zip(start, end)]
    squared = sum(c * c for c in axis)

    def distance(p):
        t = min(1.0, max(0.0, sum((c - a) * d for c, a, d in zip(p, start, axis)) / squared))
        return math.sqrt(sum((c - a - t * d) ** 2 for c, a, d in zip(p, start, axis))) - (thick + t * (thin - thick))

    return distance


def union(parts, softness):
    """The parts' union with rounded seams: minima blended by a parabola over `softness`."""
    def distance(p):
        nearest = parts[0](p)
        for part in parts[1:]:
            other = part(p)
            blend = max(softness - abs(nearest - other), 0.0)
            nearest = min(nearest, other) - blend * blend / (4 * softness)
        return nearest

    return distance


def surface(field, low, high, step, place):
    """The triangles of field = 0 within the box low..high, one point to each cell that the surface crosses.

    `place` moves points, and the tips of the normals.
    """
    size = [round((b - a) / step) + 1 for a, b in zip(low, high)]

    def corner(i, j, k):
        return tuple(a + step * n for a, n in zip(low, (i, j, k)))

    value = {(i, j, k): field(corner(i, j, k)) for i in range(size[0]) for j in range(size[1]) for k in range(size[2])}
    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    sums, quads = {}, []  # of each cell: the crossings of its edges, summed, and their number
    for at, here in value.items():
        for axis, (dx, dy, dz) in enumerate(axes):
            there = value.get((at[0] + dx, at[1] + dy, at[2] + dz))
            if there is None or (here < 0) == (there < 0):
                continue
            crossing = list(corner(*at))
            crossing[axis] += step * here / (here - there)
            u, v = axes[(axis + 1) % 3], axes[(axis + 2) % 3]
            around = [tuple(n - a * p - b * q for n, p, q in zip(at, u, v)) for a, b in ((1, 1), (0, 1), (0, 0), (1, 0))]
            for cell in around:
                total = sums.setdefault(cell, [0.0, 0.0, 0.0, 0])
                for c in range(3):
                    total[c] += crossing[c]
                total[3] += 1
            # Inside is negative: the quad faces along the axis where the field grows.
            quads.append(around if here < 0 else around[::-1])
    index, points, normals = {}, [], []
    for cell, (x, y, z, count) in sums.items():
        index[cell] = len(points)
        p = (x / count, y / count, z / count)
        slope = [field(tuple(c + 0.001 * a for c, a in zip(p, axis))) - field(tuple(c - 0.001 * a for c, a in zip(p, axis))) for axis in axes]
        length = math.sqrt(sum(s * s for s in slope))
        here, tip = place(p), place(tuple(c + s / length for c, s in zip(p, slope)))
        scale = math.dist(here, tip)
        points.append(here)
        normals.append(tuple((b - a) / scale for a, b in zip(here, tip)))
    triangles = []
    for a, b, c, d in ([index[cell] for cell in quad] for quad in quads):
        triangles += [(a, b, c), (a, c, d)]
    return mesh(points, triangles, normals)


def rabbit(place, step=0.035):
    """Sits on y = 0 and looks along +x; 1.1 high, 1 long. `place` moves its points."""
    body = [
        ellipsoid((-0.08, 0.27, 0), (0.29, 0.26, 0.22)),
        ellipsoid((0.15, 0.33, 0), (0.15, 0.22, 0.15)),
        ellipsoid((0.29, 0.6, 0), (0.16, 0.13, 0.125)),
        ellipsoid((0.4, 0.57, 0), (0.08, 0.07, 0.07)),
        ellipsoid((-0.38, 0.24, 0), (0.09, 0.09, 0.09)),
    ]
    for side in (-1, 1):
        body += [
            limb((0.24, 0.7, 0.05 * side), (0.06, 1.03, 0.13 * side), 0.055, 0.04),
            ellipsoid((-0.1, 0.2, 0.17 * side), (0.17, 0.18, 0.09)),
            ellipsoid((0.08, 0.05, 0.18 * side), (0.17, 0.055, 0.065)),
            ellipsoid((0.27, 0.11, 0.08 * side), (0.07, 0.12, 0.05)),
        ]
    return surface(union(body, 0.06), (-0.56, -0.04, -0.34), (0.56, 1.16, 0.34), step, place)
