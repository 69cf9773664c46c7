"""Z-fighting: two surfaces so close that the depth buffer can't tell which is in front.

Where both get the same code, LESS keeps whichever came first. Here that is the wall behind, so each
of its pixels is wrong: of two walls d apart, with steps of Δz, the share 1 − d/Δz. A step is the
longer the closer the near plane is (see depth-precision), so the remedies are, in this order: move
the near plane out, take more bits, or push one surface's depth by an offset (glPolygonOffset),
which only hides the question. A 32-bit float depth buffer gains nothing here: F lies between ½ and
1, and there floats are no finer than 24 bits.

Look at: an orange wall right behind a teal one, slanting away to the right, in 16 bits of depth.
From left to right the near plane is at 0.01, at 0.1, and at 0.01 with a polygon offset of (−1, −1)
for the teal wall. Orange should be seen nowhere; the stripes are pairs of equal codes.

Try: in `ch06_tests/z_fighting.vert` write `aPos.y + 4.0 * aGap` for `aPos.y + aGap`: the walls are
two steps apart, and no stripe is left.
"""

from itertools import product

import numpy as np

from shaderlab import Case, any_order, both_ways, formula, measure, reading
from shaderlab.glslmath import swizzle, vec4
from shaderlab.reference.depth import same_code_share

from ..scenes.figures import figure
from ..scenes.panels import cell, picture
from ..scenes.two_walls import FAR, MIDDLE, ORANGE, SLANT, TEAL, two_walls

NEARS = (0.01, 0.1, 1.0)
BITS = {"depth16": 16, "depth24": 24, "depth32f": 24}
# Gaps, in steps of the depth buffer at the wall's middle. The smallest one with 24 bits is lost in
# the vertices themselves: both walls are the same, and every pixel shows the first.
STEPS = {16: (0.125, 0.5, 0.875, 2.0, 8.0), 24: (0.0001, 0.5, 1.0, 4.0, 16.0)}
ROWS = 5
SIZE = (640, 4 * ROWS)
# In slopes of the surface over one pixel, and in the smallest steps of depth. With 16 bits a slope
# of this wall is a fiftieth of a step, with 24 bits it is five of them.
OFFSETS = {"depth16": (0.0, -1.0), "depth24": (-1.0, 0.0), "depth32f": (-1.0, -1.0)}
# Codes that 32-bit arithmetic may misplace the two walls by: a vertex's depth is rounded in some
# operations on its way to the buffer, by 2^-24 of itself each. With 16 bits that is next to
# nothing, but softpipe steps along a row of pixels in fixed point: up to a tenth of a code.
ROUNDED = {16: 0.125, 24: 1.5}
# Each column of pixels is one trial whether two depths share a code: three standard deviations.
CHANCE = 3.0 * (0.25 / SIZE[0]) ** 0.5
CUT = -0.9  # where the wall in front begins, of −1 … 1


def step(near, bits):
    """A step of the depth buffer in the middle of the wall."""
    return MIDDLE * MIDDLE * (1.0 / near - 1.0 / FAR) / 2.0**bits


PANEL = 360  # pixels
RISE = 0.6
GAP = 0.5 * step(0.01, 16)


def gaps(near, bits):
    """The distances of the walls that are tried."""
    return [share * step(near, bits) for share in STEPS[bits]]


def name_of(format, near):
    """The pass of one depth format and near plane."""
    return f"{format}_{near:g}".replace(".", "")


def trials(format, near, offset=None, prefix=""):
    """A pass with a row for each gap."""
    draws = two_walls(near, gaps(near, BITS[format]), (-1.0, CUT, 1.0), offset)
    name, colors = prefix + name_of(format, near), {"winner": "r32f"}
    return picture(draws, SIZE, name, depth=format, colors=colors)


def panels():
    """The picture's panels, with a margin of the background around each."""
    for k, (near, offset) in enumerate(PANELS.values()):
        yield from two_walls(
            near, [GAP], (-0.9, -0.8, 0.9), offset, RISE, 0.9, cell(k, len(PANELS))
        )


