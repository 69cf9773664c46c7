"""Euler angles: three turns, one after the other, reach every orientation, and lose one on the way.

Yaw turns the heading around y, pitch lifts the nose around x, roll banks around z. They are nested
like the rings of a gimbal: the yaw ring carries the pitch ring, which carries the roll ring. Pitch
by 90° and the innermost axis has swung into the outermost one. Now yaw and roll do the same thing,
only their difference counts, and no ring can turn in the remaining direction: gimbal lock.

Look at: the rings, green for yaw, red for pitch and blue for roll, each shown around its own axis.
Above, a yaw of 40°, a pitch of 40°, a roll of −40°: three different poses. Below, the nose points
straight up: on the left the blue ring lies in the green one's plane. Then a yaw of 40°, and a roll
of −40°: the two aircraft stand alike.

Try: in `ch03_transforms/euler_angles.vert` write `rolling * (pitching * (yawing * aPos))` for
`yawing * (pitching * (rolling * aPos))`: the roll comes last. The lower two aircraft differ,
although the nose still points straight up.
"""

from math import radians

import numpy as np

from shaderlab import Case, formula
from shaderlab.reference.euler import euler_matrix, euler_turned, gimbal_freedom

from ..scenes import stage
from ..scenes.cameras import camera
from ..scenes.figures import each_draw, figures, results
from ..scenes.glm import euler_by_glm
from ..scenes.laws import projected, renamed
from ..scenes.props import aircraft, gimbal

CAMERA = camera((2.6, 2.1, 4.2), (0.0, 0.0, 0.0), 38.0)
# yaw, pitch, roll in degrees, from the upper left to the lower right
POSES = {
    "yaw": (40.0, 0.0, 0.0),
    "pitch": (0.0, 40.0, 0.0),
    "roll": (0.0, 0.0, -40.0),
    "nose up": (0.0, 90.0, 0.0),
    "nose up, yaw": (40.0, 90.0, 0.0),
    "nose up, roll": (0.0, 90.0, -40.0),
}


def panel(place, pose):
    """One pose: the gimbal and the aircraft in it."""
    yaw, pitch, roll = (radians(angle) for angle in pose)
    yield stage.prop(gimbal(yaw, pitch), CAMERA, cell=place)
    uniforms = {"yaw": yaw, "pitch": pitch, "roll": roll, **CAMERA}
    yield stage.subject("ch03_transforms/euler_angles.vert", aircraft(), uniforms, cell=place)


def wing(yaw, pitch, roll):
    """The right wing's tip in a pose."""
    angles = {"yaw": radians(yaw), "pitch": radians(pitch), "roll": radians(roll)}
    return {"aPos": (1.0, 0.0, 0.0), **angles}


def apart(pitch):
    """Largest difference between yawing by 40° and rolling by −40° at a pitch."""
    yawed = euler_matrix(radians(40.0), radians(pitch), 0.0)
    rolled = euler_matrix(0.0, radians(pitch), radians(-40.0))
    return np.abs(yawed - rolled).max()


AIRCRAFT = {2 * k + 1: name for k, name in enumerate(POSES)}
SAME = "the same matrix: one angle has nothing left to do"

case = Case(
    title="Euler angles and gimbal lock",
    section="3.6",
    math=r"R = R_y(\text{yaw})\,R_x(\text{pitch})\,R_z(\text{roll}), \qquad "
    r"R_y(\alpha)\,R_x(90^\circ)\,R_z(\gamma) = R_y(\alpha - \gamma)\,R_x(90^\circ)",
    passes=stage.gallery(panel, POSES.values(), 3, (960, 640)),
    picture="picture.FragColor",
    rows=("yaw, pitch, roll", "nose up: still, yaw, roll"),
    expect=[
        *stage.checks(),
        *each_draw("judged.Turned", euler_turned, AIRCRAFT, also={"PyGLM": euler_by_glm}),
        *each_draw("judged.Normal", renamed(euler_turned, aPos="aNormal"), AIRCRAFT, "normals, {}"),
        *stage.color_checks(AIRCRAFT),
        formula("judged.gl_Position", projected(euler_turned), name="clip coordinates"),
        *figures(
            "judged.Turned",
            {
                "yaw alone": (wing(40.0, 0.0, 0.0), (0.766044, 0.0, -0.642788)),
                "roll alone": (wing(0.0, 0.0, 40.0), (0.766044, 0.642788, 0.0)),
                "all three": (wing(30.0, 60.0, 45.0), (0.918559, 0.353553, 0.176777)),
                "nose up, then yaw by 40°": (wing(40.0, 90.0, 0.0), (0.766044, 0.0, -0.642788)),
                "nose up, then roll by −40°": (wing(0.0, 90.0, -40.0), (0.766044, 0.0, -0.642788)),
            },
            reference=euler_turned,
        ),
        *results({"yaw 40° against roll −40°, level": (apart(0.0), 0.642788)}),
        *results({"yaw 40° against roll −40°, nose up": (apart(90.0), 0.0, SAME)}, digits=15),
        *results(
            {
                f"volume spanned by the axes at a pitch of {pitch}°": (freedom, volume)
                for pitch, volume in ((0, 1.0), (60, 0.5), (90, 0.0))
                for freedom in [gimbal_freedom(radians(pitch))]
            },
            digits=12,
        ),
    ],
)
