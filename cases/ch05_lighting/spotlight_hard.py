"""A spotlight with a hard edge: a lamp in a tube. Inside the cone it shines, outside it does not.

A fragment is inside if the ray that reaches it is less than the cut-off angle away from the spot's
axis. Comparing angles takes an arccosine; comparing their cosines takes none, but turns the sign
around: the larger cosine is the smaller angle, so inside means θ > cutOff. Outside, the ambient
part is left, or whatever lies there would be a hole in the picture.

Look at: the sharp ellipse that the cone cuts out of the ground, and its edge on the balls. Within
a single pixel full light becomes none: that is why lamps got a second, outer cone.
"""

from math import cos, radians

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
from shaderlab.reference.spotlight import spot_cosine
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
MODEL = rotate(radians(8.0), (0.0, 1.0, 0.0)) @ scale((1.0, 1.1, 1.0))


def stage(name, mesh, **target):
    """The plaza under one spot."""
    return mesh_pass(
        "ch05_lighting/lit_painted.vert",
        "ch05_lighting/spotlight_hard.frag",
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
            "light.position": (-3.2, 5.4, 3.4),
            "light.direction": (3.0, -5.0, -3.1),
            "light.cutOff": cos(radians(18.0)),
            "light.ambient": (0.05, 0.07, 0.13),
            "light.diffuse": (1.1, 1.02, 0.85),
            "light.specular": (1.1, 1.0, 0.85),
        },
        target=Target(depth="depth24", clear=(0.004, 0.006, 0.012, 1.0), **target),
        state=State(depth=Depth()),
    )


def color(
    FragPos, Normal, Color, viewPos, specular, shininess,
    light_position, light_direction, light_cutOff, light_ambient, light_diffuse, light_specular,
):  # fmt: skip
    """The lit colour with an alpha of 1."""
    lit = light_sources.hard_spot(
        FragPos, Normal, Color, viewPos, specular, shininess,
        light_position, light_direction, light_cutOff,
        light_ambient, light_diffuse, light_specular,
    )  # fmt: skip
    return vec4(lit, 1.0)


# The test point's lamp, turned away from it by its direction.
POINT = {
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 0.0, 1.0),
    "Color": (1.0, 0.5, 0.31),
    "viewPos": (0.0, 0.0, 3.0),
    "specular": (0.5, 0.5, 0.5),
    "shininess": 32.0,
    "light.position": (1.2, 1.0, 2.0),
    "light.cutOff": cos(radians(12.5)),
    "light.ambient": (0.2, 0.2, 0.2),
    "light.diffuse": (0.5, 0.5, 0.5),
    "light.specular": (1.0, 1.0, 1.0),
}
AT_IT, PAST_IT = (-1.2, -1.0, -2.0), (0.0, 0.0, -1.0)

case = Case(
    title="Spotlight with a hard edge",
    section="5.5.3",
    math=r"\cos\theta = L \cdot (-D), \qquad C = \begin{cases} A + d\,L_d \odot M_d + "
    r"s\,L_s \odot M_s & \cos\theta > \cos\varphi \\ A & \text{otherwise} \end{cases}, \quad "
    r"A = L_a \odot M_d",
    passes=(
        *both_ways(*stage("scene", plaza(), size=(1024, 1024), colors={"FragColor": "rgba16f"})),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        *both_ways(*stage("judged", plaza(tiles=6, segments=16))),
    ),
    picture="picture.FragColor",
    expect=[
        formula("gl_Position", clip_position),
        formula("FragPos", world_position),
        formula("Normal", world_normal),
        formula("Color", handed_on),
        formula("theta", spot_cosine),
        formula("FragColor", color),
        formula("picture.FragColor", finished(texture), name="the picture"),
        any_order("scene.FragColor"),
        any_order("judged.FragColor"),
        value(
            "FragColor",
            at={**POINT, "light.direction": AT_IT},
            equals=(0.594301, 0.297273, 0.184402, 1.0),
            digits=6,
            name="the point inside the cone",
        ),
        value(
            "FragColor",
            at={**POINT, "light.direction": PAST_IT},
            equals=(0.2, 0.1, 0.062, 1.0),
            digits=6,
            name="the point outside: ambient only",
        ),
        value(
            "theta",
            at={**POINT, "light.direction": PAST_IT},
            equals=0.788110,
            digits=6,
            name="its cosine, 38° off the axis",
        ),
        value(
            "FragColor",
            at={**POINT, "viewPos": (2.0, 0.0, 1.215), "light.direction": AT_IT, "shininess": 0.5},
            equals=(0.629593, 0.332565, 0.219695, 1.0),
            digits=6,
            name="nearly 90° from the mirrored ray",
        ),
    ],
)
