"""The viewport: from −1…1 to pixels, and from −1…1 to a depth.

The last step is the hardware's: half the width times x plus the middle of the rectangle, and
likewise for y; depth goes from −1…1 to the depth range, by default 0…1. Device coordinates know
nothing of pixels: a projection with another aspect than the viewport's makes all circles oval.

Look at: one and the same square of device coordinates in six viewports. Lines stand every quarter,
the dark cross is x = 0 and y = 0, and the gold disc lies around (½, −½) in each of them: three
quarters of the way to the right, one quarter up, whatever the rectangle; round only where that is a
square.

Try: in `ch04_spaces/viewport.vert` write `vec4(aPos, 2.0)` for `vec4(aPos, 1.0)`: w halves the
square around the centre of each viewport.
"""

import numpy as np

from shaderlab import Case, Cell, Draw, Mesh, Pixel, Ramp, State, boundaries, coverage, formula
from shaderlab.glslmath import abs, dot, fract, min, swizzle, vec3, vec4, where
from shaderlab.reference.spaces import window

from ..scenes import stage
from ..scenes.figures import each_draw, figure, figures, results
from ..scenes.laws import device_place, unchanged
from ..scenes.panels import panel, picture

LARGE = (10, 20, 640, 480)
OFF_CENTRE = {"viewport": LARGE, "depthRange": (0.0, 1.0)}
BEYOND = (-10, -20, 640, 480)
CELLS = (
    Cell(column=0, row=0, columns=2, rows=1),
    Cell(column=1, row=1, columns=2, rows=2),
    *(Cell(column=k, row=0, columns=8, rows=2) for k in (4, 5)),
    *(Cell(column=3, row=k, columns=4, rows=4) for k in (0, 1)),
)


def rectangle(*corners):
    """A rectangle of device coordinates."""
    return Mesh(attributes={"aPos": np.array(corners, float)}, indices=np.array([0, 1, 2, 0, 2, 3]))


SQUARE = rectangle((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))
# A patch of 4 × 3 pixels of that viewport, whose lower left corner is (½, −½); flat at 0.2.
PATCH = rectangle(
    (0.5, -0.5, 0.2), (0.5125, -0.5, 0.2), (0.5125, -0.4875, 0.2), (0.5, -0.4875, 0.2)
)


def filled(mesh, state, uniforms=OFF_CENTRE):
    """A rectangle in one viewport."""
    return Draw(
        vertex="ch04_spaces/viewport.vert",
        fragment="ch04_spaces/viewport.frag",
        mesh=mesh,
        uniforms=uniforms,
        state=state,
    )


def patch(name, viewport, depths=(0.0, 1.0)):
    """The patch in a viewport and a depth range of the hardware's own. The viewport reaches beyond
    the window, and only what lies in both is seen."""
    state = State(viewport=viewport, depth_range=depths)
    draw = filled(PATCH, state, {"viewport": viewport, "depthRange": depths})
    return picture([draw], (512, 256), name, depth="depth24")


def closeup(name, corner, side):
    """A part of the square, far enlarged."""
    domain = {"Ndc": Ramp((*corner, 0.0), (side, 0.0, 0.0), (0.0, side, 0.0))}
    draw = panel("ch04_spaces/viewport.frag", domain)
    return picture([draw], (96, 96), name)


def by_hand(aPos, viewport, depthRange):
    """The window coordinates that the vertex shader works out."""
    return window(aPos, viewport, depthRange)


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


PLACE = {"aPos": (0.5, -0.5, 0.2)}
NEAR, FAR = {"aPos": (0.5, -0.5, -1.0)}, {"aPos": (1.0, 1.0, 1.0)}
NOTHING, THERE = (0.0, 0.0, 0.0), Pixel(470, 100)
OFF_CENTRE_PLACE = "(½, −½, 0.2) in the viewport (10, 20, 640, 480)"
IN_FLOAT64 = window(np.array(PLACE["aPos"]), np.array(LARGE), np.array([0, 1]))
VIEWPORTS = {k: k + 1 for k in range(len(CELLS))}

