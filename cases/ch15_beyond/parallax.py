"""Parallax: a flat wall, read where the ray from the eye would meet its stones.

A normal map changes how a flat wall is lit, not where things are seen. Parallax mapping walks along
the ray below the wall's plane, in layers of equal depth, until the texture says that the stones are
above; between the last two places a line is as good as it gets. For stones of one depth d that is
exact: the place moves by d · v.xy / v.z; for a slope, too. The loop is counted. The well-known
listing ends it only when a sum of n times 1/n reaches the depth. Of the numbers of layers that it
uses, 8 to 32, six add up to less than 1 in floats: at the very bottom it takes a step too many. A
depth past 1 would keep it going for long.

Look at: a wall with a lamp close by, seen from its lower left. Left it is flat, with its light but
no depth; right the stones stand out, hide each other and throw shadows.

Try: in `ch15_beyond/parallax.frag` write `at + along` for `at + along * (below / (below - last))`:
the stones fall apart into slices.
"""

import numpy as np

from shaderlab import Case, Texture, measure
from shaderlab.glslmath import clamp, mix, normalize, smoothstep, vec3, vec4

from ..scenes.drawing import encoded
from ..scenes.figures import results
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, panel_pass, square

LAYERS, SIDE, SCALE = 32, 128, 0.09
SHADER = "ch15_beyond/parallax.frag"
EYE, LAMP = np.array([-0.2, -0.5, 0.9]), np.array([0.75, 0.9, 0.45])
# The shader filters.
TEXELS = {"filter": ("nearest", "nearest"), "wrap": ("repeat", "repeat")}


def stones():
    """Depths of round stones in mortar: those of a jittered lattice, 5 by 5, without seams."""
    random = np.random.default_rng(7)
    centre = np.stack(np.mgrid[0:5, 0:5], -1) + random.uniform(0.15, 0.85, (5, 5, 2))
    place = np.stack(np.mgrid[0:SIDE, 0:SIDE], -1)[..., None, :] / SIDE * 5.0
    away = np.abs(place - centre.reshape(-1, 2))
    away = np.sort(np.linalg.norm(np.minimum(away, 5.0 - away), axis=-1), axis=-1)
    edge = np.clip((away[..., 1] - away[..., 0]) / 0.42, 0.0, 1.0)
    depth = 1.0 - (1.0 - (1.0 - edge) ** 3) * 0.92
    return np.repeat(depth[..., None], 4, axis=-1)


DEPTHS = stones().astype(np.float32)


def wall(scale, at):
    """The wall through its parallax."""
    uniforms = {"eye": EYE, "lamp": LAMP, "scale": scale}
    textures = {"depths": Texture(image=DEPTHS, **TEXELS)}
    return panel(SHADER, {"place": square(0.0, 1.0)}, uniforms, textures=textures, cell=at)


def depth_at(at):
    """The texture, filtered linearly and repeated, in float64."""
    place = at * SIDE - 0.5
    low = np.floor(place).astype(int)
    x, y = (place - low).T
    left, right = low[:, 0] % SIDE, (low[:, 0] + 1) % SIDE
    of = DEPTHS[..., 0].astype(float)

    def row(j):
        return of[j % SIDE, left] * (1.0 - x) + of[j % SIDE, right] * x

    found = row(low[:, 1]) * (1.0 - y) + row(low[:, 1] + 1) * y
    return found[:, None]


def met(place, scale):
    """Where rays meet the stones."""
    along = (EYE[:2] - place) / EYE[2] * scale / LAYERS
    at, depth, below = place, 0.0, depth_at(place)
    last = below
    for _ in range(LAYERS):
        going = below > 0.0
        last = np.where(going, below, last)
        at = np.where(going, at - along, at)
        depth = np.where(going, depth + 1.0 / LAYERS, depth)
        below = np.where(going, depth_at(at) - depth, below)
    moved = below < last
    return np.where(moved, at + along * below / np.where(moved, below - last, 1.0), at)


def unshaded(at, lamp, scale):
    """How much of the lamp is seen over the stones."""
    depth, above = depth_at(at), 0.0
    along = lamp[:, :2] / lamp[:, 2:] * scale
    for k in range(1, 17):
        up = depth * k / 16.0
        above = np.maximum(above, depth - up - depth_at(at + along * up))
    return 1.0 - clamp(8.0 * above, 0.0, 1.0)


