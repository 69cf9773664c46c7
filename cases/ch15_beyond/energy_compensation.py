"""Later bounces: the light that a rough metal loses in its model, given back.

The microfacet model follows light to one tiny mirror and away. What a second mirror catches is
counted as lost, on a rough surface more than half of all light: the white furnace of `pbr-furnace`
shows it. Nature keeps it: after more bounces it leaves in some direction. C. Kulla and A. Conty
("Revisiting Physically Based Shading at Imageworks", 2017) give it back as a second lobe, (1 −
E(v)) (1 − E(l)) / (π (1 − m)): E is the share that one bounce sends back, m its mean over all
directions. The lobe's own share is just what was lost, 1 − E(v), and the sum of both is 1 whatever
the roughness. In a coloured metal each bounce takes its part: later ones are deeper in colour.

Look at: gold under three lamps, from polished to rough. Above is one bounce: it grows dark and pale
to the right. Below are all bounces: it stays gold.

Try: in `lib/energy.glsl` write `average * mean` for `average * average * mean`: later bounces are
as pale as the first one.
"""

from functools import partial

import numpy as np

from shaderlab import Case, Output, across, formula, measure, reading, up
from shaderlab.glslmath import (
    clamp,
    dot,
    ivec2,
    max,
    mix,
    normalize,
    sqrt,
    swizzle,
    vec2,
    vec3,
    vec4,
    where,
)
from shaderlab.glslmath.sampling import texelFetch, texture
from shaderlab.reference import microfacets

from ..scenes import furnace
from ..scenes.drawing import encoded
from ..scenes.figures import each_draw, results
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, panel_pass, picture, square

SIDE = 16
RING = np.cos((np.arange(8) + 0.5) / 8.0 * np.pi)
ROUGHNESS = (0.2, 0.36, 0.52, 0.68, 0.84, 1.0)
LAMPS = [(-0.48, 0.64, 0.6), (0.8, 0.0, 0.6), (0.0, -0.96, 0.28)]
COLORS = [(3.4, 3.3, 3.1), (0.9, 1.1, 1.5), (0.5, 0.35, 0.3)]
GOLD = (1.0, 0.71, 0.29)
TABLES = {"table": Output("table.share", filter=("linear", "linear"))}
TABLES["means"] = Output("means.mean", filter=("linear", "linear"))


def ball(number, later, at=None, radius=50.0):
    """A ball of gold, the later bounces left out or not."""
    uniforms = {"f0": GOLD, "later": later, "lamps": LAMPS, "colors": COLORS, "radius": radius}
    uniforms["roughness"] = ROUGHNESS[number]
    place = {"place": square(-1.08, 1.08)}
    return panel("ch15_beyond/energy.frag", place, uniforms, textures=TABLES, cell=at)


def summed(number, roughness):
    """All directions of light on a white metal, as areas of a disc."""
    uniforms, of = {"roughness": roughness, "view": SLANTED}, {"size": (64, 64), "textures": TABLES}
    shader = "ch15_beyond/energy_sum.frag"
    return panel_pass(f"sum-{number}", shader, {"place": square()}, uniforms, **of)


def share(normalView, roughness, ring):
    """E: the share of one bounce, with GGX's own masking."""
    return furnace.reflected_share(normalView, roughness, microfacets.masking, 16, ring)


def mean(table, frag_coord):
    """2 ∫ E(μ) μ dμ along a row of the table."""
    total, row = 0.0, swizzle(frag_coord, "y")
    for k in range(SIDE):
        total = total + (k + 0.5) * swizzle(texelFetch(table, ivec2(k, row)), "r")
    return 2.0 * total / float(SIDE * SIDE)


def metal(view, light, normal, roughness, f0, later, table, means):
    """f · (n·l) of a metal: one bounce, and `later` times the lobe of all others."""
    half = normalize(view + light)
    cosines = max(dot(normal, view), 0.01), max(dot(normal, light), 0.0)
    masks = microfacets.masking(cosines[0], roughness) * microfacets.masking(cosines[1], roughness)
    d = microfacets.distribution_of(normal, half, roughness)
    first = d * masks / (4.0 * cosines[0]) * microfacets.fresnel(dot(half, view), f0)
    one, other = (swizzle(texture(table, vec2(c, roughness)), "r") for c in cosines)
    mean = swizzle(texture(means, vec2(0.5, roughness)), "r")
    lobe = furnace.later_bounces(1.0 - one, 1.0 - other, mean, f0)
    return first + later * lobe * cosines[1]


