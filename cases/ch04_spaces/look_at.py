"""The view matrix: three axes of a camera as rows, and the way back from where it stands.

Forward f goes from the eye to the target, side s = f × up to the right, u = s × f upwards. Each row
takes one of a place's coordinates in the camera's frame, with −f for z, because a camera looks down
its −z. So the frame {s, u, −f} is right-handed while {s, u, f} is not. f and up are at right angles
only by chance: without normalising it, s is too short and the picture too narrow.

Look at: the camera on the left and its axes, red to its right, green up, blue backwards, and the
pyramid of what it sees. On the right is what it does see: red letters stay to the right of blue
ones, wherever the camera goes.
"""

from math import radians

import numpy as np

from shaderlab import Case, Cell, Depth, Draw, Mesh, State, computed, formula, value
from shaderlab.assets import solids
from shaderlab.assets.order import any_order
from shaderlab.glslmath import mul, vec4
from shaderlab.reference.spaces import in_camera
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    perspective,
    rotate,
    translate,
    world_normal,
)
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.glm import in_camera_by_glm, rotation_by_glm_float32
from ..scenes.props import letter_f, tile, tripod
from ..scenes.studio import handed_on, softened, studio_color

EYE, TARGET, UP = (3.0, 2.0, 5.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)
SEES = perspective(radians(30.0), 4.0 / 3.0, 1.0, 9.0)
WATCHER = look_at((7.4, 5.4, 8.6), (1.1, 1.05, 1.9))
WATCHES = perspective(radians(32.0), 4.0 / 3.0, 0.5, 40.0)

LETTERS = tuple(
    solids.placed(letter_f(front=color), translate((x, 0.0, z)))
    for x, z, color in (
        (-1.3, -0.4, solids.BLUE),
        (-0.3, 0.0, solids.ORANGE),
        (0.7, 0.4, solids.RED),
    )
)
SCENE = solids.gathered(
    tile(2.4, 0.6),
    solids.placed(tripod(0.6, 0.03), translate((0, 0.01, 0))),
    *LETTERS,
)


