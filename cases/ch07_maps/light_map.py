"""Light maps: light that was computed in advance, stored in a texture and multiplied in.

Light that never changes need not be computed for each frame. Whatever it took to find it (here four
lamps with Lambert's law and the inverse square; in a game hours of radiosity), the result goes into
a small texture with coordinates of its own: the bricks repeat over the wall, the light does not. A
pixel is then one product, texture times light map, and light changes so slowly from place to place
that a few texels with GL_LINEAR are enough.

Look at: the bricks as they are on the left, the light map alone in the middle, of 24 × 24 texels,
and their product on the right: the colour of each lamp, and the dark between them.

Try: in `ch07_maps/light_map.frag` write `color + light` for `color * light`: light that is added
washes the bricks out.
"""

import numpy as np

from shaderlab import Case, Texture
from shaderlab.glslmath import clamp, mix, swizzle, vec4
from shaderlab.glslmath.sampling import texture, textureSize
from shaderlab.reference.light_maps import baked

from ..scenes import painted_textures
from ..scenes.figures import each_draw, figures, results
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, picture, rectangle, square

# On a wall of 1 × 1: where each lamp is, how far in front of it, and its colour.
LAMPS = [
    ((0.18, 0.80, 0.16), (1.00, 0.78, 0.48)),
    ((0.80, 0.84, 0.20), (0.40, 0.62, 1.00)),
    ((0.50, 0.22, 0.12), (1.00, 0.44, 0.30)),
    ((0.95, 0.15, 0.30), (0.70, 1.00, 0.75)),
]


def light(side=24):
    """The light of all lamps at each texel's centre."""
    v, u = (np.mgrid[0:side, 0:side] + 0.5) / side
    total = sum(
        baked(np.stack([u, v], axis=-1), np.array(place), 0.06 * np.array(color))
        for place, color in LAMPS
    )
    return np.concatenate([0.05 + total, np.ones((side, side, 1))], axis=-1)


RANDOM = np.random.default_rng(72)
TEXELS, LIGHT = RANDOM.random((5, 4, 4)), 2.0 * RANDOM.random((3, 4, 4))
PAIR = np.array([[(0.8, 0.6, 0.4, 1.0)]]), np.full((2, 2, 4), (0.5, 0.5, 1.0, 1.0))
WAYS = [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
PARTS = "the texture alone", "the light alone", "their product"
MIXED = (0.9 * 0.875, 0.8 * 0.875, 0.7, 1.0)


def walls(diffuse, baked_light, ways=WAYS):
    """A wall with a texture that repeats twice and a light map that does not, in each way."""
    smooth = {"filter": ("linear", "linear")}
    textures = {
        "diffuseMap": Texture(image=diffuse, **smooth),
        "lightMap": Texture(image=baked_light, wrap=("clamp_to_edge",) * 2, **smooth),
    }
    domain = {"TexCoords": rectangle((0.02, 0.01), (2.02, 2.04)), "LightCoords": square(0.0, 1.0)}
    for k, shown in enumerate(ways):
        place, fragment = cell(k, len(ways)), "ch07_maps/light_map.frag"
        yield panel(fragment, domain, {"shown": shown}, textures=textures, cell=place)


def lit(diffuseMap, lightMap, TexCoords, LightCoords, shown):
    """The texture's colour times the light, which at an edge is that of the texels there."""
    edge = 0.5 / textureSize(lightMap, 0)
    color = mix(1.0, swizzle(texture(diffuseMap, TexCoords), "rgb"), swizzle(shown, "x"))
    light = texture(lightMap, clamp(LightCoords, edge, 1.0 - edge))
    light = mix(1.0, swizzle(light, "rgb"), swizzle(shown, "y"))
    return vec4(color * light, 1.0)


def white_light(beside, away):
    """The light of a lamp of strength 1, on the wall so far beside it."""
    return baked(np.array([beside, 0.0]), np.array([0.0, 0.0, away]), 1.0)


case = Case(
    title="A light map",
    section="7.2",
    math=r"\text{FragColor} = \text{diffuse}(s, t) \cdot \text{light}(u, v), \qquad "
    r"\text{light} = \sum_k c_k\,\frac{h_k}{\left(d^2 + h_k^2\right)^{3/2}}",
    passes=(
        *enlarged(walls(lambda: painted_textures.brick_wall(512), light), (129, 43), 9),
        picture(walls(TEXELS, LIGHT), (111, 41), "judged"),
        picture(walls(*PAIR, WAYS[2:]), (8, 8), "pair"),
    ),
    picture="picture.FragColor",
    columns=("texture", "light map", "product"),
    expect=[
        enlarged_check(),
        *each_draw("small.FragColor", lit, enumerate(("bricks", "light", "lit bricks"))),
        *each_draw("judged.FragColor", lit, enumerate(PARTS)),
        *figures(
            "pair.FragColor",
            {
                "(0.8, 0.6, 0.4) in a light of (½, ½, 1)": ({}, (0.4, 0.3, 0.4, 1.0)),
                "half of the texture, a quarter of the light": ({"shown": (0.5, 0.25)}, MIXED),
            },
            at={"TexCoords": (0.5, 0.5), "LightCoords": (0.5, 0.5)},
            reference=lit,
        ),
        *results({"right in front of a lamp, 2 away": (white_light(0.0, 2.0), 0.25)}, digits=9),
        *results({"3 beside a lamp that is 4 away": (white_light(3.0, 4.0), 0.032)}, digits=9),
    ],
)
