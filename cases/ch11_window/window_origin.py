"""The window's origin: lower left, and the first pixel's centre at (0.5, 0.5).

OpenGL counts a window's pixels from the lower left corner, to the right and up. A pixel is a square
of side 1, and `gl_FragCoord` is its centre: the first one is at (0.5, 0.5), not (0, 0), and the
last one of 16 × 12 at (15.5, 11.5). Most window systems and image files count rows from above, and
row r from the top is row `height − 1 − r` from the bottom. A shader may ask for that by redeclaring
`gl_FragCoord` with `origin_upper_left`, and y becomes the height minus y, centres again.

Look at: the two windows of 16 × 12 pixels, each with a dot at its centre. Red grows with x, green
with y, as each pixel itself says where it is; the one that says (0.5, 0.5) is yellow. On the left
it is the lower left one, on the right, where the origin was asked to be above, the upper left one.
"""

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Draw,
    Output,
    Pass,
    Pixel,
    Ramp,
    State,
    Target,
    exact,
    formula,
    fullscreen,
    value,
)
from shaderlab.glslmath import swizzle

WIDTH, HEIGHT = 16, 12
X, Y = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
FROM_BELOW = np.stack([X, Y], axis=-1).astype(np.float32)
FROM_ABOVE = np.stack([X, HEIGHT - Y], axis=-1).astype(np.float32)


def window(name, shader):
    """A window in which each pixel writes down where it is."""
    size = Target(size=(WIDTH, HEIGHT))
    return fullscreen(f"ch11_window/{shader}.frag", name=name, domain={}, target=size)


def enlarged(k, name):
    """One of the windows, each of its pixels as a square."""
    return Draw(
        fragment="ch11_window/window_origin_picture.frag",
        domain={"field": Ramp((0.0, 0.0), (WIDTH, 0.0), (0.0, HEIGHT))},
        textures={"window": Output(f"{name}.place")},
        state=State(cell=Cell(column=k, row=0, columns=2, rows=1)),
    )


def centre(frag_coord):
    """What a fragment's coordinate is, as it was captured."""
    return swizzle(frag_coord, "xy")


case = Case(
    title="The window's origin",
    section="11.4",
    math=r"\text{FragCoord} = (i + \tfrac12,\ j + \tfrac12), \qquad y_{\text{upper}} = h - y",
    passes=(
        *window("lower", "window_origin"),
        *window("upper", "window_origin_upper"),
        Pass(
            name="picture",
            target=Target(size=(1024, 384)),
            draws=(enlarged(0, "lower"), enlarged(1, "upper")),
        ),
    ),
    picture="picture.FragColor",
    expect=[
        exact("lower.place", FROM_BELOW, name="every centre, from the lower left"),
        exact("upper.place", FROM_ABOVE, name="every centre, from the upper left"),
        formula("lower.place", centre, name="what the capture says of itself"),
        *(
            value(
                f"{name}.place",
                at=Pixel(x, y),
                equals=place,
                digits=6,
                name=f"{name}: {what}",
                reference=None,
            )
            for name, what, x, y, place in (
                ("upper", "the lowest row's first pixel", 0, 0, (0.5, 11.5)),
                ("upper", "the top row's last pixel", 15, 11, (15.5, 0.5)),
            )
        ),
    ],
)
