"""Larger shapes of the scenes: rooms, pierced walls, tubes, tori, discs, and a teapot. Text, as in pbrt_writer."""
import math

from pbrt_writer import box, define, diffuse, lathe, mesh, quad, use


def room(low, high, **materials):
    """The inside of a box: floor, ceiling, left (-x), right (+x), back (-z), front (+z). A side that is not named is open. uv are metres."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    sides = {
        "floor": [(x0, y0, z1), (x1, y0, z1), (x1, y0, z0), (x0, y0, z0)],
        "ceiling": [(x0, y1, z0), (x1, y1, z0), (x1, y1, z1), (x0, y1, z1)],
        "left": [(x0, y0, z1), (x0, y0, z0), (x0, y1, z0), (x0, y1, z1)],
        "right": [(x1, y0, z0), (x1, y0, z1), (x1, y1, z1), (x1, y1, z0)],
        "back": [(x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)],
        "front": [(x1, y0, z1), (x0, y0, z1), (x0, y1, z1), (x1, y1, z1)],
    }
    text = ""
    for side, material in materials.items():
        a, b, _, d = corners = sides[side]
        wide, tall = math.dist(a, b), math.dist(a, d)
        text += use(material) + quad(*corners, [(0, 0), (wide, 0), (wide, tall), (0, tall)])
    return text


def box_to_glow_in():
    """A Cornell box of 2 m with two blocks, open to the camera and without a light; its material "lamp" reflects nothing."""
    text = define({
        "white": diffuse(0.73, 0.71, 0.68),
        "red": diffuse(0.63, 0.07, 0.05),
        "green": diffuse(0.14, 0.45, 0.09),
        "lamp": diffuse(0, 0, 0),
    }) + "\n"
    text += room((-1, 0, -1), (1, 2, 1), floor="white", ceiling="white", back="white", left="red", right="green") + "\n"
    text += use("white") + box((-0.68, 0, -0.62), (-0.08, 1.2, -0.02), 17, (-0.38, -0.32)) + "\n"
    return text + box((0.08, 0, 0.0), (0.66, 0.6, 0.58), -18, (0.37, 0.29))


def pierced_wall(low, high, opening):
    """A wall with a rectangular opening (from, to, bottom, top); its thin side is x or z, `from` and `to` are along the other."""
    along = 0 if high[0] - low[0] > high[2] - low[2] else 2
    start, end, bottom, top = opening

    def piece(a, b, y0, y1):
        if b - a < 1e-6 or y1 - y0 < 1e-6:
            return ""
        p, q = list(low), list(high)
        p[along], q[along], p[1], q[1] = a, b, y0, y1
        return box(p, q)

    return (piece(low[along], start, low[1], high[1]) + piece(end, high[along], low[1], high[1])
            + piece(start, end, low[1], bottom) + piece(start, end, top, high[1]))


def _minus(a, b):
    return tuple(p - q for p, q in zip(a, b))


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _unit(a):
    length = math.sqrt(sum(c * c for c in a))
    return tuple(c / length for c in a)


def _frame(normal):
    """Two directions that make a right-handed frame with `normal`."""
    helper = (0, 1, 0) if abs(normal[1]) < 0.9 else (1, 0, 0)
    first = _unit(_cross(helper, normal))
    return first, _cross(normal, first)


def disc(centre, normal, radius, steps=24, inner=0.0):
    normal = _unit(normal)
    first, second = _frame(normal)
    rim = [(math.cos(2 * math.pi * k / steps), math.sin(2 * math.pi * k / steps)) for k in range(steps)]
    ring = [[tuple(c + r * (x * f + y * s) for c, f, s in zip(centre, first, second)) for x, y in rim] for r in (inner, radius)]
    if inner == 0:
        return mesh([centre] + ring[1], [(0, 1 + k, 1 + (k + 1) % steps) for k in range(steps)])
    triangles = []
    for k in range(steps):
        n = (k + 1) % steps
        triangles += [(k, steps + k, steps + n), (k, steps + n, n)]
    return mesh(ring[0] + ring[1], triangles)


def tube(path, radii, steps=12, closed=False):
    """Sweeps a circle along `path`; `radii` is one number or one for each point. Ends are open."""
    if not isinstance(radii, (list, tuple)):
        radii = [radii] * len(path)
    points, normals, triangles = [], [], []
    first = None
    for i, centre in enumerate(path):
        if closed:
            tangent = _unit(_minus(path[(i + 1) % len(path)], path[i - 1]))
        else:
            tangent = _unit(_minus(path[min(i + 1, len(path) - 1)], path[max(i - 1, 0)]))
        if first is None:
            first = _frame(tangent)[0]
        # The frame is carried along, without a turn of its own.
        along = sum(f * t for f, t in zip(first, tangent))
        first = _unit(tuple(f - along * t for f, t in zip(first, tangent)))
        second = _cross(tangent, first)
        for k in range(steps):
            x, y = math.cos(2 * math.pi * k / steps), math.sin(2 * math.pi * k / steps)
            normal = tuple(x * f + y * s for f, s in zip(first, second))
            points.append(tuple(c + radii[i] * n for c, n in zip(centre, normal)))
            normals.append(normal)
    for i in range(len(path) if closed else len(path) - 1):
        for k in range(steps):
            a, b = i * steps + k, i * steps + (k + 1) % steps
            c, d = (a + steps) % len(points), (b + steps) % len(points)
            triangles += [(a, b, d), (a, d, c)]
    return mesh(points, triangles, normals)


def torus(centre, axis, major, minor, around=48, across=24):
    """A closed tube around a circle. The circle lies in a plane, so the carried frame closes."""
    first, second = _frame(_unit(axis))
    turns = [2 * math.pi * i / around for i in range(around)]
    path = [tuple(c + major * (math.cos(t) * f + math.sin(t) * s) for c, f, s in zip(centre, first, second)) for t in turns]
    return tube(path, minor, across, closed=True)


def curve(points, steps):
    """A smooth path through `points` (Catmull-Rom), `steps` pieces between two of them."""
    path = []
    for i in range(len(points) - 1):
        p0, p1, p2, p3 = points[max(i - 1, 0)], points[i], points[i + 1], points[min(i + 2, len(points) - 1)]
        for k in range(steps):
            t = k / steps
            path.append(tuple(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t + (3 * b - a - 3 * c + d) * t * t * t)
                              for a, b, c, d in zip(p0, p1, p2, p3)))
    return path + [points[-1]]


def turned(place, centre, turn, scale=1.0):
    """`place` in the frame of an object that is scaled and turned by `turn` degrees about the vertical, then put at `centre`."""
    angle = math.radians(turn)
    x, y, z = (scale * c for c in place)
    return (centre[0] + math.cos(angle) * x + math.sin(angle) * z, centre[1] + y, centre[2] - math.sin(angle) * x + math.cos(angle) * z)


def teapot(centre, turn=0.0, scale=1.0):
    """A pot of our own: body and lid are turned, spout (+x) and handle (-x) are swept. 0.16 m high at scale 1."""
    def profile(rows):
        return [(scale * r, scale * h) for r, h in rows]

    body = profile(curve([(0.045, 0.0), (0.075, 0.02), (0.098, 0.06), (0.09, 0.1), (0.055, 0.122), (0.05, 0.128)], 3))
    lid = profile(curve([(0.051, 0.128), (0.03, 0.14), (0.008, 0.145), (0.008, 0.15), (0.015, 0.158), (0.0, 0.166)], 3))
    spout = curve([(0.08, 0.045, 0), (0.12, 0.06, 0), (0.14, 0.1, 0), (0.172, 0.128, 0)], 4)
    radii = [scale * (0.026 - 0.016 * i / (len(spout) - 1)) for i in range(len(spout))]
    handle = curve([(-0.07, 0.11, 0), (-0.12, 0.118, 0), (-0.147, 0.085, 0), (-0.13, 0.05, 0), (-0.085, 0.035, 0)], 4)
    return (lathe([(0.0, 0.0)] + body, centre) + lathe(lid, centre)
            + tube([turned(p, centre, turn, scale) for p in spout], radii)
            + tube([turned(p, centre, turn, scale) for p in handle], 0.009 * scale))


def cup(centre, scale=1.0):
    """A bowl with a wall, open at the top. 0.06 m high at scale 1."""
    outer = curve([(0.02, 0.0), (0.024, 0.006), (0.042, 0.03), (0.047, 0.06)], 3)
    inner = [(r - 0.004, h) for r, h in reversed(outer) if h > 0.008] + [(0.0, 0.008)]
    return lathe([(scale * r, scale * h) for r, h in [(0.0, 0.0)] + outer + inner], centre)


def table(low, high, top, leg):
    """A table top and four legs within the box low..high."""
    text = box((low[0], high[1] - top, low[2]), high)
    for x in (low[0] + leg, high[0] - 2 * leg):
        for z in (low[2] + leg, high[2] - 2 * leg):
            text += box((x, low[1], z), (x + leg, high[1] - top, z + leg))
    return text
