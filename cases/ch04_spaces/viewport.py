"""The viewport: from −1…1 to pixels, and from −1…1 to a depth.

The last step is the hardware's: half the width times x, plus the middle of the rectangle, and so on
up; depth goes from −1…1 to the depth range, 0…1 unless told otherwise. Device coordinates know
nothing of pixels: a projection with another aspect than the viewport's makes all circles oval.

Look at: one and the same square of device coordinates in six viewports. Lines stand every quarter,
the dark cross is x = 0 and y = 0, and the gold disc lies around (½, −½) in each of them: three
quarters of the way to the right, one quarter up, whatever the rectangle; round only where that is a
square.
"""

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Draw,
    Mesh,
    Pass,
    Pixel,
    Ramp,
    State,
    Target,
    computed,
    coverage,
    formula,
    fullscreen,
    value,
)
from shaderlab.glslmath import abs, dot, fract, min, swizzle, vec3, vec4, where
from shaderlab.reference.spaces import window
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.studio import softened

SQUARE = Mesh(
    attributes={"aPos": np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float)},
    indices=np.array([0, 1, 2, 0, 2, 3]),
)
LARGE = (10, 20, 640, 480)
NOTES = {"viewport": LARGE, "depthRange": (0.0, 1.0)}
CELLS = (
    Cell(column=0, row=0, columns=2, rows=1),
    Cell(column=1, row=1, columns=2, rows=2),
    *(Cell(column=k, row=0, columns=8, rows=2) for k in (4, 5)),
    *(Cell(column=3, row=k, columns=4, rows=4) for k in (0, 1)),
)


def filled(cell, mesh=SQUARE):
    """The square of device coordinates in one viewport."""
    return Draw(
        vertex="ch04_spaces/viewport.vert",
        fragment="ch04_spaces/viewport.frag",
        mesh=mesh,
        uniforms=NOTES,
        state=State(cell=cell),
    )


# A patch of 4 × 3 pixels of the notes' viewport, whose lower left corner is (½, −½); flat at 0.2.
PATCH = Mesh(
    attributes={
        "aPos": np.array(
            [(0.5, -0.5, 0.2), (0.5125, -0.5, 0.2), (0.5125, -0.4875, 0.2), (0.5, -0.4875, 0.2)]
        )
    },
    indices=np.array([0, 1, 2, 0, 2, 3]),
)


def patch(name, viewport, depths=(0.0, 1.0)):
    """The patch in a viewport and a depth range of the hardware's own. The viewport reaches beyond
    the window, and only what lies in both is seen."""
    draw = Draw(
        vertex="ch04_spaces/viewport.vert",
        fragment="ch04_spaces/viewport.frag",
        mesh=PATCH,
        uniforms={"viewport": viewport, "depthRange": depths},
        state=State(viewport=viewport, depth_range=depths),
    )
    return Pass(name=name, target=Target(size=(512, 256), depth="depth24"), draws=(draw,))


def closeup(name, corner, side):
    """A part of the square, far enlarged."""
    (drawn,) = fullscreen(
        "ch04_spaces/viewport.frag",
        name=name,
        domain={"Ndc": Ramp((*corner, 0.0), (side, 0.0, 0.0), (0.0, side, 0.0))},
        target=Target(size=(96, 96)),
    )
    return drawn


def by_hand(aPos, viewport, depthRange):
    """The window coordinates that the vertex shader works out."""
    return window(aPos, viewport, depthRange)


def same_place(aPos):
    """The mesh is in device coordinates from the start."""
    return aPos


def clip(aPos):
    """With w = 1, device coordinates are clip coordinates."""
    return vec4(aPos, 1.0)


def chart(Ndc):
    """The picture: a colour for each place, lines every quarter, the axes, and the disc."""
    x, y = swizzle(Ndc, "x"), swizzle(Ndc, "y")
    across, up = 0.5 * x + 0.5, 0.5 * y + 0.5
    color = vec3(0.25 + 0.5 * across, 0.55 - 0.2 * across, 0.45 + 0.3 * up)
    field = abs(fract(4.0 * swizzle(Ndc, "xy") + 0.5) - 0.5)
    color = color * where(min(swizzle(field, "x"), swizzle(field, "y")) < 0.03, 0.75, 1.0)
    color = color * where(min(abs(x), abs(y)) < 0.012, 0.4, 1.0)
    off = swizzle(Ndc, "xy") - np.array([0.5, -0.5])
    return vec4(where(dot(off, off) < 0.0064, vec3(1.0, 0.85, 0.2), color), 1.0)


