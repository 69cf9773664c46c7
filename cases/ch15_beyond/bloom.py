"""Bloom: what is too bright for a display spills over its neighbours.

A display can't show that a neon tube is eight times as bright as white paper. An eye and a lens
would scatter some of it around, and so the picture is told to: what lies above 1 is taken out,
blurred and added again. As each weight is a product, a blur with 9 × 9 weights is two blurs with
nine, across and upward; and nine samples become five, because one between two texels reads their
mean, weighted by where it lies. Variances add up: the same blur n times is √n times as wide.
Weights that do not add up to 1 would make each of these steps brighter or darker.

Look at: the same neon sign twice. On the left the tubes are cut-out shapes; on the right they
shine.

Try: in `ch15_beyond/bloom_blur.frag` write `1.0` for `1.3846153846`: the glow gets narrower than it
should be.
"""

from itertools import pairwise

import numpy as np

from shaderlab import Case, Output, Texture, formula, measure, reading
from shaderlab.glslmath import (
    abs,
    clamp,
    distance,
    dot,
    exp,
    floor,
    fract,
    length,
    max,
    min,
    mod,
    smoothstep,
    swizzle,
    vec3,
    vec4,
)
from shaderlab.glslmath.sampling import texture, textureLod

from ..scenes.drawing import encoded
from ..scenes.figures import results
from ..scenes.panels import WHOLE, cell, panel, panel_pass, picture, square

SIDE, QUARTER = 160, 40
# Row 12 of Pascal's triangle without its ends.
BINOMIAL = np.array([66, 220, 495, 792, 924, 792, 495, 220, 66]) / 4070.0
SMOOTH = {"filter": ("linear", "linear"), "wrap": ("clamp_to_edge", "clamp_to_edge")}
CHAIN = ("linear_mipmap_nearest", "linear")
RANDOM = np.random.default_rng(4).uniform(0.0, 1.0, (24, 24, 4))
POINT = np.zeros((33, 33, 4))
POINT[16, 16] = 1.0
BOLT = [(0.16, 0.46), (-0.20, -0.04), (0.20, 0.06), (-0.14, -0.46)]


def blurred(name, source, side, times=1):
    """Passes that blur a texture, across and upward in turn."""
    for k in range(2 * times):
        along = (1.0 / side, 0.0) if k % 2 == 0 else (0.0, 1.0 / side)
        yield panel_pass(
            f"{name}-{k}",
            "ch15_beyond/bloom_blur.frag",
            WHOLE,
            {"along": along},
            textures={"image": source},
            size=(side, side),
        )
        source = Output(f"{name}-{k}.FragColor", **SMOOTH)


def sign(strength, column):
    """The sign with its glow, as strong as told."""
    textures = {"scene": Output("scene.FragColor"), "glow": Output("glow-7.FragColor", **SMOOTH)}
    uniforms = {"strength": strength}
    return panel("ch15_beyond/bloom.frag", WHOLE, uniforms, textures=textures, cell=cell(column, 2))


def to_segment(at, start, end):
    """How far a place is from a line between two others."""
    along = np.subtract(end, start)
    part = clamp(dot(at - np.array(start), along) / dot(along, along), 0.0, 1.0)
    return distance(at, np.array(start) + part * along)


def bricks(at):
    """How bright the wall's bricks are."""
    x, y = 4.0 * swizzle(at, "x"), 8.0 * swizzle(at, "y")
    x = x + 0.5 * mod(floor(y) + 0.5, 2.0)
    aside, above = (0.5 - abs(fract(c) - 0.5) for c in (x, y))
    return 0.25 + 0.75 * (smoothstep(0.04, 0.12, aside) * smoothstep(0.08, 0.20, above))


def tube(away, hue, wall):
    """A tube's light, and that on the wall about it."""
    core = 1.0 - smoothstep(0.020, 0.034, away)
    return vec3(*hue) * (8.0 * core + 0.30 * wall * exp(-5.0 * away))


def neon(place):
    """The sign: a ring and a bolt before bricks, in light."""
    wall = bricks(place)
    a, b, c = (to_segment(place, *ends) for ends in pairwise(BOLT))
    light = vec3(0.010, 0.012, 0.020) * wall
    light = light + tube(abs(length(place) - 0.70), (1.0, 0.08, 0.30), wall)
    return vec4(light + tube(min(a, min(b, c)), (0.10, 0.55, 1.0), wall), 1.0)


