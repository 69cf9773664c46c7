"""Perspective projection: w becomes the distance, and dividing by it makes far things small.

The last row (0, 0, −1, 0) puts −z into w, and the hardware divides by it. x and y are first scaled
by the focal length 1 / tan(fovy/2), so that the opening angle lands on ±1. Depth has two numbers to
tune, A and B in A + B/z: they send the near plane to −1 and the far plane to 1, and between them
nearly all of the depths go to what is near.

Look at: the rails. They are parallel and meet on the horizon, in the point that all lines along −z
share; the posts shrink as one over their distance. Halfway to a post twice as far there is no
halfway in depth: at a distance of 1, one hundredth of the way, 90 % of the depths are used up.
"""

from math import radians

import numpy as np

from shaderlab import Case, Depth, Draw, Mesh, State, computed, formula, sweep, value
from shaderlab.assets.order import any_order
from shaderlab.glslmath import mul, swizzle, vec4
from shaderlab.reference.spaces import device, perspective_clip
from shaderlab.reference.transforms import look_at, perspective
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.glm import perspective_by_glm
from ..scenes.props import railway
from ..scenes.studio import handed_on, softened, studio_color

VIEW = look_at((0.9, 1.9, 3.6), (0.15, 0.9, -7.0))
LENS = {"fovy": radians(45.0), "aspect": 4.0 / 3.0, "near": 0.1, "far": 100.0}

track = Draw(
    vertex="ch04_spaces/perspective.vert",
    fragment="ch03_transforms/studio.frag",
    mesh=Mesh(**railway(60.0)),
    uniforms={"view": VIEW, **LENS},
    state=State(depth=Depth()),
)


def clip(aPos, view, fovy, aspect, near, far):
    """Clip coordinates of a vertex."""
    return perspective_clip(swizzle(mul(view, vec4(aPos, 1.0)), "xyz"), fovy, aspect, near, far)


def in_device(aPos, view, fovy, aspect, near, far):
    """Device coordinates: after the division by w."""
    return device(clip(aPos, view, fovy, aspect, near, far))


def by_glm(aPos, view, fovy, aspect, near, far):
    """The same through glm.perspective."""
    numbers = (float(np.ravel(v)[0]) for v in (fovy, aspect, near, far))
    points = np.column_stack([aPos, np.ones(len(aPos))])
    return points @ view.T @ perspective_by_glm(*numbers).T


def same_normal(aNormal):
    """The light is the world's, and so are the normals."""
    return aNormal


def entry(row, column, equals):
    """One entry of the matrix: what a unit vector gives."""
    return computed(
        f"row {row + 1}, column {column + 1}",
        lambda: perspective(*LENS.values())[row, column],
        equals=equals,
        digits=6,
    )


def lands(place, ndc, name):
    """Where one place lands, seen without a view matrix."""
    return value(
        "judged.Ndc",
        at={"aPos": place, "view": np.eye(4), **LENS},
        equals=ndc,
        digits=6,
        reference=in_device,
        name=name,
    )


def screen(place):
    """A place on the screen, in device coordinates of the case's own camera."""
    x, y, _, w = perspective(*LENS.values()) @ VIEW @ (*place, 1.0)
    return np.array([x, y]) / w


def apart(distance):
    """Distance between the two rails on the screen, far along the track."""
    return float(np.linalg.norm(screen((0.7, 0.0, -distance)) - screen((-0.7, 0.0, -distance))))


case = Case(
    title="Perspective projection",
    section="4.4",
    math=r"\begin{pmatrix} \frac{1}{a \tan(\theta/2)} & 0 & 0 & 0 \\ 0 & \frac{1}{\tan(\theta/2)} "
    r"& 0 & 0 \\ 0 & 0 & \frac{f+n}{n-f} & \frac{2fn}{n-f} \\ 0 & 0 & -1 & 0 \end{pmatrix}",
    passes=stage.photographed((track,), (800, 600)),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        any_order("judged.FragColor"),
        *stage.light_checks(studio_color),
        formula("judged.gl_Position", clip, also={"PyGLM": by_glm}),
        formula("judged.Ndc", in_device),
        formula("judged.Normal", same_normal),
        formula("judged.Color", handed_on),
        formula("judged.FragColor", studio_color),
        entry(0, 0, 1.810660),
        entry(1, 1, 2.414214),
        entry(2, 2, -1.002002),
        entry(2, 3, -0.200200),
        entry(3, 2, -1.0),
        value(
            "judged.gl_Position",
            at={"aPos": (1.0, 1.0, -1.0), "view": np.eye(4), **LENS},
            equals=(1.810660, 2.414214, 0.801802, 1.0),
            digits=6,
            reference=clip,
            name="(1, 1, −1) in clip space",
            note="−1.002002 · (−1) − 0.200200",
        ),
        lands((0.0, 0.0, -0.1), (0.0, 0.0, -1.0), "the near plane"),
        lands((0.0, 0.0, -100.0), (0.0, 0.0, 1.0), "the far plane"),
        lands((0.0, 0.0, -1.0), (0.0, 0.0, 0.801802), "at a distance of 1"),
        lands((0.0, 1.0, -2.414214), (0.0, 1.0, 0.919076), "the edge of 45°"),
        sweep(
            "judged.gl_Position",
            clip,
            over="fovy",
            at={"aPos": (1.0, 1.0, -1.0), "view": np.eye(4)},
            values=np.radians(np.linspace(20.0, 120.0, 41)),
            name="wider openings, smaller pictures",
        ),
        computed(
            "rails on the screen at a distance of 10⁶", lambda: apart(1e6), equals=0.0, digits=5
        ),
        computed(
            "their width twice as far, relative",
            lambda: apart(2e6) / apart(1e6),
            equals=0.5,
            digits=4,
            note="as one over the distance: they meet",
        ),
    ],
)
