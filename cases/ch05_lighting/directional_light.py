"""Directional light: a lamp so far away that its rays are parallel, like the sun.

All it needs is a direction, and no place: every point sees it under the same angle, and nothing
fades. The direction is the way the light travels, (−0.2, −1, −0.3) in the notes; the formulas want
the way back to the light, so it is turned around and made unit length: (0.188144, 0.940721,
0.282216). Forgetting the minus lights the world from below.

Look at: nine balls on a plaza in a low sun, and how alike they are. The line between light and
shade lies at the same place on each of them, and the tiles are equally bright from corner to
corner. (There are no shadows on the ground yet: each point is lit as if it were alone.)
"""

from math import radians

from shaderlab import (
    Case,
    Depth,
    Mesh,
    Output,
    State,
    Target,
    formula,
    fullscreen,
    mesh_pass,
    value,
)
from shaderlab.assets.order import any_order, both_ways
from shaderlab.glslmath import vec4
from shaderlab.reference import light_sources
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    perspective,
    rotate,
    scale,
    world_normal,
    world_position,
)
from shaderlab.sampling import texture

from ..scenes.plaza import plaza
from ..scenes.studio import finished, handed_on

EYE = (4.4, 5.2, 8.6)
# Not quite evenly scaled, so that the normals have something to get wrong.
MODEL = rotate(radians(8.0), (0.0, 1.0, 0.0)) @ scale((1.0, 1.1, 1.0))


def evening(name, mesh, **target):
    """The plaza in a low sun."""
    return mesh_pass(
        "ch05_lighting/lit_painted.vert",
        "ch05_lighting/directional_light.frag",
        Mesh(**mesh),
        name=name,
        uniforms={
            "model": MODEL,
            "normalMatrix": normal_matrix(MODEL),
            "view": look_at(EYE, (0.1, 0.45, 0.0)),
            "projection": perspective(radians(36.0), 1.0, 0.1, 60.0),
            "viewPos": EYE,
            "specular": (0.35, 0.33, 0.30),
            "shininess": 32.0,
            "light.direction": (0.9, -0.62, -0.38),
            "light.ambient": (0.10, 0.13, 0.20),
            "light.diffuse": (1.25, 0.95, 0.62),
            "light.specular": (1.2, 1.0, 0.75),
        },
        target=Target(depth="depth24", clear=(0.30, 0.38, 0.50, 1.0), **target),
        state=State(depth=Depth()),
    )


def back_to_the_light(light_direction):
    """From a surface to the light, of unit length."""
    return light_sources.direction_to_light(light_direction)


def color(
    FragPos, Normal, Color, viewPos, specular, shininess,
    light_direction, light_ambient, light_diffuse, light_specular,
):  # fmt: skip
    """The lit colour with an alpha of 1."""
    lit = light_sources.directional(
        FragPos, Normal, Color, viewPos, specular, shininess,
        light_direction, light_ambient, light_diffuse, light_specular,
    )  # fmt: skip
    return vec4(lit, 1.0)


POINT = {
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 0.0, 1.0),
    "Color": (1.0, 0.5, 0.31),
    "viewPos": (0.0, 0.0, 3.0),
    "specular": (0.5, 0.5, 0.5),
    "light.direction": (-0.2, -1.0, -0.3),
    "light.ambient": (0.2, 0.2, 0.2),
    "light.diffuse": (0.5, 0.5, 0.5),
    "light.specular": (1.0, 1.0, 1.0),
    "shininess": 4.0,
}

case = Case(
    title="Directional light",
    section="5.5.1",
    math=r"L = -\frac{D}{\lVert D \rVert}, \qquad "
    r"C = (L_a + d\,L_d) \odot M_d + s\,L_s \odot M_s",
    passes=(
        *both_ways(*evening("scene", plaza(), size=(1024, 1024), colors={"FragColor": "rgba16f"})),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        *both_ways(*evening("judged", plaza(tiles=6, segments=16))),
    ),
    picture="picture.FragColor",
    expect=[
        formula("gl_Position", clip_position),
        formula("FragPos", world_position),
        formula("Normal", world_normal),
        formula("Color", handed_on),
        formula("lightDir", back_to_the_light),
        formula("FragColor", color),
        formula("picture.FragColor", finished(texture), name="the picture"),
        any_order("scene.FragColor"),
        any_order("judged.FragColor"),
        value(
            "lightDir",
            at=POINT,
            equals=(0.188144, 0.940721, 0.282216),
            digits=6,
            name="the notes' direction, turned around",
        ),
        value(
            "FragColor",
            at=POINT,
            equals=(0.344280, 0.173726, 0.108915, 1.0),
            digits=6,
            name="colour at the point",
        ),
        value(
            "FragColor",
            at={
                **POINT,
                "viewPos": (2.0, 0.0, 1.215),
                "light.direction": (-1.2, -1.0, -2.0),
                "shininess": 0.5,
            },
            equals=(0.629593, 0.332565, 0.219695, 1.0),
            digits=6,
            name="nearly 90° from the mirrored ray",
        ),
    ],
)
