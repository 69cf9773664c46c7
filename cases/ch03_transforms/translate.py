"""Translation: the offset stands in the last column, where only the fourth coordinate reaches it.

A 3 × 3 matrix leaves the origin where it is, so it can't move anything. With a fourth coordinate w
it can: the last column is multiplied by w. Positions have w = 1 and move. Directions have w = 0 and
stay, as they should: north is the same direction from everywhere. Rotation and scaling sit in the
other three columns and change both.

Look at: the letter, twice under the same matrix, and pale where it was. On the left its corners
have w = 1 and it lands at the tip of the arrow, which is the offset. On the right they have w = 0:
the letter covers its pale double exactly, the arrow goes off without it.

Try: in `ch03_transforms/translate.vert` write `vec4(0.5 * offset, 1.0)` for `vec4(offset, 1.0)`:
the left letter stops halfway along its arrow, and the right one does not notice.
"""

from shaderlab import Case, Depth, Erratum, formula
from shaderlab.glslmath import swizzle
from shaderlab.reference.transforms import in_view, scale, translate, translated

from ..scenes import painted_solids as solids, stage
from ..scenes.cameras import camera, turned
from ..scenes.figures import each_draw, figures, results
from ..scenes.glm import translated_by_glm
from ..scenes.laws import unchanged
from ..scenes.panels import cell
from ..scenes.props import letter_f, tile

OFFSET = (1.35, 0.55, -0.4)
CAMERA = camera((1.0, 2.5, 5.1), (0.35, 0.62, 0.0), 32.5, 4.0 / 3.0)
STILL = (
    tile(1.9, 0.475),
    solids.repainted(letter_f(), (0.62, 0.66, 0.70), 0.85),
    solids.arrow(OFFSET, color=solids.BLUE, thickness=0.028),
)


def half(column, w):
    """The letter before and after, the offset as an arrow, and a floor that nothing moves."""
    side = cell(column, 2)
    after = stage.subject(
        "ch03_transforms/translate.vert",
        letter_f(),
        {"offset": OFFSET, "w": w, **CAMERA},
        cell=side,
        depth=Depth(func="lequal"),
    )
    return *(stage.prop(solid, CAMERA, cell=side) for solid in STILL), after


def position(aPos, offset, w, view, projection):
    """Where the moved vertex lands in clip space."""
    return in_view(swizzle(translated(aPos, offset, w), "xyz"), view, projection)


# The letter's draws, left and right.
HALVES = {3: "w = 1", 7: "w = 0"}
EAST = (1, 0, 0, 0)

case = Case(
    title="Translation",
    section="3.1",
    math=r"\begin{pmatrix} 1 & 0 & 0 & T_x \\ 0 & 1 & 0 & T_y \\ 0 & 0 & 1 & T_z \\ 0 & 0 & 0 & 1"
    r"\end{pmatrix} \begin{pmatrix} x \\ y \\ z \\ w \end{pmatrix} = "
    r"\begin{pmatrix} x + w\,T_x \\ y + w\,T_y \\ z + w\,T_z \\ w \end{pmatrix}",
    passes=stage.photographed((*half(0, 1.0), *half(1, 0.0)), (800, 300)),
    picture="picture.FragColor",
    columns=("w = 1", "w = 0"),
    expect=[
        *stage.checks(),
        *each_draw("judged.Moved", translated, HALVES, also={"PyGLM": translated_by_glm}),
        formula("judged.Normal", unchanged("aNormal"), draw=3),
        *each_draw("judged.gl_Position", position, HALVES, "clip coordinates, {}"),
        *stage.color_checks(HALVES),
        *figures(
            "judged.Moved",
            {
                "a place moves": ({"w": 1.0}, (2.0, 2.0, 3.0, 1.0)),
                "a direction stays": ({"w": 0.0}, (1.0, 0.0, 0.0, 0.0)),
            },
            at={"aPos": (1.0, 0.0, 0.0), "w": 1.0, "offset": (1.0, 2.0, 3.0)},
            reference=translated,
        ),
        *results(
            {
                "translate · (1, 0, 0, 0)": (translate((1, 2, 3)) @ EAST, (1.0, 0.0, 0.0, 0.0)),
                "scale by 2 · (1, 2, 3, 0)": (
                    scale(2.0) @ (1, 2, 3, 0),
                    (2.0, 4.0, 6.0, 0.0),
                    "and so does a scale",
                ),
                "90° around z · (1, 0, 0, 0)": (
                    turned(90.0, (0, 0, 1)) @ EAST,
                    (0.0, 1.0, 0.0, 0.0),
                    "a rotation does change directions",
                ),
            },
            digits=12,
        ),
    ],
    errata=[
        Erratum(
            section="3.1",
            says="a vector has w = 0: multiplied by a transform it is itself",
            truth="of translations only; a scale by 2 makes (2, 4, 6, 0) of (1, 2, 3, 0)",
            proof="scale by 2 · (1, 2, 3, 0)",
        )
    ],
)
