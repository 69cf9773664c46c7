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

from shaderlab import Case, Output, Pixel, Target, exact, formula, fullscreen, measure
from shaderlab.glslmath import swizzle

from ..scenes.figures import figure
from ..scenes.panels import cell, panel, picture, rectangle

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
    return panel(
        "ch11_window/window_origin_picture.frag",
        {"field": rectangle((0.0, 0.0), (WIDTH, HEIGHT))},
        textures={"window": Output(f"{name}.place")},
        cell=cell(k, 2),
    )


def shown(place):
    """A window enlarged, each of its pixels as 32 × 32: colours by place, dots, and a grid."""
    height, width, _ = place.shape
    x, y = np.moveaxis(place / (width, height), 2, 0)
    first = (place == 0.5).all(axis=-1, keepdims=True)
    color = np.stack([0.04 + 0.55 * x, 0.06 + 0.45 * y, 0.16 + 0.16 * (1.0 - x)], axis=-1)
    color = np.where(first, (1.0, 0.75, 0.12), color).repeat(32, axis=0).repeat(32, axis=1)
    ink = np.where(first, 0.05, 0.75).repeat(32, axis=0).repeat(32, axis=1)
    off = np.abs((np.arange(32) + 0.5) / 32.0 - 0.5)
    across, up = np.tile(off, width)[None, :, None], np.tile(off, height)[:, None, None]
    soft = np.clip((np.hypot(across, up) - 0.07) / 0.03, 0.0, 1.0)
    color = ink + (color - ink) * soft * soft * (3.0 - 2.0 * soft)
    return np.clip(color * (np.maximum(across, up) <= 0.475), 1e-6, 1.0) ** (1.0 / 2.2)


def furthest_shown(FragColor, lower, upper):
    """How far any channel of the picture is from both windows side by side."""
    both = np.hstack([shown(lower), shown(upper)])
    return np.abs(FragColor - np.dstack([both, np.ones_like(both[..., :1])])).max()


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
        picture([enlarged(0, "lower"), enlarged(1, "upper")], (1024, 384)),
    ),
    picture="picture.FragColor",
    expect=[
        exact("lower.place", FROM_BELOW, name="every centre, from the lower left"),
        exact("upper.place", FROM_ABOVE, name="every centre, from the upper left"),
        measure(
            "the picture",
            furthest_shown,
            reads={
                "FragColor": "picture.FragColor",
                "lower": "lower.place",
                "upper": "upper.place",
            },
            at_most=0.5 / 255.0,
            note="half a code of eight bits, which no eye sees: edges of dots are steep",
        ),
        formula("lower.place", centre, name="what the capture says of itself"),
        *(
            figure(f"{name}.place", f"{name}: {what}", Pixel(x, y), place)
            for name, what, x, y, place in (
                ("upper", "the lowest row's first pixel", 0, 0, (0.5, 11.5)),
                ("upper", "the top row's last pixel", 15, 11, (15.5, 0.5)),
            )
        ),
    ],
)
