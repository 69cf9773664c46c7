"""The white furnace: how much light a reflection model loses where none may be lost.

Put a ball of perfect mirrors, however rough, into a room that is equally bright on every side. All
light that falls on it leaves it again, so it looks as bright as the room: it cannot be seen. Two
sums must be right for that. D, weighted by n·h, has the integral 1 over the hemisphere, as the tiny
mirrors seen from above cover the surface once. And the reflected share may never exceed 1. It does
stay below: light that one mirror throws onto the next is counted as hidden and given up.

Look at: three rows of balls in such a room, roughness from 0.15 to 1. Above, G is GGX's own: smooth
balls vanish, rough ones darken by the light of second bounces that the model leaves out. In the
middle, the rational approximation with k = α/2. Below, with k = (roughness + 1)²/8, which is made
for lamps: in light from everywhere even the smoothest ball has a black rim. The shader adds up 128
halfway vectors, as few as show that; at n·v = 0.7 and roughness 0.5 they give 0.893975 where the
integral is 0.884792.

Try: in `lib/furnace.glsl` write `form == SKY ?` for `form == DIRECT ?`: the middle and the lower
row change places.
"""

import numpy as np

from shaderlab import Case, across, formula, measure, reading, up
from shaderlab.glslmath import (
    clamp,
    floor,
    fract,
    length,
    max,
    mix,
    sqrt,
    swizzle,
    vec2,
    vec3,
    vec4,
    where,
)
from shaderlab.reference import microfacets

from ..scenes import furnace
from ..scenes.drawing import change, encoded, pixel_size
from ..scenes.figures import figure, results
from ..scenes.panels import WHOLE, panel_pass

PICTURE = "ch05_lighting/pbr_furnace_picture.frag"
LEVELS = 16
RING = np.cos((np.arange(8) + 0.5) / 8.0 * np.pi)
# Ten rows of pixels, whose middles are 0.1, 0.2, …, 1.
ROUGHNESS = up(0.05, 1.05)
ROWS = [round(0.1 * k, 1) for k in range(1, 11)]
SERIES = {"direct": "k for lamps", "sky": "k = α/2", "smith": "GGX's own G"}
FORMS = {
    "direct": microfacets.shadowing,
    "sky": microfacets.shadowing_under_sky,
    "smith": microfacets.masking,
}


def share(half_of_g):
    """The reflected share with one form of G."""

    def reflected(normalView, roughness, ring):
        return furnace.reflected_share(normalView, roughness, half_of_g, LEVELS, ring)

    return reflected


def facing(t, roughness):
    """D·(n·h) dω over t, where t³ is the sine of the angle to the halfway vector."""
    sine = t * t * t
    halfway = vec3(sine, 0.0, sqrt(1.0 - sine * sine))
    d = microfacets.distribution_of(vec3(0.0, 0.0, 1.0), halfway, roughness)
    return 6.0 * microfacets.PI * (t * t * t * t * t) * d


def balls(TexCoords, frag_coord, ring, light):
    """The picture: what each ball sends back of the light around it, encoded."""

    def of_row(place):
        return clamp(floor(swizzle(place, "y") / 1.66), 0.0, 2.0)

    def outwards(at):
        place = 6.0 * at - vec2(0.0, 0.51)
        up = swizzle(place, "y") - 1.66 * (of_row(place) + 0.5)
        return length(vec2(fract(swizzle(place, "x")) - 0.5, up) / 0.46)

    place, off = 6.0 * TexCoords - vec2(0.0, 0.51), outwards(TexCoords)
    rough = 0.15 + 0.17 * floor(swizzle(place, "x"))
    cosine = max(sqrt(max(1.0 - off * off, 0.0)), 0.02)
    row = of_row(place)

    def half_of_g(cosine, roughness):
        direct, sky, smith = (form(cosine, roughness) for form in FORMS.values())
        return where(row > 1.5, smith, where(row > 0.5, sky, direct))

    of_ball = share(half_of_g)(cosine, rough, ring)
    size = pixel_size(TexCoords, (0.0, 0.0), frag_coord)
    edge = clamp((1.0 - off) / change(outwards, TexCoords, size) + 0.5, 0.0, 1.0)
    seen = mix(1.0, where(off < 1.05, of_ball, 1.0), edge)
    return vec4(encoded(light * vec3(1.0, 0.95, 0.87) * seen), 1.0)


def covered(facing, row):
    """∫ D (n·h) dω: the mean over t, by the midpoint rule with one node a pixel."""
    return facing[int(row)].mean()


