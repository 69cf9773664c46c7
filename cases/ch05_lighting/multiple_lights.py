"""Many lights: light adds up, so each lamp is a function and the picture is their sum.

Six lamps: a moon (directional), four bulbs (point lights, an array of structs) and a spot with a
soft edge. Each is a GLSL function of its own that returns the lamp's contribution, and main() adds
them up. That is more than tidy: because light is linear, drawing the scene once for each lamp and
adding the images must give the same picture. Forward renderers with many lights rest on it, and so
do these checks.

Look at: how the colours meet. Each bulb tints the balls that face it, between two of them both
colours mix, and the spot's white circle washes them out. In the corners only the moon is left.

Try: in `ch05_lighting/multiple_lights.frag` write `directional + points` for `directional + points
+ spot`: the spot's white circle is gone, and the single lamps no longer add up to the picture.
"""

from math import cos, radians

import numpy as np

from shaderlab import Blend, Case, Depth, Erratum, any_order, compile_fails, formula, measure
from shaderlab.reference import light_sources
from shaderlab.reference.lighting import mirrored_lobe
from shaderlab.reference.transforms import clip_position

from ..scenes import lit, plaza
from ..scenes.draws import twins
from ..scenes.figures import figure
from ..scenes.laws import gated_or_not, opaque, renamed, summed
from ..scenes.panels import picture

# Place and colour of the four bulbs.
BULBS = [
    ((-1.1, 0.75, 2.9), (1.0, 0.32, 0.10)),
    ((1.25, 0.70, 1.0), (0.15, 0.65, 1.0)),
    ((-1.2, 0.90, -0.9), (0.95, 0.15, 0.75)),
    ((1.3, 0.90, -1.4), (0.20, 1.0, 0.35)),
]
MOON = {
    "dirLight.direction": (0.5, -1.0, -0.6),
    "dirLight.ambient": (0.012, 0.016, 0.030),
    "dirLight.diffuse": (0.05, 0.07, 0.13),
    "dirLight.specular": (0.10, 0.12, 0.20),
}
SPOT = {
    "spotLight.position": (-2.6, 5.2, 3.2),
    "spotLight.direction": (2.6, -5.2, -3.0),
    "spotLight.cutOff": cos(radians(9.0)),
    "spotLight.outerCutOff": cos(radians(14.0)),
    "spotLight.constant": 1.0,
    "spotLight.linear": 0.045,
    "spotLight.quadratic": 0.0075,
    "spotLight.ambient": (0.004, 0.004, 0.004),
    "spotLight.diffuse": (1.3, 1.25, 1.1),
    "spotLight.specular": (1.2, 1.1, 1.0),
}


def bulb(i, place, color):
    """The uniforms of bulb `i`: each fades differently."""
    return {
        f"pointLights[{i}].position": place,
        f"pointLights[{i}].constant": 1.0,
        f"pointLights[{i}].linear": 0.35 + 0.05 * i,
        f"pointLights[{i}].quadratic": 0.90 - 0.08 * i,
        f"pointLights[{i}].ambient": tuple(0.03 * channel for channel in color),
        f"pointLights[{i}].diffuse": tuple((1.7 + 0.1 * i) * channel for channel in color),
        f"pointLights[{i}].specular": tuple(1.5 * channel for channel in color),
    }


LAMPS = [MOON, *(bulb(i, *lamp) for i, lamp in enumerate(BULBS)), SPOT]
ALL = {name: light for lamp in LAMPS for name, light in lamp.items()}


def only(number):
    """All lamps' uniforms, with the colours of all but one black."""
    lit = LAMPS[number]
    return {
        name: light
        if name in lit or name.split(".")[1] not in ("ambient", "diffuse", "specular")
        else (0.0, 0.0, 0.0)
        for name, light in ALL.items()
    }


def lit_by(lamps, *, small=True, **state):
    """The plaza in the light of these lamps.

    Back faces are culled: along an outline they may be as near as the front, to all the digits of
    a depth buffer, and a test for equal depth would then add a lamp twice.
    """
    shader, surface = "ch05_lighting/multiple_lights.frag", {"specular": (0.40, 0.38, 0.35)}
    return plaza.in_light(shader, {**surface, **lamps}, small=small, cull="back", **state)


GLOWING = [
    lit.bulb(place, tuple(0.35 + 0.65 * channel for channel in color), 0.09, plaza.CAMERA)
    for place, color in BULBS
]
ADD = Blend(source="one", destination="one", source_alpha="zero", destination_alpha="one")
ONE_BY_ONE = [lit_by(only(0))]
ONE_BY_ONE += [lit_by(only(k), depth=Depth(func="equal"), blend=ADD) for k in range(1, 6)]

