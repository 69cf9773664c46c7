"""Soft shadows: a lamp that is not a point, from a shadow map that is drawn from one.

Where half of the lamp is hidden there is half a shadow, and it gets wider the higher above the
floor its caster is: by the lamp's size times the height. Percentage-closer soft shadows look first
how high things in the way are, in the mean, and then count how much is free in a circle of that
size. For one height that is what rays to all of the lamp find. A variance shadow map keeps a mean
height μ and a mean square, which may be blurred and filtered: by Chebyshev's inequality at most
σ²/(σ² + μ²) of what they are means of lies on the floor. With one height above a floor that is no
bound, but the very share. With two heights it is too much, and light leaks through.

Look at: four balls at four heights under a round lamp. Left by variance: all shadows equally soft.
Right percentage-closer: sharp under the ball that lies on the floor, soft under the highest.

Try: in `lib/soft_shadow.glsl` write `lamp * 0.2` for `lamp * heights / blockers`: all shadows are
equally sharp.
"""

import numpy as np

from shaderlab import Case, Output, Texture, formula, measure
from shaderlab.glslmath import mix, normalize, swizzle, vec3, vec4

from ..scenes import round_lamp
from ..scenes.cameras import camera, camera_rays
from ..scenes.drawing import chessboard
from ..scenes.figures import results
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import WHOLE, cell, enlarged, panel, panel_pass, square
from ..scenes.round_lamp import BALLS, LAMP, POINTS, SIDE

EYE = (0.0, 3.4, 4.6)
RAYS = camera_rays(**camera(EYE, (0.0, 0.30, 0.0), 31.0))
SMALL = 26
NEAREST = {"filter": ("nearest", "nearest"), "wrap": ("clamp_to_edge", "clamp_to_edge")}
LINEAR = {"filter": ("linear", "linear"), "wrap": ("clamp_to_edge", "clamp_to_edge")}
WAYS = ("by variance", "percentage-closer")
SHADES = {"map": Output("map.moments", **NEAREST), "means": Output("means.moments", **LINEAR)}


def shown(way, at):
    """A panel of the picture."""
    uniforms = {"points": POINTS, "lamp": LAMP, "balls": BALLS, "eye": EYE, "way": way}
    of = {"textures": SHADES, "cell": at}
    return panel("ch15_beyond/soft_shadows.frag", {"ray": RAYS}, uniforms, **of)


def shares(name, textures, size, **of):
    """Both shares of the lamp over a map."""
    uniforms = {"points": POINTS, "lamp": LAMP}
    shader, domain = "ch15_beyond/soft_shadow_share.frag", {"at": WHOLE["TexCoords"]}
    return panel_pass(name, shader, domain, uniforms, textures=textures, size=size, **of)


def blurred(name, map):
    """Means over 13 × 13 texels."""
    size = (SIDE, SIDE) if name == "means" else (64, 64) if name == "edge" else (16, 16)
    shader = "ch15_beyond/soft_shadow_mean.frag"
    return panel_pass(name, shader, {}, textures={"map": map}, size=size)


def from_rays(closer):
    """The mean and the largest difference from what rays find."""
    return np.abs(closer.ravel() - round_lamp.rays(round_lamp.places(len(closer))))


def seen(share):
    """A panel of the small picture in float64, by what share of the lamp the floor sees."""
    steps = (np.arange(SMALL) + 0.5) / SMALL
    x, y = steps[None, :, None], steps[:, None, None]
    direction = np.array(RAYS.origin) + x * np.array(RAYS.dx) + y * np.array(RAYS.dy)
    direction = normalize(direction.reshape(-1, 3))
    nearest = -EYE[1] / direction[:, 1:2]
    place = np.array(EYE) + nearest * direction
    tile = chessboard(2.0 * swizzle(place, "xz"))
    tile = mix(vec3(0.62, 0.58, 0.52), vec3(0.50, 0.47, 0.43), tile)
    lit = share(0.25 * place[:, ::2] + 0.5) * np.array([0.95, 0.88, 0.76])
    light = tile * (np.array([0.16, 0.18, 0.22]) + lit)
    for k, ball in enumerate(BALLS):
        off = np.array(EYE) - ball[:3]
        half = direction @ off[:, None]
        square = half**2 - off @ off + ball[3] ** 2
        away = -half - np.sqrt(np.maximum(square, 0.0))
        up = (EYE[1] + away * direction[:, 1:2] - ball[1]) / ball[3]
        paint = 0.5 + 0.42 * np.cos(np.array([0.3, 2.3, 4.1]) + 1.6 * k)
        met = (square > 0.0) & (away < nearest)
        light = np.where(met, paint * (0.34 + 0.14 * up + 0.6 * np.maximum(up, 0.0)), light)
        nearest = np.where(met, away, nearest)
    return np.asarray(vec4(light ** (1.0 / 2.2), 1.0)).reshape(SMALL, SMALL, 4)