case = Case(
    title="The viewport",
    section="4.5",
    math=r"\begin{pmatrix} x_w \\ y_w \\ z_w \end{pmatrix} = \begin{pmatrix} \frac w2\,x_n + x + "
    r"\frac w2 \\ \frac h2\,y_n + y + \frac h2 \\ \frac{f - n}2\,z_n + \frac{n + f}2 \end{pmatrix}",
    passes=(
        *stage.photographed(
            [filled(SQUARE, State(cell=cell)) for cell in CELLS],
            (960, 480),
            clear=(0.93, 0.93, 0.92, 1),
        ),
        closeup("chart", (-0.06, -0.06), 0.36),
        closeup("disc", (0.41, -0.59), 0.18),
        patch("patch", LARGE),
        patch("middle", BEYOND, (0.25, 0.75)),
        patch("turned", BEYOND, (1.0, 0.0)),
    ),
    picture="picture.FragColor",
    expect=[
        *stage.picture_checks("landed"),
        formula("judged.Window", by_hand),
        formula("judged.Ndc", unchanged("aPos")),
        formula("judged.gl_Position", device_place),
        *each_draw("judged.FragColor", chart, VIEWPORTS, "viewport {} of 6"),
        formula("chart.FragColor", chart, name="axes and lines from near by"),
        formula("disc.FragColor", chart, name="the disc from near by"),
        *(
            boundaries("judged.FragColor", chart, draw=k, name=f"… at its edges, viewport {k + 1}")
            for k in (0, 1)
        ),
        boundaries("disc.FragColor", chart, name="the disc's edge"),
        boundaries("chart.FragColor", chart, name="the edges of axes and lines"),
        *(formula(f"{name}.landed", where_it_is) for name in ("chart", "disc")),
        formula("judged.landed", where_it_is),
        *(
            formula(f"{name}.{output}", reference)
            for name in ("patch", "middle", "turned")
            for output, reference in (("landed", where_it_is), ("FragColor", chart))
        ),
        *figures(
            "judged.Window",
            {
                OFF_CENTRE_PLACE: ({}, (490.0, 140.0, 0.6)),
                "lower left corner, near": ({"aPos": (-1.0, -1.0, -1.0)}, (10.0, 20.0, 0.0)),
                "upper right corner, far": (FAR, (650.0, 500.0, 1.0)),
                "depth range ¼ … ¾": ({"depthRange": (0.25, 0.75)}, (490.0, 140.0, 0.55)),
                "depth range 0 … ½": ({"depthRange": (0.0, 0.5)}, (490.0, 140.0, 0.3)),
                "depth range 1 … 0": ({**NEAR, "depthRange": (1.0, 0.0)}, (490.0, 140.0, 1.0)),
            },
            at={**PLACE, **OFF_CENTRE},
            reference=by_hand,
        ),
        coverage(12, pass_name="patch", name="the patch covers 4 × 3 pixels"),
        *figures(
            "patch.landed",
            {
                "the patch's first pixel": (Pixel(490, 140), (490.5, 140.5, 0.6)),
                "its last pixel": (Pixel(493, 142), (493.5, 142.5, 0.6)),
                "one pixel to the left": (Pixel(489, 140), NOTHING),
                "one pixel below": (Pixel(490, 139), NOTHING),
                "one pixel to the right": (Pixel(494, 142), NOTHING),
                "one pixel above": (Pixel(493, 143), NOTHING),
            },
        ),
        figure("middle.landed", "in the depth range ¼ … ¾", THERE, (470.5, 100.5, 0.55)),
        figure("turned.landed", "in the depth range 1 … 0", THERE, (470.5, 100.5, 0.4)),
        coverage(12, pass_name="middle", name="a viewport may reach beyond the window"),
        *results({f"{OFF_CENTRE_PLACE}, in float64": (IN_FLOAT64, (490.0, 140.0, 0.6))}, digits=9),
    ],
)
