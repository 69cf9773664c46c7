"""Primitives: six vertices, assembled in six ways.

A vertex buffer is a list of corners, and does not say what they are corners of. The draw's mode
does. Of n vertices GL_POINTS makes n points, GL_LINES n/2 lines and GL_LINE_STRIP n − 1, each from
the last one's end. GL_TRIANGLES makes n/3 triangles; in a GL_TRIANGLE_STRIP each vertex from the
third on makes one with the two before it, in a GL_TRIANGLE_FAN one with the vertex before it and
the very first. Strips and fans send each shared corner once. In a strip every other triangle would
run the other way round; OpenGL swaps two of its corners, so that all face the same side.

Look at: the same six vertices, in a zigzag from the left. Above points, lines and a line strip,
below triangles, a strip and a fan; a draw's first primitive is amber, later ones turn blue. The
strip fills the rectangle, although back faces are culled. The fan overlaps itself: its vertices
should go around the first.

Try: in `ch02_basics/primitives.frag` write `float(gl_PrimitiveID % 2)` for `0.2 *
float(gl_PrimitiveID)`: neighbours differ, so the primitives of each field can be counted.
"""

import numpy as np

from shaderlab import Case, Draw, Mesh, Output, Pass, State, Target, exact, formula, query
from shaderlab.glslmath import mix, vec3, vec4

from ..scenes.figures import each_draw
from ..scenes.panels import cell

WIDE, HIGH, SIZE = 128, 64, 12.0
# Corners between pixels of a field of 128 × 64; along a diagonal of the zigzag a square's pixels
# lie on both sides of it, half of them each.
ZIGZAG = np.array([(x, y) for x in (-0.75, 0.0, 0.75) for y in (-0.75, 0.75)])
# Mode, how many primitives it makes, and their vertices one by one, as separate ones need them.
MODES = {
    "triangles": (2, [(0, 1, 2), (3, 4, 5)]),
    "triangle_strip": (4, [(0, 1, 2), (2, 1, 3), (2, 3, 4), (4, 3, 5)]),
    "triangle_fan": (4, [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]),
    "points": (6, [(k,) for k in range(6)]),
    "lines": (3, [(0, 1), (2, 3), (4, 5)]),
    "line_strip": (5, [(k, k + 1) for k in range(5)]),
}
SEPARATE = {1: "points", 2: "lines", 3: "triangles"}
# The strip alone has back faces culled: none of its triangles may be one.
CLOCKWISE = {"cull": "back", "front_face": "cw"}
# Pixels of a rectangle of the zigzag, 48 × 48; two of them are all of it.
SQUARE = 48 * 48


def field(k, mode, spelt_out):
    """One way to put the six vertices together, in its field."""
    vertices, indices = MODES[mode][1], None
    if spelt_out:
        mode, indices = SEPARATE[len(vertices[0])], np.ravel(vertices)
    return Draw(
        vertex="ch02_basics/primitives.vert",
        fragment="ch02_basics/primitives.frag",
        mesh=Mesh(attributes={"aPos": ZIGZAG}, indices=indices, primitive=mode),
        uniforms={"size": SIZE},
        state=State(cell=cell(k, 3, 2), **(CLOCKWISE if k == 1 else {})),
    )


def drawn(name, *, spelt_out):
    """All six, by their modes or each primitive from vertices of its own."""
    target = Target(size=(3 * WIDE, 2 * HIGH), clear=(0.07, 0.08, 0.10, 1.0))
    draws = tuple(field(k, mode, spelt_out) for k, mode in enumerate(MODES))
    return Pass(name=name, target=target, draws=draws)


def by_number(gl_PrimitiveID):
    """From amber to blue, by the number of the primitive in its draw."""
    return vec4(mix(vec3(1.0, 0.72, 0.25), vec3(0.2, 0.45, 1.0), 0.2 * gl_PrimitiveID), 1.0)


def in_place(aPos):
    """Device coordinates as they are."""
    return vec4(aPos, 0.0, 1.0)


def counted(counter, k, name, **bounds):
    """What the driver counts while it draws field `k`."""
    return query(counter, draw=k, pass_name="modes", name=name, **bounds)


case = Case(
    title="Primitives",
    section="2.2.2",
    math=r"n \mapsto n,\ \tfrac{n}{2},\ n - 1 \text{ points and lines}, \qquad "
    r"n \mapsto \tfrac{n}{3},\ n - 2,\ n - 2 \text{ triangles}",
    passes=(drawn("spelt out", spelt_out=True), drawn("modes", spelt_out=False)),
    picture="modes.FragColor",
    rows=("points, lines, line strip", "triangles, strip, fan"),
    expect=[
        exact("modes.FragColor", Output("spelt out.FragColor"), name="the same, one by one"),
        *each_draw("modes.FragColor", by_number, enumerate(MODES)),
        formula("modes.gl_Position", in_place),
        *(
            counted("primitives_submitted", k, f"{mode}: primitives", equals=count)
            for k, (mode, (count, _)) in enumerate(MODES.items())
        ),
        counted("vertices_submitted", 1, "triangle_strip: vertices", equals=6),
        counted("samples_passed", 0, "triangles: half of the zigzag", equals=SQUARE),
        counted("samples_passed", 1, "triangle_strip: all of it", equals=2 * SQUARE),
        counted("samples_passed", 3, "points: squares of 12 × 12", equals=6 * 12 * 12),
    ],
)
