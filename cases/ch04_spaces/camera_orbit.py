"""A camera on a circle: only the view matrix changes from one frame to the next.

The eye is at (r sin α, h, r cos α), the target stays, and each frame computes a new view matrix
from the two. Nothing in the world moves. That its picture turns the other way is the same matrix
read twice: a camera that goes round to the right sees the world go round to the left.

Look at: the strip, row by row from the upper left, twelve frames 30° apart. The F is read from the
front in the first and from behind in the seventh; the light stays where it is in the world, so the
side that is lit comes and goes.

Try: in `ch04_spaces/camera_orbit.vert` write `vec3(0.4, 1.0, 0.0)` for `vec3(0.0, 1.0, 0.0)`: the
camera tilts, and the ground leans to one side in the first frame and to the other in the seventh.
"""

from math import hypot, radians

import numpy as np

from shaderlab import Case, formula, sweep
from shaderlab.glslmath import mul, vec3, vec4
from shaderlab.reference.spaces import in_camera, orbit_eye
from shaderlab.reference.transforms import perspective

from ..scenes import stage
from ..scenes.figures import each_draw, figures, results
from ..scenes.laws import unchanged
from ..scenes.panels import cell
from ..scenes.props import letter_among_solids

FRAMES = range(12)
SOME = {k: f"frame {k}" for k in FRAMES[::3]}
RADIUS, HEIGHT = 4.6, 2.0
MIDDLE = (0.0, 0.4, 0.0)
PROJECTION = perspective(radians(34.0), 4.0 / 3.0, 0.1, 20.0)
SCENE = letter_among_solids()


def frame(k):
    """One place on the circle; Vulkan bounds a sine's error on −180°…180° only, GLSL nowhere."""
    angle = radians((360.0 * k / len(FRAMES) + 180.0) % 360.0 - 180.0)
    circle = {"angle": angle, "radius": RADIUS, "height": HEIGHT, "projection": PROJECTION}
    place = cell(k, 4, 3, from_above=True)
    return stage.subject("ch04_spaces/camera_orbit.vert", SCENE, circle, cell=place)


def seen(aPos, angle, radius, height):
    """A vertex in the camera's frame."""
    return in_camera(aPos, orbit_eye(angle, radius, height), vec3(*MIDDLE), vec3(0.0, 1.0, 0.0))


def position(aPos, angle, radius, height, projection):
    """Clip coordinates of the vertex."""
    return mul(projection, vec4(seen(aPos, angle, radius, height), 1.0))


def ahead(degrees):
    """Where the target is in the camera's frame: always on the axis, at one distance."""
    return seen(vec3(*MIDDLE), radians(degrees), RADIUS, HEIGHT)


NEAR_BY = {"angle": radians(30.0), "radius": 0.01, "height": MIDDLE[1]}
NO_PROJECTION = {"aPos": (3.0, 2.0, 1.0), **NEAR_BY, "projection": np.eye(4)}
NEAR, NEARBY = "close to the target, without a projection", (2.098076, 1.6, 2.356025, 1.0)
SMALL = "so small a circle passes on little of what sine and cosine may err"
EYES = {0: (0.0, 1.0, 5.0), 30: (2.5, 1.0, 4.330127), 90: (5.0, 1.0, 0.0)}
AHEAD = (0.0, 0.0, -hypot(RADIUS, HEIGHT - MIDDLE[1]))

case = Case(
    title="A camera in orbit",
    section="4.3",
    math=r"e(\alpha) = (r \sin\alpha,\ h,\ r \cos\alpha), \qquad "
    r"V(\alpha) = \text{lookAt}(e(\alpha), \text{target}, \text{up})",
    passes=stage.photographed([frame(k) for k in FRAMES], (1120, 630)),
    picture="picture.FragColor",
    rows=("0° to 90°", "120° to 210°", "240° to 330°"),
    expect=[
        *stage.checks(props=False),
        *each_draw("judged.Eye", orbit_eye, enumerate(FRAMES), "eye of frame {}"),
        *each_draw("judged.gl_Position", position, SOME, "clip coordinates, {}"),
        *stage.color_checks(SOME),
        formula("judged.Normal", unchanged("aNormal")),
        sweep(
            "judged.Eye",
            orbit_eye,
            over="angle",
            at={"aPos": (0.0, 0.0, 0.0)},
            values=np.linspace(-np.pi, np.pi, 49)[1:-1],
            name="the circle",
        ),
        *figures("judged.gl_Position", {NEAR: (NO_PROJECTION, NEARBY, SMALL)}, reference=position),
        *figures(
            "judged.Eye",
            {
                f"the eye at {degrees}°": ({"angle": radians(degrees)}, place)
                for degrees, place in EYES.items()
            },
            at={"aPos": (0, 0, 0), "angle": 0.0, "radius": 5.0, "height": 1.0},
            reference=orbit_eye,
        ),
        *results(
            {
                f"the target in the camera's frame at {degrees}°": (ahead(degrees), AHEAD)
                for degrees in (0, 30, 135)
            },
            digits=12,
        ),
    ],
)
