"""Perspective projection: w becomes the distance, and dividing by it makes far things small.

The last row (0, 0, −1, 0) puts −z into w, and the hardware divides by it. x and y are first scaled
by the focal length 1 / tan(fovy/2), so that the opening angle lands on ±1. Depth has two free
numbers, A and B in A + B/z: they send the near plane to −1 and the far plane to 1, and between them
nearly all depths are spent on what is near.

Look at: the rails. They are parallel and meet on the horizon, in the point that all lines along −z
share; the posts shrink as one over their distance. Half the distance is not half the depth: at a
distance of 1, one hundredth of the way, 90 % of the depths are used up.

Try: in `ch04_spaces/perspective.vert` write `tan(fovy / 4.0)` for `tan(fovy / 2.0)`: half the
angle, like a longer lens: all is larger, and the rails meet in the same point.
"""

from math import radians

import numpy as np

from shaderlab import Case, formula, sweep
from shaderlab.glslmath import mul, swizzle, vec4
from shaderlab.reference.spaces import device, perspective_clip
from shaderlab.reference.transforms import look_at, perspective

from ..scenes import stage
from ..scenes.figures import figures, results
from ..scenes.glm import perspective_by_glm
from ..scenes.laws import unchanged
from ..scenes.props import railway
from ..scenes.studio import studio_color

VIEW = look_at((0.9, 1.9, 3.6), (0.15, 0.9, -7.0))
LENS = {"fovy": radians(45.0), "aspect": 4.0 / 3.0, "near": 0.1, "far": 100.0}
MATRIX = perspective(*LENS.values())
TRACK = stage.subject("ch04_spaces/perspective.vert", railway(60.0), {"view": VIEW, **LENS})


def clip(aPos, view, fovy, aspect, near, far):
    """Clip coordinates of a vertex."""
    return perspective_clip(swizzle(mul(view, vec4(aPos, 1.0)), "xyz"), fovy, aspect, near, far)


def in_device(aPos, view, fovy, aspect, near, far):
    """Device coordinates: after the division by w."""
    return device(clip(aPos, view, fovy, aspect, near, far))


def screen(place):
    """A place on the screen, in device coordinates of the case's own camera."""
    x, y, _, w = MATRIX @ VIEW @ (*place, 1.0)
    return np.array([x, y]) / w


def apart(distance):
    """Distance between the two rails on the screen, far along the track."""
    return float(np.linalg.norm(screen((0.7, 0.0, -distance)) - screen((-0.7, 0.0, -distance))))


POINT = {"aPos": (1.0, 1.0, -1.0), "view": np.eye(4)}
# Where the matrix is not 0, and what it makes of the point.
ENTRIES = zip(
    ((0, 0), (1, 1), (2, 2), (2, 3), (3, 2)),
    (1.810660, 2.414214, -1.002002, -0.200200, -1.0),
    strict=True,
)
TWICE_AS_FAR = (apart(2e6) / apart(1e6), 0.5, "as one over the distance: they meet")
IN_CLIP = (1.810660, 2.414214, 0.801802, 1.0)
CORNER = ({**POINT, **LENS}, IN_CLIP, "−1.002002 · (−1) − 0.200200")

case = Case(
    title="Perspective projection",
    section="4.4",
    math=r"\begin{pmatrix} \frac{1}{a \tan(\theta/2)} & 0 & 0 & 0 \\ 0 & \frac{1}{\tan(\theta/2)} "
    r"& 0 & 0 \\ 0 & 0 & \frac{f+n}{n-f} & \frac{2fn}{n-f} \\ 0 & 0 & -1 & 0 \end{pmatrix}",
    passes=stage.photographed((TRACK,), (800, 600)),
    picture="picture.FragColor",
    expect=[
        *stage.checks(props=False),
        formula("judged.gl_Position", clip, also={"PyGLM": perspective_by_glm}),
        formula("judged.Ndc", in_device),
        formula("judged.Normal", unchanged("aNormal")),
        formula("judged.FragColor", studio_color),
        *results(
            {f"row {r + 1}, column {c + 1}": (MATRIX[r, c], entry) for (r, c), entry in ENTRIES}
        ),
        *figures("judged.gl_Position", {"(1, 1, −1) in clip space": CORNER}, reference=clip),
        *figures(
            "judged.Ndc",
            {
                "the near plane": ({"aPos": (0.0, 0.0, -0.1)}, (0.0, 0.0, -1.0)),
                "the far plane": ({"aPos": (0.0, 0.0, -100.0)}, (0.0, 0.0, 1.0)),
                "at a distance of 1": ({"aPos": (0.0, 0.0, -1.0)}, (0.0, 0.0, 0.801802)),
                "the edge of 45°": ({"aPos": (0.0, 1.0, -2.414214)}, (0.0, 1.0, 0.919076)),
            },
            at={**POINT, **LENS},
            reference=in_device,
        ),
        sweep(
            "judged.gl_Position",
            clip,
            over="fovy",
            at=POINT,
            values=np.radians(np.linspace(20.0, 120.0, 41)),
            name="wider openings, smaller pictures",
        ),
        *results({"rails on the screen at a distance of 10⁶": (apart(1e6), 0.0)}, digits=5),
        *results({"their width twice as far, relative": TWICE_AS_FAR}, digits=4),
    ],
)
