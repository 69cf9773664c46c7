"""Handedness: the world is right-handed, normalised device coordinates are left-handed.

In the world and in view space x × y = z: thumb along x, first finger along y, and the middle finger
of the right hand points along z, towards the viewer. The projection matrix turns z around, because
a depth should grow with the distance. So in device coordinates z points into the screen, and depth
falls as z in view space grows: z rising means coming nearer.

Look at: the blue arrows. The dice are the same on both sides, gold the nearest. On the left z comes
towards you, and the dice stand at ever lower z. On the right z points away, it takes the left hand
to follow these axes, and from gold to ink z grows: a depth.

Try: in `ch04_spaces/handedness.vert` write `vec3(-1.0, 1.0, 1.0)` for `vec3(1.0, 1.0, -1.0)`: on
the right x points to the left and z towards you, which still takes the left hand.
"""

from math import radians

import numpy as np

from shaderlab import Case, across, formula, sweep
from shaderlab.glslmath import cross, vec3, where
from shaderlab.reference.spaces import depth_of
from shaderlab.reference.transforms import perspective

from ..scenes import stage
from ..scenes.cameras import camera
from ..scenes.figures import each_draw, figure, figures, results
from ..scenes.laws import projected, renamed
from ..scenes.panels import cell, panel_pass
from ..scenes.props import dice, tripod

CAMERA = camera((2.9, 2.5, 3.6), (0.28, 0.37, -0.1), 24.0, 4.0 / 3.0)
NEAR, FAR = 0.1, 100.0
DICE = dice()


def half(column, left_handed):
    """One hand's axes, and the dice."""
    side, uniforms = cell(column, 2), {"leftHanded": left_handed, **CAMERA}
    axes = stage.subject("ch04_spaces/handedness.vert", tripod(1.35, 0.045), uniforms, cell=side)
    return stage.prop(DICE, CAMERA, cell=side), axes


def in_hand(aPos, leftHanded):
    """z changes its sign in a left-handed frame, all else stays."""
    return aPos * where(leftHanded > 0.5, vec3(1.0, 1.0, -1.0), vec3(1.0))


def both(viewZ, near, far):
    """Device depth and its slope."""
    return depth_of(viewZ, near, far)


def by_matrix(z):
    """Device depth through the perspective matrix."""
    *_, z, w = perspective(radians(45.0), 4.0 / 3.0, NEAR, FAR) @ (0.0, 0.0, z, 1.0)
    return z / w


def slope(z, h=1e-5):
    """The slope of the device depth at z, by a central difference."""
    return (by_matrix(z + h) - by_matrix(z - h)) / (2.0 * h)


VIEW_Z, PLANES = {"viewZ": across(-10.0, -0.1)}, {"near": NEAR, "far": FAR}
# (x × y) · z in device coordinates.
TRIPLE_PRODUCT = np.linalg.det(np.diag([1.0, 1.0, np.sign(slope(-1.0))]))
HANDS = {1: "right-handed", 3: "left-handed"}
LEFT = {"aPos": (1.0, 2.0, 3.0), "leftHanded": True}
NEARER_IS_LESS = "the slope is negative: nearer is less"
TURNED_AROUND = "the projection has turned z around"

case = Case(
    title="Handedness",
    section="2.1.2",
    math=r"e_x \times e_y = e_z, \qquad z_{\text{ndc}} = \frac{f+n}{f-n} + \frac{2fn}{(f-n)\,z}, "
    r"\qquad \frac{\partial z_{\text{ndc}}}{\partial z} = -\frac{2fn}{(f-n)\,z^2} < 0",
    passes=(
        *stage.photographed((*half(0, False), *half(1, True)), (880, 330)),
        panel_pass("depth", "ch04_spaces/handedness_depth.frag", VIEW_Z, PLANES, size=(64, 1)),
    ),
    picture="picture.FragColor",
    columns=("right-handed", "left-handed"),
    expect=[
        *stage.checks(light=False),
        *each_draw("judged.Seen", in_hand, HANDS),
        formula("judged.Normal", renamed(in_hand, aPos="aNormal"), draw=3),
        *each_draw("judged.gl_Position", projected(in_hand), HANDS, "clip coordinates, {}"),
        *stage.color_checks(HANDS),
        formula("depth.depth", both, name="depth and its slope"),
        sweep("depth.depth", both, over="viewZ", values=-np.geomspace(0.1, 100.0, 65)),
        *figures(
            "depth.depth",
            {
                "at z = −1": ({"viewZ": -1.0}, (0.801802, -0.200200), NEARER_IS_LESS),
                "near": ({"viewZ": -0.1}, (-1.0, -20.02002)),
                "far": ({"viewZ": -100.0}, (1.0, -0.00002)),
            },
        ),
        figure("judged.Seen", "(1, 2, 3) in a left-handed frame", LEFT, (1, 2, -3)),
        *results(
            {
                "x × y in the world": (cross(vec3(1, 0, 0), vec3(0, 1, 0)), (0.0, 0.0, 1.0)),
                "(x × y) · z in device coordinates": (TRIPLE_PRODUCT, -1.0, TURNED_AROUND),
            },
            digits=12,
        ),
        *results({"slope at z = −1 by the matrix": (slope(-1.0), -0.200200)}),
    ],
)
