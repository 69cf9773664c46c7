"""A point cloud from a PCD file, each point as large as its distance makes it.

A PCD file is a short header in text, which names the fields of a point, their types and how many
points there are, and then the points: as text, as they lie in memory, or packed. `GL_POINTS` draws
a square around each of them, `gl_PointSize` pixels wide (with GL_PROGRAM_POINT_SIZE enabled). A
point of a fixed size in space spans pixels in inverse proportion to its distance, and that is clip
w: the size is the scale over w. `gl_PointCoord` runs over the square, and turns it into a disc. A
header may claim anything, so the lab checks it against the file's size.

Look at: the galaxy, 1500 stars of one file. The near arm's are the larger ones. The same cloud is
there in three encodings, and all three draw the same picture, to the bit.

Try: in `ch14_point_clouds/point_cloud.vert` write `pointScale` for `pointScale / gl_Position.w`:
all stars are of one size, and the galaxy looks flat.
"""

from functools import cache
from math import radians
from pathlib import Path

import numpy as np

from shaderlab import Blend, Case, Mesh, Output, assets, coverage, exact, formula, measure, sweep
from shaderlab.glslmath import dot, max, mix, mul, swizzle, vec3, vec4
from shaderlab.reference.transforms import look_at, perspective

from ..scenes.broken_files import broken_files
from ..scenes.discs import SUPPORTED, add_discs
from ..scenes.draws import drawn
from ..scenes.figures import figure, results
from ..scenes.laws import unchanged
from ..scenes.panels import picture

DROP, CHECK = "leave such points out with drop_invalid=True", "check the path and its spelling"
FOLDER = Path(__file__).parent / "point_cloud"
VIEW = look_at((0.30, 1.45, 2.10), (0.0, 0.0, 0.10))
# What sums of a few stars lose in 32 bits, and places of the points in pixels.
ROUNDED = 1e-4
LARGE, NIGHT = 26.0, (0.006, 0.008, 0.02, 1.0)
PROJECTION = perspective(radians(55.0), 1.5, 0.1, 10.0)


@cache
def cloud(encoding):
    """The galaxy from one of its three files."""
    return assets.load_pcd(FOLDER / f"galaxy_{encoding}.pcd")


def places():
    """Where the stars are."""
    return cloud("binary").positions


def stars(encoding):
    """The galaxy as points."""
    found = cloud(encoding)
    attributes = {"aPos": found.positions, "aWarmth": found.fields["warmth"]}
    return Mesh(attributes=attributes, primitive="points")


def points(
    name, mesh, size, scale, view=VIEW, projection=PROJECTION, fragment="point_cloud.frag", **state
):
    """One pass of points; `scale` is a point's diameter at distance 1."""
    shaders = ("ch14_point_clouds/point_cloud.vert", f"ch14_point_clouds/{fragment}")
    uniforms = {"view": view, "projection": projection, "pointScale": scale}
    draw = drawn(shaders, mesh, uniforms, point_size="program", **state)
    return picture([draw], size, name, depth="depth24", clear=NIGHT)


def judged(name, encoding):
    """A small picture of one file, its stars in the order of the file."""
    later = Mesh.later(lambda: stars(encoding))
    return points(name, later, (96, 64), 9.0)


# Three points on the corners of pixels, at distances 1, 2 and 4: 16, 8 and 4 pixels wide.
RULER = Mesh(
    attributes={
        "aPos": np.array([(-0.5, -0.5, -1.0), (1.0, -1.0, -2.0), (0.0, 2.0, -4.0)]),
        "aWarmth": np.array([0.0, 0.5, 1.0]),
    },
    primitive="points",
)


def square(warmth):
    """The ruler's colours."""
    return vec4(warmth, 0.5, 1.0 - warmth, 1.0)


def clip(aPos, view, projection):
    """Clip coordinates: points have no model matrix of their own."""
    return mul(projection, mul(view, vec4(aPos, 1.0)))


def width(aPos, view, projection, pointScale):
    """A point's diameter: in inverse proportion to clip w."""
    return pointScale / swizzle(clip(aPos, view, projection), "w")


def star(warmth, gl_PointCoord):
    """Between blue and amber, with no light left at the circle's rim."""
    off = gl_PointCoord - 0.5
    light = max(1.0 - 4.0 * dot(off, off), 0.0)
    color = mix(vec3(0.20, 0.36, 0.85), vec3(1.0, 0.70, 0.35), warmth)
    return vec4(light * color, 1.0)