by_moon = renamed(light_sources.directional, light="dirLight")
by_spot = renamed(light_sources.soft_spot, light="spotLight")
by_points = gated_or_not(light_sources.points, highlight=mirrored_lobe)
by_all = opaque(summed(by_moon, by_points, by_spot))
by_all_gated = opaque(summed(by_moon, light_sources.points, by_spot))


def largest_difference(one, other):
    """Of any pixel and channel."""
    return np.abs(one - other).max()


ASIDE = {
    **lit.CORAL_POINT,
    "viewPos": lit.ASIDE,
    "shininess": 0.5,
    "dirLight.direction": (-1.2, -1.0, -2.0),
    "dirLight.ambient": (0.2, 0.2, 0.2),
    "dirLight.diffuse": (0.5, 0.5, 0.5),
    "dirLight.specular": (1.0, 1.0, 1.0),
}

# Where all four bulbs are before the surface.
CONSTANTS = {f"pointLights[{i}].constant": 2.0 + i for i in range(4)}
BEFORE_ALL = {**ASIDE, "FragPos": (0.0, 0.0, -2.0), **CONSTANTS}
UNDERNEATH = {"position": lit.BELOW, "direction": lit.TOWARDS_BELOW, "ambient": (0, 0, 0)}
# All six lamps below the surface's horizon, without the light that is everywhere.
ALL_BELOW = {
    **ASIDE,
    **lit.GRAZING,
    "shininess": 8.0,
    **{
        f"{lamp}.{member}": value
        for lamp, *_ in (name.split(".") for name in ALL)
        for member, value in UNDERNEATH.items()
        if f"{lamp}.{member}" in ALL
    },
}

ALMOST_MIRRORED, LESS = "nearly 90° from the mirrored ray", "bulbs that shine less from near"
MOONLIT, DIM = (0.629593, 0.332565, 0.219695), (0.369335, 0.159546, 0.201533)
BLACK = (0.0, 0.0, 0.0, 1.0)

case = Case(
    title="Multiple lights",
    section="5.6",
    math=r"C = C_{\text{dir}} + \sum_{i=1}^{4} C_{\text{point},i} + C_{\text{spot}}",
    passes=(
        *twins(
            lit.large_scene((*GLOWING, lit_by(ALL, small=False)), clear=(0.002, 0.003, 0.006, 1.0))
        ),
        *lit.picture(),
        picture(GLOWING[:1], None, "bulbs", depth="depth24"),
        lit.glow(BULBS[0][1]),
        *twins(picture([lit_by(ALL)], None, "together", depth="depth24")),
        picture(ONE_BY_ONE, None, "added", colors={"FragColor": "rgba32f"}, depth="depth24"),
    ),
    picture="picture.FragColor",
    expect=[
        *lit.vertex_stage_checks("gl_Position", "FragPos", "Normal", "Color", pass_name="together"),
        formula("together.directional", by_moon, name="the moon"),
        formula("together.points", by_points, name="the four bulbs"),
        formula("together.spot", by_spot, name="the spot"),
        formula("together.FragColor", by_all, name="all six at once"),
        formula("added.FragColor", by_all, given=ALL, name="one by one, added"),
        measure(
            "one by one against all at once",
            largest_difference,
            reads={"one": "added.FragColor", "other": "together.FragColor"},
            at_most=16 * 2.0**-22,
            note="16 sums of light below 4, each rounded by 2⁻²² at most",
        ),
        formula("bulbs.gl_Position", clip_position, name="where a bulb is"),
        formula("bulbs.FragColor", lit.glowing, name="colour of a bulb"),
        lit.glow_check(),
        lit.picture_check(),
        any_order("scene.FragColor"),
        any_order("together.FragColor"),
        compile_fails(
            "ch05_lighting/errata/output.frag",
            (7, "'output' : Reserved word."),
            departs={"NVIDIA": "accepted"},
            name="a variable called output is refused",
        ),
        figure("together.directional", ALMOST_MIRRORED, ASIDE, MOONLIT, reference=by_moon),
        figure("together.points", LESS, BEFORE_ALL, DIM, reference=light_sources.points),
        figure("together.FragColor", lit.TURNED_AWAY, ALL_BELOW, BLACK, reference=by_all_gated),
    ],
    errata=[
        Erratum(
            section="5.6",
            says="vec3 output; to which each lamp's light is then added",
            truth="output is reserved in GLSL: a variable can't be called so. And a sum has to "
            "begin at 0: without a value given to it a local variable holds anything",
            proof="a variable called output is refused",
        )
    ],
)
