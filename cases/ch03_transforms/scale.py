"""Scaling: the diagonal holds a factor for each axis, and a negative one mirrors.

Equal factors keep the shape, unequal ones stretch it, and then normals must be divided by the
factors, or slopes would be lit as if they were not stretched. The determinant is how volume grows;
below zero the solid is its own mirror image, and its triangles wind the other way round. A
translation in the last column is not scaled, because it is added afterwards.

Look at: the four letters, each in front of a pale one that is not scaled. Above: one half in every
direction, then (1, 2, 3). Below: (2, ½, 1), then (−1, 1, 1), which no turn could make: the letter
reads backwards.
"""

from math import radians

import numpy as np

from shaderlab import Case, Cell, Depth, Draw, Mesh, State, computed, formula, value
from shaderlab.assets import solids
from shaderlab.assets.order import any_order
from shaderlab.glslmath import mul
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    perspective,
    scale,
    scaled,
    translate,
    world_normal,
)
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.glm import scaled_by_glm
from ..scenes.props import letter_f, tile
from ..scenes.studio import handed_on, softened, studio_color

VIEW = look_at((1.5, 2.3, 5.6), (0.15, 0.75, 0.0))
PROJECTION = perspective(radians(34.0), 4.0 / 3.0, 0.1, 20.0)
GHOST = solids.repainted(letter_f(), (0.62, 0.66, 0.70), 0.85)
FLOOR = tile(1.5, 0.5)
FRONT = (0.0, 0.0, 0.55)
SCALES = {
    "one half": ((0.5, 0.5, 0.5), (0, 1)),
    "stretched": ((1.0, 2.0, 3.0), (1, 1)),
    "squashed": ((2.0, 0.5, 1.0), (0, 0)),
    "mirrored": ((-1.0, 1.0, 1.0), (1, 0)),
}


def quarter(factors, place):
    """One cell: floor, the letter as it is, the letter scaled."""
    cell = Cell(column=place[0], row=place[1], columns=2, rows=2)
    props = (
        stage.prop(FLOOR, VIEW, PROJECTION, cell=cell),
        stage.prop(GHOST, VIEW, PROJECTION, cell=cell, model=translate((0.0, 0.0, -0.6))),
    )
    letter = Draw(
        vertex="ch03_transforms/scale.vert",
        fragment="ch03_transforms/studio.frag",
        mesh=Mesh(**letter_f()),
        uniforms={"factors": factors, "offset": FRONT, "view": VIEW, "projection": PROJECTION},
        state=State(depth=Depth(), cell=cell),
    )
    return *props, letter


def across_the_slope(aNormal, factors):
    """A normal through the inverse transpose of a diagonal matrix."""
    return aNormal / factors


def position(aPos, factors, offset, view, projection):
    """Where the scaled vertex lands in clip space."""
    return mul(projection, mul(view, scaled(aPos, factors, offset)))


LAST = {name: 3 * k + 2 for k, name in enumerate(SCALES)}
MIXED = {"aPos": (7.0, 8.0, 9.0), "factors": (1.0, 2.0, 3.0)}

case = Case(
    title="Scaling",
    section="3.3",
    math=r"\begin{pmatrix} S_1 & 0 & 0 & V_1 \\ 0 & S_2 & 0 & V_2 \\ 0 & 0 & S_3 & V_3 \\ 0 & 0 & "
    r"0 & 1 \end{pmatrix} \begin{pmatrix} x \\ y \\ z \\ 1 \end{pmatrix} = \begin{pmatrix} "
    r"S_1 x + V_1 \\ S_2 y + V_2 \\ S_3 z + V_3 \\ 1 \end{pmatrix}",
    passes=stage.photographed(
        [draw for entry in SCALES.values() for draw in quarter(*entry)], (800, 600)
    ),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        any_order("judged.FragColor"),
        *stage.prop_checks(clip_position, world_normal, handed_on, studio_color),
        *(
            formula("judged.Scaled", scaled, draw=k, also={"PyGLM": scaled_by_glm}, name=name)
            for name, k in LAST.items()
        ),
        *(
            formula("judged.FragColor", studio_color, draw=k, name=f"colour, {name}")
            for name, k in LAST.items()
        ),
        formula("judged.Normal", across_the_slope, draw=LAST["stretched"], name="normals"),
        formula("judged.Color", handed_on),
        formula("judged.gl_Position", position, name="clip coordinates"),
        value(
            "judged.Scaled",
            at={**MIXED, "offset": (4.0, 5.0, 6.0)},
            equals=(11.0, 21.0, 33.0, 1.0),
            digits=6,
            reference=scaled,
            name="(1, 2, 3) times, then moved by (4, 5, 6)",
        ),
        value(
            "judged.Scaled",
            at={**MIXED, "offset": (0.0, 0.0, 0.0)},
            equals=(7.0, 16.0, 27.0, 1.0),
            digits=6,
            reference=scaled,
            name="diag(1, 2, 3)",
        ),
        value(
            "judged.Scaled",
            at={"aPos": (7.0, 8.0, 9.0), "factors": (-1.0, 1.0, 1.0), "offset": (0.0, 0.0, 0.0)},
            equals=(-7.0, 8.0, 9.0, 1.0),
            digits=6,
            reference=scaled,
            name="mirrored",
        ),
        value(
            "judged.Normal",
            at={"aNormal": (1.0, 1.0, 0.0), "factors": (1.0, 2.0, 3.0)},
            equals=(1.0, 0.5, 0.0),
            digits=6,
            reference=across_the_slope,
            name="a normal is divided",
            note="a slope of 45° along (1, −1) becomes (1, −2), at right angles to (1, ½)",
        ),
        computed(
            "translate(4, 5, 6) · scale(1, 2, 3) · (7, 8, 9)",
            lambda: translate((4, 5, 6)) @ scale((1, 2, 3)) @ (7, 8, 9, 1),
            equals=(11.0, 21.0, 33.0, 1.0),
            digits=12,
        ),
        computed(
            "volume under (1, 2, 3)",
            lambda: np.linalg.det(scale((1, 2, 3))),
            equals=6.0,
            digits=12,
        ),
        computed(
            "determinant of the mirror",
            lambda: np.linalg.det(scale((-1, 1, 1))),
            equals=-1.0,
            digits=12,
            note="negative: left and right change places",
        ),
    ],
)
