"""Quaternions: four numbers for an orientation, with no pose in which one of them is lost.

(u sin φ/2, cos φ/2) turns by φ around u, as q v q*: the half angle is there because q acts from
both sides. Two turns compose by one product, sixteen multiplications and no sine. Between two
orientations slerp follows the great arc at even speed; halfway, it is as far from one as from the
other. Straight up, where Euler's yaw and roll fall together, a quaternion is as good as anywhere.

Look at: the aircraft, fanned out around the ball from the first orientation on the left to the last
on the right. Between neighbours there are 25° each, that is slerp's even speed. The middle one has
its nose straight up, the pose that locks a gimbal, and nothing happens there: slerp knows nothing
of yaw and roll.

Try: in `ch03_transforms/quaternion.vert` write `normalize(mix(a, b, t))` for `(sin((1.0 - t) *
angle) * a + sin(t * angle) * b) / sin(angle)`: the path is the same, but the gaps at its ends
shrink to 21°, and those in the middle grow to 29°.
"""

from math import acos, degrees, pi, radians, sqrt

import numpy as np
from numpy.linalg import norm

from shaderlab import Case, Mesh, Target, assets, formula, mesh_pass, sweep
from shaderlab.glslmath import vec4
from shaderlab.reference.euler import euler_matrix
from shaderlab.reference.quaternions import axis_angle, conjugate, matrix_of, product, slerp, turned
from shaderlab.reference.transforms import scale

from ..scenes import painted_solids as solids, stage
from ..scenes.cameras import camera
from ..scenes.figures import each_draw, figure, figures, results
from ..scenes.glm import slerp_by_glm, turned_by_glm
from ..scenes.laws import projected, renamed
from ..scenes.props import aircraft, letter_f

CAMERA = camera((0.3, 1.5, 6.0), (0.0, 0.65, 0.0), 32.0, 3.0 / 2.0)
FRAMES, SMALL = 7, Target(size=(64, 64))
AIRCRAFT = assets.moved(aircraft(), scale(0.36))
# An aircraft stands a radius from the middle, ahead along its own nose.
AWAY = (0.0, 0.0, -1.72)
UPRIGHT = axis_angle((1, 0, 0), radians(90.0))
START = product(axis_angle((0, 0, 1), radians(75.0)), UPRIGHT)
END = product(axis_angle((0, 0, 1), radians(-75.0)), UPRIGHT)


def globe():
    """A ball with the great circle that the aircraft follow."""
    ball = solids.painted(assets.sphere(0.9, segments=64, rings=32), (0.16, 0.30, 0.38))
    circle = solids.painted(assets.torus(1.14, 0.014, segments=96, sides=8), solids.GOLD)
    tilt = matrix_of(axis_angle((1, 0, 0), pi / 2))
    return assets.joined(ball, assets.moved(circle, tilt))


def frame(step):
    """One aircraft of the formation."""
    uniforms = {"from": START, "to": END, "t": step / (FRAMES - 1), "away": AWAY, **CAMERA}
    return stage.subject("ch03_transforms/quaternion.vert", AIRCRAFT, uniforms)


def through(name, q):
    """The letter through one quaternion, for its vertices only."""
    shader, letter = "ch03_transforms/quaternion_turn", Mesh(**letter_f()).only("aPos")
    return mesh_pass(
        f"{shader}.vert", f"{shader}.frag", letter, uniforms={"q": q}, name=name, target=SMALL
    )


def orientation(t):
    """The shader's quaternion at t; `from` is a word of Python's, so its value is given here."""
    return slerp(START.astype(np.float32), END.astype(np.float32), t)


def at_place(aPos, away, t):
    """Turned around the ball's middle."""
    return turned(aPos + away, orientation(t))


def turned_normal(aNormal, t):
    """Normals turn as points do."""
    return turned(aNormal, orientation(t))


by_quaternion = renamed(turned, v="aPos")


def half_size(aPos, q):
    """On the screen the letter is half as large: w is 2."""
    return vec4(turned(aPos, q), 2.0)


def one_color():
    """The colour that only shows that something was drawn."""
    return vec4(0.25, 0.5, 0.75, 1.0)


TILTED = axis_angle((1, 2, 2), radians(110.0))
QUARTER, NONE = axis_angle((0, 0, 1), pi / 2), np.array([0.0, 0.0, 0.0, 1.0])
# Nose straight up, then banked: the pose where yaw and roll are one.
LOCKED = product(axis_angle((0, 1, 0), radians(40.0)), axis_angle((1, 0, 0), radians(90.0)))


def matrix_gap():
    """Largest difference between the locked pose's matrix and that of Euler's angles."""
    return np.abs(matrix_of(LOCKED) - euler_matrix(radians(40.0), radians(90.0), 0.0)).max()


