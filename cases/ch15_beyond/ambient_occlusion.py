"""Ambient occlusion: corners are dark, because they see less of the sky.

What hides the sky from a place is taken from the depth buffer, which is a landscape: here it is
seen from straight above. SSAO throws points into the half ball above the surface and counts those
that are not below the landscape. At a distance of t radii from a high wall (1 − t)²(2 + t)/4 of
them are in it. Without the normal the points fill a whole ball, and half of them lie below an open
plane: its grey is the mark of the first such pictures. GTAO cuts slices and finds the horizon to
either side; what lies between is integrated by hand, as bright as Lambert's law has it. At the foot
of an endless wall that is ½, and (1 + cos e)/2 where its edge stands at an elevation e.

Look at: pebbles in a tray under a grey sky, which is their only light. Left 64 points, which leave
their pattern, right six slices: what lies deep between the stones gets darker.

Try: in `ch15_beyond/ambient_occlusion.frag` write `points[k];` for `dot(points[k], normal) < 0.0 ?
-points[k] : points[k];`: on the left all turns grey, and the tops of the stones most.
"""

import math

import numpy as np

from shaderlab import Case, Texture, measure, reading
from shaderlab.glslmath import normalize, vec3, vec4

from ..scenes.drawing import encoded
from ..scenes.figures import results
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, panel_pass, rectangle, square
from ..scenes.pebbles import height_at, pebble_at, pebbles

SHADER = "ch15_beyond/ambient_occlusion.frag"
POINTS, SLICES, STEPS, SMALL = 64, 6, 8, 24
# The shader filters.
TEXELS = {"filter": ("nearest", "nearest"), "wrap": ("clamp_to_edge", "clamp_to_edge")}
WAYS, RADIUS = ("SSAO", "GTAO"), 0.1
X = (np.arange(1024) + 0.5) / 1024.0


def spread():
    """Points in a ball: golden angles, heights evenly, and radii as the cube root wants them."""
    k = np.arange(POINTS) + 0.5
    height, turn = 1.0 - 2.0 * k / POINTS, k * math.pi * (3.0 - math.sqrt(5.0))
    out = np.sqrt(1.0 - height**2)
    away = ((k * 0.423) % 1.0) ** (1.0 / 3.0)
    return away[:, None] * np.column_stack([out * np.cos(turn), out * np.sin(turn), height])


POINTS_IN_BALL = spread()
TURNS = math.pi * (np.arange(SLICES) + 0.25) / SLICES
ALONG = np.column_stack([np.cos(TURNS), np.sin(TURNS)])


def settings(way, radius=RADIUS, steps=STEPS):
    """The uniforms."""
    kind = {"way": WAYS.index(way), "radius": radius, "steps": steps}
    return {"points": POINTS_IN_BALL, "slices": ALONG, **kind}


def plain(height):
    """A strip of a landscape whose height depends on x."""
    return np.broadcast_to(np.float32(height(X))[:, None], (4, 1024, 4))


def shown(way, at):
    """The tray in one way."""
    textures, domain = {"landscape": Texture(image=pebbles, **TEXELS)}, {"place": square(0.0, 1.0)}
    return panel(SHADER, domain, settings(way), textures=textures, cell=at)


def strip(name, way, heights, radius=0.2, origin=(0.3, 0.45)):
    """The shares of the sky over a strip of a landscape."""
    domain = {"place": rectangle(origin, (0.2, 0.1))}
    textures = {"landscape": Texture(image=heights, **TEXELS)}
    of = {"textures": textures, "size": (20, 3), "colors": {"sky": "r32f"}}
    return panel_pass(name, SHADER, domain, settings(way, radius, 80), **of)


def by_points(here, normal):
    """The share of points that lie in nothing."""
    side = np.where(normal @ POINTS_IN_BALL.T < 0.0, -1.0, 1.0)
    at = [here + RADIUS * side[:, k : k + 1] * POINTS_IN_BALL[k] for k in range(POINTS)]
    return sum(height_at(one[:, :2]) <= one[:, 2:] for one in at) / POINTS


def by_slices(here, normal):
    """The cosine-weighted share of the sky between the horizons of all slices."""
    total = 0.0
    for along in ALONG:
        inside = normal[:, :2] @ along[:, None]
        lean = np.arctan2(inside, normal[:, 2:])
        for side in (1.0, -1.0):
            rises = [
                (height_at(here[:, :2] + side * far * along) - here[:, 2:]) / far
                for far in RADIUS * np.arange(1, STEPS + 1) / STEPS
            ]
            up = 0.5 * math.pi - np.arctan(np.max(rises, axis=0))
            up = side * np.minimum(up, 0.5 * math.pi + side * lean)
            arc = 0.25 * (np.cos(lean) - np.cos(2.0 * up - lean) + 2.0 * up * np.sin(lean))
            total = total + np.hypot(inside, normal[:, 2:]) * arc
    return total / SLICES