def bright(scene, TexCoords):
    """What is above 1, in its own colour."""
    light = swizzle(textureLod(scene, TexCoords, 2.0), "rgb")
    r, g, b = (swizzle(light, name) for name in "rgb")
    most = max(r, max(g, b))
    return vec4(light * (max(most - 1.0, 0.0) / max(most, 0.0001)), 1.0)


def blur(image, TexCoords, along):
    """Five samples with nine texels' weights."""
    total = 0.2270270270 * swizzle(texture(image, TexCoords), "rgb")
    for weight, offset in ((0.3162162162, 1.3846153846), (0.0702702703, 3.2307692308)):
        pair = [swizzle(texture(image, TexCoords + k * offset * along), "rgb") for k in (1.0, -1.0)]
        total = total + weight * (pair[0] + pair[1])
    return vec4(total, 1.0)


def shown(scene, glow, TexCoords, strength):
    """Both together on a display."""
    light, around = (swizzle(texture(image, TexCoords), "rgb") for image in (scene, glow))
    return vec4(encoded(1.0 - exp(-(light + strength * around))), 1.0)


def by_numpy(blurred):
    """The largest difference from all 81 weights at once, on whole texels."""
    padded = np.pad(RANDOM[..., :3], ((4, 4), (4, 4), (0, 0)), mode="edge")
    total = np.zeros_like(RANDOM[..., :3])
    for (y, x), weight in np.ndenumerate(np.outer(BINOMIAL, BINOMIAL)):
        total += weight * padded[y : y + 24, x : x + 24]
    return np.abs(blurred[..., :3] - total).max()


def spread(times):
    """Between which variances a point lies after so many blurs: with weights of eight bits, as
    Direct3D demands of filters (11.3 functional specification, 7.18.8), a place between two texels
    is off by up to 1/256. OpenGL demands nothing.

    The mean of texels k and k + 1 by 1 - t and t has the variance k² + (2 k + 1) t.
    """
    exact = float((BINOMIAL * (np.arange(9) - 4.0) ** 2).sum())
    off = 2.0 * (3.0 * 0.3162162162 + 7.0 * 0.0702702703) / 256.0
    return times * (exact - off), times * (exact + off)


def variance(spot):
    """How widely a point is spread from left to right, in squares of texels."""
    across = spot[..., 0].sum(axis=0)
    return float((across * (np.arange(33) - 16.0) ** 2).sum() / across.sum())


case = Case(
    title="Bloom",
    section="15.4",
    math=r"c' = c + s \cdot G * \max(c - 1, 0), \qquad G(x, y) = g(x)\,g(y), \qquad "
    r"\sigma^2_{n} = n\,\sigma^2_1",
    passes=(
        panel_pass("scene", "ch15_beyond/bloom_scene.frag", {"place": square()}, size=(SIDE, SIDE)),
        panel_pass(
            "bright",
            "ch15_beyond/bloom_bright.frag",
            WHOLE,
            textures={
                "scene": Output(
                    "scene.FragColor", mipmaps=True, filter=("linear_mipmap_nearest", "linear")
                )
            },
            size=(QUARTER, QUARTER),
        ),
        *blurred("glow", Output("bright.FragColor", **SMOOTH), QUARTER, 4),
        *blurred("random", Texture(image=RANDOM, **SMOOTH), 24),
        *blurred("point", Texture(image=POINT, **SMOOTH), 33, 3),
        picture([sign(0.0, 0), sign(0.7, 1)], (2 * SIDE, SIDE)),
    ),
    picture="picture.FragColor",
    columns=("without", "with"),
    expect=[
        formula("scene.FragColor", neon, name="a neon sign"),
        formula("bright.FragColor", bright, name="what is above 1"),
        *(formula(f"glow-{k}.FragColor", blur) for k in range(8)),
        formula("random-0.FragColor", blur, name="across"),
        formula("picture.FragColor", shown, draw=0, name="without its glow"),
        formula("picture.FragColor", shown, draw=1, name="with its glow"),
        measure("81 weights", by_numpy, reads={"blurred": "random-1.FragColor"}, at_most=0.0031),
        measure(
            "variance",
            variance,
            readings=[
                reading(f"{n} ×", reads={"spot": f"point-{last}.FragColor"}, between=spread(n))
                for n, last in ((1, 1), (3, 5))
            ],
        ),
        *results({"the weights": (2.0 * (0.3162162162 + 0.0702702703) + 0.2270270270, 1.0)}),
    ],
)
