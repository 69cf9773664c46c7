"""Orthographic projection: a box becomes the cube from −1 to 1, and distance leaves no trace.

Each axis is scaled and shifted by itself: left and right land on −1 and 1, bottom and top likewise,
the near plane on depth −1 and the far one on 1. The last row is (0, 0, 0, 1), so w stays 1 and
nothing is divided. What is parallel stays parallel, what is of one size stays so: plans, shadow
maps of a sun, and text are drawn this way.

Look at: the track. Its rails run side by side to the very end, and the last post is exactly as tall
as the first. You can't tell how far away anything is; compare the perspective picture of the same
track.
"""

import numpy as np

from shaderlab import Case, Depth, Draw, Mesh, State, computed, formula, value
from shaderlab.assets.order import any_order
from shaderlab.glslmath import mul, swizzle, vec4
from shaderlab.reference.spaces import orthographic_clip
from shaderlab.reference.transforms import look_at, orthographic
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.glm import orthographic_by_glm
from ..scenes.props import railway
from ..scenes.studio import handed_on, softened, studio_color

VIEW = look_at((3.4, 4.6, 3.0), (-0.6, 0.2, -7.0))
BOX = {"left": -5.2, "right": 6.0, "bottom": -3.6, "top": 4.8, "near": 0.5, "far": 40.0}
NOTES = {"left": -3.0, "right": 5.0, "bottom": -2.0, "top": 7.0, "near": 1.0, "far": 7.5}

track = Draw(
    vertex="ch04_spaces/orthographic.vert",
    fragment="ch03_transforms/studio.frag",
    mesh=Mesh(**railway(16.0)),
    uniforms={"view": VIEW, **BOX},
    state=State(depth=Depth()),
)


def clip(aPos, view, left, right, bottom, top, near, far):
    """Clip coordinates of a vertex, for the case's box."""
    seen = swizzle(mul(view, vec4(aPos, 1.0)), "xyz")
    return orthographic_clip(seen, left, right, bottom, top, near, far)


def same_normal(aNormal):
    """The light is the world's, and so are the normals."""
    return aNormal


def corner(place, equals, name):
    """Where one place of the box lands, seen without a view matrix."""
    return value(
        "judged.gl_Position",
        at={"aPos": place, "view": np.eye(4), **NOTES},
        equals=(*equals, 1.0),
        digits=6,
        reference=clip,
        name=name,
    )


def across_rails(z):
    """How far apart the rails are on the screen at z."""
    matrix = orthographic(*BOX.values())
    right, left = (matrix @ VIEW @ (x, 0.0, z, 1.0) for x in (0.7, -0.7))
    return (right - left)[:2]


case = Case(
    title="Orthographic projection",
    section="4.4",
    math=r"\begin{pmatrix} \frac{2}{r-l} & 0 & 0 & -\frac{r+l}{r-l} \\ 0 & \frac{2}{t-b} & 0 & "
    r"-\frac{t+b}{t-b} \\ 0 & 0 & \frac{-2}{f-n} & -\frac{f+n}{f-n} \\ 0 & 0 & 0 & 1 \end{pmatrix}",
    passes=stage.photographed((track,), (800, 600)),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        any_order("judged.FragColor"),
        *stage.light_checks(studio_color),
        formula("judged.gl_Position", clip, also={"PyGLM": orthographic_by_glm}),
        formula("judged.Normal", same_normal),
        formula("judged.Color", handed_on),
        formula("judged.FragColor", studio_color),
        corner((-3.0, -2.0, -1.0), (-1.0, -1.0, -1.0), "lower left corner, near"),
        corner((5.0, 7.0, -7.5), (1.0, 1.0, 1.0), "upper right corner, far"),
        corner((1.0, 2.5, -4.25), (0.0, 0.0, 0.0), "the middle"),
        computed(
            "depth of the near plane",
            lambda: (orthographic(*BOX.values()) @ (0, 0, -0.5, 1))[2],
            equals=-1.0,
            digits=12,
        ),
        computed(
            "depth of the far plane",
            lambda: (orthographic(*BOX.values()) @ (0, 0, -40.0, 1))[2],
            equals=1.0,
            digits=12,
        ),
        computed(
            "rails on the screen, far less near",
            lambda: across_rails(-16.0) - across_rails(0.0),
            equals=(0.0, 0.0),
            digits=12,
            note="parallel lines stay parallel",
        ),
        computed(
            "diagonal of the unit box −1…1, −1…1, 1…−1",
            lambda: np.diag(orthographic(-1, 1, -1, 1, -1, 1)),
            equals=(1.0, 1.0, -1.0, 1.0),
            digits=12,
            note="only z turns around",
        ),
    ],
)
