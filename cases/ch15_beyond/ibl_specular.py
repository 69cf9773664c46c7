"""A glossy surface under a whole sky: one sum becomes the product of two.

What a rough surface mirrors is a sum over its tiny mirrors of sky times reflectance, hundreds of
directions for each pixel. Taken apart, it can be made beforehand: the sky alone, blurred once for
each roughness, and the reflectance alone, two numbers A and B for each angle and roughness. The
colour is about sky · (f0 · A + B). Under an even sky that is no approximation, and A + B is what a
white furnace gets back. Without roughness A + B is 1, and B is Schlick's (1 − n·v)⁵. The sample
points come from the radical inverse, the bits of their number in opposite order: the first 32 are
spread as evenly as can be, and the first four of them are 0, 1/2, 1/4 and 3/4.

Look at: gold in the morning, from a mirror on the left to dull metal on the right, and below it a
black plastic, which shows the sky at its rim only. The blurred sky takes every surface as seen from
straight above: at the rims of the dull balls it is a little wrong, as in all engines that do this.

Try: in `ch15_beyond/ibl_specular.frag` write `f0 * factors.x` for `f0 * factors.x + factors.y`: the
plastic's rims vanish.
"""

import numpy as np

from shaderlab import Case, CubeTexture, Output, across, exact, formula, up
from shaderlab.glslmath import (
    abs,
    clamp,
    cross,
    dot,
    either,
    max,
    mix,
    mul,
    normalize,
    sqrt,
    swizzle,
    vec2,
    vec3,
    vec4,
    where,
)
from shaderlab.glslmath.sampling import texture, textureLod
from shaderlab.reference.microfacets import shadowing_under_sky

from ..scenes.cameras import turned
from ..scenes.drawing import encoded
from ..scenes.figures import figure, results
from ..scenes.furnace import reflected_share_by_directions
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, panel_pass, picture, square
from ..scenes.sky import sky_light
from ..scenes.split_sum import AZIMUTHS, added, factors, halfways

BALLS = 6
BITS = [int(f"{k * 2654435761 % 2**32:032b}"[::-1], 2) for k in range(64)]
CAMERA = turned(80.0)[:3, :3]
GOLD, PLASTIC = (1.0, 0.71, 0.29), (0.04, 0.04, 0.04)
SMOOTH = ("linear_mipmap_linear", "linear")
MORNING = CubeTexture(
    faces=[lambda k=k: sky_light(k, 128, sun=12.0) for k in range(6)], filter=SMOOTH, mipmaps=True
)
# Past white, and texels as large as the steps of its mirrors.
NOISE = CubeTexture(
    faces=list(np.random.default_rng(15).uniform(0.0, 2.0, (6, 4, 4, 4))),
    filter=SMOOTH,
    mipmaps=True,
)
WHITE = CubeTexture(faces=[np.ones((1, 1, 4))] * 6, filter=SMOOTH, mipmaps=True)


def ball(number, f0, sky, at=None, radius=50.0):
    """A ball before the sky: the first of a row is a mirror, the last as rough as can be."""
    uniforms = {
        "azimuths": AZIMUTHS,
        "f0": f0,
        "roughness": number / (BALLS - 1.0),
        "camera": CAMERA,
        "aside": (0.25 * (number - 2.5), 0.0),
        "radius": radius,
    }
    textures = {"sky": sky, "table": Output("table.factors", filter=("linear", "linear"))}
    domain = {"place": square(-1.08, 1.08)}
    return panel("ch15_beyond/ibl_specular.frag", domain, uniforms, textures=textures, cell=at)


def tabled(name, size):
    """The two factors over the cosine and the roughness."""
    domain = {"normalView": across(0.0, 1.0), "roughness": up(0.0, 1.0)}
    uniforms = {"azimuths": AZIMUTHS}
    return panel_pass(name, "ch15_beyond/ibl_specular_table.frag", domain, uniforms, size=size)


