"""Light maps: light that was worked out beforehand, kept in a texture and multiplied in.

Light that never changes need not be computed for each frame. Whatever it took to find it (here four
lamps with Lambert's law and the inverse square; in a game hours of radiosity), the result goes into
a small texture with coordinates of its own: the bricks repeat over the wall, the light does not. A
pixel is then one product, texture times light map, and light changes so slowly from place to place
that a few texels with GL_LINEAR are enough.

Look at: the bricks as they are on the left, the light map alone in the middle, of 24 × 24 texels,
and their product on the right: the colour of each lamp, and the dark between them.
"""

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Draw,
    Pass,
    Ramp,
    State,
    Target,
    Texture,
    assets,
    computed,
    formula,
    value,
)
from shaderlab.glslmath import mix, swizzle, vec4
from shaderlab.reference.light_maps import baked
from shaderlab.sampling import texture

# On a wall of 1 × 1: where each lamp is, how far in front of it, and its colour.
LAMPS = [
    ((0.18, 0.80, 0.16), (1.00, 0.78, 0.48)),
    ((0.80, 0.84, 0.20), (0.40, 0.62, 1.00)),
    ((0.50, 0.22, 0.12), (1.00, 0.44, 0.30)),
    ((0.95, 0.15, 0.30), (0.70, 1.00, 0.75)),
]
SMOOTH = ("linear", "linear")
EDGE = ("clamp_to_edge", "clamp_to_edge")


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
PAIR = np.array([[(0.8, 0.6, 0.4, 1.0)]]), np.array([[(0.5, 0.5, 1.0, 1.0)]])


def wall(diffuse, baked_light, shown, cell, repeat=2.0):
    """A wall with a texture that repeats and a light map that does not."""
    return Draw(
        fragment="ch07_maps/light_map.frag",
        domain={
            "TexCoords": Ramp((0.02, 0.01), (repeat * 1.01, 0.0), (0.0, repeat * 1.02)),
            "LightCoords": Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)),
        },
        uniforms={"shown": shown},
        textures={
            "diffuseMap": Texture(image=diffuse, filter=SMOOTH),
            "lightMap": Texture(image=baked_light, filter=SMOOTH, wrap=EDGE),
        },
        state=State(cell=cell),
    )


WAYS = [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
THIRDS = [Cell(column=k, row=0, columns=3, rows=1) for k in range(3)]


def lit(diffuseMap, lightMap, TexCoords, LightCoords, shown):
    """The texture's colour times the light."""
    color = mix(1.0, swizzle(texture(diffuseMap, TexCoords), "rgb"), swizzle(shown, "x"))
    light = mix(1.0, swizzle(texture(lightMap, LightCoords), "rgb"), swizzle(shown, "y"))
    return vec4(color * light, 1.0)


case = Case(
    title="A light map",
    section="7.2",
    math=r"\text{FragColor} = \text{diffuse}(s, t) \cdot \text{light}(u, v), \qquad "
    r"\text{light} = \sum_k c_k\,\frac{h_k}{\left(d^2 + h_k^2\right)^{3/2}}",
    passes=(
        Pass(
            name="picture",
            target=Target(size=(1152, 384)),
            draws=tuple(
                wall(lambda: assets.brick_wall(512), light, shown, cell)
                for shown, cell in zip(WAYS, THIRDS, strict=True)
            ),
        ),
        Pass(
            name="judged",
            target=Target(size=(111, 41)),
            draws=tuple(
                wall(TEXELS, LIGHT, shown, cell) for shown, cell in zip(WAYS, THIRDS, strict=True)
            ),
        ),
        Pass(
            name="pair",
            target=Target(size=(8, 8)),
            draws=(wall(*PAIR, (1.0, 1.0), Cell(column=0, row=0, columns=1, rows=1)),),
        ),
    ),
    picture="picture.FragColor",
    expect=[
        formula("judged.FragColor", lit, draw=0, name="the texture alone"),
        formula("judged.FragColor", lit, draw=1, name="the light alone"),
        formula("judged.FragColor", lit, draw=2, name="their product"),
        value(
            "pair.FragColor",
            at={"TexCoords": (0.5, 0.5), "LightCoords": (0.5, 0.5)},
            equals=(0.4, 0.3, 0.4, 1.0),
            digits=6,
            reference=lit,
            name="(0.8, 0.6, 0.4) in a light of (½, ½, 1)",
        ),
        value(
            "pair.FragColor",
            at={"TexCoords": (0.5, 0.5), "LightCoords": (0.5, 0.5), "shown": (0.5, 0.25)},
            equals=(0.9 * 0.875, 0.8 * 0.875, 0.7, 1.0),
            digits=6,
            reference=lit,
            name="half of the texture, a quarter of the light",
        ),
        computed(
            "right in front of a lamp, 2 away",
            lambda: baked(np.array([0.0, 0.0]), np.array([0.0, 0.0, 2.0]), 1.0),
            equals=0.25,
            digits=9,
        ),
        computed(
            "3 beside a lamp that is 4 away",
            lambda: baked(np.array([3.0, 0.0]), np.array([0.0, 0.0, 4.0]), 1.0),
            equals=0.032,
            digits=9,
        ),
    ],
)
