"""The eight stencil operations: how each changes the stored value, whichever test triggers it.

glStencilOp takes three of them: for a fragment that fails the stencil test, for one that passes it
and fails the depth test, and for one that passes both. INCR and DECR stop at 255 and 0, the forms
with WRAP wrap around; REPLACE stores the reference of glStencilFunc, INVERT flips every bit. Only
the bits of the write mask change.

Look at: the table. From bottom to top stand KEEP, ZERO, REPLACE (with 200), INCR, INCR_WRAP, DECR,
DECR_WRAP and INVERT; the three blocks are stencil test failed, depth test failed, both passed, and
in each the stored value was 0, 1, 90, 254 and 255. The blocks are alike: which of the three
operations is carried out depends on the tests, what it does never. The stored values are read with
the stencil test itself: eight draws, each let through by one bit and worth 1, 2, 4, … 128, add up.
"""

import numpy as np

from shaderlab import Blend, Case, Cell, Depth, Stencil, Variant, exact
from shaderlab.reference.depth_stencil import OPERATIONS, stencil_after

from ..scenes.panels import cell, panel, picture
from ..scenes.tables import edges_check, shown, shown_checks

NAMES = tuple(OPERATIONS)
FARES = ("fail", "depth_fail", "depth_pass")
STORED = (0, 1, 90, 254, 255)
REFERENCE = 200
COLUMNS, ROWS = len(FARES) * len(STORED), len(NAMES)
SIZE = (COLUMNS, ROWS)


def draw(worth, **state):
    """A draw over the whole table, or over the state's cell."""
    return panel("ch06_tests/count.frag", {}, {"worth": worth}, **state)


def unseen(**state):
    """A draw that leaves the colours alone; it would be seen if it did not."""
    return draw(1000.0, color_mask=(False,) * 4, **state)


def remember(column):
    """Store a column's value in all of its fields."""
    stencil = Stencil(reference=STORED[column % len(STORED)], depth_pass="replace")
    return unseen(stencil=stencil, cell=Cell(column=column, row=0, columns=COLUMNS, rows=1))


def change(k, write_mask):
    """One operation for a fragment that fares so; the two others would leave another value."""
    row, column = divmod(k, COLUMNS)
    fare, operation = FARES[column // len(STORED)], NAMES[row]
    decoy = "incr_wrap" if operation != "incr_wrap" else "decr_wrap"
    stencil = Stencil(
        func="never" if fare == "fail" else "always",
        reference=REFERENCE,
        write_mask=write_mask,
        **{name: operation if name == fare else decoy for name in FARES},
    )
    depth = Depth(func="never" if fare == "depth_fail" else "always")
    return unseen(stencil=stencil, depth=depth, cell=cell(k, *SIZE))


def read(bit):
    """Add a bit's worth wherever it is set."""
    stencil = Stencil(func="equal", reference=1 << bit, mask=1 << bit)
    return draw(float(1 << bit), stencil=stencil, blend=Blend(source="one", destination="one"))


def table(write_mask):
    """The passes of one table: the values, a pixel a field, and their picture."""
    draws = (
        *(remember(column) for column in range(COLUMNS)),
        *(change(k, write_mask) for k in range(COLUMNS * ROWS)),
        *(read(bit) for bit in range(8)),
    )
    formats = {"colors": {"total": "r32f"}, "depth": "depth24_stencil8"}
    group = {"group": float(len(STORED)), "whole": 255.0}
    return (
        picture(draws, SIZE, "table", **formats),
        *shown("numbers", "table.total", SIZE, (14, 12), **group),
    )


def holds(write_mask):
    """Every field is what the reference says of it."""
    rows = [
        [[stencil_after(name, stored, REFERENCE, write_mask)] for _ in FARES for stored in STORED]
        for name in NAMES
    ]
    name = "8 operations × 3 ways to fare × 5 stored values"
    return [exact("table.total", np.array(rows, np.float32), name=name)]


case = Case(
    title="The stencil operations",
    section="6.1.1",
    math=r"s' = (s \mathbin{\&} \lnot m) \mathbin{|} (\mathrm{op}(s, \mathit{ref}) "
    r"\mathbin{\&} m)",
    passes=table(0xFF),
    variants=[
        Variant("every bit", expect=[*holds(0xFF), edges_check("numbers")]),
        Variant("write mask 0x3C", passes=table(0x3C), expect=holds(0x3C)),
    ],
    picture="picture.FragColor",
    columns=("stencil test fails", "depth test fails", "both pass"),
    rows=[name.upper() for name in reversed(NAMES)],
    expect=shown_checks("numbers"),
)
