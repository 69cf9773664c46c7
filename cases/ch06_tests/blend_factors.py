"""The blend factors and equations: each factor of either colour under every equation.

A fragment's colour S and the stored one D are weighted by a factor each, then added, subtracted
(S·f − D·g), subtracted in reverse, or reduced to their minimum or maximum, channel by channel; MIN
and MAX leave the factors out. The factors are 0, 1, the two colours, the two alphas, a constant
colour and its alpha, one minus each of these, and SRC_ALPHA_SATURATE: min(As, 1 − Ad) for the
colour and 1 for the alpha.

Look at: two rows of 15 fields for each equation. Below, the source's factor changes to the right,
and the stored colour keeps all of itself; above, the stored colour's factor changes. Each field
shows its colour, and in the lower right half its alpha. In floats the numbers are chosen so that
nothing needs rounding, and every field is exact, below zero and above one too. In eight bits what
leaves 0…1 is cut off, and no code is more than one from the formula's: half a code for each of the
two products.

Try: in `ch06_tests/blend_equation.frag` write `vec4(color, 1.0)` for `vec4(color, alpha)`:
SRC_ALPHA and DST_ALPHA do what ONE does, and 1 minus either what ZERO does.
"""

import numpy as np

from shaderlab import Blend, Case, Ramp, Variant, exact, measure
from shaderlab.reference.blending import EQUATIONS, FACTORS, blended

from ..scenes.panels import cell, panel, picture
from ..scenes.tables import edges_check, shown, shown_checks

# Sums of a few powers of two: products and sums of them are exact in 32-bit floats.
FLOATS = ((0.75, 0.3125, 0.9375, 0.625), (0.25, 0.5, 0.125, 0.8125), (0.5625, 0.875, 0.1875, 0.375))
# Much the same in whole codes of 8 bits, so that nothing is rounded on the way in.
BYTES = tuple(tuple(round(255 * v) / 255 for v in color) for color in FLOATS)
NAMES = tuple(FACTORS)
# Row by row from below: the source's factor and the destination's.
PAIRS = [*((name, "one") for name in NAMES), *(("one", name) for name in NAMES)]
FIELDS = len(NAMES), 2


def layer(color, **state):
    """A draw in one colour."""
    domain, uniforms = {"alpha": Ramp(color[3])}, {"color": color[:3]}
    return panel("ch06_tests/blend_equation.frag", domain, uniforms, **state)


def table(equation, name, format, colors):
    """The factors under one equation, a pixel each, over the stored colour."""
    source, stored, constant = colors
    factors = {"equation": equation, "constant": constant}
    fields = (
        layer(source, blend=Blend(source=s, destination=d, **factors), cell=cell(k, *FIELDS))
        for k, (s, d) in enumerate(PAIRS)
    )
    return picture((layer(stored), *fields), FIELDS, name, colors={"FragColor": format})


def passes(equation):
    """The table in floats and in bytes, and its picture."""
    return (
        table(equation, "float", "rgba32f", FLOATS),
        table(equation, "bytes", "rgba8", BYTES),
        *shown("fields", "float.FragColor", FIELDS, (9, 18)),
    )


def truth(equation, colors):
    """What the formula says of every field."""
    found = [blended(equation, pair, *colors) for pair in PAIRS]
    return np.reshape(found, (*reversed(FIELDS), 4))


def codes_apart(equation):
    """The largest distance of a stored code from the formula's, before that is rounded."""
    wanted = 255.0 * np.clip(truth(equation, BYTES), 0.0, 1.0)
    return lambda bytes_: np.abs(bytes_ - wanted).max()


def variant(equation):
    """One equation's table and what must hold of it."""
    return Variant(
        equation,
        passes=None if equation == "add" else passes(equation),
        expect=[
            exact("float.FragColor", truth(equation, FLOATS), name="2 × 15 factors, bit for bit"),
            measure(
                "largest distance in codes of 8 bits",
                codes_apart(equation),
                reads={"bytes_": "bytes.FragColor"},
                at_most=1.001,
                note="a code is 1/255; two products are rounded to half a code each",
            ),
        ],
    )


case = Case(
    title="Blend factors and equations",
    section="6.3.2",
    math=r"C = S \cdot f \;\circ\; D \cdot g, \qquad \circ \in \{+,\ -,\ \text{reverse } -,\ "
    r"\min(S, D),\ \max(S, D)\}",
    passes=passes("add"),
    variants=[variant(equation) for equation in EQUATIONS],
    picture="picture.FragColor",
    columns=[name.upper() for name in NAMES],
    rows=["destination", "source"],
    expect=[*shown_checks("fields"), edges_check("fields")],
)
