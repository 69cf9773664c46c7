"""Distance fields: a scene that is one function, and rays that walk through it.

A function gives each place its distance to the nearest surface. A ray may then go as far as that
without hitting anything, again and again; where the distance is about 0 it has arrived. For that no
distance may be too large: the function may nowhere grow faster than the place moves. The minimum of
two such functions is one as well, and so is the blend that melts solids together. The same function
gives normals, by where it grows, the soft edge of shadows, by how close a ray to the lamp passes
by, and dark corners, where a place away from the surface is still near to it.

Look at: a drop that melts into a ring, a ball and a block of candy, on a floor that goes on to the
horizon. No triangle was drawn but the one that covers the window.

Try: in `lib/solids.glsl` write `vec3(0.0, 1.32, 0.0)` for `vec3(0.0, 0.72, 0.0)`: the drop leaves
the ring.
"""

import numpy as np

from shaderlab import Case, Ramp, formula, measure
from shaderlab.glslmath import (
    clamp,
    cos,
    dot,
    max,
    mix,
    normalize,
    pow,
    reflect,
    smoothstep,
    step,
    swizzle,
    vec3,
    vec4,
    where,
)

from ..scenes.cameras import camera, camera_rays
from ..scenes.drawing import chessboard, encoded
from ..scenes.figures import results
from ..scenes.panel_checks import smaller_check, softened_check
from ..scenes.panels import panel, panel_pass, picture, softened_pass
from ..scenes.solids import to_scene, to_torus

EYE = (0.0, 2.1, 5.6)
RAYS = camera_rays(**camera(EYE, (0.0, 0.55, 0.0), 34.0, 1.6))
LAMP = np.array([-0.48, 0.64, 0.6])
SMALL = (64, 40)
BALL, RADIUS = np.array([-1.75, 0.5, 0.3]), 0.5
SLICE = Ramp((-2.6, -0.2, 0.1), (5.2, 0.0, 0.0), (0.0, 2.0, 0.0))


def rays():
    """The directions of the small picture's pixels, of unit length."""
    x, y = ((np.arange(n) + 0.5) / n for n in SMALL)
    place = np.array(RAYS.origin) + x[None, :, None] * np.array(RAYS.dx)
    return normalize((place + y[:, None, None] * np.array(RAYS.dy)).reshape(-1, 3))


def walked(direction):
    """How far rays go, in steps of the distance."""
    far, away = np.zeros((len(direction), 1)), np.ones((len(direction), 1))
    for _ in range(72):
        going = (far < 24.0) & (away > 0.0001)
        away = np.where(going, to_scene(np.array(EYE) + far * direction), away)
        far = np.where(going, far + away, far)
    return far


def outward(place):
    """Normals, from the distances at four places around."""
    ends = np.array([[1, -1, -1], [-1, -1, 1], [-1, 1, -1], [1, 1, 1]]) * 0.5773
    return normalize(sum(end * to_scene(place + 0.001 * end) for end in ends))


def unshaded(place):
    """How much of the lamp is seen."""
    open_, along = np.ones((len(place), 1)), np.full((len(place), 1), 0.03)
    for _ in range(24):
        away = to_scene(place + along * LAMP)
        open_ = np.minimum(open_, 9.0 * away / along)
        along = along + clamp(away, 0.04, 0.35)
    return smoothstep(0.0, 1.0, open_)


def seen(direction):
    """The small picture in float64, by its rays."""
    far = walked(direction)
    height = clamp(2.0 * swizzle(direction, "y"), 0.0, 1.0)
    sky = mix(vec3(0.62, 0.75, 0.92), vec3(0.16, 0.33, 0.66), height)
    place = np.array(EYE) + far * direction
    normal = outward(place)
    above = step(0.01, swizzle(place, "y"))
    field = vec3(0.55 - 0.23 * chessboard(swizzle(place, "xz")))
    candy = 0.5 + 0.4 * cos(1.5 * swizzle(place, "x") + np.array([0.2, 1.7, 2.9]))
    corner = clamp(0.4 + 2.4 * to_scene(place + 0.25 * normal), 0.0, 1.0)
    light = max(dot(normal, LAMP), 0.0) * unshaded(place + 0.002 * normal)
    gloss = pow(max(dot(reflect(direction, normal), LAMP), 0.0), 40.0)
    lit = light * np.array([1.15, 1.02, 0.85]) + corner * (0.25 + 0.2 * swizzle(normal, "y")) * sky
    color = mix(field, candy, above) * lit + 0.35 * above * gloss * light
    color = where(far < 24.0, mix(color, sky, smoothstep(10.0, 24.0, far)), sky)
    return vec4(encoded(color), 1.0)