def blurred(sky, axis, roughness):
    """The sky around a direction, as blurred as a surface shows it from straight above."""
    pole = where(abs(swizzle(axis, "y")) < 0.9, vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0))
    aside = normalize(cross(pole, axis))
    upward = cross(axis, aside)
    local = halfways(roughness)
    x, y, z = (swizzle(local, name) for name in "xyz")
    rays = 2.0 * z * (x * aside + y * upward + z * axis) - axis
    weights = max(2.0 * z * z - 1.0, 0.0)
    light = weights * swizzle(textureLod(sky, rays, 7.0 * roughness), "rgb")
    return added(light) / added(weights)


def color(place, sky, table, f0, roughness, camera, aside, radius):
    """The blurred sky times the table's factors, or what is behind the ball; encoded."""
    outward = dot(place, place)
    facing = sqrt(max(1.0 - outward, 0.0001))
    axis = mul(camera, vec3(2.0 * facing * place, 1.0 - 2.0 * outward))
    seen = blurred(sky, axis, roughness)
    behind = textureLod(sky, mul(camera, vec3(aside + 0.125 * place, -1.0)), 3.0)
    ball = seen * reflectance(facing, roughness, table, f0)
    return shown(outward, radius, ball, swizzle(behind, "rgb"))


def even(place, table, f0, roughness, radius):
    """The same where the sky is 1 everywhere: f0 · A + B on a ball, without a sum."""
    outward = dot(place, place)
    facing = sqrt(max(1.0 - outward, 0.0001))
    # The weighted mean of 32 ones may be as many roundings away from 1.
    one = either(1.0 - 32.0 * 2.0**-24, 1.0 + 32.0 * 2.0**-24)
    return shown(outward, radius, one * reflectance(facing, roughness, table, f0), vec3(1.0))


def reflectance(facing, roughness, table, f0):
    """f0 · A + B."""
    two = texture(table, vec2(facing, roughness))
    return f0 * swizzle(two, "x") + swizzle(two, "y")


def shown(outward, radius, ball, behind):
    """A ball with a soft edge, one pixel wide, before what is behind it; encoded."""
    edge = clamp(0.5 * radius * (1.0 - outward) + 0.5, 0.0, 1.0)
    return vec4(encoded(mix(behind, ball, edge)), 1.0)


FEW = {"normalView": 0.7, "roughness": 0.5}
LOW = {"normalView": 0.1, "roughness": 1.0}
SLOPE = {"normalView": 0.25, "roughness": 0.0}
SHOWN = [
    ball(number, f0, MORNING, cell(6 * row + number, 6, 2))
    for row, f0 in enumerate((PLASTIC, GOLD))
    for number in range(BALLS)
]

case = Case(
    title="A glossy surface under a sky",
    section="15.2",
    math=r"\int L f\,(n \cdot l)\, d\omega \approx "
    r"\frac{\sum_k L(l_k)(n \cdot l_k)}{\sum_k (n \cdot l_k)}\,(f_0 A + B)",
    passes=(
        tabled("table", (16, 16)),
        panel_pass("bits", "ch15_beyond/ibl_specular_bits.frag", {}, size=(64, 1)),
        *enlarged(SHOWN, (24, 8), 27),
        picture([ball(3, GOLD, WHITE)], (8, 8), "white"),
        picture([ball(3, GOLD, NOISE, radius=5.5)], (12, 12), "noise"),
    ),
    picture="picture.FragColor",
    rows=("gold", "plastic"),
    expect=[
        exact("bits.fraction", np.array(BITS)[None, :, None], name="bits in opposite order"),
        formula("table.factors", factors, name="A and B"),
        formula("small.FragColor", color, draw=8, name="gold, a little rough"),
        formula("noise.FragColor", color, name="a rough ball among random texels"),
        enlarged_check(),
        formula("white.FragColor", even, name="under an even sky there is no approximation"),
        figure("table.factors", "32 points at n·v = 0.7", FEW, (0.831834, 0.004366)),
        figure("table.factors", "without roughness B is (1 − n·v)⁵", SLOPE, (0.762695, 0.237305)),
        figure("table.factors", "far down on a dull surface", LOW, (0.534594, 0.014161)),
        *results(
            {
                "A + B at n·v = 0.7, by directions of light": (
                    lambda: reflected_share_by_directions(0.7, 0.5, shadowing_under_sky),
                    0.814652,
                )
            }
        ),
    ],
)
