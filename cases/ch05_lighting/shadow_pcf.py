"""Percentage-closer filtering: nine comparisons make an edge of ten steps.

A shadow map's texels are squares, and so are the edges of its shadows. Depths must not be averaged:
the mean of a near and a far depth is the depth of nothing. But comparisons can be. Each of 3 × 3
texels around the point votes for shadow or light, and the share of votes for shadow is how dark the
point is. The edge becomes three texels wide and has the values 0, 1/9, 2/9, … 1.

A sampler2DShadow does the comparison itself. With NEAREST it returns the result of one texel. With
LINEAR it may compare the four surrounding texels and interpolate the results in a single call,
which is what drivers usually do; OpenGL leaves the details open, and asks for a result in 0…1 that
is proportional to the comparisons that pass.

That is softer, not truer: a sun of no size throws sharp edges, and against those the error stays.

Look at: a pillar and its shadow, with a map of 512². On the left one texel decides, and the edge is
a staircase. On the right nine do. The steps are still there, but of a few ninths, or of one.
"""

from dataclasses import replace

import numpy as np

from shaderlab import Case, Output, any_order, both_ways, formula, measure, reading
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.transforms import orthographic

from ..scenes import shadow_stage as courtyard
from ..scenes.cameras import camera
from ..scenes.courtyard_light import compared_shadow, courtyard_references, light_position
from ..scenes.figures import figures
from ..scenes.lit import vertex_stage_checks
from ..scenes.panels import cell
from ..scenes.shadow_stage import BOXES, LIGHT_SPACE, LIGHT_VIEW, MODEL, SHADOW, SUN, WHITE, reads
from ..scenes.shadow_truth import against_rays, rms_error

EYE = (1.4, 1.9, -2.6)
BIAS = {"leastBias": 0.002, "mostBias": 0.03}
STEADY = {"leastBias": 0.012, "mostBias": 0.0}
LOOK_AT = (0.55, 0.15, -0.5)
NEAR_BY = camera(EYE, LOOK_AT, 34.0, far=60.0)
PILLAR = camera(EYE, (0.60, 0.52, -0.62), 59.0, 0.5, far=60.0)
# What the camera looks at from the sun, a tenth as wide: with texels so small, hardly a pixel lies
# between four that disagree, about which OpenGL says nothing.
_x, _y = (LIGHT_VIEW @ (*LOOK_AT, 1.0))[:2]
NEAR_SPACE = orthographic(_x - 0.6, _x + 0.6, _y - 0.6, _y + 0.6, 1.0, 9.0) @ LIGHT_VIEW


def seen(name, radius, view=NEAR_BY, **target):
    """A shadow with 1 or 9 texels asked, its edge from nearby or all of it."""
    uniforms = {**(BIAS if radius else STEADY), "radius": radius}
    shadow_map = Output("map.depth", **WHITE)
    return courtyard.lit(
        name, shadow_map, LIGHT_SPACE, MODEL, tuple(view.values()), uniforms, **target
    )


def compared(name, filtering, bias, map_name="map", light_space=LIGHT_SPACE):
    """The same edge, by a sampler that compares: NEAREST or LINEAR."""
    made = seen(name, 0, size=(96, 96), colors=SHADOW)
    (draw,) = made.draws
    kept = {key: draw.uniforms[key] for key in draw.uniforms if key not in ("viewPos", "radius")}
    own = replace(
        draw,
        fragment="ch05_lighting/shadow_compare.frag",
        uniforms={**kept, **bias, "lightSpaceMatrix": light_space},
        textures={
            "shadowMap": Output(
                f"{map_name}.depth", filter=(filtering,) * 2, compare="lequal", **WHITE
            )
        },
    )
    return replace(made, draws=(own,))


def off_the_steps(shadow, steps):
    """How far any value is from a multiple of 1/steps."""
    return np.abs(shadow * steps - np.rint(shadow * steps)).max()


def values(shadow):
    """How many different values there are, to a thousandth."""
    return len(np.unique(np.rint(shadow * 1000.0)))


def in_between(shadow):
    """The share of pixels that are neither dark nor bright."""
    return np.mean((shadow > 0.001) & (shadow < 0.999))


def edge(shadow, upright):
    """The same of the places that face the sun."""
    return in_between(shadow[..., 0][courtyard.faces(upright, SUN)])


def disagreement(one, other):
    """The share of pixels where two passes tell something else."""
    return np.mean(one != other)


def of(name, *outputs, **given):
    """What a reading reads: the shadow of one pass, and surfaces, which all passes share."""
    return {"reads": reads("nine", *outputs, shadow=f"{name}.shadow"), "given": given}


