"""Tessellation: twenty triangles become a ball, in small steps where one looks closely.

A mesh of patches is divided while it is drawn. The control stage says into how many parts each edge
and the inside go; the evaluation stage places each new corner, by weights of the patch's corners
whose sum is 1. A triangle whose edges and inside go into n parts becomes 3n²/2 triangles, half a
triangle less if n is odd. Two patches that share an edge must divide it alike and place its points
alike, or the ball cracks: a level may depend on the edge, but not on the patch. The usual "distance
to the patch's middle" does not.

Look at: a mosaic of twenty patches with dark edges; its tiles are small at the upper left, which is
where the ball is divided finest, and large on the other side.

Try: in `ch15_beyond/tessellation.tese` write `fractional_odd_spacing` for `equal_spacing`: parts of
an edge differ in length, so that levels can change without a jump.

Tessellation came with OpenGL 4.0; softpipe, WebGL2 and the lab's Vulkan have none.
"""

import numpy as np

from shaderlab import Blend, Case, Depth, Draw, Mesh, Pass, State, Target, formula, measure, query
from shaderlab.glslmath import (
    clamp,
    distance,
    dot,
    fract,
    max,
    min,
    mix,
    normalize,
    smoothstep,
    swizzle,
    vec3,
)
from shaderlab.reference.transforms import in_view

from ..scenes.cameras import camera
from ..scenes.figures import results
from ..scenes.panel_checks import smaller_check, softened_check
from ..scenes.panels import softened_pass
from ..scenes.studio import studio_color

GOLDEN = 0.5 * (1.0 + 5.0**0.5)
NEAR, PAINT = (-0.45, 0.6, 0.75), (0.95, 0.50, 0.28)
CAMERA = camera((0.0, 0.9, 4.2), (0.0, 0.0, 0.0), 31.0)
STAGES = {
    "vertex": "ch15_beyond/tessellation.vert",
    "tess_control": "ch15_beyond/tessellation.tesc",
    "tess_evaluation": "ch15_beyond/tessellation.tese",
    "fragment": "ch15_beyond/tessellation.frag",
}
SPACE = (0.80, 0.83, 0.86, 1.0)


def icosahedron():
    """Corners of twenty triangles, counterclockwise from outside."""
    ends = [(0.0, one, GOLDEN * other) for one in (-1.0, 1.0) for other in (-1.0, 1.0)]
    corners = np.array([np.roll(end, k) for end in ends for k in range(3)])
    corners /= np.linalg.norm(corners[0])
    edge = np.linalg.norm(corners[:, None] - corners, axis=-1)
    near = np.isclose(edge, np.sort(edge[0])[1])
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(12)
        for c in range(12)
        if a < b
        and a < c
        and near[a, b]
        and near[b, c]
        and near[c, a]
        and np.linalg.det(corners[[a, b, c]]) > 0.0
    ]
    return corners, np.array(faces)


CORNERS, FACES = icosahedron()
PATCHES = Mesh(attributes={"aPos": CORNERS[FACES].reshape(-1, 3)}, primitive="patches")


def ball(name, side, finest, roundness=1.0, mesh=PATCHES, clear=SPACE, **state):
    """A pass that draws the ball."""
    uniforms = {**CAMERA, "near": NEAR, "finest": finest, "roundness": roundness, "paint": PAINT}
    draw = Draw(**STAGES, mesh=mesh, uniforms=uniforms, state=State(cull="back", **state))
    return Pass(
        name=name, target=Target(size=(side, side), depth="depth24", clear=clear), draws=(draw,)
    )


def counted(name, finest, roundness=1.0, mesh=PATCHES):
    """A pass in which each triangle adds 1 to alpha."""
    blend = Blend(source="one", destination="one")
    return ball(name, 96, finest, roundness, mesh, (0.0, 0.0, 0.0, 0.0), blend=blend)


def level(one, other, near, finest):
    """Into how many parts an edge goes."""
    return clamp(finest / (0.25 + distance(near, 0.5 * (one + other))), 1.0, 32.0)


