"""The depth mask: with glDepthMask(GL_FALSE) the depth buffer is read but not written.

The depth function decides whether a fragment is drawn; function and mask together decide whether
its depth is kept. Transparent objects need a depth buffer that is only read: they are hidden by
what is in front of them and hide nothing themselves. Turning the depth test off is not the same as
ALWAYS: without the test nothing is written, whatever the mask says.

Look at: the table of what the depth buffer holds in the end, in hundredths; before, it held 50. Its
columns are NEVER, LESS, EQUAL, LEQUAL, GREATER, NOTEQUAL, GEQUAL, ALWAYS, and last the test turned
off; its rows, from the bottom, a fragment at 25, 50 and 75 with the mask closed, then the same
three with the mask open. The lower half never changes.
"""

import numpy as np

from shaderlab import Blend, Case, Depth, Pass, Target, exact
from shaderlab.reference.depth_stencil import FUNCTIONS, depth_after, depth_passes

from ..scenes.panels import cell, panel
from ..scenes.tables import all_figures, edges_check, shown, shown_check, shown_checks

STORED = 0.5
DEPTHS = (0.25, 0.5, 0.75)  # exact in a depth buffer of 32-bit floats
FUNCS = (*FUNCTIONS, None)
FIELDS = [(write, depth) for write in (False, True) for depth in DEPTHS]
COLUMNS, ROWS = len(FUNCS), len(FIELDS)
ADDED = Blend(source="one", destination="one")


def draw(worth, **state):
    """A draw over the state's cell, or over the whole table."""
    return panel("ch06_tests/count.frag", {}, {"worth": worth}, **state)


def tried(column, row):
    """One fragment in its field, counted where it is drawn."""
    write, depth = FIELDS[row]
    func = FUNCS[column]
    test = None if func is None else Depth(func=func, write=write)
    place = cell(row * COLUMNS + column, COLUMNS, ROWS)
    return draw(1.0, depth=test, cell=place, depth_range=(depth, depth))


def found(depth):
    """Adds up a depth, in hundredths, wherever it is the stored one."""
    test = Depth(func="equal", write=False)
    return draw(100.0 * depth, depth=test, depth_range=(depth, depth), blend=ADDED)


fields = [tried(column, row) for row in range(ROWS) for column in range(COLUMNS)]
target = Target(
    size=(COLUMNS, ROWS), colors={"total": "r32f"}, depth="depth32f", clear_depth=STORED
)
wiped = draw(0.0, blend=Blend(source="zero", destination="zero"))

case = Case(
    title="The depth mask",
    section="6.2.1",
    math=r"z' = \begin{cases} z_{\text{incoming}} & \text{test on, passed, mask open} \\ "
    r"z_{\text{stored}} & \text{otherwise} \end{cases}",
    passes=(
        Pass(name="drawn", target=target, draws=tuple(fields)),
        # The same fragments; then the colours are wiped out, and the depths written instead.
        Pass(
            name="kept", target=target, draws=(*fields, wiped, *(found(depth) for depth in DEPTHS))
        ),
        *shown("numbers", "kept.total", (COLUMNS, ROWS), (20, 14), group=3.0, whole=100.0),
        all_figures(),
    ),
    picture="picture.FragColor",
    columns=[*(name.upper() for name in FUNCTIONS), "test off"],
    rows=[f"{d}, mask {m}" for m in ("open", "closed") for d in (75, 50, 25)],
    expect=[
        *shown_checks("numbers"),
        shown_check("numbers", "figures", "figures that the table has not"),
        edges_check("numbers", "figures"),
        exact(
            "drawn.total",
            np.array(
                [
                    [[1.0 if f is None else depth_passes(f, z, STORED)] for f in FUNCS]
                    for _, z in FIELDS
                ],
                np.float32,
            ),
            name="what is drawn: the mask has no say",
        ),
        exact(
            "kept.total",
            np.array(
                [
                    [[100.0 * depth_after(f, write, z, STORED)] for f in FUNCS]
                    for write, z in FIELDS
                ],
                np.float32,
            ),
            name="what the depth buffer holds: 9 tests × 3 depths × mask closed, open",
        ),
    ],
)
