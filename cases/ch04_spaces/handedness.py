"""Handedness: the world is right-handed, normalised device coordinates are left-handed.

In the world and in view space x × y = z: thumb along x, first finger along y, and the middle finger
of the right hand points along z, towards the viewer. The projection matrix turns z around, because
a depth should grow with the distance. So in device coordinates z points into the screen, and depth
falls as z in view space grows: z rising means coming nearer.

Look at: the blue arrows. The dice are the same on both sides, gold the nearest. On the left z comes
towards you, and the dice stand at ever lower z. On the right z points away, it takes the left hand
to follow these axes, and from gold to ink z grows: a depth.
"""

from math import radians

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Depth,
    Draw,
    Mesh,
    State,
    Target,
    across,
    computed,
    formula,
    fullscreen,
    sweep,
    value,
)
from shaderlab.assets import solids
from shaderlab.assets.order import any_order
from shaderlab.glslmath import cross, vec3, where
from shaderlab.reference.spaces import depth_of
from shaderlab.reference.transforms import (
    clip_position,
    in_view,
    look_at,
    perspective,
    world_normal,
)
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.props import tripod
from ..scenes.studio import handed_on, softened, studio_color

VIEW = look_at((2.9, 2.5, 3.6), (0.2, 0.32, -0.1))
PROJECTION = perspective(radians(33.0), 4.0 / 3.0, 0.1, 20.0)
NEAR, FAR = 0.1, 100.0
SHADES = (solids.GOLD, solids.ORANGE, solids.TEAL, solids.INK)


def dice():
    """Four dice in a row along −z."""
    blocks = []
    for k, color in enumerate(SHADES):
        z = -0.42 * (k + 1)
        blocks.append(
            solids.painted(solids.box((0.46, 0.0, z - 0.13), (0.72, 0.26, z + 0.13)), color)
        )
    return solids.gathered(*blocks)


AXES = Mesh(**tripod(1.35, 0.045))


def half(column, left_handed):
    """One hand's axes, and the dice."""
    cell = Cell(column=column, row=0, columns=2, rows=1)
    axes = Draw(
        vertex="ch04_spaces/handedness.vert",
        fragment="ch03_transforms/studio.frag",
        mesh=AXES,
        uniforms={"leftHanded": left_handed, "view": VIEW, "projection": PROJECTION},
        state=State(depth=Depth(), cell=cell),
    )
    return stage.prop(dice(), VIEW, PROJECTION, cell=cell), axes


def in_hand(aPos, leftHanded):
    """z changes its sign in a left-handed frame, all else stays."""
    return aPos * where(leftHanded > 0.5, vec3(1.0, 1.0, -1.0), vec3(1.0))


def normal_in_hand(aNormal, leftHanded):
    """Normals are mirrored likewise."""
    return in_hand(aNormal, leftHanded)


def position(aPos, leftHanded, view, projection):
    """Clip coordinates of the vertex."""
    return in_view(in_hand(aPos, leftHanded), view, projection)


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


case = Case(
    title="Handedness",
    section="2.1.2",
    math=r"e_x \times e_y = e_z, \qquad z_{\text{ndc}} = \frac{f+n}{f-n} + \frac{2fn}{(f-n)\,z}, "
    r"\qquad \frac{\partial z_{\text{ndc}}}{\partial z} = -\frac{2fn}{(f-n)\,z^2} < 0",
    passes=(
        *stage.photographed((*half(0, False), *half(1, True)), (880, 330)),
        *fullscreen(
            "ch04_spaces/handedness_depth.frag",
            name="depth",
            domain={"viewZ": across(-10.0, -0.1)},
            uniforms={"near": NEAR, "far": FAR},
            target=Target(size=(64, 1)),
        ),
    ),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        any_order("judged.FragColor"),
        *stage.prop_checks(clip_position, world_normal, handed_on, studio_color),
        formula("judged.Seen", in_hand, draw=1, name="right-handed"),
        formula("judged.Seen", in_hand, draw=3, name="left-handed"),
        formula("judged.Normal", normal_in_hand, draw=3),
        formula("judged.Color", handed_on),
        formula("judged.gl_Position", position, draw=1, name="clip coordinates, right-handed"),
        formula("judged.gl_Position", position, draw=3, name="clip coordinates, left-handed"),
        formula("judged.FragColor", studio_color, draw=1, name="colour, right-handed"),
        formula("judged.FragColor", studio_color, draw=3, name="colour, left-handed"),
        formula("depth.depth", both, name="depth and its slope"),
        sweep("depth.depth", both, over="viewZ", values=-np.geomspace(0.1, 100.0, 65)),
        value(
            "depth.depth",
            at={"viewZ": -1.0},
            equals=(0.801802, -0.200200),
            digits=6,
            name="at z = −1",
            note="the slope is negative: nearer is less",
        ),
        value("depth.depth", at={"viewZ": -0.1}, equals=(-1.0, -20.02002), digits=6, name="near"),
        value("depth.depth", at={"viewZ": -100.0}, equals=(1.0, -0.00002), digits=6, name="far"),
        value(
            "judged.Seen",
            at={"aPos": (1.0, 2.0, 3.0), "leftHanded": True},
            equals=(1.0, 2.0, -3.0),
            digits=6,
            reference=in_hand,
            name="(1, 2, 3) in a left-handed frame",
        ),
        computed(
            "x × y in the world",
            lambda: cross(vec3(1, 0, 0), vec3(0, 1, 0)),
            equals=(0.0, 0.0, 1.0),
            digits=12,
        ),
        computed(
            "(x × y) · z in device coordinates",
            lambda: np.linalg.det(np.diag([1.0, 1.0, np.sign(slope(-1.0))])),
            equals=-1.0,
            digits=12,
            note="the projection has turned z around",
        ),
        computed("slope at z = −1 by the matrix", lambda: slope(-1.0), equals=-0.200200, digits=6),
    ],
)