def seen(by):
    """A panel of the small picture in float64."""
    steps = (np.arange(SMALL) + 0.5) / SMALL
    place = np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)
    sides = np.array([[0.002, 0.0], [0.0, 0.002]])
    slope = np.hstack([height_at(place + off) - height_at(place - off) for off in sides]) / 0.004
    here = np.hstack([place, height_at(place)])
    sky = by(here, normalize(vec3(-slope, 1.0)))
    color = np.asarray(vec4(encoded(pebble_at(place)[:, :3] * sky), 1.0))
    return color.reshape(SMALL, SMALL, 4), sky.reshape(SMALL, SMALL, 1)


def unlike(color, sky):
    """The share of pixels a thirtieth of a code of eight bits or more from the same in float64."""
    panels = zip(*map(seen, (by_points, by_slices)), strict=True)
    truth = [np.concatenate(parts, axis=1) for parts in panels]
    apart = [np.abs(a - b).max(axis=-1) for a, b in zip((color, sky), truth, strict=True)]
    return 1.0 - np.mean(np.maximum(*apart) < 2.0**-13)


def from_law(law):
    """The largest difference from a law of the distance to the wall."""

    def furthest(sky):
        away = 0.5 - (0.3 + 0.2 * (np.arange(20) + 0.5) / 20.0)
        return np.abs(sky[..., 0] - law(away)).max()

    return furthest


def law_of_points(away):
    """What of a half ball is not behind the wall."""
    t = away / 0.2
    return 1.0 - (1.0 - t) ** 2 * (2.0 + t) / 4.0


def law_of_arcs(away):
    """The light that comes over a wall's edge, 0.2 above."""
    return 0.5 * (1.0 + away / np.hypot(away, 0.2))


def below():
    """The share of all points that lie below an open plane."""
    return (POINTS_IN_BALL[:, 2] < 0.0).mean()


FLAT, TILTED = plain(lambda x: 0.0 * x), plain(lambda x: 0.5 * x)
LOW, HIGH = (plain(lambda x, h=h: np.where(x > 0.5, h, 0.0)) for h in (0.2, 9.0))
OPEN = {"SSAO, flat": FLAT, "SSAO, tilted": TILTED, "GTAO, flat": FLAT, "GTAO, tilted": TILTED}

BOTH, ARCS = {"color": "small.FragColor", "sky": "small.sky"}, {"sky": "arcs.sky"}

case = Case(
    title="Ambient occlusion",
    section="15.12",
    math=r"a = \frac{1}{4}\sum_{i = 1, 2}\left(\cos\gamma - \cos(2 h_i - \gamma) + 2 h_i "
    r"\sin\gamma\right)",
    passes=(
        *enlarged([shown(way, cell(k, 2)) for k, way in enumerate(WAYS)], (2 * SMALL, SMALL), 9),
        *(strip(name, name[:4], heights) for name, heights in OPEN.items()),
        strip("points", "SSAO", HIGH),
        strip("arcs", "GTAO", LOW, 0.6),
        strip("foot", "GTAO", HIGH, 0.3, (0.2995, 0.45)),
    ),
    picture="picture.FragColor",
    columns=("64 points", "six slices"),
    expect=[
        measure("unlike the same in float64", unlike, reads=BOTH, at_most=0.004),
        enlarged_check(),
        measure(
            "from the whole sky over a plane",
            lambda sky: np.abs(sky - 1.0).max(),
            readings=[
                reading(name, reads={"sky": f"{name}.sky"}, at_most=1e-6 * (name[0] == "G"))
                for name in OPEN
            ],
        ),
        measure(
            "from what 64 points above a plane find of a wall",
            from_law(law_of_points),
            reads={"sky": "points.sky"},
            at_most=0.04,
        ),
        measure("from the light over a wall", from_law(law_of_arcs), reads=ARCS, at_most=0.03),
        measure(
            "the sky from the foot of an endless wall",
            lambda sky: sky[..., -1, 0].mean(),
            reads={"sky": "foot.sky"},
            equals=0.5,
            digits=2,
        ),
        *results({"of a ball's points, those below an open plane": (below, 0.5)}),
    ],
)
