"""The view matrix: three axes of a camera as rows, and the way back from where it stands.

Forward f goes from the eye to the target, side s = f × up to the right, u = s × f upwards. Each row
takes one of a place's coordinates in the camera's frame, with −f for z, because a camera looks down
its −z. So the frame {s, u, −f} is right-handed while {s, u, f} is not. f and up are rarely at right
angles: unless s is normalised, it is too short and the picture too narrow.

Look at: the camera on the left and its axes, red to its right, green up, blue backwards, and the
pyramid of what it sees. On the right is what it does see: red letters stay to the right of blue
ones, wherever the camera goes.

Try: in `lib/look_at.glsl` write `cross(forward, up);` for `normalize(cross(forward, up));`: what
the camera sees shrinks by one or two hundredths.
"""

import numpy as np

from shaderlab import Case, Erratum, assets, formula
from shaderlab.glslmath import mul, vec4
from shaderlab.reference.spaces import in_camera
from shaderlab.reference.transforms import look_at, translate

from ..scenes import painted_solids as solids, stage
from ..scenes.cameras import camera, turned
from ..scenes.figures import figures, results
from ..scenes.glm import in_camera_by_glm, rotation_by_glm_float32
from ..scenes.laws import unchanged
from ..scenes.panels import cell
from ..scenes.props import frustum, letter_f, tile, tripod

EYE, TARGET, UP = (3.0, 2.0, 5.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)
SEES = camera(EYE, TARGET, 30.0, 4.0 / 3.0, near=1.0, far=9.0)
WATCHES = camera((7.4, 5.4, 8.6), (1.1, 1.05, 1.9), 32.0, 4.0 / 3.0, near=0.5, far=40.0)
# What is drawn of the pyramid that the camera sees ends sooner.
PYRAMID = camera(EYE, TARGET, 30.0, 4.0 / 3.0, near=1.0, far=6.5)["projection"]

SCENE = assets.joined(
    tile(2.4, 0.6),
    assets.moved(tripod(0.6, 0.03), translate((0, 0.01, 0))),
    *(
        assets.moved(letter_f(front=color), translate((x, 0.0, z)))
        for x, z, color in (
            (-1.3, -0.4, solids.BLUE),
            (-0.3, 0.0, solids.ORANGE),
            (0.7, 0.4, solids.RED),
        )
    ),
)
# A camera at the eye: a box with a lens, its three axes, and the pyramid that it sees.
PLACED = assets.moved(
    assets.joined(
        solids.painted(solids.box((-0.20, -0.15, -0.10), (0.20, 0.15, 0.30)), solids.INK),
        solids.painted(solids.box((-0.10, -0.10, -0.22), (0.10, 0.10, -0.10)), solids.STONE),
        tripod(1.1, 0.04),
        frustum(PYRAMID, solids.GOLD, 0.022),
    ),
    np.linalg.inv(look_at(EYE, TARGET, UP)),
)
# On the left the camera in its scene, on the right the scene in the camera.
DRAWS = (
    *(stage.prop(solid, WATCHES, cell=cell(0, 2)) for solid in (SCENE, PLACED)),
    stage.subject(
        "ch04_spaces/look_at.vert",
        SCENE,
        {"eye": EYE, "target": TARGET, "up": UP, "projection": SEES["projection"]},
        cell=cell(1, 2),
    ),
)


def seen_place(aPos, eye, target, up):
    """A vertex in the camera's frame."""
    return in_camera(aPos, eye, target, up)


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


def inverse_gap():
    """The view matrix less the inverse of the camera's own, whose columns are its axes and its
    place: some 9 · 10⁻¹⁶ in float64."""
    side, above, forward = axes()
    placed = np.eye(4)
    placed[:3] = np.column_stack([side, above, -forward, EYE])
    return widest(np.linalg.inv(placed) - look_at(EYE, TARGET, UP))


def widest(difference):
    """The largest absolute entry."""
    return float(np.abs(difference).max())


def view_of(place, eye, target):
    """One place before one camera."""
    return {"aPos": place, "eye": eye, "target": target, "up": UP}


