"""The blend equation: what a fragment leaves of the colour behind it.

result = source · α + destination · (1 − α), for all four channels, the alpha channel too: its
result is α² + (1 − α)·Ad and not the source's α. Green at 0.6 over opaque red is (0.4, 0.6, 0,
0.76); stored in eight bits that is 102, 153, 0, 194.

Look at: green laid over red, from not at all on the left to fully on the right. Between them it
is olive and darker than either, because the numbers are mixed and not the light (see gamma).
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
    blend = Blend(source="src_alpha", destination="one_minus_src_alpha")
    layers = (layer(RED, Ramp(1.0)), layer(GREEN, alpha, blend=blend))
    return Pass(name=name, target=target or Target(), draws=layers)


def blended(color, alpha):
    """Equation 6.1 for a layer over opaque red."""
    return over(vec4(color, alpha), vec4(*RED, 1.0))


FIGURE = {"at": Pixel(8, 8), "equals": (0.4, 0.6, 0.0, 0.76), "digits": 6, "reference": blended}

case = Case(
    title="The blend equation",
    section="6.3.2",
    math=r"C = C_s\,\alpha_s + C_d\,(1 - \alpha_s), \qquad "
    r"A = \alpha_s^2 + A_d\,(1 - \alpha_s)",
    passes=(
        green_over_red("ramp", across(0.0, 1.0)),
        green_over_red("float", Ramp(0.6), Target(size=(16, 16))),
        green_over_red("bytes", Ramp(0.6), Target(size=(16, 16), colors={"FragColor": "rgba8"})),
    ),
    picture="ramp.FragColor",
    expect=[
        formula("ramp.FragColor", blended, name="every alpha"),
        value("float.FragColor", **FIGURE, name="green 0.6 over red"),
        value("bytes.FragColor", **FIGURE, name="green 0.6 over red, in eight bits"),
        exact("bytes.FragColor", (102, 153, 0, 194), name="the bytes themselves"),
    ],
)