def wrong_winners(winner, row):
    """The share of pixels that should show the wall in front and do not."""
    rows = SIZE[1] // ROWS
    front = winner[int(row) * rows : (int(row) + 1) * rows, SIZE[0] // 20 :]
    return (front != 1.0).mean()


def seen_behind(winner):
    """The share of the margin that shows the wall behind."""
    return (winner[:, : SIZE[0] // 20] == 2.0).mean()


def panel_of(winner, k):
    """The winners of one panel of the picture."""
    return winner[:, PANEL * int(k) : PANEL * (int(k) + 1)]


def orange(winner, k):
    """The share of a panel's front wall where the wall behind is seen."""
    edge = PANEL // 20
    return (panel_of(winner, k)[edge:-edge, 2 * edge : -edge] == 2.0).mean()


def orange_beside(winner, k):
    """The share of a panel's margin that shows the wall behind, and of the rest that does not."""
    edge, panel = PANEL // 20, panel_of(winner, k)
    behind = panel[edge:-edge, edge : 2 * edge] == 2.0
    rim = panel.copy()
    rim[edge:-edge, edge:-edge] = 0.0
    return behind.mean() - ((rim == 1.0) | (rim == 2.0)).mean()


def in_other_colors(color, winner):
    """Pixels of the picture in another colour than their winner's, or the background's."""
    walls = np.float32([(*TEAL, 1.0), (*ORANGE, 1.0)])
    wanted = np.where(winner == 1.0, walls[0], np.where(winner == 2.0, walls[1], np.float32(CLEAR)))
    return np.count_nonzero((color != wanted).any(axis=-1))


def equal_codes(gap, near, bits, middles, slant):
    """The share of equal codes of walls at these distances, less and more what rounding may do."""
    slack = ROUNDED[bits] * step(near, bits)
    for error in (slack, -slack):
        walls = [same_code_share(gap + error, z, slant, near, FAR, bits) for z in middles]
        yield np.mean(walls)


def allowed(near, bits, gap):
    """The share of equal codes, with what rounding may add or take away."""
    if gap < 0.001 * step(near, bits):
        return (1.0, 1.0)
    # What is counted begins where the wall in front is cut.
    middle, slant = MIDDLE + SLANT * (1.0 + CUT) / 2.0, SLANT * (1.0 - CUT) / 2.0
    low, high = equal_codes(gap, near, bits, [middle], slant)
    return (max(low - CHANCE, 0.0), min(high + CHANCE, 1.0))


def allowed_in_picture():
    """The same of the picture's first panel, whose walls also slant upward by RISE."""
    middles = MIDDLE + SLANT * (0.9 - 0.8) / 2.0 + RISE * np.linspace(-0.9, 0.9, 19)
    return tuple(equal_codes(GAP, 0.01, 16, middles, SLANT * (0.9 + 0.8) / 2.0))


def over_gaps(format, near, prefix="", **more):
    """Readings over the distance of the walls; only those with no offset show the wall behind."""
    for row, gap in enumerate(gaps(near, BITS[format])):
        bound = {} if prefix else {"between": allowed(near, BITS[format], gap)}
        winner = {"winner": f"{prefix}{name_of(format, near)}.winner"}
        yield reading(gap, reads=winner, given={"row": float(row)}, **bound, **more)


def clip(aPos, aGap, near, far, middle, slant, rise):
    """The corner of a wall in clip space."""
    z = middle + slant * swizzle(aPos, "x") + rise * swizzle(aPos, "y") + aGap
    depth = (far + near) / (far - near) * z - 2.0 * far * near / (far - near)
    return vec4(aPos * z, depth, z)


CLEAR = (0.93, 0.93, 0.91, 1.0)
PANELS = {"n = 0.01": (0.01, None), "n = 0.1": (0.1, None), "with an offset": (0.01, (-1.0, -1.0))}
SHOWN = {"winner": "picture.winner"}
ALL = tuple(product(BITS, NEARS))

case = Case(
    title="Z-fighting",
    section="6.2.3",
    math=r"\text{wrong} = \max\left(0,\ 1 - \frac{d}{\Delta z}\right), \qquad "
    r"\Delta z \approx \frac{z^2}{2^b}\left(\frac 1n - \frac 1f\right)",
    passes=(
        *(trials(format, near) for format, near in ALL),
        *(p for f in BITS for p in both_ways(trials(f, NEARS[0], OFFSETS[f], "offset_"))),
        picture(panels(), (PANEL * len(PANELS), PANEL), depth="depth16", clear=CLEAR),
    ),
    picture="picture.FragColor",
    columns=("n = 0.01", "n = 0.1", "n = 0.01, offset"),
    expect=[
        *(
            formula(f"{of}.gl_Position", clip, draw=draw, name=f"the {color} wall, {where}")
            for of, where in (("picture", "n = 0.01"), ("depth24_1", "n = 1"))
            for draw, color in enumerate(("orange", "teal"))
        ),
        figure(
            "picture.gl_Position",
            "a wall that slants twice as much",
            {"aPos": (1.0, 0.0), "aGap": 0.0, "near": 1.0, "slant": 2.0, "rise": 0.0},
            (12.0, 0.0, 10.2222, 12.0),
            digits=4,
            reference=clip,
            draw=0,
        ),
        measure(
            "pixels in another colour than their wall's",
            in_other_colors,
            reads={"color": "picture.FragColor", "winner": "picture.winner"},
            equals=0.0,
            digits=9,
        ),
        measure(
            "share of wrong winners",
            wrong_winners,
            readings=[r for f, n in ALL for r in over_gaps(f, n, series=f"{f}, n = {n:g}")],
            x_label="distance of the walls",
            y_label="share of pixels that show the wall behind",
            log_x=True,
        ),
        measure(
            "with a polygon offset",
            wrong_winners,
            # Where it is worst.
            readings=[r for f in BITS for r in over_gaps(f, NEARS[0], "offset_", series=f)],
            equals=0.0,
            digits=9,
            x_label="distance of the walls",
            log_x=True,
        ),
        *(any_order(f"offset_{name_of(format, NEARS[0])}.winner") for format in BITS),
        measure(
            "margin in which the wall behind is seen",
            seen_behind,
            readings=[
                *(
                    reading(f"{f}, n = {n:g}", reads={"winner": f"{name_of(f, n)}.winner"})
                    for f, n in ALL
                ),
                *(
                    reading(f"{f}, offset", reads={"winner": f"offset_{name_of(f, 0.01)}.winner"})
                    for f in BITS
                ),
            ],
            equals=1.0,
            digits=9,
        ),
        measure(
            "orange in the picture",
            orange,
            readings=[
                reading("n = 0.01", reads=SHOWN, given={"k": 0.0}, between=allowed_in_picture()),
                reading("n = 0.1", reads=SHOWN, given={"k": 1.0}, equals=0.0, digits=9),
                reading("with an offset", reads=SHOWN, given={"k": 2.0}, equals=0.0, digits=9),
            ],
        ),
        measure(
            "orange beside the teal wall",
            orange_beside,
            readings=[
                reading(name, reads=SHOWN, given={"k": float(k)}) for k, name in enumerate(PANELS)
            ],
            equals=1.0,
            digits=9,
        ),
    ],
)
