"""Swizzling: a vector's components in any order, any number of times.

After the dot come up to four letters of one set, x y z w, r g b a or s t p q, and the result is a
vector of as many components. The three sets name the same components; which one is used only says
what the vector means. On the left of an assignment no letter may come twice, and only the named
components change.

Look at: the six orders of red, green and blue. In the upper row, from the left, `.rgb`, `.gbr` and
`.brg`, which turn the lamps in a circle; below them `.rbg`, `.grb` and `.bgr`, each of which
exchanges two lamps. The white in the middle, where all three are equal, no order can change.

Try: in `ch02_basics/swizzle_picture.frag` write `c.rrr` for `c.gbr`: of the second field one lamp
remains, and it is white: all three components are the first.
"""

import numpy as np

from shaderlab import Case, Variant, boundaries, exact, formula, fullscreen
from shaderlab.glslmath import abs, distance, max, mix, smoothstep, swizzle, vec2, vec3, where

from ..scenes.drawing import encoded
from ..scenes.laws import opaque
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, square

ORDERS = ("rgb", "gbr", "brg", "rbg", "grb", "bgr")


def field(order):
    """Three lamps in one order of their colours."""
    return panel(
        "ch02_basics/swizzle_picture.frag",
        {"place": square()},
        {"order": order},
        cell=cell(order, 3, 2, from_above=True),
    )


def lamps(order):
    """Red above, green at the lower left, blue at the lower right, then taken in an order."""

    def seen(place):
        light = {}
        for name, x, y in (("r", 0.0, 0.30), ("g", -0.28, -0.18), ("b", 0.28, -0.18)):
            light[name] = 1.0 - smoothstep(0.42, 0.48, distance(place, vec2(x, y)))
        color = mix(vec3(0.004, 0.005, 0.008), vec3(1.0), vec3(*(light[name] for name in order)))
        frame = max(abs(swizzle(place, "x")), abs(swizzle(place, "y")))
        return encoded(where(frame <= 0.97, color, vec3(0.0)))

    return opaque(seen)


def components(x, y):
    """The six vectors for `someVec` = (x, y), written out."""
    return [
        exact("differentVec", np.float32((x, y, x, x)), name="someVec.xyxx"),
        exact("anotherVec", np.float32((x, y, x)), name="differentVec.zyw"),
        exact(
            "otherVec",
            np.float32((x, x, x, x)) + np.float32((y, x, x, y)),
            name="someVec.xxxx + anotherVec.yxzy",
        ),
        exact("asColor", np.float32((x, y, x, x)), name="someVec.rgrr"),
        exact("asTexture", np.float32((x, y, x, x)), name="someVec.stss"),
        exact("written", np.float32((0.0, y, 0.0, x)), name="written.wy = someVec"),
    ]


case = Case(
    title="Swizzling",
    section="2.3.2",
    math=r"(1, 2)_{xyxx} = (1, 2, 1, 1), \qquad "
    r"(1, 2)_{xxxx} + (1, 2, 1)_{yxzy} = (3, 2, 2, 3)",
    passes=(
        *enlarged((field(k) for k in range(len(ORDERS))), (81, 54), 9),
        *fullscreen("ch02_basics/swizzle.frag", domain={}, uniforms={"someVec": (1.0, 2.0)}),
    ),
    picture="picture.FragColor",
    rows=(".rgb, .gbr, .brg", ".rbg, .grb, .bgr"),
    expect=[
        enlarged_check(),
        *(
            formula("small.FragColor", lamps(order), draw=k, name=f".{order}, the lamps")
            for k, order in enumerate(ORDERS)
        ),
        boundaries("picture.FragColor", lamps(ORDERS[0]), draw=0, name="a panel's edges"),
    ],
    variants=[
        Variant(
            "(1, 2)",
            expect=[
                *components(1.0, 2.0),
                exact("otherVec", (3.0, 2.0, 2.0, 3.0), name="(3, 2, 2, 3)"),
            ],
        ),
        Variant("(0.1, −7)", {"someVec": (0.1, -7.0)}, expect=components(0.1, -7.0)),
    ],
)