def camera():
    """A camera at the eye: a box with a lens, its three axes, and the pyramid that it sees."""
    body = solids.painted(solids.box((-0.20, -0.15, -0.10), (0.20, 0.15, 0.30)), solids.INK)
    lens = solids.painted(solids.box((-0.10, -0.10, -0.22), (0.10, 0.10, -0.10)), solids.STONE)
    corners = [(x, y, z, 1.0) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    seen = (np.linalg.inv(perspective(radians(30.0), 4.0 / 3.0, 1.0, 6.5)) @ np.array(corners).T).T
    frustum = solids.wire(seen[:, :3] / seen[:, 3:], solids.GOLD, 0.022)
    parts = solids.gathered(body, lens, tripod(1.1, 0.04), frustum)
    return solids.placed(parts, np.linalg.inv(look_at(EYE, TARGET, UP)))


def draws():
    """On the left the camera in its scene, on the right the scene in the camera."""
    left, right = (Cell(column=k, row=0, columns=2, rows=1) for k in (0, 1))
    watched = (SCENE, camera())
    seen = Draw(
        vertex="ch04_spaces/look_at.vert",
        fragment="ch03_transforms/studio.frag",
        mesh=Mesh(**SCENE),
        uniforms={"eye": EYE, "target": TARGET, "up": UP, "projection": SEES},
        state=State(depth=Depth(), cell=right),
    )
    return *(stage.prop(solid, WATCHER, WATCHES, cell=left) for solid in watched), seen


def seen_place(aPos, eye, target, up):
    """A vertex in the camera's frame."""
    return in_camera(aPos, eye, target, up)


def same_normal(aNormal):
    """The light is the world's, and so are the normals."""
    return aNormal


def position(aPos, eye, target, up, projection):
    """Clip coordinates of the vertex."""
    return mul(projection, vec4(in_camera(aPos, eye, target, up), 1.0))


def axes():
    """s, u and f of the camera, as rows."""
    view = look_at(EYE, TARGET, UP)[:3, :3]
    return np.array([view[0], view[1], -view[2]])


def unnormalised_side():
    """Length of f × up, before it is normalised."""
    forward = np.subtract(TARGET, EYE) / np.linalg.norm(np.subtract(TARGET, EYE))
    return np.linalg.norm(np.cross(forward, UP))


def camera_placed():
    """The camera's own model matrix: its axes as columns, its place as the last one."""
    side, above, forward = axes()
    matrix = np.eye(4)
    matrix[:3] = np.column_stack([side, above, -forward, EYE])
    return matrix


def widest(difference):
    """The largest absolute entry."""
    return float(np.abs(difference).max())


def inverse_gap():
    """The view matrix less the inverse of the camera's own: some 9 · 10⁻¹⁶ in float64."""
    return widest(np.linalg.inv(camera_placed()) - look_at(EYE, TARGET, UP))


def view_from(eye, target, at, equals, name):
    """One place as one camera sees it."""
    return value(
        "judged.InView",
        at={"aPos": at, "eye": eye, "target": target, "up": UP},
        equals=equals,
        digits=6,
        reference=seen_place,
        name=name,
    )


ORIGIN, TOWARDS_MINUS_X = (0.0, 0.0, 0.0), (-1.0, 0.0, 0.0)

case = Case(
    title="The view matrix",
    section="4.3",
    math=r"V = \begin{pmatrix} s_x & s_y & s_z & -s \cdot e \\ u_x & u_y & u_z & -u \cdot e \\ "
    r"-f_x & -f_y & -f_z & f \cdot e \\ 0 & 0 & 0 & 1 \end{pmatrix}, \quad "
    r"s = \frac{f \times \text{up}}{\lVert f \times \text{up} \rVert},\quad u = s \times f",
    passes=stage.photographed(draws(), (1000, 375)),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        any_order("judged.FragColor"),
        *stage.prop_checks(clip_position, world_normal, handed_on, studio_color),
        formula("judged.InView", seen_place, also={"PyGLM": in_camera_by_glm}, name="every vertex"),
        formula("judged.gl_Position", position, name="clip coordinates"),
        formula("judged.Normal", same_normal),
        formula("judged.Color", handed_on),
        formula("judged.FragColor", studio_color, draw=1, name="colour of the camera"),
        formula("judged.FragColor", studio_color, name="colour, seen by the camera"),
        view_from(ORIGIN, (0.0, 0.0, -1.0), (1.0, 2.0, 3.0), (1.0, 2.0, 3.0), "the default camera"),
        view_from(
            ORIGIN, TOWARDS_MINUS_X, (1.0, 2.0, 3.0), (-3.0, 2.0, 1.0), "towards −x: (−z, y, x)"
        ),
        view_from(
            (1.0, 2.0, 3.0),
            (4.0, 0.0, 2.0),
            (2.0, -1.0, 5.0),
            (2.213594, -2.366432, -1.870829),
            "askew",
        ),
        view_from(EYE, TARGET, EYE, (0.0, 0.0, 0.0), "the eye is the origin"),
        view_from(EYE, TARGET, TARGET, (0.0, 0.0, -5.916080), "the target is straight ahead"),
        computed(
            "the default camera less the identity",
            lambda: widest(look_at(ORIGIN, (0, 0, -1)) - np.eye(4)),
            equals=0.0,
            digits=15,
        ),
        computed(
            "rows of the camera that looks towards −x",
            lambda: look_at(ORIGIN, TOWARDS_MINUS_X)[:3, :3].ravel(),
            equals=(0, 0, -1, 0, 1, 0, 1, 0, 0),
            digits=15,
        ),
        computed(
            "its difference from rotate(−90°, y), in float64",
            lambda: widest(look_at(ORIGIN, TOWARDS_MINUS_X) - rotate(radians(-90.0), UP)),
            equals=0.0,
            digits=15,
        ),
        computed(
            "its difference from GLM's float32 rotate(−90°, y)",
            lambda: widest(
                rotation_by_glm_float32(radians(-90.0), UP) - look_at(ORIGIN, TOWARDS_MINUS_X)
            ),
            equals=5.96e-8,
            digits=10,
            note="half an ULP of 1: cos 90° is −4.4 · 10⁻⁸ there",
        ),
        computed("det {s, u, f}", lambda: np.linalg.det(axes()), equals=-1.0, digits=14),
        computed(
            "det of the view matrix",
            lambda: np.linalg.det(look_at(EYE, TARGET, UP)),
            equals=1.0,
            digits=14,
            note="−f in its place makes the frame right-handed",
        ),
        computed(
            "the inverse of the camera's matrix is the view matrix, to below 10⁻¹⁵ (1: it is)",
            lambda: inverse_gap() < 1e-15,
            equals=1.0,
            digits=0,
            note="9 · 10⁻¹⁶ apart at most, the rounding of float64",
        ),
        computed("|f × up|", unnormalised_side, equals=0.985611, digits=6),
    ],
)