LAWS = courtyard_references(texture)
COMPARED = ("compared-nearest", "compared-linear")
POINT = {"FragPosLightSpace": (0.0, 0.0, 0.0, 1.0), "Normal": (0.0, 1.0, 0.0)}

case = Case(
    title="Percentage-closer filtering",
    section="5.9.1",
    math=r"s = \frac{1}{9} \sum_{i=-1}^{1} \sum_{j=-1}^{1} \left[z - b > z_{\text{map}}(x + i, "
    r"y + j)\right]",
    passes=(
        courtyard.cast("map", LIGHT_SPACE, MODEL, 512),
        *courtyard.photographed(
            [courtyard.in_cell(seen("", radius, PILLAR), cell(radius, 2)) for radius in (0, 1)],
            size=(768, 768),
        ),
        seen("one", 0, size=(96, 96), colors=SHADOW),
        seen("nine", 1, size=(96, 96)),
        *both_ways(seen("twenty-five", 2, size=(40, 40), colors=SHADOW)),
        compared("compared-nearest", "nearest", STEADY),
        *both_ways(courtyard.cast("map-near", NEAR_SPACE, MODEL, 512)),
        compared("compared-linear", "linear", BIAS, "map-near", NEAR_SPACE),
    ),
    picture="picture.FragColor",
    columns=("one texel", "3 × 3 texels"),
    expect=[
        *courtyard.map_checks("map"),
        *(formula(f"nine.{output}", law) for output, law in LAWS.items()),
        *(formula(f"{name}.shadow", LAWS["shadow"]) for name in ("one", "twenty-five")),
        *(formula(f"{name}.shadow", compared_shadow(texture)) for name in COMPARED),
        *vertex_stage_checks("FragPos", "Normal", "Color", pass_name="compared-nearest"),
        formula("compared-nearest.FragPosLightSpace", light_position),
        any_order("twenty-five.shadow"),
        any_order("map-near.depth"),
        *courtyard.single_points("nine"),
        *courtyard.surface_checks(EYE, BOXES, "nine", ("one", *COMPARED)),
        *courtyard.picture_checks(EYE, BOXES),
        courtyard.past_far_plane("nine"),
        measure(
            "NEAREST that compares, against one texel compared by hand",
            disagreement,
            reads={"one": "compared-nearest.shadow", "other": "one.shadow"},
            at_most=0.0005,  # four pixels: where depths differ by their rounding, either is right
        ),
        measure(
            "in between, of pixels compared by the sampler",
            in_between,
            readings=[
                reading("NEAREST", **of("compared-nearest"), equals=0.0, digits=6),
                # How the four are mixed is the driver's own business.
                reading("LINEAR", **of("compared-linear")),
            ],
        ),
        *figures(
            "compared-nearest.shadow",
            {
                name: ({"FragPosLightSpace": (0.0, 0.0, depth, 1.0)}, equals)
                for depth, equals, name in (
                    (0.99, 1.0, "before the far plane the sampler says dark"),
                    (1.01, 0.0, "past the far plane the sampler says nothing"),
                )
            },
            at=POINT,
        ),
        measure(
            "distance from the nearest step",
            off_the_steps,
            readings=[
                reading("one texel: 0 and 1", **of("one", steps=1.0)),
                reading("nine texels: ninths", **of("nine", steps=9.0)),
            ],
            # Up to nine ones are added exactly; the quotient is off by 2½ units of 2⁻²⁴ at most,
            # and nine of it are looked at.
            at_most=9.0 * 2.5 * 2.0**-24,
        ),
        measure(
            "different values",
            values,
            readings=[
                reading("one texel", **of("one"), equals=2, digits=0),
                reading("nine texels", **of("nine"), equals=10, digits=0),
            ],
        ),
        measure(
            "share of places in between",
            edge,
            readings=[
                reading("one texel", **of("one", "upright"), equals=0.0, digits=6),
                reading("nine texels", **of("nine", "upright")),
            ],
        ),
        *(
            courtyard.map_of_rays_check(
                f"{texels}: ",
                radius=radius,
                reads=reads("nine", "place", "upright", shadow=f"{name}.shadow"),
                given={"size": 512, "biases": tuple(bias.values())},
            )
            for name, texels, radius, bias in (
                ("one", "one texel", 0, STEADY),
                ("nine", "nine texels", 1, BIAS),
            )
        ),
        measure(
            "error against rays",
            against_rays(rms_error, SUN, BOXES),
            readings=[
                reading("one texel", **of("one", "place", "upright")),
                reading("nine texels", **of("nine", "place", "upright")),
            ],
            # Only places within 1½ texels of an edge, a twentieth of all, can be wrong, and are so
            # by a half on average: √(1/20) / 2. What they are follows from the map of rays.
            at_most=0.112,
        ),
    ],
)