def unlike(color, map, means):
    """The share of pixels a thirtieth of a code of eight bits or more from the same in float64."""
    panels = [
        seen(lambda at: round_lamp.by_variance(means, at)),
        seen(lambda at: round_lamp.by_closer(map, at)),
    ]
    return 1.0 - np.mean(np.abs(color - np.concatenate(panels, axis=1)).max(axis=-1) < 2.0**-13)


def two_heights():
    """What leaks through two heights, half of each, where nothing of the lamp is seen."""
    mean, square = 0.5 * (0.3 + 1.05), 0.5 * (0.3**2 + 1.05**2)
    return 1.0 - mean**2 / square


# Something with a straight edge, 0.6 above a floor; where a place is no number, nothing is free.
X = (np.arange(64) + 0.5) / 64.0
EDGE = np.zeros((64, 64, 4))
EDGE[:, :32, :2] = 0.6, 0.36
NOISE = np.random.default_rng(15).uniform(0.0, 1.0, (16, 16, 4))
EDGE_SHADES = {"map": Texture(image=EDGE, **NEAREST), "means": Output("edge.moments", **NEAREST)}


def from_share(variance):
    """How far Chebyshev's bound is from the share of 13 texels that are free."""
    free = np.pad(EDGE[0, :, 0] == 0.0, 6, mode="edge")
    share = np.lib.stride_tricks.sliding_window_view(free, 13).mean(axis=-1)
    return np.abs(variance[..., 0] - share).max()


def from_segment(closer):
    """How far percentage-closer is from the part of a circle on one side of an edge."""
    u = np.clip((X - 0.5) / (LAMP * 0.6), -1.0, 1.0)
    share = 0.5 + (u * np.sqrt(1.0 - u * u) + np.arcsin(u)) / np.pi
    return np.abs(closer[..., 0] - share).max()


def from_same(closer):
    """How far percentage-closer is from the same in float64."""
    return np.abs(closer.reshape(-1, 1) - round_lamp.by_closer(EDGE, round_lamp.places(64))).max()


SMALL_COLOR = {"color": "small.FragColor", "map": "map.moments", "means": "means.moments"}
CLOSER = {"closer": "shares.closer"}

case = Case(
    title="Soft shadows",
    section="15.14",
    math=r"w = a\,\bar h, \qquad P \le \frac{\sigma^2}{\sigma^2 + \mu^2}",
    passes=(
        panel_pass(
            "map",
            "ch15_beyond/soft_shadow_map.frag",
            {"place": square(-2.0, 2.0)},
            {"balls": BALLS},
            size=(SIDE, SIDE),
        ),
        blurred("means", Output("map.moments")),
        blurred("edge", Texture(image=EDGE)),
        blurred("noise", Texture(image=NOISE)),
        shares("shares", SHADES, (24, 24), colors={"closer": "r32f"}),
        shares("edge_shares", EDGE_SHADES, (64, 64)),
        *enlarged([shown(k, cell(k, 2)) for k in (0, 1)], (2 * SMALL, SMALL), 9),
    ),
    picture="picture.FragColor",
    columns=("by variance", "percentage-closer"),
    expect=[
        formula("map.moments", round_lamp.moments, name="what the lamp sees"),
        measure(
            "means",
            round_lamp.from_means,
            reads={"map": "map.moments", "means": "means.moments"},
            at_most=2.0**-18,
        ),
        measure(
            "means of random texels",
            lambda means: round_lamp.from_means(NOISE[..., :2], means),
            reads={"means": "noise.moments"},
            at_most=2.0**-18,
        ),
        # Three pixels: of 43,000 texels that are read, float32 may choose a neighbour of some.
        measure("unlike the same in float64", unlike, reads=SMALL_COLOR, at_most=0.003),
        enlarged_check(),
        measure(
            "mean distance from rays",
            lambda closer: from_rays(closer).mean(),
            reads=CLOSER,
            at_most=0.02,
        ),
        measure(
            "one height: from the share that is free",
            from_share,
            reads={"variance": "edge_shares.variance"},
            at_most=2.0**-17,
        ),
        measure(
            "one height: from a circle's segment",
            from_segment,
            reads={"closer": "edge_shares.closer"},
            at_most=0.05,
        ),
        measure(
            "one height: from the same in float64",
            from_same,
            reads={"closer": "edge_shares.closer"},
            at_most=2.0**-20,
        ),
        *results({"light that leaks through two heights": (two_heights, 0.235849)}),
    ],
)
