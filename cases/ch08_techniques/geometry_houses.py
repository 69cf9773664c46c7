"""Geometry shaders: a point goes in, a house comes out.

A geometry shader runs once for each primitive, gets all of its vertices, and emits any number of
new ones up to the max_vertices that it declares, as points, line strips or triangle strips. Here
each point becomes a strip of three triangles with five corners: two for the walls, one for the
roof, whose tip is white. The same points also become outlines (line_strip) and windows (points).

Look at: the four houses at (±½, ±½), in the colours of their points. The white of the tip fades
into the colour of the walls: it is an output of the vertex that was emitted last, and is
interpolated.

Try: in `ch08_techniques/geometry_houses.geom` write `vec2(0.0, 4.0)` for `vec2(0.0, 2.0)`: the
roofs become spires, and the outlines stay, which another shader draws.
"""

import numpy as np

from shaderlab import Case, Draw, Mesh, Pass, Target, compile_fails, formula, query
from shaderlab.glslmath import vec2, vec3, vec4, where

from ..scenes.figures import each_draw, ground
from ..scenes.laws import entry, opaque, unchanged

COLORS = np.array([(0.85, 0.25, 0.2), (0.3, 0.6, 0.3), (0.25, 0.4, 0.8), (0.9, 0.7, 0.2)])
LIGHT = np.array((1.0, 0.95, 0.6))
POINTS = Mesh(
    attributes={
        "aPos": np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]),
        "aColor": COLORS,
    },
    primitive="points",
)
SKY = (0.80, 0.83, 0.86, 1.0)
TRIANGLES = ((-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (0.0, 2.0))
OUTLINE = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 2.0), (-1.0, 1.0), (-1.0, -1.0))
WINDOWS = ((-0.5, 0.25), (0.5, 0.25))
TOO_MANY = "ch08_techniques/errata/too_many_vertices.geom"
KINDS = {"walls": "", "outline": "_outline", "windows": "_corners"}


def houses(kind):
    """The four points through one of the geometry shaders."""
    return Draw(
        vertex="ch08_techniques/geometry_houses.vert",
        geometry=f"ch08_techniques/geometry_houses{kind}.geom",
        fragment="ch08_techniques/geometry_houses.frag",
        mesh=POINTS,
        uniforms={"scale": (0.2, 0.18)},
    )


def drawn(name, *draws, side=128):
    """A window with some of the draws."""
    target = Target(size=(side, side), clear=SKY)
    return Pass(name=name, target=target, draws=draws)


def standing(offsets):
    """A corner's place in clip space: the point, and the scaled offset of the emitted corner."""

    def position(gl_in_gl_Position, emitted, scale):
        """Point plus scale · offset."""
        (point,) = gl_in_gl_Position
        x, y = (entry(emitted, [offset[axis] for offset in offsets]) for axis in (0, 1))
        return point + vec4(scale * vec2(x, y), 0.0, 0.0)

    return position


def painted(wall, emitted):
    """The point's colour, white for the fifth corner."""
    return where(emitted > 3.5, vec3(1.0), wall[0])


def outlined(wall):
    """Outlines are darker than the walls."""
    return 0.4 * wall[0]


def lit(wall):
    """Light in the windows."""
    return vec3(*LIGHT) - 0.25 * wall[0]


def size_of():
    """Windows are squares of twelve pixels."""
    return 12.0


def as_it_is(aPos):
    """The vertex shader only hands the point on."""
    return vec4(aPos, 0.0, 1.0)


PAINT = opaque(unchanged("fColor"))


def emitted(number, kind, name):
    """So many primitives leave the geometry shader."""
    return query("geometry_primitives_emitted", equals=number, pass_name=kind, name=name)


case = Case(
    title="Houses out of points",
    section="8.6",
    math=r"p_k = p + \begin{pmatrix} s_x & 0 \\ 0 & s_y \end{pmatrix} o_k, \qquad "
    r"o = (-1,-1), (1,-1), (-1,1), (1,1), (0,2)",
    passes=(
        drawn("street", *map(houses, KINDS.values()), side=512),
        *(drawn(name, houses(kind)) for name, kind in KINDS.items()),
    ),
    picture="street.FragColor",
    expect=[
        formula("walls.gl_Position", standing(TRIANGLES), name="triangle_strip: places"),
        formula("walls.fColor", painted, name="triangle_strip: colours"),
        formula("outline.gl_Position", standing(OUTLINE), name="line_strip: places"),
        formula("outline.fColor", outlined, name="line_strip: colours"),
        formula("windows.gl_Position", standing(WINDOWS), name="points: places"),
        formula("windows.gl_PointSize", size_of, name="points: size"),
        formula("windows.fColor", lit, name="points: colours"),
        *(formula(f"{kind}.FragColor", PAINT, name=f"{kind}: pixels") for kind in KINDS),
        *each_draw("street.FragColor", PAINT, {k: f"street: {w}" for k, w in enumerate(KINDS)}),
        *(
            formula(f"{kind}.gl_in.gl_Position", as_it_is, name=f"{kind}: points that go in")
            for kind in KINDS
        ),
        *(
            formula(f"{kind}.wall", unchanged("aColor"), name=f"{kind}: their colours")
            for kind in KINDS
        ),
        *(ground(f"{name}.FragColor", SKY, f"{name}: the sky") for name in ("street", *KINDS)),
        emitted(12, "walls", "triangles of walls"),
        emitted(20, "outline", "lines"),
        emitted(8, "windows", "points"),
        query("samples_passed", equals=1152, pass_name="windows", name="8 · 12² pixels"),
        compile_fails(  # linked as well: GLSL does not say which of the two must refuse it
            ("ch08_techniques/geometry_houses.vert", TOO_MANY),
            (
                TOO_MANY,
                3,
                "'max_vertices' : too large, must be less than gl_MaxGeometryOutputVertices",
            ),
            name="more vertices than there may be",
        ),
    ],
)
