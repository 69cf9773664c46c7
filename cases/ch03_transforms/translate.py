"""Translation: the offset stands in the last column, where only the fourth coordinate reaches it.

A 3 × 3 matrix leaves the origin where it is, so it can't move anything. With a fourth coordinate w
it can: the last column counts w times. Places have w = 1 and move. Directions have w = 0 and stay,
as they should: the way north is the same from everywhere. Rotation and scaling sit in the other
three columns and change both.

Look at: the letter, twice under the same matrix, and pale where it was. On the left its corners
have w = 1 and it lands at the tip of the arrow, which is the offset. On the right they have w = 0:
the letter covers its pale double exactly, the arrow goes off without it.
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
    computed,
    formula,
    value,
)
from shaderlab.assets import solids
from shaderlab.assets.order import any_order
from shaderlab.glslmath import swizzle
from shaderlab.reference.transforms import (
    clip_position,
    in_view,
    look_at,
    perspective,
    rotate,
    translate,
    translated,
    world_normal,
)
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.glm import translated_by_glm
from ..scenes.props import letter_f, tile
from ..scenes.studio import handed_on, softened, studio_color

OFFSET = (1.35, 0.55, -0.4)
LETTER = letter_f()
STILL = (
    tile(1.9, 0.475),
    solids.repainted(LETTER, (0.62, 0.66, 0.70), 0.85),
    solids.arrow(OFFSET, color=solids.BLUE, thickness=0.028),
)
VIEW = look_at((0.9, 2.3, 4.6), (0.45, 0.55, 0.0))
PROJECTION = perspective(radians(42.0), 4.0 / 3.0, 0.1, 20.0)


def half(column, w):
    """The letter before and after, the offset as an arrow, and a floor that nothing moves."""
    cell = Cell(column=column, row=0, columns=2, rows=1)
    after = Draw(
        vertex="ch03_transforms/translate.vert",
        fragment="ch03_transforms/studio.frag",
        mesh=Mesh(**LETTER),
        uniforms={"offset": OFFSET, "w": w, "view": VIEW, "projection": PROJECTION},
        state=State(depth=Depth(func="lequal"), cell=cell),
    )
    return *(stage.prop(solid, VIEW, PROJECTION, cell=cell) for solid in STILL), after


def normal_stays(aNormal):
    """A normal is a direction: translation has no hold on it."""
    return aNormal


def position(aPos, offset, w, view, projection):
    """Where the moved vertex lands in clip space."""
    return in_view(swizzle(translated(aPos, offset, w), "xyz"), view, projection)


case = Case(
    title="Translation",
    section="3.1",
    math=r"\begin{pmatrix} 1 & 0 & 0 & T_x \\ 0 & 1 & 0 & T_y \\ 0 & 0 & 1 & T_z \\ 0 & 0 & 0 & 1"
    r"\end{pmatrix} \begin{pmatrix} x \\ y \\ z \\ w \end{pmatrix} = "
    r"\begin{pmatrix} x + w\,T_x \\ y + w\,T_y \\ z + w\,T_z \\ w \end{pmatrix}",
    passes=stage.photographed((*half(0, 1.0), *half(1, 0.0)), (800, 300)),
    picture="picture.FragColor",
    expect=[
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        any_order("judged.FragColor"),
        *stage.prop_checks(clip_position, world_normal, handed_on, studio_color),
        formula(
            "judged.Moved", translated, draw=3, also={"PyGLM": translated_by_glm}, name="w = 1"
        ),
        formula(
            "judged.Moved", translated, draw=7, also={"PyGLM": translated_by_glm}, name="w = 0"
        ),
        formula("judged.Normal", normal_stays, draw=3),
        formula("judged.Color", handed_on),
        formula("judged.gl_Position", position, draw=3, name="clip coordinates, w = 1"),
        formula("judged.gl_Position", position, draw=7, name="clip coordinates, w = 0"),
        formula("judged.FragColor", studio_color, draw=3, name="colour, w = 1"),
        formula("judged.FragColor", studio_color, draw=7, name="colour, w = 0"),
        value(
            "judged.Moved",
            at={"aPos": (1.0, 0.0, 0.0), "w": 1.0, "offset": (1.0, 2.0, 3.0)},
            equals=(2.0, 2.0, 3.0, 1.0),
            digits=6,
            reference=translated,
            name="a place moves",
        ),
        value(
            "judged.Moved",
            at={"aPos": (1.0, 0.0, 0.0), "w": 0.0, "offset": (1.0, 2.0, 3.0)},
            equals=(1.0, 0.0, 0.0, 0.0),
            digits=6,
            reference=translated,
            name="a direction stays",
        ),
        computed(
            "translate · (1, 0, 0, 0)",
            lambda: translate((1, 2, 3)) @ (1, 0, 0, 0),
            equals=(1.0, 0.0, 0.0, 0.0),
            digits=12,
        ),
        computed(
            "90° around z · (1, 0, 0, 0)",
            lambda: rotate(np.pi / 2, (0, 0, 1)) @ (1, 0, 0, 0),
            equals=(0.0, 1.0, 0.0, 0.0),
            digits=12,
            note="a rotation does change directions",
        ),
    ],
)
