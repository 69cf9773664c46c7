"""A point light: a bulb in the middle of things. Its light has a direction, and an end.

Every point sees the lamp elsewhere, so the direction is computed for each fragment: lightPos −
FragPos. And the light fades on the way, by 1 / (Kc + Kl·d + Kq·d²), all three parts of it: a far
wall gets less diffuse light, but also less of the light that found its way around.

Look at: the plaza of the directional light at night, with one bulb in its midst. All balls show
their lit sides to the bulb, each another side. The tiles around it are bright and the corners
nearly dark; even the ambient light ends there, because it fades as well.
"""

from math import radians

from shaderlab import (
    Case,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    assets,
    formula,
    fullscreen,
    sweep,
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
    translate,
    world_normal,
    world_position,
)
from shaderlab.sampling import texture

from ..scenes.plaza import plaza
from ..scenes.studio import finished, handed_on

EYE, LAMP = (4.4, 5.2, 8.6), (1.1, 1.25, 0.95)
CAMERA = {
    "view": look_at(EYE, (0.1, 0.45, 0.0)),
    "projection": perspective(radians(36.0), 1.0, 0.1, 60.0),
}
MODEL = rotate(radians(8.0), (0.0, 1.0, 0.0)) @ scale((1.0, 1.1, 1.0))


def bulb():
    """The lamp itself: a small ball that is not lit, but shines."""
    return Draw(
        vertex="ch05_lighting/lamp.vert",
        fragment="ch05_lighting/lamp.frag",
        mesh=Mesh(**assets.sphere(0.11)).only("aPos"),
        uniforms={"model": translate(LAMP), "glow": (1.0, 0.95, 0.80), **CAMERA},
        state=State(depth=Depth()),
    )


def night(name, mesh, **target):
    """The bulb, and the plaza in its light."""
    lit = Draw(
        vertex="ch05_lighting/lit_painted.vert",
        fragment="ch05_lighting/point_light.frag",
        mesh=Mesh(**mesh),
        uniforms={
            "model": MODEL,
            "normalMatrix": normal_matrix(MODEL),
            **CAMERA,
            "viewPos": EYE,
            "specular": (0.35, 0.33, 0.30),
            "shininess": 32.0,
            "light.position": LAMP,
            "light.constant": 1.0,
            "light.linear": 0.35,
            "light.quadratic": 0.44,
            "light.ambient": (0.16, 0.14, 0.11),
            "light.diffuse": (2.6, 2.2, 1.5),
            "light.specular": (2.2, 2.0, 1.5),
        },
        state=State(depth=Depth()),
    )
    sky = (0.003, 0.004, 0.008, 1.0)
    return Pass(
        name=name,
        target=Target(depth="depth24", clear=sky, **target),
        draws=(bulb(), lit),
    )


def color(
    FragPos, Normal, Color, viewPos, specular, shininess,
    light_position, light_constant, light_linear, light_quadratic,
    light_ambient, light_diffuse, light_specular,
):  # fmt: skip
    """The lit colour with an alpha of 1."""
    lit = light_sources.point(
        FragPos, Normal, Color, viewPos, specular, shininess,
        light_position, light_constant, light_linear, light_quadratic,
        light_ambient, light_diffuse, light_specular,
    )  # fmt: skip
    return vec4(lit, 1.0)


def glowing(glow):
    """The bulb's own light."""
    return vec4(glow, 1.0)


POINT = {
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 0.0, 1.0),
    "Color": (1.0, 0.5, 0.31),
    "viewPos": (0.0, 0.0, 3.0),
    "specular": (0.5, 0.5, 0.5),
    "shininess": 32.0,
    "light.position": (1.2, 1.0, 2.0),
    "light.linear": 0.09,
    "light.quadratic": 0.032,
    "light.ambient": (0.2, 0.2, 0.2),
    "light.diffuse": (0.5, 0.5, 0.5),
    "light.specular": (1.0, 1.0, 1.0),
}

case = Case(
    title="Point light",
    section="5.5.2",
    math=r"C = F(d)\,(L_a \odot M_d + n\,L_d \odot M_d + s\,L_s \odot M_s), \qquad "
    r"F(d) = \frac{1}{K_c + K_l\,d + K_q\,d^2}",
    passes=(
        *both_ways(night("scene", plaza(), size=(1024, 1024), colors={"FragColor": "rgba16f"})),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        *both_ways(night("judged", plaza(tiles=6, segments=16))),
    ),
    picture="picture.FragColor",
    expect=[
        formula("gl_Position", clip_position),
        formula("gl_Position", clip_position, draw=0, name="where the bulb is"),
        formula("FragPos", world_position),
        formula("Normal", world_normal),
        formula("Color", handed_on),
        formula("attenuation", light_sources.fading),
        formula("FragColor", color),
        formula("FragColor", glowing, draw=0, name="the bulb"),
        formula("picture.FragColor", finished(texture), name="the picture"),
        any_order("scene.FragColor"),
        any_order("judged.FragColor"),
        value(
            "attenuation",
            at=POINT,
            equals=0.697119,
            digits=6,
            name="left at the point, 2.537716 away",
        ),
        value(
            "FragColor",
            at=POINT,
            equals=(0.414298, 0.207235, 0.128551, 1.0),
            digits=6,
            name="colour at the point",
        ),
        value(
            "FragColor",
            at={**POINT, "light.diffuse": (0.0, 0.0, 0.0), "light.specular": (0.0, 0.0, 0.0)},
            equals=(0.139424, 0.069712, 0.043221, 1.0),
            digits=6,
            name="its ambient part fades as well",
        ),
        sweep(
            "FragColor",
            color,
            over="light.quadratic",
            values=[0.0001 * 10.0 ** (k / 12.0) for k in range(49)],
            at=POINT,
            log_x=True,
            name="colour over the quadratic term",
        ),
        value(
            "FragColor",
            at={**POINT, "viewPos": (2.0, 0.0, 1.215), "shininess": 0.5},
            equals=(0.438901, 0.231838, 0.153153, 1.0),
            digits=6,
            name="nearly 90° from the mirrored ray",
        ),
    ],
)
