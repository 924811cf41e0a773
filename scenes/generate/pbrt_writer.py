"""Small pieces of pbrt-v4 text: headers, materials, lights, meshes of boxes, quads and lathes. No dependency beyond Python 3.

Units are metres, y is up. Every function returns text; positions are rounded to a tenth of a millimetre so that files stay small and the
generated text does not depend on the machine.
"""
import math


def number(value):
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def numbers(values):
    return " ".join(number(v) for v in values)


def prologue(script, depth, resolution, eye, target, fov, spp=64):
    """Everything before WorldBegin, and WorldBegin. `fov` in degrees, of the shorter side of the image."""
    width, height = resolution
    return "\n".join([
        f"# Written by scenes/generate/{script}.py; edit that instead. Apache-2.0. Metres, y up.",
        f'Integrator "path" "integer maxdepth" {depth}',
        f'Sampler "independent" "integer pixelsamples" {spp}',
        'PixelFilter "gaussian" "float xradius" 1.5 "float yradius" 1.5 "float sigma" 0.5',
        f'Film "rgb" "integer xresolution" {width} "integer yresolution" {height} "string filename" "{script.replace("_", "-")}.exr"',
        f"LookAt {numbers(eye)}  {numbers(target)}  0 1 0",
        f'Camera "perspective" "float fov" {number(fov)}',
        "\nWorldBegin\n\n"])


def diffuse(*rgb):
    return f'"string type" "diffuse" "rgb reflectance" [ {numbers(rgb)} ]'


def checkered(name, per_metre, first, second):
    """A texture of squares, for meshes whose uv are metres."""
    return (f'Texture "{name}" "spectrum" "checkerboard" "float uscale" {number(per_metre)} "float vscale" {number(per_metre)} '
            f'"rgb tex1" [ {numbers(first)} ] "rgb tex2" [ {numbers(second)} ]\n')


def metal(symbol, alpha):
    """A measured metal; `alpha` is the microfacet width itself, not pbrt's remapped roughness. 0 is a mirror."""
    return (f'"string type" "conductor" "spectrum eta" "metal-{symbol}-eta" "spectrum k" "metal-{symbol}-k" '
            f'"float roughness" {number(alpha)} "bool remaproughness" false')


def steel(alpha, *rgb):
    """A metal by its reflectance at normal incidence."""
    return f'"string type" "conductor" "rgb reflectance" [ {numbers(rgb)} ] "float roughness" {number(alpha)} "bool remaproughness" false'


def coated(alpha, reflectance):
    """Lacquer or glaze over a diffuse base: `reflectance` is three numbers, or the name of a texture."""
    base = f'"texture reflectance" "{reflectance}"' if isinstance(reflectance, str) else f'"rgb reflectance" [ {numbers(reflectance)} ]'
    return f'"string type" "coateddiffuse" {base} "float roughness" {number(alpha)} "bool remaproughness" false'


GLASS = '"string type" "dielectric" "float eta" 1.5 "float roughness" 0'


def define(materials):
    return "".join(f'MakeNamedMaterial "{name}" {parameters}\n' for name, parameters in materials.items()) + "\n"


def use(material):
    return f'NamedMaterial "{material}"\n'


def lamp(radiance, shape, material="lamp"):
    """`shape` shines with `radiance` (W/m2/sr per channel) to the side that its normal points to."""
    return f'AttributeBegin\nNamedMaterial "{material}"\nAreaLightSource "diffuse" "rgb L" [ {numbers(radiance)} ]\n{shape}AttributeEnd\n\n'


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


def sphere(x, y, z, radius):
    return f'AttributeBegin\nTranslate {numbers((x, y, z))}\nShape "sphere" "float radius" {number(radius)}\nAttributeEnd\n'


def named_object(name, shapes):
    return f'ObjectBegin "{name}"\n{shapes}ObjectEnd\n'


def instance(name, x, y, z, scale=1.0, turn=0.0):
    """A named object, scaled and turned by `turn` degrees about the vertical, at (x, y, z)."""
    return (f'AttributeBegin\nTranslate {numbers((x, y, z))}\nRotate {number(turn)} 0 1 0\nScale {numbers((scale,) * 3)}\n'
            f'ObjectInstance "{name}"\nAttributeEnd\n')


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


def lathe(profile, centre, steps=32, directions=None):
    """Turns a profile of (radius, height), from the bottom up along the outside, about the vertical through `centre`.

    A point given twice is a crease; elsewhere the shading is smooth, by the profile's chords or the given (radial, upward) normals.
    """
    points, normals, triangles = [], [], []
    for i, (radius, height) in enumerate(profile):
        before, after = profile[max(i - 1, 0)], profile[min(i + 1, len(profile) - 1)]
        # The outward normal of a profile that climbs by (dr, dh) is (dh, -dr).
        dr, dh = after[0] - before[0], after[1] - before[1]
        length = math.hypot(dr, dh) or 1.0
        out, up = directions[i] if directions else (dh / length, -dr / length)
        for k in range(steps):
            angle = 2 * math.pi * k / steps
            points.append((centre[0] + radius * math.cos(angle), centre[1] + height, centre[2] + radius * math.sin(angle)))
            normals.append((out * math.cos(angle), up, out * math.sin(angle)))
    for i in range(len(profile) - 1):
        if profile[i] == profile[i + 1]:
            continue
        for k in range(steps):
            a, b = i * steps + k, i * steps + (k + 1) % steps
            # A ring of radius zero is the axis: its half of each quad would have no area.
            if profile[i][0] > 0:
                triangles.append((a, a + steps, b))
            if profile[i + 1][0] > 0:
                triangles.append((b, a + steps, b + steps))
    return mesh(points, triangles, normals)
