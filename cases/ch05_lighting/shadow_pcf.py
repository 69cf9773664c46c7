"""Percentage-closer filtering: nine comparisons make an edge of ten steps.

A shadow map's texels are squares, and so are the edges of its shadows. Depths must not be averaged:
the mean of a near and a far depth is the depth of nothing. But comparisons can be. Each of 3 × 3
texels around the point says shadow or light, and the share of those that say shadow is how dark the
point is. The edge becomes three texels wide and has the values 0, 1/9, 2/9, … 1.

A sampler2DShadow compares by itself. With NEAREST it says what one texel says. With LINEAR it may
compare the four texels around and mix the answers by the place between them, which is the usual
thing, for the price of one call; OpenGL only asks that the answer is between 0 and 1.

That is softer, not truer: a sun of no size throws sharp edges, and against those the error stays.

Look at: the same edge from nearby, with a map of 512². Above, one texel decides, and the shadow is
a staircase. Below nine do. The steps are still there, each of them nine times as small.
"""

from dataclasses import replace
from math import radians

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Output,
    Pass,
    Target,
    exact,
    formula,
    fullscreen,
    measure,
    reading,
    value,
)
from shaderlab.reference.transforms import look_at, orthographic, perspective, rotate
from shaderlab.sampling import texture

from ..scenes.courtyard import boxes
from ..scenes.courtyard_light import (
    compared_shadow,
    courtyard_references,
    light_position,
    seen_place,
    stored_depth,
)
from ..scenes.shadow_stage import PICTURED, SUN, cast, lit, single_points
from ..scenes.shadow_truth import blocked, hidden_share
from ..scenes.studio import finished

MODEL = rotate(radians(6.0), (0.0, 1.0, 0.0))
BOXES = [MODEL @ box for box in boxes()]
LIGHT_SPACE = orthographic(-6.0, 6.0, -6.0, 6.0, 1.0, 9.0) @ look_at(SUN, (0.0, 0.0, 0.0))
EYE = (1.4, 1.9, -2.6)
NEAR_BY = look_at(EYE, (0.55, 0.15, -0.5))
BIAS = {"leastBias": 0.002, "mostBias": 0.03}
STEADY = {"leastBias": 0.012, "mostBias": 0.0}
WHITE = {"wrap": ("clamp_to_border",) * 2, "border": (1.0, 1.0, 1.0, 1.0)}


def drawn(FragColor):
    """The share of pixels that show anything: the floor reaches to all edges."""
    return (FragColor[..., 3] > 0.0).mean()


def seen(name, radius, aspect=1.0, **target):
    """The edge of a shadow from nearby, with 1 or 9 texels asked."""
    camera = NEAR_BY, perspective(radians(34.0), aspect, 0.1, 60.0)
    uniforms = {**(BIAS if radius else STEADY), "radius": radius}
    shadow_map = Output("map", "depth", **WHITE)
    return lit(name, shadow_map, LIGHT_SPACE, MODEL, camera, uniforms, **target)


def compared(name, filtering, bias):
    """The same edge, by a sampler that compares: NEAREST or LINEAR."""
    made = seen(name, 0, size=(96, 96))
    (draw,) = made.draws
    asked = {key: draw.uniforms[key] for key in draw.uniforms if key not in ("viewPos", "radius")}
    asked.update(bias)
    shadow_map = Output("map", "depth", filter=(filtering,) * 2, compare="lequal", **WHITE)
    own = replace(
        draw,
        fragment="ch05_lighting/shadow_compare.frag",
        uniforms=asked,
        textures={"shadowMap": shadow_map},
    )
    return replace(made, draws=(own,))


def half(row, radius):
    """One half of the picture."""
    (draw,) = seen("", radius, aspect=2.0).draws
    cell = Cell(column=0, row=row, columns=1, rows=2)
    return replace(draw, state=replace(draw.state, cell=cell))


def off_the_steps(shadow, steps):
    """How far any value is from a multiple of 1/steps."""
    return np.abs(shadow * steps - np.rint(shadow * steps)).max()


def values(shadow):
    """How many different values there are, to a thousandth."""
    return len(np.unique(np.rint(shadow * 1000.0)))


def edge(FragColor, shadow, upright):
    """The share of lit places that are neither dark nor bright."""
    there = (FragColor[..., 3] > 0.0) & ((upright * SUN).sum(axis=-1) > 0.0)
    half = (shadow[..., 0] > 0.001) & (shadow[..., 0] < 0.999)
    return half[there].mean()


def error(FragColor, shadow, place, upright):
    """Root mean square of the difference from what rays say, on places that face the sun."""
    there = (FragColor[..., 3] > 0.0) & ((upright * SUN).sum(axis=-1) > 0.0)
    truth = blocked(place, SUN, BOXES)
    return np.sqrt(np.mean((shadow[..., 0] - truth)[there] ** 2))


def disagreement(one, other):
    """The share of pixels where two passes tell something else."""
    return np.mean(one != other)


def in_between(shadow):
    """The share of pixels that are neither dark nor bright."""
    return np.mean((shadow > 0.001) & (shadow < 0.999))


