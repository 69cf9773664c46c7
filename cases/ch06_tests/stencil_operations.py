"""The eight stencil operations: what becomes of the stored value, for each way a fragment can fare.

glStencilOp takes three of them: for a fragment that fails the stencil test, for one that passes it
and fails the depth test, and for one that passes both. INCR and DECR stop at 255 and 0, the forms
with WRAP go round; REPLACE stores the reference of glStencilFunc, INVERT turns every bit over. Only
the bits of the write mask change.

Look at: the table. From bottom to top stand KEEP, ZERO, REPLACE (with 200), INCR, INCR_WRAP, DECR,
DECR_WRAP and INVERT; the three blocks are stencil test failed, depth test failed, both passed, and
in each the stored value was 0, 1, 90, 254 and 255. The blocks are alike: which of the three
operations is carried out depends on the tests, what it does never. The stored values are read with
the stencil test itself: eight draws, each let through by one bit and worth 1, 2, 4, … 128, add up.
"""

import numpy as np

from shaderlab import (
    Blend,
    Case,
    Cell,
    Depth,
    Draw,
    Output,
    Pass,
    Ramp,
    State,
    Stencil,
    Target,
    Variant,
    exact,
)
from shaderlab.reference.depth_stencil import OPERATIONS, stencil_after

NAMES = tuple(OPERATIONS)
FARES = ("fail", "depth_fail", "depth_pass")
STORED = (0, 1, 90, 254, 255)
REFERENCE = 200
COLUMNS, ROWS = len(FARES) * len(STORED), len(NAMES)
NOTHING = (False,) * 4


def draw(state, worth=0.0):
    """A draw over the whole table, or over the state's cell."""
    return Draw(fragment="ch06_tests/count.frag", domain={}, uniforms={"worth": worth}, state=state)


def remember(column):
    """Store a column's value in all of its fields."""
    stencil = Stencil(reference=STORED[column % len(STORED)], depth_pass="replace")
    cell = Cell(column=column, row=0, columns=COLUMNS, rows=1)
    return draw(State(stencil=stencil, cell=cell, color_mask=NOTHING))


def change(column, row, write_mask):
    """One operation for a fragment that fares so; the two others would leave another value."""
    fare, operation = FARES[column // len(STORED)], NAMES[row]
    decoy = "incr_wrap" if operation != "incr_wrap" else "decr_wrap"
    stencil = Stencil(
        func="never" if fare == "fail" else "always",
        reference=REFERENCE,
        write_mask=write_mask,
        **{name: operation if name == fare else decoy for name in FARES},
    )
    depth = Depth(func="never" if fare == "depth_fail" else "always")
    cell = Cell(column=column, row=row, columns=COLUMNS, rows=ROWS)
    return draw(State(stencil=stencil, depth=depth, cell=cell, color_mask=NOTHING))


def read(bit):
    """Add a bit's worth wherever it is set."""
    stencil = Stencil(func="equal", reference=1 << bit, mask=1 << bit)
    return draw(
        State(stencil=stencil, blend=Blend(source="one", destination="one")), float(1 << bit)
    )


def table(write_mask):
    """The passes of one table: the values, a pixel a field, and their picture."""
    fields = [(column, row) for row in range(ROWS) for column in range(COLUMNS)]
    values = Pass(
        name="table",
        target=Target(size=(COLUMNS, ROWS), colors={"total": "r32f"}, depth="depth24_stencil8"),
        draws=(
            *(remember(column) for column in range(COLUMNS)),
            *(change(*field, write_mask) for field in fields),
            *(read(bit) for bit in range(8)),
        ),
    )
    picture = Draw(
        fragment="ch06_tests/numbers.frag",
        domain={"place": Ramp((0.0, 0.0), (COLUMNS, 0.0), (0.0, ROWS))},
        uniforms={"group": float(len(STORED)), "whole": 255.0},
        textures={"values": Output("table", "total")},
    )
    return (values, Pass(name="picture", target=Target(size=(960, 384)), draws=(picture,)))


def truth(write_mask):
    """What the reference says of every field."""
    return np.array(
        [
            [
                [stencil_after(name, stored, REFERENCE, write_mask)]
                for _ in FARES
                for stored in STORED
            ]
            for name in NAMES
        ],
        np.float32,
    )


EVERY = "8 operations × 3 ways to fare × 5 stored values"

case = Case(
    title="The stencil operations",
    section="6.1.1",
    math=r"s' = (s \mathbin{\&} \lnot m) \mathbin{|} (\mathrm{op}(s, \mathit{ref}) "
    r"\mathbin{\&} m)",
    passes=table(0xFF),
    variants=[
        Variant("every bit", expect=[exact("table.total", truth(0xFF), name=EVERY)]),
        Variant(
            "write mask 0x3C",
            passes=table(0x3C),
            expect=[exact("table.total", truth(0x3C), name=EVERY)],
        ),
    ],
    expect=[],
)
