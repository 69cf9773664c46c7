"""Scaling: the diagonal holds a factor for each axis, and a negative one mirrors.

Equal factors keep the shape, unequal ones stretch it, and then normals must be divided by the
factors, or slopes would be lit as if they were not stretched. The determinant is how volume grows;
below zero the solid is its own mirror image, and its triangles wind the other way round. A
translation in the last column is not scaled, because it is added afterwards.

Look at: the four letters, each in front of a pale one that is not scaled. Above: one half in every
direction, then (1, 2, 3). Below: (2, ½, 1), then (−1, 1, 1), which no turn could make: the letter
reads backwards.

Try: in `ch03_transforms/scale.vert` write `vec4(offset * factors, 1.0)` for `vec4(offset, 1.0)`:
the way from the pale letter is scaled as well, so (1, 2, 3) brings its letter much nearer to you.
"""

from numpy.linalg import det

from shaderlab import Case, formula
from shaderlab.reference.transforms import scale, scaled, translate

from ..scenes import painted_solids as solids, stage
from ..scenes.cameras import camera
from ..scenes.figures import each_draw, figures, results
from ..scenes.glm import scaled_by_glm
from ..scenes.laws import projected
from ..scenes.props import letter_f, tile

CAMERA = camera((1.5, 2.3, 5.6), (0.15, 0.85, 0.0), 27.0, 4.0 / 3.0)
GHOST = solids.repainted(letter_f(), (0.62, 0.66, 0.70), 0.85)
SCALES = {
    "one half": (0.5, 0.5, 0.5),
    "stretched": (1.0, 2.0, 3.0),
    "squashed": (2.0, 0.5, 1.0),
    "mirrored": (-1.0, 1.0, 1.0),
}


def quarter(place, factors):
    """One cell: floor, the letter as it is, the letter scaled."""
    yield stage.prop(tile(1.5, 0.5), CAMERA, cell=place)
    yield stage.prop(GHOST, CAMERA, cell=place, model=translate((0.0, 0.0, -0.6)))
    uniforms = {"factors": factors, "offset": (0.0, 0.0, 0.55), **CAMERA}
    yield stage.subject("ch03_transforms/scale.vert", letter_f(), uniforms, cell=place)


def across_the_slope(aNormal, factors):
    """A normal through the inverse transpose of a diagonal matrix."""
    return aNormal / factors


LAST = {3 * k + 2: name for k, name in enumerate(SCALES)}
MIXED = {"aPos": (7.0, 8.0, 9.0), "factors": (1.0, 2.0, 3.0), "offset": (0.0, 0.0, 0.0)}
NORMAL = {"aNormal": (1.0, 1.0, 0.0), "factors": (1.0, 2.0, 3.0)}
SLOPE = "a slope of 45° along (1, −1) becomes (1, −2), at right angles to (1, ½)"
DIVIDED = {"a normal is divided": (NORMAL, (1.0, 0.5, 0.0), SLOPE)}
LEFT = "negative: left and right change places"
MOVED, TIMES = {"offset": (4.0, 5.0, 6.0)}, (11.0, 21.0, 33.0, 1.0)

case = Case(
    title="Scaling",
    section="3.3",
    math=r"\begin{pmatrix} S_1 & 0 & 0 & V_1 \\ 0 & S_2 & 0 & V_2 \\ 0 & 0 & S_3 & V_3 \\ 0 & 0 & "
    r"0 & 1 \end{pmatrix} \begin{pmatrix} x \\ y \\ z \\ 1 \end{pmatrix} = \begin{pmatrix} "
    r"S_1 x + V_1 \\ S_2 y + V_2 \\ S_3 z + V_3 \\ 1 \end{pmatrix}",
    passes=stage.gallery(quarter, SCALES.values(), 2, (800, 600)),
    picture="picture.FragColor",
    rows=("½, (1, 2, 3)", "(2, ½, 1), (−1, 1, 1)"),
    expect=[
        *stage.checks(),
        *each_draw("judged.Scaled", scaled, LAST, also={"PyGLM": scaled_by_glm}),
        *stage.color_checks(LAST),
        formula("judged.Normal", across_the_slope, draw=5, name="normals"),
        formula("judged.gl_Position", projected(scaled, homogeneous=True), name="clip coordinates"),
        *figures(
            "judged.Scaled",
            {
                "(1, 2, 3) times, then moved by (4, 5, 6)": (MOVED, TIMES),
                "diag(1, 2, 3)": ({}, (7.0, 16.0, 27.0, 1.0)),
                "mirrored": ({"factors": (-1.0, 1.0, 1.0)}, (-7.0, 8.0, 9.0, 1.0)),
            },
            at=MIXED,
            reference=scaled,
        ),
        *figures("judged.Normal", DIVIDED, reference=across_the_slope),
        *results(
            {
                "translate(4, 5, 6) · scale(1, 2, 3) · (7, 8, 9)": (
                    translate((4, 5, 6)) @ scale((1, 2, 3)) @ (7, 8, 9, 1),
                    TIMES,
                ),
                "volume under (1, 2, 3)": (det(scale((1, 2, 3))), 6.0),
                "determinant of the mirror": (det(scale((-1, 1, 1))), -1.0, LEFT),
            },
            digits=12,
        ),
    ],
)