def of(name, *outputs, **given):
    """What a reading reads of one pass."""
    return {"reads": {output: f"{name}.{output}" for output in outputs}, "given": given}


LAWS = courtyard_references(texture)
COMPARED = compared_shadow(texture)
ALL = ("FragColor", "shadow", "place", "upright")

case = Case(
    title="Percentage-closer filtering",
    section="5.9.1",
    math=r"s = \frac{1}{9} \sum_{i=-1}^{1} \sum_{j=-1}^{1} \left[z - b > z_{\text{map}}(x + i, "
    r"y + j)\right]",
    passes=(
        cast("map", LIGHT_SPACE, MODEL, 512),
        Pass(
            name="scene",
            target=Target(
                size=(1024, 1024),
                colors=PICTURED,
                depth="depth24",
            ),
            draws=(half(1, 0), half(0, 1)),
        ),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        seen("one", 0, size=(96, 96)),
        seen("nine", 1, size=(96, 96)),
        seen("twenty-five", 2, size=(40, 40)),
        compared("compared-nearest", "nearest", STEADY),
        compared("compared-linear", "linear", BIAS),
    ),
    picture="picture.FragColor",
    expect=[
        formula("map.gl_Position", light_position),
        formula("map.depth", stored_depth),
        *(formula(f"nine.{output}", law) for output, law in LAWS.items()),
        formula("one.shadow", LAWS["shadow"]),
        formula("twenty-five.shadow", LAWS["shadow"]),
        formula("compared-nearest.shadow", COMPARED),
        formula("compared-nearest.place", seen_place),
        formula("compared-linear.shadow", COMPARED),
        exact(
            "compared-linear.place",
            Output("compared-nearest", "place"),
            name="both filters see the same places",
        ),
        formula("picture.FragColor", finished(texture), name="the picture"),
        *single_points("nine"),
        measure(
            "places hidden from the eye",
            hidden_share(EYE, BOXES, step=1),
            readings=[
                reading(name, reads={key: f"{name}.{key}" for key in ("FragColor", "place")})
                for name in ("one", "nine", "twenty-five")
            ],
            at_most=0.002,
        ),
        measure(
            "share of the large picture that is drawn",
            drawn,
            reads={"FragColor": "scene.FragColor"},
            at_least=0.99,
        ),
        measure(
            "places hidden from the eye, in the large picture",
            hidden_share(EYE, BOXES, step=8),
            reads={key: f"scene.{key}" for key in ("FragColor", "place")},
            at_most=0.002,
        ),
        value(
            "nine.shadow",
            at={
                "FragPosLightSpace": (0.0, 0.0, 1.01, 1.0),
                "FragPos": (0.0, 0.0, 0.0),
                "Normal": (0.0, 1.0, 0.0),
                "Color": (1.0, 1.0, 1.0),
            },
            equals=0.0,
            digits=6,
            name="past the far plane nothing is dark",
        ),
        measure(
            "NEAREST that compares, against one texel compared by hand",
            disagreement,
            reads={"one": "compared-nearest.shadow", "other": "one.shadow"},
            at_most=0.0005,
        ),
        measure(
            "in between, of pixels compared by the sampler",
            in_between,
            readings=[
                reading("NEAREST", **of("compared-nearest", "shadow"), equals=0.0, digits=6),
                # How the four are mixed is the driver's own business.
                reading("LINEAR", **of("compared-linear", "shadow")),
            ],
        ),
        *(
            value(
                "compared-nearest.shadow",
                at={
                    "FragPosLightSpace": (0.0, 0.0, depth, 1.0),
                    "FragPos": (0.0, 0.0, 0.0),
                    "Normal": (0.0, 1.0, 0.0),
                },
                equals=equals,
                digits=6,
                name=name,
            )
            for depth, equals, name in (
                (0.99, 1.0, "before the far plane the sampler says dark"),
                (1.01, 0.0, "past the far plane the sampler says nothing"),
            )
        ),
        measure(
            "distance from the nearest step",
            off_the_steps,
            readings=[
                reading("one texel: 0 and 1", **of("one", "shadow", steps=1.0)),
                reading("nine texels: ninths", **of("nine", "shadow", steps=9.0)),
            ],
            at_most=1e-5,
        ),
        measure(
            "different values",
            values,
            readings=[
                reading("one texel", **of("one", "shadow"), equals=2, digits=0),
                reading("nine texels", **of("nine", "shadow"), equals=10, digits=0),
            ],
        ),
        measure(
            "share of places in between",
            edge,
            readings=[
                reading("one texel", **of("one", *ALL[:2], "upright"), equals=0.0, digits=6),
                reading("nine texels", **of("nine", *ALL[:2], "upright"), between=(0.045, 0.06)),
            ],
        ),
        measure(
            "error against rays",
            error,
            readings=[
                reading("one texel", **of("one", *ALL)),
                reading("nine texels", **of("nine", *ALL)),
            ],
            between=(0.06, 0.09),
        ),
    ],
)