def lost(share, row):
    """What a furnace loses at a rough surface, all directions together: 1 − 2 ∫ E(μ) μ dμ."""
    cosines = (np.arange(share.shape[1]) + 0.5) / share.shape[1]
    return 1.0 - 2.0 * (share[int(row), :, 0] * cosines).mean()


def brightest(share):
    """The largest share that any pixel reflects."""
    return share.max()


def reading_of(output, row):
    """One point of one of the curves of loss; 0 at least, or there would be light from nowhere."""
    return reading(
        ROWS[row],
        reads={"share": f"table.{output}"},
        given={"row": row},
        series=SERIES[output],
        between=(0.0, 0.64),  # the loss grows with the roughness, up to 0.623 at 1: see below
    )


def loss_at(output, row, equals):
    """One figure of the loss, to three digits."""
    return reading(
        f"{SERIES[output]}, roughness {ROWS[row]:g}",
        reads={"share": f"table.{output}"},
        given={"row": row},
        equals=equals,
        digits=3,
    )


def of_point(output, normal_view, roughness, equals):
    """The share at one angle and roughness."""
    name = f"{SERIES[output]}: share at n·v = {normal_view:g}, roughness {roughness:g}"
    at = {"normalView": normal_view, "roughness": roughness}
    return figure(f"table.{output}", name, at, equals)


def by_directions(form, equals, excess):
    """An independent figure: the integral over directions of light instead of halfway vectors; and
    by how much the 128 halfway vectors of the shader give more."""

    def integral():
        return furnace.reflected_share_by_directions(0.7, 0.5, FORMS[form])

    def difference():
        few = furnace.reflected_share(0.7, 0.5, FORMS[form], LEVELS, RING)
        return few - integral()

    place = f"{SERIES[form]}: the share at (0.7, 0.5)"
    return results(
        {
            f"{place}, by directions of light": (integral, equals),
            f"{place}, what 128 halfway vectors add": (difference, excess),
        }
    )


STRAIGHT_ON = "GGX's own G: share straight on, the cosine rounded up past 1"
PAST_1 = 1.0 + 2.0**-23

case = Case(
    title="The white furnace",
    section="5.13",
    math=r"\int_\Omega D(h)\,(n \cdot h)\,d\omega_h = 1, \qquad "
    r"E(v) = \int_\Omega \frac{D\,G}{4\,(n \cdot v)}\,d\omega_l \le 1",
    passes=(
        panel_pass(
            "facing",
            "ch05_lighting/pbr_facing.frag",
            {"t": across(0.0, 1.0), "roughness": ROUGHNESS},
            size=(64, 10),
        ),
        panel_pass(
            "table",
            "ch05_lighting/pbr_furnace.frag",
            {"normalView": across(0.0, 1.0), "roughness": ROUGHNESS},
            {"ring": RING},
            size=(32, 10),
        ),
        panel_pass("picture", PICTURE, WHOLE, {"ring": RING, "light": 0.5}),
    ),
    picture="picture.FragColor",
    expect=[
        formula("facing.facing", facing),
        formula("picture.FragColor", balls, name="the picture"),
        *(formula(f"table.{output}", share(form)) for output, form in FORMS.items()),
        measure(
            "∫ D (n·h) dω",
            covered,
            reads={"facing": "facing.facing"},
            readings=[reading(r, given={"row": k}) for k, r in enumerate(ROWS)],
            equals=1.0,
            digits=3,
            x_label="roughness",
        ),
        measure(
            "largest share reflected",
            brightest,
            readings=[
                reading(SERIES[output], reads={"share": f"table.{output}"}) for output in FORMS
            ],
            # Nothing is won, and a smooth surface seen from above loses nothing.
            between=(0.99, 1.0),
        ),
        measure(
            "share lost",
            lost,
            readings=[reading_of(output, row) for output in FORMS for row in range(10)],
            x_label="roughness",
            log_y=True,
        ),
        measure(
            "share lost, in figures",
            lost,
            readings=[
                loss_at("smith", 4, 0.118),
                loss_at("smith", 9, 0.623),
                loss_at("sky", 4, 0.196),
                loss_at("direct", 0, 0.177),
            ],
        ),
        of_point("direct", 0.7, 0.5, 0.710234),
        of_point("sky", 0.7, 0.5, 0.822288),
        of_point("smith", 0.7, 0.5, 0.893975),
        figure("table.smith", STRAIGHT_ON, {"normalView": PAST_1, "roughness": 0.5}, 0.919925),
        *by_directions("direct", 0.704693, 0.005542),
        *by_directions("sky", 0.814652, 0.007635),
        *by_directions("smith", 0.884792, 0.009183),
    ],
)