def where_it_is(frag_coord):
    """gl_FragCoord's first three."""
    return swizzle(frag_coord, "xyz")


def at(place, equals, name, **changes):
    """One place's window coordinates."""
    return value(
        "judged.Window",
        at={"aPos": place, **NOTES, **changes},
        equals=equals,
        digits=6,
        reference=by_hand,
        name=name,
    )


def landing(x, y, equals, name, into="patch"):
    """What a pixel of the window holds: its own place and depth, or nothing."""
    return value(f"{into}.landed", at=Pixel(x, y), equals=equals, digits=6, name=name)


case = Case(
    title="The viewport",
    section="4.5",
    math=r"\begin{pmatrix} x_w \\ y_w \\ z_w \end{pmatrix} = \begin{pmatrix} \frac w2\,x_n + x + "
    r"\frac w2 \\ \frac h2\,y_n + y + \frac h2 \\ \frac{f - n}2\,z_n + \frac{n + f}2 \end{pmatrix}",
    passes=(
        *stage.photographed(
            [filled(cell) for cell in CELLS], (960, 480), clear=(0.93, 0.93, 0.92, 1)
        ),
        closeup("chart", (-0.06, -0.06), 0.36),
        closeup("disc", (0.41, -0.59), 0.18),
        patch("patch", LARGE),
        patch("middle", (-10, -20, 640, 480), (0.25, 0.75)),
        patch("turned", (-10, -20, 640, 480), (1.0, 0.0)),
    ),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        formula("judged.Window", by_hand),
        formula("judged.Ndc", same_place),
        formula("judged.gl_Position", clip),
        *(
            formula("judged.FragColor", chart, draw=k, name=f"viewport {k + 1} of {len(CELLS)}")
            for k in range(len(CELLS))
        ),
        formula("chart.FragColor", chart, name="axes and lines from near by"),
        formula("disc.FragColor", chart, name="the disc from near by"),
        formula("judged.landed", where_it_is),
        at(
            (0.5, -0.5, 0.2), (490.0, 140.0, 0.6), "(½, −½, 0.2) in the viewport (10, 20, 640, 480)"
        ),
        at((-1.0, -1.0, -1.0), (10.0, 20.0, 0.0), "lower left corner, near"),
        at((1.0, 1.0, 1.0), (650.0, 500.0, 1.0), "upper right corner, far"),
        at((0.5, -0.5, 0.2), (490.0, 140.0, 0.55), "depth range ¼ … ¾", depthRange=(0.25, 0.75)),
        at((0.5, -0.5, -1.0), (490.0, 140.0, 1.0), "depth range 1 … 0", depthRange=(1.0, 0.0)),
        coverage(12, pass_name="patch", name="the patch covers 4 × 3 pixels"),
        landing(490, 140, (490.5, 140.5, 0.6), "the patch's first pixel"),
        landing(493, 142, (493.5, 142.5, 0.6), "its last pixel"),
        landing(489, 140, (0.0, 0.0, 0.0), "one pixel to the left"),
        landing(490, 139, (0.0, 0.0, 0.0), "one pixel below"),
        landing(494, 142, (0.0, 0.0, 0.0), "one pixel to the right"),
        landing(493, 143, (0.0, 0.0, 0.0), "one pixel above"),
        landing(470, 100, (470.5, 100.5, 0.55), "in the depth range ¼ … ¾", "middle"),
        landing(470, 100, (470.5, 100.5, 0.4), "in the depth range 1 … 0", "turned"),
        coverage(12, pass_name="middle", name="a viewport may reach beyond the window"),
        computed(
            "(½, −½, 0.2) in the viewport (10, 20, 640, 480), in float64",
            lambda: window(
                np.array([0.5, -0.5, 0.2]), np.array([10, 20, 640, 480]), np.array([0, 1])
            ),
            equals=(490.0, 140.0, 0.6),
            digits=9,
        ),
    ],
)
