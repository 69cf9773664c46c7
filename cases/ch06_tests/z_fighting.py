"""Z-fighting: two surfaces so close that the depth buffer can't tell which is in front.

Where both fall on the same code, LESS keeps whichever came first. Here that is the wall behind, so
each of its pixels is wrong: of two walls d apart, with steps of Δz, the share 1 − d/Δz. A step is
the longer the closer the near plane is (see depth-precision), so the remedies are, in this order:
move the near plane out, take more bits, or push one surface's depth by an offset (glPolygonOffset),
which only hides the question. A 32-bit float depth buffer gains nothing here: F lies between ½ and
1, and there floats are no finer than 24 bits.

Look at: an orange wall right behind a teal one, slanting away to the right, with 16 bits of depth.
From left to right the near plane is at 0.01, at 0.1, and at 0.01 with a polygon offset of (−1, −1)
for the teal wall. Orange should be seen nowhere; the stripes are pairs of equal codes.
"""

from itertools import product

from shaderlab import (
    Case,
    Cell,
    Depth,
    Draw,
    Mesh,
    Pass,
    State,
    Target,
    assets,
    formula,
    measure,
    reading,
)
from shaderlab.glslmath import swizzle, vec4
from shaderlab.reference.depth import same_code_share

FAR, MIDDLE, SLANT = 100.0, 10.0, 1.0
NEARS = (0.01, 0.1, 1.0)
BITS = {"depth16": 16, "depth24": 24, "depth32f": 24}
STEPS = (0.125, 0.5, 0.875, 2.0, 8.0)  # gaps, in steps of the depth buffer at the wall's middle
SIZE = (640, 4 * len(STEPS))
# Codes that 32-bit arithmetic may misplace the two walls by: a vertex's depth is rounded in some
# operations on its way to the buffer, by 2^-24 of itself each. With 16 bits that is next to
# nothing, but softpipe steps along a row of pixels in fixed point: up to a tenth of a code.
ROUNDED = {16: 0.125, 24: 4.0}
# Each column of pixels is one trial whether two depths share a code: three standard deviations.
CHANCE = 3.0 * (0.25 / SIZE[0]) ** 0.5
SQUARE = Mesh(**assets.quad(2.0)).only("aPos")
ORANGE, TEAL = (0.95, 0.55, 0.12), (0.10, 0.45, 0.50)


def wall(near, gap, cell, nearer, offset=None):
    """One of the two walls in one cell."""
    return Draw(
        vertex="ch06_tests/z_fighting.vert",
        fragment="ch06_tests/z_fighting.frag",
        mesh=SQUARE,
        uniforms={
            "near": near,
            "far": FAR,
            "middle": MIDDLE,
            "slant": SLANT,
            "gap": gap,
            "color": TEAL if nearer else ORANGE,
            "nearer": float(nearer),
        },
        state=State(depth=Depth(), cell=cell, polygon_offset=offset),
    )


def both(near, gap, cell, offset=None):
    """The wall behind, then the wall in front."""
    return (wall(near, gap, cell, False), wall(near, 0.0, cell, True, offset))


def step(near, bits):
    """A step of the depth buffer in the middle of the wall."""
    return MIDDLE * MIDDLE * (1.0 / near - 1.0 / FAR) / 2.0**bits


def gaps(near, bits):
    """The distances of the walls that are tried."""
    return [share * step(near, bits) for share in STEPS]


def name_of(format, near):
    """The pass of one depth format and near plane."""
    return f"{format}_{near:g}".replace(".", "")


def trials(format, near, offset=None, prefix=""):
    """A pass with a row for each gap."""
    rows = enumerate(gaps(near, BITS[format]))
    cells = [(Cell(column=0, row=k, columns=1, rows=len(STEPS)), gap) for k, gap in rows]
    return Pass(
        name=prefix + name_of(format, near),
        target=Target(size=SIZE, depth=format, colors={"winner": "r32f"}),
        draws=tuple(draw for cell, gap in cells for draw in both(near, gap, cell, offset)),
    )


def wrong_winners(winner, row):
    """The share of pixels that show the wall behind."""
    rows = SIZE[1] // len(STEPS)
    return (winner[int(row) * rows : (int(row) + 1) * rows] == 0.0).mean()


def allowed(near, bits, gap):
    """The share of equal codes, with what rounding may add or take away."""
    slack = ROUNDED[bits] * step(near, bits)
    low, high = (
        same_code_share(gap + error, MIDDLE, SLANT, near, FAR, bits) for error in (slack, -slack)
    )
    return (max(low - CHANCE, 0.0), min(high + CHANCE, 1.0))


def curve(format, near):
    """Readings over the distance of the walls, for one depth format and near plane."""
    bits = BITS[format]
    for row, gap in enumerate(gaps(near, bits)):
        yield reading(
            gap,
            reads={"winner": f"{name_of(format, near)}.winner"},
            given={"row": float(row)},
            between=allowed(near, bits, gap),
            series=f"{format}, n = {near:g}",
        )


def mended(format):
    """Readings with a polygon offset, where it is worst."""
    for row, gap in enumerate(gaps(NEARS[0], BITS[format])):
        yield reading(
            gap,
            reads={"winner": f"offset_{name_of(format, NEARS[0])}.winner"},
            given={"row": float(row)},
            series=format,
        )


def clip(aPos, near, far, middle, slant, gap):
    """The corner of a wall in clip space."""
    z = middle + slant * swizzle(aPos, "x") + gap
    depth = (far + near) / (far - near) * z - 2.0 * far * near / (far - near)
    return vec4(swizzle(aPos, "xy") * z, depth, z)


def one_color(color):
    """A wall's colour."""
    return vec4(color, 1.0)


PANELS = ((0.01, None), (0.1, None), (0.01, (-1.0, -1.0)))
GAP = 0.5 * step(0.01, 16)
ALL = tuple(product(BITS, NEARS))

case = Case(
    title="Z-fighting",
    section="6.2.3",
    math=r"\text{wrong} = \max\left(0,\ 1 - \frac{d}{\Delta z}\right), \qquad "
    r"\Delta z \approx \frac{z^2}{2^b}\left(\frac 1n - \frac 1f\right)",
    passes=(
        *(trials(format, near) for format, near in ALL),
        *(trials(format, NEARS[0], (-1.0, -1.0), "offset_") for format in BITS),
        Pass(
            name="picture",
            target=Target(size=(1080, 360), depth="depth16"),
            draws=tuple(
                draw
                for k, (near, offset) in enumerate(PANELS)
                for draw in both(near, GAP, Cell(column=k, row=0, columns=3, rows=1), offset)
            ),
        ),
    ),
    picture="picture.FragColor",
    expect=[
        formula("picture.gl_Position", clip, name="the teal wall"),
        formula("picture.gl_Position", clip, draw=0, name="the orange wall"),
        formula("picture.FragColor", one_color),
        measure(
            "share of wrong winners",
            wrong_winners,
            readings=[r for format, near in ALL for r in curve(format, near)],
            x_label="distance of the walls",
            y_label="share of pixels that show the wall behind",
            log_x=True,
        ),
        measure(
            "with a polygon offset",
            wrong_winners,
            readings=[r for format in BITS for r in mended(format)],
            equals=0.0,
            digits=9,
            x_label="distance of the walls",
            log_x=True,
        ),
        formula("picture.FragColor", one_color, draw=0, name="what is seen of the orange wall"),
    ],
)
