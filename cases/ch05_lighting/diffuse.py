"""Diffuse light: a matte surface is the brighter the more squarely the light meets it.

A beam that comes in at an angle spreads over a larger patch, and each point gets less of it: the
cosine between normal and light, and nothing from behind. The normals have to follow the object.
A turned object turns its normals; a squeezed one tilts them the other way than its points, by the
inverse transpose of the model matrix. Handed on as they are, or sent where points go, they are no
longer perpendicular to anything.

Look at: the normals, drawn as thin rods. Upper left is a ball as its mesh has it. The other three
are the same ball squeezed flat. Upper right it kept the round ball's normals, lower left they
went where points go, and in both the rods lean over and the light falls as on some other body.
Only lower right do they stand upright, and the flat top, which faces the lamp, is the bright part.
"""

from math import acos, degrees, radians

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Depth,
    Draw,
    Erratum,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    assets,
    computed,
    formula,
    fullscreen,
    value,
)
from shaderlab.assets.order import any_order, both_ways
from shaderlab.glslmath import inverse, mat3, mul, transpose
from shaderlab.reference.lighting import diffuse_color, diffuse_factor
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    perspective,
    rotate,
    scale,
    translate,
    world_position,
)
from shaderlab.sampling import texture

from ..scenes import normal_rods as normals
from ..scenes.studio import finished

AS_IT_IS, LIKE_A_POINT, INVERSE_TRANSPOSE = PATHS = (0, 1, 2)
CORAL, BRASS = (1.0, 0.5, 0.31), (1.0, 0.83, 0.35)
TILT = translate((0.05, 0.04, -0.1)) @ rotate(radians(-14.0), (0.0, 0.0, 1.0))
SQUEEZED = TILT @ scale((1.0, 0.4, 1.0))

RADIUS = 0.97
BALL = assets.sphere(RADIUS)
LAMP = (-2.4, 3.0, 2.6)
SLANTED = (0.5**0.5, 0.5**0.5, 0.0)


def thing(mesh, model, path, cell, color=CORAL, ambient=0.1):
    """One thing in a quarter of the picture, its normals on one of the three paths."""
    return Draw(
        vertex="ch05_lighting/diffuse.vert",
        fragment="ch05_lighting/diffuse.frag",
        mesh=Mesh(**mesh).only("aPos", "aNormal"),
        uniforms={
            "model": model,
            "view": look_at((0.0, 1.3, 6.0), (0.0, 0.0, 0.0)),
            "projection": perspective(radians(28.5), 1.0, 0.1, 20.0),
            "path": path,
            "objectColor": color,
            "lightColor": (1.0, 0.97, 0.92),
            "lightPos": LAMP,
            "ambientStrength": ambient,
        },
        state=State(
            depth=Depth(), cell=Cell(column=cell % 2, row=1 - cell // 2, columns=2, rows=2)
        ),
    )


def on_path(normal, model, path):
    """Where a normal of the ball goes, by NumPy."""
    if path == AS_IT_IS:
        return np.asarray(normal, float)
    return (model[:3, :3] if path == LIKE_A_POINT else normal_matrix(model)) @ normal


def rods(model, path):
    """The normals as rods, each where the model has its point."""

    def direction(normal):
        return on_path(normal, model, path)

    return normals.rods(model @ scale(RADIUS), direction, length=0.36, rows=8, columns=14)


def quarters(name, with_rods, **target):
    """The round ball, and the squeezed one with its normals on three paths."""
    draws = []
    for cell, (model, path) in enumerate(
        [(TILT, LIKE_A_POINT), *((SQUEEZED, path) for path in PATHS)]
    ):
        if with_rods:
            draws.append(thing(rods(model, path), np.eye(4), AS_IT_IS, cell, BRASS, 0.5))
        draws.append(thing(BALL, model, path, cell))
    target = Target(depth="depth24", clear=(0.018, 0.022, 0.03, 1.0), **target)
    return Pass(name=name, target=target, draws=draws)


def as_it_is(aNormal):
    """The notes' way: the ball's own normal."""
    return aNormal


def like_a_point(aNormal, model):
    """The model matrix without its translation."""
    return mul(mat3(model), aNormal)


def inverse_transposed(aNormal, model):
    """The inverse transpose of the model matrix."""
    return mul(transpose(inverse(mat3(model))), aNormal)


def angle_to_surface(path):
    """Degrees between a slanted normal on its path and the surface there; 90 is upright."""
    along = SQUEEZED[:3, :3] @ (-SLANTED[1], SLANTED[0], 0.0)
    normal = on_path(SLANTED, SQUEEZED, path)
    cosine = np.dot(along, normal) / np.linalg.norm(along) / np.linalg.norm(normal)
    return degrees(acos(cosine))


POINT = {
    "lightColor": (1.0, 1.0, 1.0),
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 0.0, 1.0),
    "lightPos": (1.2, 1.0, 2.0),
}

case = Case(
    title="Diffuse light",
    section="5.2.2",
    math=r"d = \max(N \cdot L,\ 0), \qquad N = (M^{-1})^{\mathsf T} N_{\text{mesh}}",
    passes=(
        *both_ways(quarters("scene", True, size=(1024, 1024), colors={"FragColor": "rgba16f"})),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        *both_ways(quarters("judged", False)),
    ),
    picture="picture.FragColor",
    expect=[
        formula("gl_Position", clip_position),
        formula("FragPos", world_position),
        formula("Normal", as_it_is, draw=1, name="normals as they are"),
        formula("Normal", like_a_point, draw=2, name="normals like points"),
        formula("Normal", inverse_transposed, draw=3, name="normals by the inverse transpose"),
        formula("diff", diffuse_factor),
        formula("FragColor", diffuse_color, draw=1, name="colour, normals as they are"),
        formula("FragColor", diffuse_color, name="colour, normals by the inverse transpose"),
        formula("picture.FragColor", finished(texture), name="the picture"),
        any_order("scene.FragColor"),
        any_order("judged.FragColor"),
        value("diff", at=POINT, equals=0.788110, digits=6, name="diffuse factor at the point"),
        value(
            "FragColor",
            at=POINT,
            equals=(0.888110, 0.444055, 0.275314, 1.0),
            digits=6,
            name="colour at the point",
        ),
        computed(
            "as it is: angle to the surface",
            lambda: angle_to_surface(AS_IT_IS),
            equals=99.198591,
            digits=6,
        ),
        computed(
            "like a point: angle to the surface",
            lambda: angle_to_surface(LIKE_A_POINT),
            equals=136.397181,
            digits=6,
        ),
        computed(
            "inverse transpose: angle to the surface",
            lambda: angle_to_surface(INVERSE_TRANSPOSE),
            equals=90.0,
            digits=6,
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
