"""Diffuse light: a matte surface is the brighter the more squarely the light meets it.

A beam that comes in at an angle spreads over a larger patch, and each point gets less of it: the
cosine between normal and light, and nothing from behind. The normals have to follow the object. A
turned object turns its normals; a squeezed one tilts them the other way than its points, by the
inverse transpose of the model matrix. Left unchanged, or transformed like points, they are no
longer perpendicular to anything.

Look at: the normals, drawn as thin rods. Upper left is a ball as its mesh has it. The other three
are the same ball squeezed flat. Upper right it kept the round ball's normals, lower left they went
where points go, and in both the rods lean over and the light falls as on some other body. Only
lower right do they stand upright, and the flat top, which faces the lamp, is the bright part.

Try: in `ch05_lighting/diffuse.frag` write `diffuseFactor(-normalize(Normal), lightDir)` for
`diffuseFactor(normalize(Normal), lightDir)`: the lit and the dark sides change places.
"""

from math import acos, degrees

import numpy as np

from shaderlab import Case, Erratum, assets, formula
from shaderlab.glslmath import inverse, mat3, mul, transpose
from shaderlab.reference.lighting import diffuse_color, diffuse_factor
from shaderlab.reference.transforms import normal_matrix, scale, translate

from ..scenes import lit, normal_rods
from ..scenes.cameras import camera, turned
from ..scenes.draws import tested
from ..scenes.figures import each_draw, figure, results
from ..scenes.laws import unchanged
from ..scenes.panels import cell

AS_IT_IS, LIKE_A_POINT, INVERSE_TRANSPOSE = PATHS = (0, 1, 2)
BRASS = (1.0, 0.83, 0.35)
CAMERA = camera((0.0, 1.3, 6.0), (0.0, 0.0, 0.0), 28.5)
TILT = translate((0.05, 0.04, -0.1)) @ turned(-14.0, (0.0, 0.0, 1.0))
SQUEEZED = TILT @ scale((1.0, 0.4, 1.0))
RADIUS = 0.97
BALL = assets.sphere(RADIUS)
SLANTED = (0.5**0.5, 0.5**0.5, 0.0)
# The round ball, and the squeezed one with its normals on three paths.
QUARTERS = [(TILT, LIKE_A_POINT), *((SQUEEZED, path) for path in PATHS)]


def thing(mesh, model, path, quarter, color=lit.CORAL, ambient=0.1):
    """One thing in a quarter of the picture, its normals on one of the three paths."""
    uniforms = {
        "model": model,
        **CAMERA,
        "path": path,
        "objectColor": color,
        "lightColor": (1.0, 0.97, 0.92),
        "lightPos": (-2.4, 3.0, 2.6),
        "ambientStrength": ambient,
    }
    place = cell(quarter, 2, 2, from_above=True)
    return tested("ch05_lighting/diffuse", mesh, uniforms, only=("aPos", "aNormal"), cell=place)


def on_path(normal, model, path):
    """Where a normal of the ball goes, by NumPy."""
    if path == AS_IT_IS:
        return np.asarray(normal, float)
    return (model[:3, :3] if path == LIKE_A_POINT else normal_matrix(model)) @ normal


def rods(model, path):
    """The normals as rods, each where the model has its point."""

    def direction(normal):
        return on_path(normal, model, path)

    return normal_rods.rods(model @ scale(RADIUS), direction, length=0.36, rows=8, columns=14)


BALLS = [thing(BALL, *row, quarter) for quarter, row in enumerate(QUARTERS)]
RODS = [
    thing(rods(*row), np.eye(4), AS_IT_IS, quarter, BRASS, 0.5)
    for quarter, row in enumerate(QUARTERS)
]


def like_a_point(aNormal, model):
    """The model matrix without its translation."""
    return mul(mat3(model), aNormal)


def inverse_transposed(aNormal, model):
    """The inverse transpose of the model matrix."""
    return mul(transpose(inverse(mat3(model))), aNormal)


def angle(path):
    """Degrees between a slanted normal on its path and the surface there; 90 is upright."""
    along = SQUEEZED[:3, :3] @ (-SLANTED[1], SLANTED[0], 0.0)
    normal = on_path(SLANTED, SQUEEZED, path)
    cosine = np.dot(along, normal) / np.linalg.norm(along) / np.linalg.norm(normal)
    return degrees(acos(cosine))


POINT = {
    "lightColor": lit.WHITE,
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 0.0, 1.0),
    "lightPos": lit.POINT_LAMP,
}

case = Case(
    title="Diffuse light",
    section="5.2.2",
    math=r"d = \max(N \cdot L,\ 0), \qquad N = (M^{-1})^{\mathsf T} N_{\text{mesh}}",
    passes=lit.photographed(
        [draw for pair in zip(RODS, BALLS, strict=True) for draw in pair],
        BALLS,
        clear=(0.018, 0.022, 0.03, 1.0),
    ),
    picture="picture.FragColor",
    rows=("the ball; squeezed, old normals", "like points; by the inverse transpose"),
    expect=[
        *lit.vertex_stage_checks("gl_Position", "FragPos"),
        formula("Normal", unchanged("aNormal"), draw=1, name="normals as they are"),
        formula("Normal", like_a_point, draw=2, name="normals like points"),
        formula("Normal", inverse_transposed, draw=3, name="normals by the inverse transpose"),
        *each_draw("diff", diffuse_factor, ((k, f"diffuse factor, ball {k}") for k in range(4))),
        formula("FragColor", diffuse_color, draw=1, name="colour, normals as they are"),
        formula("FragColor", diffuse_color, name="colour, normals by the inverse transpose"),
        *lit.picture_checks(),
        figure("diff", "diffuse factor at the point", POINT, 0.788110),
        figure("FragColor", "colour at the point", POINT, (0.888110, 0.444055, 0.275314, 1.0)),
        *results(
            {
                "as it is: angle to the surface": (angle(AS_IT_IS), 99.198591),
                "like a point: angle to the surface": (angle(LIKE_A_POINT), 136.397181),
                "inverse transpose: angle to the surface": (angle(INVERSE_TRANSPOSE), 90.0),
            }
        ),
    ],
    errata=[
        Erratum(
            section="5.2.2",
            says="the vertex shader hands on the normal: Normal = aNormal",
            truth="a model matrix that turns or squeezes needs transpose(inverse(mat3(model)))",
            proof="inverse transpose: angle to the surface",
        )
    ],
)
