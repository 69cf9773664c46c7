"""The eight stencil functions: pass where `(reference & mask) func (stored & mask)` holds.

Reference and mask come from glStencilFunc, the stored value from the buffer, and the mask is
applied to both before they are compared. A mask of 0 therefore does not switch the test off: it
compares 0 with 0, which EQUAL, LEQUAL, GEQUAL and ALWAYS pass and the other four do not.

Look at: the table, exhaustive over two bits, each at both ends of a byte. From left to right stand
NEVER, LESS, EQUAL, LEQUAL, GREATER, NOTEQUAL, GEQUAL and ALWAYS, from bottom to top four masks. In
each block of 4 × 4 fields the stored value grows to the right and the reference upward: with the
full mask LESS is a triangle and EQUAL the diagonal.
"""

import numpy as np

from shaderlab import Case, Cell, Erratum, Stencil, exact
from shaderlab.engine.expectations.gl_call import call
from shaderlab.reference.depth_stencil import FUNCTIONS, stencil_passes

from ..scenes.api import answers
from ..scenes.objects import depth_alone
from ..scenes.panels import cell, panel, picture
from ..scenes.tables import edges_check, shown, shown_checks

# References, stored values and masks: all there are in two bits, at both ends of a byte.
VALUES = [0b00000000, 0b01000001, 0b10000010, 0b11000011]
FUNCS = tuple(FUNCTIONS)
COLUMNS, ROWS = 4 * len(FUNCS), 4 * 4
FORMATS = {"colors": {"total": "r32f"}, "depth": "depth24_stencil8", "clear_stencil": VALUES[3]}


def strip(verdict, stencil, at):
    """A draw over a strip of fields that writes `verdict` where the stencil test passes."""
    return panel("ch06_tests/count.frag", {}, {"worth": verdict}, stencil=stencil, cell=at)


# First every column gets its stored value, but for the one that the buffer is cleared to; then each
# function, mask and reference draws one row of its block in green, over all four at once.
stored = [
    strip(0.0, Stencil(reference=value, depth_pass="replace"), cell(column, COLUMNS))
    for column, value in enumerate(VALUES * len(FUNCS))
    if value != FORMATS["clear_stencil"]
]
tests = [
    strip(
        1.0,
        Stencil(func=func, reference=VALUES[row % 4], mask=VALUES[row // 4]),
        Cell(column=block, row=row, columns=len(FUNCS), rows=ROWS),
    )
    for block, func in enumerate(FUNCS)
    for row in range(ROWS)
]


def passes(column, row):
    """What the reference says of one field of the table."""
    reference, stored_value, mask = VALUES[row % 4], VALUES[column % 4], VALUES[row // 4]
    return stencil_passes(FUNCS[column // 4], reference, stored_value, mask)


# A buffer of zeros, in it a frame of ones: the middle of 9 × 9 pixels without its own middle.
frame = [
    strip(0.0, Stencil(reference=1, depth_pass="replace"), cell(4, 3, 3)),
    strip(0.0, Stencil(reference=0, depth_pass="replace"), cell(40, 9, 9)),
    strip(1.0, Stencil(func="equal", reference=1), cell(0, 1, 1)),
]
hollow = np.pad(np.pad([[0.0]], 1, constant_values=1.0), 3).astype(np.float32)
STENCIL = call("glReadPixels", 0, 0, 1, 1, "GL_STENCIL_INDEX", "GL_UNSIGNED_BYTE")
ATTACHED = depth_alone("GL_DEPTH24_STENCIL8", "GL_DEPTH_STENCIL_ATTACHMENT")


FIVE, ZERO = (
    (call("glClearStencil", value), call("glClear", "GL_STENCIL_BUFFER_BIT")) for value in (5, 0)
)
truth = np.array([[[passes(c, r)] for c in range(COLUMNS)] for r in range(ROWS)], np.float32)

case = Case(
    title="The stencil functions",
    section="6.1.1",
    math=r"\text{pass} \iff (\mathit{ref} \mathbin{\&} \mathit{mask})\ \mathit{func}\ "
    r"(\mathit{stored} \mathbin{\&} \mathit{mask})",
    passes=(
        picture((*stored, *tests), (COLUMNS, ROWS), "table", **FORMATS),
        picture(frame, (9, 9), "hollow", **{**FORMATS, "clear_stencil": 0}),
        *shown("verdicts", "table.total", (COLUMNS, ROWS), (8, 8), group=(4.0, 4.0)),
    ),
    picture="picture.FragColor",
    columns=[name.upper() for name in FUNCS],
    rows=[f"mask {mask:#04x}" for mask in reversed(VALUES)],
    expect=[
        exact("table.total", truth, name="8 functions × 4 references × 4 stored × 4 masks"),
        exact("hollow.total", hollow, name="a hollow rectangle: only where a 1 is stored"),
        *answers(
            {
                "glClear stores glClearStencil's value": (STENCIL, 5, ATTACHED, FIVE),
                "… the last one": (STENCIL, 0, ATTACHED, FIVE, ZERO),
            }
        ),
        *shown_checks("verdicts"),
        edges_check("verdicts"),
    ],
    errata=[
        Erratum(
            section="6.1.1",
            says="a mask of 0 switches the stencil test off",
            truth="0 is compared with 0: EQUAL, LEQUAL, GEQUAL and ALWAYS pass, the others fail",
            proof="8 functions × 4 references × 4 stored × 4 masks",
        )
    ],
)