def off_by_glm():
    """What float32 makes of the camera that looks towards −x."""
    return widest(rotation_by_glm_float32(np.radians(-90.0), UP) - SIDEWAYS)


ORIGIN, FORWARD, MINUS_X = (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0)
PLACE, ASKEW = (1.0, 2.0, 3.0), view_of((2.0, -1.0, 5.0), (1.0, 2.0, 3.0), (4.0, 0.0, 2.0))
VIEW, DEFAULT, SIDEWAYS = (
    look_at(EYE, TARGET, UP),
    look_at(ORIGIN, FORWARD),
    look_at(ORIGIN, MINUS_X),
)
BY_GLM = (off_by_glm, 5.96e-8, "half an ULP of 1: cos 90° is −4.4 · 10⁻⁸ there")
RIGHT_HANDED = "−f in its place makes the frame right-handed"
INVERSE = "the inverse of the camera's matrix is the view matrix, to below 10⁻¹⁵ (1: it is)"
ROUNDING = "9 · 10⁻¹⁶ apart at most, the rounding of float64"

case = Case(
    title="The view matrix",
    section="4.3",
    math=r"V = \begin{pmatrix} s_x & s_y & s_z & -s \cdot e \\ u_x & u_y & u_z & -u \cdot e \\ "
    r"-f_x & -f_y & -f_z & f \cdot e \\ 0 & 0 & 0 & 1 \end{pmatrix}, \quad "
    r"s = \frac{f \times \text{up}}{\lVert f \times \text{up} \rVert},\quad u = s \times f",
    passes=stage.photographed(DRAWS, (1000, 375)),
    picture="picture.FragColor",
    columns=("the camera", "what it sees"),
    expect=[
        *stage.checks(light=False),
        formula("judged.InView", seen_place, also={"PyGLM": in_camera_by_glm}, name="every vertex"),
        formula("judged.gl_Position", position, name="clip coordinates"),
        formula("judged.Normal", unchanged("aNormal")),
        *stage.color_checks({1: "colour of the camera", -1: "colour, seen by the camera"}, "{}"),
        *figures(
            "judged.InView",
            {
                "the default camera": (view_of(PLACE, ORIGIN, FORWARD), PLACE),
                "towards −x: (−z, y, x)": (view_of(PLACE, ORIGIN, MINUS_X), (-3.0, 2.0, 1.0)),
                "askew": (ASKEW, (2.213594, -2.366432, -1.870829)),
                "the eye is the origin": (view_of(EYE, EYE, TARGET), (0.0, 0.0, 0.0)),
                "the target is straight ahead": (view_of(TARGET, EYE, TARGET), (0, 0, -5.916080)),
            },
            reference=seen_place,
        ),
        *results(
            {
                "the default camera less the identity": (widest(DEFAULT - np.eye(4)), 0.0),
                "rows of the camera that looks towards −x": (
                    SIDEWAYS[:3, :3].ravel(),
                    (0, 0, -1, 0, 1, 0, 1, 0, 0),
                ),
                "its difference from rotate(−90°, y), in float64": (
                    widest(SIDEWAYS - turned(-90.0)),
                    0.0,
                ),
            },
            digits=15,
        ),
        *results({"its difference from GLM's float32 rotate(−90°, y)": BY_GLM}, digits=10),
        *results(
            {
                "det {s, u, f}": (np.linalg.det(axes()), -1.0),
                "det of the view matrix": (np.linalg.det(VIEW), 1.0, RIGHT_HANDED),
            },
            digits=14,
        ),
        *results({INVERSE: (lambda: inverse_gap() < 1e-15, 1.0, ROUNDING)}, digits=0),
        *results({"|f × up|": (unnormalised_side, 0.985611)}),
    ],
    errata=[
        Erratum(
            section="4.3",
            says="places and directions are written glm::vec(…) (and in 5.9.1 too)",
            truth="three floats are a glm::vec3; lookAt takes three of them, and gives the "
            "matrix above",
            proof="every vertex",
        )
    ],
)