def unlike(color):
    """How many pixels are a sixteenth of a code of eight bits or more from the same in float64, but
    for those at edges, where rays that turn by a hundred-thousandth see something else."""
    exact = np.asarray(seen(rays()))
    turns = 1e-5 * np.array([[1.0, 1.0, 0.0], [-1.0, -1.0, 0.0]])
    turned = np.stack([seen(normalize(rays() + turn)) for turn in turns])
    steady = np.abs(turned - exact).max(axis=(0, 2)) < 2.0**-10
    alike = np.abs(color.reshape(-1, 4) - exact).max(axis=-1) < 2.0**-12
    return np.count_nonzero(steady & ~alike) if steady.mean() > 0.98 else np.nan


def from_roots(far):
    """How far rays end from where they meet the ball, by the roots of its quadratic."""
    direction = np.asarray(rays())
    away = np.array(EYE) - BALL
    half = direction @ away
    square = half**2 - (away @ away - RADIUS**2)
    first = -half - np.sqrt(np.maximum(square, 0.0))
    return np.abs(far.reshape(-1) - first)[square > 0.01].max()


def steepest(away):
    """The largest difference of neighbours, as a share of the way between them."""
    across, up = (5.2 / away.shape[1], 2.0 / away.shape[0])
    along_x, along_y = np.diff(away[..., 0], axis=1) / across, np.diff(away[..., 0], axis=0) / up
    return np.max([np.abs(along_x).max(), np.abs(along_y).max()])


def by_law():
    """The distance from one place to a ring."""
    return to_torus(np.array([1.3, 0.4, 0.9]), 0.85, 0.24).item()


def by_points():
    """The same by a million points of its surface."""
    around, across = np.meshgrid(*(np.linspace(0.0, 2.0 * np.pi, 1001),) * 2)
    out = 0.85 + 0.24 * np.cos(across)
    ring = np.stack([out * np.cos(around), 0.24 * np.sin(across), out * np.sin(around)], -1)
    return np.linalg.norm(ring - (1.3, 0.4, 0.9), axis=-1).min()


AWAY, COLOR = {"away": "slice.away"}, {"color": "judged.FragColor"}
FAR = {"far": "judged.far"}
DRAW = panel("ch15_beyond/distance_fields.frag", {"ray": RAYS}, {"eye": EYE, "lamp": LAMP})

case = Case(
    title="Distance fields",
    section="15.7",
    math=r"t_{k+1} = t_k + d(o + t_k\,v), \qquad |d(p) - d(q)| \le |p - q|",
    passes=(
        picture([DRAW], (640, 400), "scene", colors={"FragColor": "rgba32f"}),
        *softened_pass("scene", (320, 200), domain={}),
        panel_pass("slice", "ch15_beyond/distance_slice.frag", {"place": SLICE}, size=(52, 20)),
        picture([DRAW], SMALL, "judged"),
    ),
    picture="picture.FragColor",
    expect=[
        formula("slice.away", to_scene, name="the distance to the scene"),
        measure(
            "its steepest slope", steepest, reads={"away": "slice.away"}, between=(0.9, 1.0001)
        ),
        measure("pixels unlike float64's", unlike, reads={"color": "judged.FragColor"}, at_most=0),
        measure(
            "the ball, by its quadratic", from_roots, reads={"far": "judged.far"}, at_most=0.001
        ),
        softened_check(),
        smaller_check(),
        *results(
            {"a ring's distance": (by_law, 0.5934), "by a million points": (by_points, 0.5934)},
            digits=4,
        ),
    ],
)
