"""The eight depth functions: a fragment passes where `incoming func stored` holds.

Depth runs from 0 at the near plane to 1 at the far one, so LESS, the default, keeps what is
nearer. Two fragments of the very same depth are no rare accident: draw a surface twice, once for
each light, and it takes EQUAL or LEQUAL to let the second time through.

Look at: the table. Its columns are NEVER, LESS, EQUAL, LEQUAL, GREATER, NOTEQUAL, GEQUAL and
ALWAYS; its rows, from the bottom, a fragment nearer than, equal to and farther than the stored
depth of ½. Each field is one draw: first the whole table in red, then one green field at a time,
which the depth test lets through or not.
"""

import numpy as np

from shaderlab import Case, Cell, Depth, Draw, Mesh, Pass, State, Target, assets, exact
from shaderlab.reference.depth_stencil import FUNCTIONS, depth_passes

NEARER, EQUAL, FARTHER = -0.5, 0.0, 0.5  # z in device coordinates: 0 is a depth of ½
DEPTHS = (NEARER, EQUAL, FARTHER)
COLUMNS, ROWS = len(FUNCTIONS), len(DEPTHS)

SQUARE = Mesh(**assets.quad()).only("aPos")


def field(depth, verdict, state, fields=(1, 1)):
    """A draw that writes `verdict` wherever the state lets it through."""
    return Draw(
        vertex="ch06_tests/truth_table.vert",
        fragment="ch06_tests/truth_table.frag",
        mesh=SQUARE,
        uniforms={"depth": depth, "fields": fields, "verdict": verdict, "block": 72.0},
        state=state,
    )


stored = field(EQUAL, 0.0, State(depth=Depth(func="always")), fields=(COLUMNS, ROWS))
tests = [
    field(
        depth,
        1.0,
        State(
            depth=Depth(func=func), cell=Cell(column=column, row=row, columns=COLUMNS, rows=ROWS)
        ),
    )
    for column, func in enumerate(FUNCTIONS)
    for row, depth in enumerate(DEPTHS)
]
truth = np.array([[[depth_passes(f, z, EQUAL)] for f in FUNCTIONS] for z in DEPTHS], np.float32)

case = Case(
    title="The depth functions",
    section="6.2.1",
    math=r"\text{pass} \iff z_{\text{incoming}}\ \mathit{func}\ z_{\text{stored}}",
    passes=(Pass(target=Target(size=(576, 216), depth="depth24"), draws=(stored, *tests)),),
    expect=[exact("passed", truth, name="8 functions × nearer, equal, farther")],
)