def color(place, roughness, f0, later, lamps, colors, radius, table, means):
    """The ball in the light of three lamps; encoded."""
    outward = dot(place, place)
    normal, total = vec3(place, sqrt(max(1.0 - outward, 0.0001))), 0.0
    for lamp, strength in zip(lamps, colors, strict=True):
        toward = vec3(0.0, 0.0, 1.0)
        total = total + strength * metal(toward, lamp, normal, roughness, f0, later, table, means)
    edge = clamp(0.5 * radius * (1.0 - outward) + 0.5, 0.0, 1.0)
    behind = vec3(0.020, 0.024, 0.032) * (1.0 - 0.3 * swizzle(place, "y"))
    return vec4(encoded(mix(behind, total, edge)), 1.0)


def per_area(later):
    """What a metal that absorbs nothing reflects, for each area of the disc of directions."""

    def reflected(place, view, roughness, table, means):
        upright = 1.0 - dot(place, place)
        light = vec3(place, sqrt(max(upright, 0.0001)))
        inside = where(upright > 0.0001, 1.0 / swizzle(light, "z"), 0.0)
        white = metal(view, light, vec3(0.0, 0.0, 1.0), roughness, vec3(1.0), later, table, means)
        return inside * swizzle(white, "r")

    return reflected


def over_disc(share):
    """The sum over the disc, whose square is 4 in area."""
    return 4.0 * share.mean()


SLANTED = (0.6, 0.0, 0.8)
BY_NUMPY = furnace.reflected_share_by_directions
SUMS = (0.52, 0.68, 0.84)
OF_TABLE = {"table": Output("table.share")}
BALLS = [ball(n, 1.0 - row, cell(6 * row + n, 6, 2)) for row in (0, 1) for n in range(6)]

case = Case(
    title="Later bounces",
    section="15.3",
    math=r"f = \frac{D\,F\,G}{4\,(n \cdot v)(n \cdot l)} + "
    r"\frac{(1 - E(v))(1 - E(l))}{\pi\,(1 - m)}\,F_{ms}, \qquad "
    r"F_{ms} = \frac{\bar F^2 m}{1 - \bar F (1 - m)}",
    passes=(
        panel_pass(
            "table",
            "ch15_beyond/energy_table.frag",
            {"normalView": across(0.0, 1.0), "roughness": up(0.0, 1.0)},
            {"ring": RING},
            size=(SIDE, SIDE),
        ),
        panel_pass("means", "ch15_beyond/energy_mean.frag", {}, textures=OF_TABLE, size=(1, SIDE)),
        *(summed(k, rough) for k, rough in enumerate(SUMS)),
        *enlarged(BALLS, (24, 8), 27),
        picture([ball(4, 1.0, radius=5.5)], (12, 12), "edge"),
    ),
    picture="picture.FragColor",
    rows=("one bounce", "all bounces"),
    expect=[
        formula("table.share", share, name="E: the share of one bounce"),
        formula("means.mean", mean, name="its mean over all directions"),
        *each_draw("small.FragColor", color, {1: "all bounces", 11: "one bounce"}),
        formula("edge.FragColor", color, name="a rough ball and its edge"),
        enlarged_check(),
        formula("sum-2.first", per_area(0.0), name="one bounce, by directions of light"),
        formula("sum-2.together", per_area(1.0), name="all bounces, by directions of light"),
        *(
            measure(
                f"{output}: the share that comes back, by directions of light",
                over_disc,
                readings=[
                    reading(rough, reads={"share": f"sum-{k}.{output}"}, **bound)
                    for k, (rough, bound) in enumerate(zip(SUMS, bounds, strict=True))
                ],
                x_label="roughness",
            )
            # The table is made of 128 halfway vectors, and as much off at both ends.
            for output, bounds in (
                ("first", [{"equals": share, "digits": 2} for share in (0.88, 0.71, 0.52)]),
                ("together", [{"between": (0.995, 1.005)}] * 3),
            )
        ),
        *results(
            {
                f"one bounce, roughness {rough:g}, by NumPy": (
                    partial(BY_NUMPY, SLANTED[2], rough, microfacets.masking),
                    share,
                )
                for rough, share in zip(SUMS, (0.880711, 0.712374, 0.516847), strict=True)
            }
        ),
    ],
)
