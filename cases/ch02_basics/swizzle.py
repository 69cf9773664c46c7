"""Swizzling: a vector's components in any order, as often as one likes.

After the dot stand up to four letters of one set, x y z w, r g b a or s t p q, and the result is a
vector of as many components. The three sets name the same components; which one is used only says
what the vector means. On the left of an assignment no letter may come twice, and only the named
components change.

Look at: the six orders of red, green and blue. In the upper row, from the left, `.rgb`, `.gbr` and
`.brg`, which turn the lamps in a circle; below them `.rbg`, `.grb` and `.bgr`, each of which
exchanges two lamps. The white in the middle, where all three are equal, no order can change.
"""

import numpy as np

from shaderlab import Case, Cell, Draw, Pass, Ramp, State, Target, Variant, exact, fullscreen

ORDERS = ("rgb", "gbr", "brg", "rbg", "grb", "bgr")


def field(order):
    """Three lamps in one order of their colours."""
    return Draw(
        fragment="ch02_basics/swizzle_picture.frag",
        domain={"place": Ramp((-1.0, -1.0), (2.0, 0.0), (0.0, 2.0))},
        uniforms={"order": order},
        state=State(cell=Cell(column=order % 3, row=1 - order // 3, columns=3, rows=2)),
    )


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
        Pass(
            name="picture",
            target=Target(size=(768, 512)),
            draws=tuple(field(k) for k in range(len(ORDERS))),
        ),
        *fullscreen("ch02_basics/swizzle.frag", domain={}, uniforms={"someVec": (1.0, 2.0)}),
    ),
    picture="picture.FragColor",
    expect=[],
    variants=[
        Variant(
            "(1, 2)",
            expect=[
                *components(1.0, 2.0),
                exact("otherVec", (3.0, 2.0, 2.0, 3.0), name="the notes' result"),
            ],
        ),
        Variant("(0.1, −7)", {"someVec": (0.1, -7.0)}, expect=components(0.1, -7.0)),
    ],
)