def half_way():
    """Degrees from the start to slerp's middle, and from there to the end."""
    middle = slerp(START, END, 0.5)
    return [2.0 * degrees(acos(abs(float(np.dot(middle, q))))) for q in (START, END)]


def smallest_response():
    """The least a small turn around any axis changes an orientation in the locked pose, per radian.

    The columns are what turns around x, y and z do to it; their least singular value is 0 where a
    direction is lost.
    """
    columns = [product(np.array([*np.eye(3)[k], 0.0]), LOCKED) / 2.0 for k in range(3)]
    return np.linalg.svd(np.array(columns).T, compute_uv=False).min()


def sandwich_less_matrix():
    """q v q* less the product of q's matrix and v, for v = (1, 2, 3)."""
    return turned(np.array([1.0, 2.0, 3.0]), TILTED) - matrix_of(TILTED)[:3, :3] @ (1, 2, 3)


PLACES = {step + 1: step for step in range(FRAMES)}
ENDS = {4: "on top", -1: "at the end"}
AT_HALF = {"aPos": (0.0, 0.0, 0.0), "t": 0.5}
BY_GLM = {"PyGLM": turned_by_glm}
MIXED, COS_22_5 = (NONE + QUARTER) / 2.0, sqrt((1.0 + sqrt(0.5)) / 2.0)
SANDWICH = "q v q* of (1, 2, 3) less its matrix times (1, 2, 3)"
NO_LOCK = "a half for every axis and in every pose; Euler's angles have 0 here"
SHORTER = "shorter than 1: mixed quaternions must be normalised"

case = Case(
    title="Quaternions",
    section="3.7",
    math=r"v' = q\,(v, 0)\,q^{*},\quad q = (u \sin\tfrac\varphi2,\ \cos\tfrac\varphi2), \qquad "
    r"\operatorname{slerp}(a, b, t) = \frac{\sin((1-t)\,\theta)\,a + \sin(t\,\theta)\,b}"
    r"{\sin\theta},\quad \cos\theta = a \cdot b",
    passes=(
        *stage.photographed(
            (stage.prop(globe(), CAMERA), *(frame(step) for step in range(FRAMES))), (900, 600)
        ),
        *through("locked", LOCKED),
        *through("tilted", TILTED),
    ),
    picture="picture.FragColor",
    expect=[
        *stage.checks(),
        formula("tilted.Turned", by_quaternion, also=BY_GLM, name="110° around (1,2,2)"),
        formula("locked.Turned", by_quaternion, also=BY_GLM, name="the locked pose"),
        *(formula(f"{name}.FragColor", one_color) for name in ("locked", "tilted")),
        formula("tilted.gl_Position", half_size),
        *each_draw("judged.Turned", at_place, PLACES, "place {} of the formation"),
        formula("judged.Orientation", orientation, also={"PyGLM": slerp_by_glm(START, END)}),
        *each_draw("judged.Normal", turned_normal, ENDS, "normals turn, {}"),
        formula("judged.gl_Position", projected(at_place), name="clip coordinates"),
        *stage.color_checks(ENDS),
        sweep(
            "judged.Orientation",
            orientation,
            over="t",
            at={"aPos": (0.0, 0.0, 0.0)},
            values=np.linspace(0.0, 1.0, 33),
        ),
        figure(
            "judged.Orientation",
            "halfway from +75° to −75° is 0°",
            AT_HALF,
            tuple(UPRIGHT.round(6)),
            reference=orientation,
        ),
        *figures(
            "tilted.Turned",
            {
                "90° around z": ({"aPos": (1.0, 0.0, 0.0), "q": QUARTER}, (0.0, 1.0, 0.0)),
                "120° around (1, 1, 1)": (
                    {"aPos": (1.0, 2.0, 3.0), "q": (0.5, 0.5, 0.5, 0.5)},
                    (3.0, 1.0, 2.0),
                ),
            },
            reference=by_quaternion,
        ),
        *results(
            {
                "q v q* against the matrix, nose up and yawed by 40°": (matrix_gap, 0.0),
                "q q*": (product(TILTED, conjugate(TILTED)), NONE),
                "length of slerp's quarter, of (0, 0, 0, 1) and 90° around z": (
                    norm(slerp(NONE, QUARTER, 0.25)),
                    1.0,
                ),
            },
            digits=15,
        ),
        *results({SANDWICH: (sandwich_less_matrix, (0.0, 0.0, 0.0))}, digits=14),
        *results({"slerp halfway, degrees from either end": (half_way, (75.0, 75.0))}, digits=9),
        *results(
            {
                "least response to a turn in the locked pose": (smallest_response, 0.5, NO_LOCK),
                "length of a plain mixture, halfway": (norm(MIXED), COS_22_5, SHORTER),
            },
            digits=12,
        ),
    ],
)
