"""The blend equation: how a fragment mixes with the colour behind it.

result = source · α + destination · (1 − α), for all four channels, the alpha channel too: its
result is α² + (1 − α)·Ad and not the source's α. Green at 0.6 over opaque red is (0.4, 0.6, 0,
0.76); stored in eight bits that is 102, 153, 0, 194.

Look at: the discs, an opaque red one and a green one with an α of 0.6 laid over it. Where they
overlap is the figure above; elsewhere the paper shows through, and its alpha sinks below 1 although
it was opaque before. Drawn over red with every α from 0 to 1, each pixel obeys the same equation.

Try: in `ch06_tests/blend_disc.frag` write `0.5 * alpha * inside` for `alpha * inside`: the red disc
is half transparent as well, and the paper shows through both.
"""

from dataclasses import replace

from shaderlab import Blend, Case, Pass, Pixel, Ramp, Target, across, exact, formula
from shaderlab.glslmath import distance, mix, smoothstep, swizzle, vec2, vec3, vec4
from shaderlab.reference.blending import over

from ..scenes.drawing import chessboard
from ..scenes.figures import figure
from ..scenes.panels import panel, square

RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
OVER = Blend(source="src_alpha", destination="one_minus_src_alpha")
SEPARATE = replace(OVER, source_alpha="one", destination_alpha="zero")
SQUARE = {"place": square()}
# Centre, colour and alpha.
DISCS = (((-0.25, 0.15), RED, 1.0), ((0.25, -0.15), GREEN, 0.6))


def green_over_red(name, alpha, blend=OVER, **target):
    """A green layer, blended onto opaque red."""
    layer = panel("ch06_tests/blend_equation.frag", {"alpha": alpha}, {"color": GREEN}, blend=blend)
    return Pass(name=name, target=Target(clear=(*RED, 1.0), **target), draws=(layer,))


def blended(color, alpha):
    """Equation 6.1 for a layer over opaque red."""
    return over(vec4(color, alpha), vec4(*RED, 1.0))


def blended_apart(color, alpha):
    """The colour as before; alpha by factors of its own, 1 and 0, is the source's."""
    return vec4(swizzle(blended(color, alpha), "rgb"), alpha)


def disc(centre, color, alpha):
    """A disc of one colour, blended."""
    uniforms = {"centre": centre, "color": color, "alpha": alpha}
    return panel("ch06_tests/blend_disc.frag", SQUARE, uniforms, blend=OVER)


def laid_over(n):
    """The paper with the first discs over it, each softly cut."""

    def seen(place):
        color = vec4(mix(vec3(0.75), vec3(0.95), chessboard(6.0 * place)), 1.0)
        for centre, hue, alpha in DISCS[:n]:
            away = distance(place, vec2(*centre)) - 0.55
            color = over(vec4(vec3(*hue), alpha * (1.0 - smoothstep(0.0, 0.008, away))), color)
        return color

    return seen


# Each layer is a pass of its own, so that each is seen before the next one covers it.
LAYERS = (
    Pass(name="paper", draws=(panel("ch06_tests/blend_backdrop.frag", SQUARE),)),
    Pass(name="red", draws=(disc(*DISCS[0]),), onto="paper"),
    Pass(name="picture", draws=(disc(*DISCS[1]),), onto="red"),
)
FIGURE = (0.4, 0.6, 0.0, 0.76)

case = Case(
    title="The blend equation",
    section="6.3.2",
    math=r"C = C_s\,\alpha_s + C_d\,(1 - \alpha_s), \qquad "
    r"A = \alpha_s^2 + A_d\,(1 - \alpha_s)",
    passes=(
        *LAYERS,
        green_over_red("ramp", across(0.0, 1.0)),
        green_over_red("float", Ramp(0.6), size=(16, 16)),
        green_over_red("separate", across(0.0, 1.0), SEPARATE),
        green_over_red("bytes", Ramp(0.6), size=(16, 16), colors={"FragColor": "rgba8"}),
    ),
    picture="picture.FragColor",
    expect=[
        *(
            formula(f"{layer.name}.FragColor", laid_over(n), name=name)
            for n, (layer, name) in enumerate(
                zip(LAYERS, ("paper", "red over paper", "green over both"), strict=True)
            )
        ),
        formula("ramp.FragColor", blended, name="every alpha"),
        formula("separate.FragColor", blended_apart, name="alpha by its own factors"),
        formula("float.FragColor", blended, name="green 0.6 over red, every pixel"),
        figure(
            "picture.FragColor",
            "where the discs overlap",
            Pixel(32, 32),
            FIGURE,
            reference=laid_over(2),
        ),
        figure("float.FragColor", "green 0.6 over red", Pixel(8, 8), FIGURE, reference=blended),
        figure("bytes.FragColor", "the same in eight bits", Pixel(8, 8), FIGURE, reference=blended),
        exact("bytes.FragColor", (102, 153, 0, 194), name="the bytes themselves"),
    ],
)