def pixels():
    """The places of a panel's pixels."""
    steps = (np.arange(36) + 0.5) / 36.0
    return np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)


def seen(scale):
    """A panel of the small picture in float64."""
    place = pixels()
    at = met(place, scale)
    sides = (np.array([0.004, 0.0]), np.array([0.0, 0.004]))
    slope = np.hstack([depth_at(at + off) - depth_at(at - off) for off in sides]) / 0.008
    normal = normalize(vec3(0.10 * slope, 1.0))
    lamp = normalize(LAMP - vec3(place, 0.0))
    light = np.maximum((normal * lamp).sum(-1, keepdims=True), 0.0) * unshaded(at, lamp, scale)
    share = smoothstep(0.1, 0.9, depth_at(at))
    stone = mix(vec3(0.62, 0.50, 0.40), vec3(0.16, 0.13, 0.12), share)
    color = stone * (0.12 + 1.5 * light * np.array([1.0, 0.86, 0.66]))
    return np.asarray(vec4(encoded(color), 1.0)).reshape(36, 36, 4)


def unlike(color):
    """The share of pixels a thirtieth of a code of eight bits or more from the same in float64."""
    truth = np.concatenate([seen(0.0), seen(SCALE)], axis=1)
    return 1.0 - np.mean(np.abs(color - truth).max(axis=-1) < 2.0**-13)


def elsewhere(shifted):
    """The share of places that are off by more than a hundredth of a texel."""
    truth = np.concatenate([met(pixels(), s).reshape(36, 36, 2) for s in (0.0, SCALE)], axis=1)
    return 1.0 - np.mean(np.abs(shifted - truth).max(axis=-1) <= 0.01 / SIDE)


def too_many():
    """Of 8 … 32 layers, how many add up to less than 1 in 32-bit floats."""
    parts = [np.full(n, np.float32(1.0) / np.float32(n)) for n in range(8, 33)]
    return sum(bool(np.add.accumulate(part)[-1] < 1.0) for part in parts)


def from_plane(level, slope):
    """How far places are from where rays meet a plane: its depth in the middle, and its slope."""

    def furthest(shifted):
        steps = 0.35 + 0.3 * (np.arange(16) + 0.5) / 16.0
        place = np.stack(np.meshgrid(steps, steps), -1)
        view = (EYE[:2] - place) / EYE[2] * SCALE
        depth = (level + slope * (place[..., :1] - 0.5)) / (1.0 + slope * view[..., :1])
        return np.abs(shifted - (place - depth * view)).max()

    return furthest


def plane(name, level, slope):
    """A pass over the middle of a plane."""
    depths = level + slope * ((np.arange(SIDE) + 0.5) / SIDE - 0.5)
    image = np.broadcast_to(depths[None, :, None], (4, SIDE, 4))
    uniforms = {"eye": EYE, "lamp": LAMP, "scale": SCALE}
    textures, domain = {"depths": Texture(image=image, **TEXELS)}, {"place": square(0.35, 0.65)}
    of = {"size": (16, 16), "textures": textures, "colors": {"shifted": "rg32f"}}
    return panel_pass(name, SHADER, domain, uniforms, **of)


SMALL, PLACES = {"color": "small.FragColor"}, {"shifted": "small.shifted"}
# Planes: their depth in the middle, and their slope.
PLANES = {"surface": (0.0, 0.0), "even": (0.4, 0.0), "bottom": (1.0, 0.0), "sloping": (0.5, 1.2)}

case = Case(
    title="Parallax",
    section="15.8",
    math=r"p' = p - d(p')\,s\,\frac{v_{xy}}{v_z}",
    passes=(
        *enlarged([wall(s, cell(k, 2)) for k, s in enumerate((0.0, SCALE))], (72, 36), 9),
        *(plane(name, *one) for name, one in PLANES.items()),
    ),
    picture="picture.FragColor",
    columns=("flat", "parallax"),
    expect=[
        measure("unlike the same in float64", unlike, reads=SMALL, at_most=0.0004),
        measure("elsewhere than in float64", elsewhere, reads=PLACES, at_most=0.0004),
        *(
            measure(
                f"from where rays meet a plane: {name}",
                from_plane(*one),
                reads={"shifted": f"{name}.shifted"},
                at_most=2.0**-18,
            )
            for name, one in PLANES.items()
        ),
        enlarged_check(),
        *results({"of 25 numbers of layers, those one step too long": (too_many, 6)}),
    ],
)
