"""The blend equation: what a fragment leaves of the colour behind it.

result = source · α + destination · (1 − α), for all four channels, the alpha channel too: its
result is α² + (1 − α)·Ad and not the source's α. Green at 0.6 over opaque red is (0.4, 0.6, 0,
0.76); stored in eight bits that is 102, 153, 0, 194.

Look at: the discs, an opaque red one and a green one with an α of 0.6 laid over it. Where they
overlap is the figure above; elsewhere the paper shows through, and its alpha sinks below 1 although
it was opaque before. Drawn over red with every α from 0 to 1, each pixel obeys the same equation.
"""

from shaderlab import (
    Blend,
    Case,
    Draw,
    Pass,
    Pixel,
    Ramp,
    State,
    Target,
    across,
    exact,
    formula,
    value,
)
from shaderlab.glslmath import vec4
from shaderlab.reference.blending import over

RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
OVER = Blend(source="src_alpha", destination="one_minus_src_alpha")
SQUARE = Ramp((-1.0, -1.0), (2.0, 0.0), (0.0, 2.0))


def layer(color, alpha, **state):
    """One draw over the whole target in one colour."""
    return Draw(
        fragment="ch06_tests/blend_equation.frag",
        domain={"alpha": alpha},
        uniforms={"color": color},
        state=State(**state),
    )


def green_over_red(name, alpha, target=None):
    """An opaque red layer and a green one blended onto it."""
    layers = (layer(RED, Ramp(1.0)), layer(GREEN, alpha, blend=OVER))
    return Pass(name=name, target=target or Target(), draws=layers)


def blended(color, alpha):
    """Equation 6.1 for a layer over opaque red."""
    return over(vec4(color, alpha), vec4(*RED, 1.0))


def disc(centre, color, alpha):
    """A disc of one colour, blended."""
    return Draw(
        fragment="ch06_tests/blend_disc.frag",
        domain={"place": SQUARE},
        uniforms={"centre": centre, "color": color, "alpha": alpha},
        state=State(blend=OVER),
    )


picture = Pass(
    name="picture",
    draws=(
        Draw(fragment="ch06_tests/blend_backdrop.frag", domain={"place": SQUARE}),
        disc((-0.25, 0.15), RED, 1.0),
        disc((0.25, -0.15), GREEN, 0.6),
    ),
)

FIGURE = {"equals": (0.4, 0.6, 0.0, 0.76), "digits": 6, "reference": blended}

case = Case(
    title="The blend equation",
    section="6.3.2",
    math=r"C = C_s\,\alpha_s + C_d\,(1 - \alpha_s), \qquad "
    r"A = \alpha_s^2 + A_d\,(1 - \alpha_s)",
    passes=(
        picture,
        green_over_red("ramp", across(0.0, 1.0)),
        green_over_red("float", Ramp(0.6), Target(size=(16, 16))),
        green_over_red("bytes", Ramp(0.6), Target(size=(16, 16), colors={"FragColor": "rgba8"})),
    ),
    picture="picture.FragColor",
    expect=[
        formula("ramp.FragColor", blended, name="every alpha"),
        value("picture.FragColor", at=Pixel(32, 32), **FIGURE, name="where the discs overlap"),
        value("float.FragColor", at=Pixel(8, 8), **FIGURE, name="green 0.6 over red"),
        value("bytes.FragColor", at=Pixel(8, 8), **FIGURE, name="the same in eight bits"),
        exact("bytes.FragColor", (102, 153, 0, 194), name="the bytes themselves"),
    ],
)
