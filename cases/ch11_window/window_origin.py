"""The window's origin: lower left, and the first pixel's centre at (0.5, 0.5).

OpenGL counts a window's pixels from the lower left corner, to the right and up. A pixel is a square
of side 1, and `gl_FragCoord` is its centre: the first one is at (0.5, 0.5), not (0, 0), and the
last one of 16 × 12 at (15.5, 11.5). Most window systems and image files count rows from above, and
row r from the top is row `height − 1 − r` from the bottom. A shader may ask for that by redeclaring
`gl_FragCoord` with `origin_upper_left`, and y becomes the height minus y, centres again.

Look at: the two windows of 16 × 12 pixels, each with a dot at its centre. Red grows with x, green
with y, as each pixel itself says where it is; the one that says (0.5, 0.5) is yellow. On the left
it is the lower left one, on the right, where the origin was asked to be above, the upper left one.

Try: in `ch11_window/window_origin_upper.frag` write `in vec4 gl_FragCoord` for `layout
(origin_upper_left) in vec4 gl_FragCoord`: the right window counts from its lower left corner, too.
"""

import numpy as np

from shaderlab import Case, Output, Pixel, Target, boundaries, exact, formula, fullscreen
from shaderlab.glslmath import (
    abs,
    floor,
    fract,
    length,
    max,
    mix,
    smoothstep,
    swizzle,
    vec3,
    vec4,
    where,
)
from shaderlab.glslmath.sampling import texelFetch

from ..scenes.drawing import encoded
from ..scenes.figures import each_draw, figure
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, rectangle

WIDTH, HEIGHT = 16, 12
X, Y = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
FROM_BELOW = np.stack([X, Y], axis=-1).astype(np.float32)
FROM_ABOVE = np.stack([X, HEIGHT - Y], axis=-1).astype(np.float32)


def window(name, shader):
    """A window in which each pixel writes down where it is."""
    size = Target(size=(WIDTH, HEIGHT))
    return fullscreen(f"ch11_window/{shader}.frag", name=name, domain={}, target=size)


def of_window(k, name):
    """One of the windows, each of its pixels as a square."""
    return panel(
        "ch11_window/window_origin_picture.frag",
        {"field": rectangle((0.0, 0.0), (WIDTH, HEIGHT))},
        textures={"window": Output(f"{name}.place")},
        cell=cell(k, 2),
    )


def shown(field, window):
    """A window enlarged: colours by place, dots, and a grid."""
    place = swizzle(texelFetch(window, floor(field)), "xy")
    x, y = swizzle(place, "x"), swizzle(place, "y")
    east = x / WIDTH
    color = vec3(0.04 + 0.55 * east, 0.06 + 0.45 * (y / HEIGHT), 0.16 + 0.16 * (1.0 - east))
    first = (x == 0.5) & (y == 0.5)
    color = where(first, vec3(1.0, 0.75, 0.12), color)
    off = fract(field) - 0.5
    ink = where(first, vec3(0.05), vec3(0.75))
    color = mix(color, ink, 1.0 - smoothstep(0.07, 0.10, length(off)))
    outer = max(abs(swizzle(off, "x")), abs(swizzle(off, "y")))
    return vec4(encoded(color * where(outer <= 0.475, 1.0, 0.0)), 1.0)


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
        *enlarged([of_window(0, "lower"), of_window(1, "upper")], (160, 60), 7),
    ),
    picture="picture.FragColor",
    columns=("origin below", "origin above"),
    expect=[
        exact("lower.place", FROM_BELOW, name="every centre, from the lower left"),
        exact("upper.place", FROM_ABOVE, name="every centre, from the upper left"),
        *each_draw("small.FragColor", shown, enumerate(("lower", "upper")), "on show: {}"),
        boundaries("small.FragColor", shown, draw=0, name="the edges of dots and squares"),
        enlarged_check(),
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
