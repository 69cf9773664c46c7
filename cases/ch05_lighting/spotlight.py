"""A spotlight with a soft edge: I = clamp((θ − γ) / (φ − γ), 0, 1), and all three are cosines.

θ belongs to the ray from the lamp to the fragment, φ to the inner cone, γ to the outer one. The
ratio is 1 on the inner cone and 0 on the outer one; the clamp takes care of everything inside and
outside. A uniform `cutOff` has to hold a cosine, and a cosine of degrees: without the conversion to
radians it is a number that looks like one and belongs to another cone.

Look at: the beam from the side, in dusty air. Amber lines are the inner cone, blue lines the outer
one, and on the grey arc, one unit from the lamp, lie the points of the table.

Try: in `lib/spotlight.glsl` write `spotRatio(light, fragPos)` for `clamp(spotRatio(light, fragPos),
0.0, 1.0)`: the beam is too bright in its middle, and negative outside of the outer cone.
"""

from functools import partial
from math import cos, radians, sin, tan

import numpy as np

from shaderlab import Case, Erratum, Ramp, Target, Variant, across, formula, fullscreen, sweep
from shaderlab.glslmath import dot, length, step, swizzle, vec2, vec3, vec4
from shaderlab.reference.spotlight import ratio_of_cosines, spot_intensity, spot_ratio

from ..scenes.drawing import AMBER, BLUE, encoded, pixel_size, with_lines
from ..scenes.figures import figure, results

# The lamp hangs at the origin and points along −z; the picture is a slice with z upward.
LIGHT = {"light.position": (0.0, 0.0, 0.0), "light.direction": (0.0, 0.0, -1.0)}
TANGENTS = [tan(radians(angle)) for angle in np.linspace(-45.0, 45.0, 121)]
SLICE = {"FragPos": Ramp((-0.8, 0.0, -1.45), (1.6, 0.0, 0.0), (0.0, 0.0, 1.6))}
# Where the arc crosses both cones.
NEAR_BY = {"FragPos": Ramp((0.15, 0.0, -1.05), (0.5, 0.0, 0.0), (0.0, 0.0, 0.5))}


def cone(inner, outer):
    """The two cut-offs as the shader wants them."""
    return {"light.cutOff": cos(radians(inner)), "light.outerCutOff": cos(radians(outer))}


def shown(shader, name, domain, **target):
    """One of the shaders, with the cone of 25° and 35°."""
    uniforms, target = {**LIGHT, **cone(25.0, 35.0)}, Target(**target)
    shader = f"ch05_lighting/{shader}.frag"
    return fullscreen(shader, name=name, domain=domain, uniforms=uniforms, target=target)


def below(tangent, light_position, light_direction, light_cutOff, light_outerCutOff):
    """The intensity along a straight line one unit below the lamp."""
    place = light_position + vec3(tangent, 0.0, -1.0)
    return spot_intensity(place, light_position, light_direction, light_cutOff, light_outerCutOff)


def dusty_air(
    FragPos, frag_coord, light_position, light_direction, light_cutOff, light_outerCutOff,
    corner=(-0.8, -1.45),
):  # fmt: skip
    """The picture: the beam in a slice of air, both cones, and an arc one unit from the lamp."""
    cone = (light_position, light_direction, light_cutOff, light_outerCutOff)
    across = vec2(swizzle(FragPos, "x"), swizzle(FragPos, "z"))
    size = pixel_size(across, corner, frag_coord)

    def place_of(across):
        return vec3(swizzle(across, "x"), swizzle(FragPos, "y"), swizzle(across, "y"))

    def ratio(across):
        return spot_ratio(place_of(across), *cone)

    def distance(across):
        return length(light_position - place_of(across))

    ray = light_position - FragPos
    beam = 0.55 * spot_intensity(FragPos, *cone) / (0.4 + dot(ray, ray))
    color = encoded(vec3(0.02, 0.03, 0.05) + vec3(1.0, 0.93, 0.75) * beam)
    in_front = step(0.05, length(ray))
    cones = (
        (lambda ratio: ratio - 1.0, 1.5, AMBER, in_front),
        (lambda ratio: ratio, 1.5, BLUE, in_front),
    )
    arc = (lambda distance: distance - 1.0, 1.0, (0.85, 0.85, 0.85), 0.35)
    color = with_lines(color, across, size, cones, of=ratio)
    return vec4(with_lines(color, across, size, [arc], of=distance), 1.0)