def outer(k):
    """The level of the edge opposite to a corner."""

    def of_edge(aPos, near, finest):
        return level(aPos[(k + 1) % 3], aPos[(k + 2) % 3], near, finest)

    return of_edge


def inner(aPos, near, finest):
    """The largest of the three."""
    first, *others = (outer(k)(aPos, near, finest) for k in range(3))
    return max(first, max(*others))


def place(gl_TessCoord, aPos, roundness):
    """Where a corner is."""
    weights = (swizzle(gl_TessCoord, axis) for axis in "xyz")
    flat = sum(weight * corner for weight, corner in zip(weights, aPos, strict=True))
    return mix(flat, normalize(flat), roundness)


def position(gl_TessCoord, aPos, roundness, view, projection):
    """The same in clip space."""
    return in_view(place(gl_TessCoord, aPos, roundness), view, projection)


def weights(gl_TessCoord):
    """Three numbers whose sum is 1."""
    x, y = swizzle(gl_TessCoord, "x"), swizzle(gl_TessCoord, "y")
    return vec3(x, y, 1.0 - x - y)


def color(Corner, Facet, paint):
    """A triangle's tone; the edges of patches dark."""
    x, y, z = (swizzle(Corner, axis) for axis in "xyz")
    share = mix(0.25, 1.0, smoothstep(0.0, 0.03, min(min(x, y), z)))
    tone = 0.55 + 0.45 * fract(dot(Facet, vec3(7.3, 4.1, 5.9)))
    return studio_color(paint * tone * share, Facet)


def wrongly_covered(FragColor):
    """Pixels within the ball's outline that are not covered once."""
    steps = (np.arange(96) + 0.5) / 48.0 - 1.0
    # The outline of a ball of radius 1 at a distance d is seen under the angle of sine 1/d.
    far = np.hypot(0.9, 4.2)
    radius = 0.96 / np.sqrt(far**2 - 1.0) / np.tan(np.radians(15.5))
    inside = np.hypot(*np.meshgrid(steps, steps)) < radius
    return np.count_nonzero(FragColor[..., 3][inside] != 1.0)


def triangles(n):
    """Of a patch whose edges and inside go into n parts."""
    return (3 * n * n - n % 2) // 2


case = Case(
    title="Tessellation",
    section="15.15",
    math=r"p = \frac{\sum_k w_k c_k}{|\sum_k w_k c_k|}, \qquad \sum_k w_k = 1, \qquad N = "
    r"\tfrac{1}{2}(3 n^2 - n \bmod 2)",
    passes=(
        ball("scene", 640, 4.5, depth=Depth()),
        *softened_pass("scene", (320, 320)),
        ball("judged", 64, 4.5, depth=Depth()),
        counted("closed", 4.5),
        counted("all_alike", 100.0),
    ),
    picture="picture.FragColor",
    expect=[
        formula("judged.gl_Position", position, name="corners"),
        formula("judged.Facet", place, name="corners on the ball"),
        formula("judged.Corner", weights, name="weights, whose sum is 1"),
        *(formula(f"judged.gl_TessLevelOuter[{k}]", outer(k), name=f"edge {k}") for k in range(3)),
        formula("judged.gl_TessLevelInner[0]", inner, name="inside"),
        formula("judged.FragColor", color, name="facets"),
        measure(
            "pixels of the ball that are not covered once",
            wrongly_covered,
            reads={"FragColor": "closed.FragColor"},
            equals=0.0,
            digits=9,
        ),
        measure(
            "all edges in 32 parts",
            wrongly_covered,
            reads={"FragColor": "all_alike.FragColor"},
            equals=0.0,
            digits=9,
        ),
        query("primitives_generated", equals=20 * triangles(32), pass_name="all_alike"),
        softened_check(),
        smaller_check(edges=0.1),
        *results({"triangles of a patch in 3 parts": (triangles(3), 13)}),
    ],
)
