"""The eight depth functions: a fragment passes where `incoming func stored` holds.

Depth runs from 0 at the near plane to 1 at the far one, so LESS, the default, keeps what is nearer.
Two fragments of exactly the same depth are not rare: a surface that is drawn twice, once for each
light, needs EQUAL or LEQUAL to pass the second time.

Look at: the table. Its columns are NEVER, LESS, EQUAL, LEQUAL, GREATER, NOTEQUAL, GEQUAL and
ALWAYS; its rows, from the bottom, a fragment nearer than, equal to and farther than the stored
depth of ½. Each field is one draw: first the whole table in red, then one green field at a time,
which the depth test lets through or not.

Try: in `ch06_tests/count.frag` write `gl_FragDepth = 0.5; total = worth` for `total = worth`: all
fragments have the stored depth, and all rows are like the middle one.
"""

import numpy as np

from shaderlab import Case, Depth, exact
from shaderlab.reference.depth_stencil import FUNCTIONS, depth_passes

from ..scenes.panels import cell, panel, picture
from ..scenes.tables import edges_check, shown, shown_checks

STORED = 0.5
DEPTHS = (0.25, 0.5, 0.75)  # nearer, equal, farther
FIELDS = [(func, depth) for depth in DEPTHS for func in FUNCTIONS]
SIZE = (len(FUNCTIONS), len(DEPTHS))


def field(verdict, depth, func, **state):
    """A draw at one depth that writes `verdict` wherever the test lets it through."""
    state = {"depth": Depth(func=func), "depth_range": (depth, depth), **state}
    return panel("ch06_tests/count.frag", {}, {"worth": verdict}, **state)


stored = field(0.0, STORED, "always")
tests = [field(1.0, depth, func, cell=cell(k, *SIZE)) for k, (func, depth) in enumerate(FIELDS)]
truth = np.array([[[depth_passes(f, z, STORED)] for f in FUNCTIONS] for z in DEPTHS], np.float32)

case = Case(
    title="The depth functions",
    section="6.2.1",
    math=r"\text{pass} \iff z_{\text{incoming}}\ \mathit{func}\ z_{\text{stored}}",
    passes=(
        picture((stored, *tests), SIZE, "table", colors={"total": "r32f"}, depth="depth32f"),
        *shown("verdicts", "table.total", SIZE, (24, 24), group=SIZE),
    ),
    picture="picture.FragColor",
    columns=[name.upper() for name in FUNCTIONS],
    rows=("farther", "equal", "nearer"),
    expect=[
        exact("table.total", truth, name="8 functions × nearer, equal, farther"),
        *shown_checks("verdicts"),
        edges_check("verdicts"),
    ],
)
