"""Orthographic projection: a box becomes the cube from −1 to 1, and distance leaves no trace.

Each axis is scaled and shifted by itself: left and right land on −1 and 1, bottom and top likewise,
the near plane on depth −1 and the far one on 1. The last row is (0, 0, 0, 1), so w stays 1 and
nothing is divided. Parallel lines stay parallel and equal sizes stay equal: plans, shadow maps of a
sun, and text are drawn this way.

Look at: the track. Its rails run side by side to the very end, and the last post is exactly as tall
as the first. You can't tell how far away anything is; compare the perspective picture of the same
track.

Try: in `ch04_spaces/orthographic.vert` write `1.0 / (top - bottom)` for `2.0 / (top - bottom)`: the
box is twice as high, so all that is in it is half as tall.
"""

import numpy as np

from shaderlab import Case, formula
from shaderlab.glslmath import mul, swizzle, vec4
from shaderlab.reference.spaces import orthographic_clip
from shaderlab.reference.transforms import look_at, orthographic

from ..scenes import stage
from ..scenes.figures import figures, results
from ..scenes.glm import orthographic_by_glm
from ..scenes.laws import unchanged
from ..scenes.props import railway
from ..scenes.studio import studio_color

VIEW = look_at((3.4, 4.6, 3.0), (-0.6, 0.2, -7.0))
BOX = {"left": -5.2, "right": 6.0, "bottom": -3.6, "top": 4.8, "near": 0.5, "far": 40.0}
PLANES = {"left": -3.0, "right": 5.0, "bottom": -2.0, "top": 7.0, "near": 1.0, "far": 7.5}
TRACK = stage.subject("ch04_spaces/orthographic.vert", railway(16.0), {"view": VIEW, **BOX})
MATRIX = orthographic(*BOX.values())


def clip(aPos, view, left, right, bottom, top, near, far):
    """Clip coordinates of a vertex, for the case's box."""
    seen = swizzle(mul(view, vec4(aPos, 1.0)), "xyz")
    return orthographic_clip(seen, left, right, bottom, top, near, far)


def across_rails(z):
    """How far apart the rails are on the screen at z."""
    right, left = (MATRIX @ VIEW @ (x, 0.0, z, 1.0) for x in (0.7, -0.7))
    return (right - left)[:2]


APART, PARALLEL = across_rails(-16.0) - across_rails(0.0), "parallel lines stay parallel"
UNIT, TURNED = np.diag(orthographic(-1, 1, -1, 1, -1, 1)), "only z turns around"

case = Case(
    title="Orthographic projection",
    section="4.4",
    math=r"\begin{pmatrix} \frac{2}{r-l} & 0 & 0 & -\frac{r+l}{r-l} \\ 0 & \frac{2}{t-b} & 0 & "
    r"-\frac{t+b}{t-b} \\ 0 & 0 & \frac{-2}{f-n} & -\frac{f+n}{f-n} \\ 0 & 0 & 0 & 1 \end{pmatrix}",
    passes=stage.photographed((TRACK,), (800, 600)),
    picture="picture.FragColor",
    expect=[
        *stage.checks(props=False),
        formula("judged.gl_Position", clip, also={"PyGLM": orthographic_by_glm}),
        formula("judged.Normal", unchanged("aNormal")),
        formula("judged.FragColor", studio_color),
        *figures(
            "judged.gl_Position",
            {
                name: ({"aPos": place}, (*equals, 1.0))
                for name, place, equals in (
                    ("lower left corner, near", (-3.0, -2.0, -1.0), (-1.0, -1.0, -1.0)),
                    ("upper right corner, far", (5.0, 7.0, -7.5), (1.0, 1.0, 1.0)),
                    ("the middle", (1.0, 2.5, -4.25), (0.0, 0.0, 0.0)),
                )
            },
            at={"aPos": (0.0, 0.0, 0.0), "view": np.eye(4), **PLANES},
            reference=clip,
        ),
        *results(
            {
                "depth of the near plane": ((MATRIX @ (0, 0, -0.5, 1))[2], -1.0),
                "depth of the far plane": ((MATRIX @ (0, 0, -40.0, 1))[2], 1.0),
                "rails on the screen, far less near": (APART, (0.0, 0.0), PARALLEL),
                "diagonal of the unit box −1…1, −1…1, 1…−1": (UNIT, (1, 1, -1, 1), TURNED),
            },
            digits=12,
        ),
    ],
)