def row(degrees, printed, ratio, intensity):
    """Both figures one unit from the lamp, some degrees off its axis, and what the notes print."""
    at = {"FragPos": (sin(radians(degrees)), 0.0, -cos(radians(degrees)))}
    return (
        figure("ratio", f"ratio at {degrees}°", at, ratio, note=f"the notes print {printed}"),
        figure("intensity", f"intensity at {degrees}°", at, intensity),
    )


TURNED = {"tangent": -0.1, "light.direction": (0.5, 0.0, -1.0)}  # no unit vector either
ON_AXIS = {"FragPos": (0.5, 0.0, -1.0), "light.direction": (0.5, 0.0, -1.0)}
ASIDE = (0.5, -2.0, 1.5)
# The rows for the cone of 25° and 35°: angle, the notes' figure, ratio, intensity.
WIDE = [
    *row(30, "0.56", 0.537811, 0.537811),
    *row(26, "0.89", 0.913789, 0.913789),
    *row(14, "1.67", 1.734179, 1.0),
    *row(34, "0.11", 0.113424, 0.113424),
    *row(50, "−2.0", -2.023555, 0.0),
    figure("ratio", "on the axis of a lamp turned", ON_AXIS, 2.0750, digits=4),
    figure("edge.intensity", "the lamp turned", TURNED, 0.302182),
    figure("edge.intensity", "the lamp elsewhere", {**TURNED, "light.position": ASIDE}, 0.302182),
]


MIXED_UP = ratio_of_cosines(cos(radians(15.0)), cos(12.5), cos(radians(17.5)))
BY_RADIANS = (MIXED_UP, 0.277, "rounding on the way made it 0.29")
NUMERATOR = "cos 15° − cos 17.5°, from figures of three digits"
# The row for the cone of 12.5° and 17.5°, whose cosine the notes took of radians.
NARROW = [
    *row(15, "0.29", 0.540717, 0.540717),
    *results({"cos 12.5°": (cos(radians(12.5)), 0.976296)}),
    *results({"cos(12.5 rad)": (cos(12.5), 0.9978, "the notes' 0.9978")}, digits=4),
    *results({"with the cosine of 12.5 rad": BY_RADIANS}, digits=3),
    *results({NUMERATOR: (0.966 - 0.953, 0.013)}, digits=3),
    *results({"cos(12.5 rad) − cos 17.5°, likewise": (0.9978 - 0.953, 0.0448)}, digits=4),
]

case = Case(
    title="Spotlight with a soft edge",
    section="5.5.3",
    math=r"I = \operatorname{clamp}\!\left(\frac{\cos\theta - \cos\gamma}"
    r"{\cos\varphi - \cos\gamma},\ 0,\ 1\right)",
    passes=(
        *shown("spotlight_picture", "picture", SLICE),
        *shown("spotlight_picture", "crossing", NEAR_BY, size=(96, 96)),
        *shown("spotlight_edge", "edge", {"tangent": across(-1.0, 1.0)}),
        *shown("spotlight", "main", SLICE),
    ),
    picture="picture.FragColor",
    expect=[
        formula("ratio", spot_ratio),
        formula("intensity", spot_intensity),
        formula("picture.FragColor", dusty_air, name="the picture"),
        formula("crossing.FragColor", partial(dusty_air, corner=(0.15, -1.05)), name="its lines"),
        sweep("edge.intensity", below, over="tangent", values=TANGENTS, name="from edge to edge"),
    ],
    variants=[
        Variant("25° and 35°", cone(25.0, 35.0), expect=WIDE),
        Variant("12.5° and 17.5°", cone(12.5, 17.5), expect=NARROW),
    ],
    errata=[
        Erratum(
            section="5.5.3",
            says="θ = 15°, φ = 12.5°, γ = 17.5°: cos φ = 0.9978, I = 0.29",
            truth="0.9978 is the cosine of 12.5 radians; cos 12.5° = 0.976296 and I = 0.540717",
            proof="ratio at 15°",
        ),
        Erratum(
            section="5.5.3",
            says="0.966 − 0.953 = 0.0448, and the fraction on one line without parentheses",
            truth="0.966 − 0.953 = 0.013; 0.0448 is the denominator, 0.9978 − 0.953. Both "
            "differences need parentheses: (0.966 − 0.953) / (0.9978 − 0.953)",
            proof=NUMERATOR,
        ),
    ],
)