def furthest_from_sum(FragColor, subpixel_step):
    """How far any channel of the picture is from the sum of all stars' light, by NumPy, with the
    kind of sizes that fits best. Middles are moved to the driver's grid: by half a step at most, so
    the sum has a least and a greatest value."""
    least = np.inf
    for supported in SUPPORTED:
        shift = np.sqrt(0.5) * subpixel_step
        low, high = (sum_of_light(supported, by) for by in (shift, -shift))
        least = min(least, np.maximum(low - FragColor[..., :3], FragColor[..., :3] - high).max())
        if least <= ROUNDED:
            break
    return least


def sum_of_light(supported, shift):
    """The picture by NumPy, with such sizes, and middles that are so far off."""
    found, total = cloud("binary"), np.broadcast_to(NIGHT[:3], (640, 960, 3)).copy()
    warmth = np.ravel(found.fields["warmth"])[:, None]
    hues = np.array([0.20, 0.36, 0.85]) * (1.0 - warmth) + np.array([1.0, 0.70, 0.35]) * warmth
    add_discs(total, found.positions, hues, PROJECTION @ VIEW, LARGE, supported, shift)
    return total


def apart(encoding):
    """The largest difference of any number from the plain binary file's."""
    one, other = cloud(encoding), cloud("binary")
    warmth = np.abs(one.fields["warmth"] - other.fields["warmth"]).max()
    return np.maximum(np.abs(one.positions - other.positions).max(), warmth)


BROKEN = {
    "truncated.pcd": "is cut off: it promises 40 points and has 33",
    "short_row.pcd": "is cut off: point 1 has 2 numbers, not 4",
    "wrong_magic.pcd": "is no PCD file: it begins with 'PLY'",
    "not_a_number.pcd": ("point 1 is [0.0, nan, 0.0]", {"remedy": DROP}),
    "enormous.pcd": "is cut off: it promises 1000000000000 points and has 4",
    "enormous_compressed.pcd": "promises 1000000000 points, 16000000000 bytes, "
    "but unpacks to 4294967295",
    "empty.pcd": "is no PCD file",
    "absent.pcd": ("there is no such file (a PCD file was asked for)", {"remedy": CHECK}),
}

case = Case(
    title="A point cloud",
    section="14",
    math=r"\text{gl\_PointSize} = \frac{s}{w_{\text{clip}}}",
    passes=(
        points(
            "picture",
            Mesh.later(lambda: stars("binary")),
            (960, 640),
            LARGE,
            blend=Blend(source="one", destination="one"),
        ),
        judged("ascii", "ascii"),
        judged("compressed", "compressed"),
        points(
            "ruler",
            RULER,
            (64, 64),
            16.0,
            view=np.eye(4),
            projection=perspective(radians(90.0), 1.0, 0.1, 10.0),
            fragment="point_square.frag",
        ),
        judged("judged", "binary"),
    ),
    picture="picture.FragColor",
    expect=[
        *results({"points": (lambda: len(places()), 1500.0)}, digits=0),
        *results(
            {
                "lowest corner of the bounds": (lambda: places().min(axis=0), (-1.5, -0.4, -1.5)),
                "highest corner of the bounds": (lambda: places().max(axis=0), (1.5, 0.4, 1.5)),
            }
        ),
        *results(
            {
                "text against binary": (lambda: apart("ascii"), 0.0),
                "packed against binary": (lambda: apart("compressed"), 0.0),
            },
            digits=12,
        ),
        exact("judged.FragColor", Output("ascii.FragColor"), name="the picture from text"),
        exact("judged.FragColor", Output("compressed.FragColor"), name="… from packed data"),
        measure(
            "the picture",
            furthest_from_sum,
            reads={"FragColor": "picture.FragColor"},
            at_most=ROUNDED,
        ),
        formula("gl_Position", clip),
        formula("diameter", width),
        formula("gl_PointSize", width),
        formula("warmth", unchanged("aWarmth")),
        formula("FragColor", star),
        formula("ruler.gl_Position", clip, name="the ruler's places"),
        formula("ruler.warmth", unchanged("aWarmth"), name="the ruler's warmth"),
        formula("ruler.FragColor", square),
        formula("ruler.diameter", width, name="the ruler's diameters"),
        coverage(16**2 + 8**2 + 4**2, pass_name="ruler", name="pixels at distances 1, 2 and 4"),
        figure("ruler.diameter", "at distance 4", {"aPos": (0, 0, -4), "aWarmth": 0.0}, 4.0),
        sweep(
            "ruler.diameter",
            width,
            over="pointScale",
            values=np.linspace(1.0, 32.0, 32),
            at={"aPos": (0.25, 0.5, -2.0), "aWarmth": 0.5},
        ),
        *broken_files(assets.load_pcd, FOLDER, BROKEN, remedy="save the cloud again"),
    ],
)
