"""A material: how a surface answers each part of the light, three colours and a shininess.

One number for the whole object's colour can't tell brass from jade. So each part gets a colour of
its own: ambient and diffuse say what the body looks like, specular what its highlight looks like
(white on lacquer and stone, the metal's own colour on metals), and shininess how wide it is. The
struct keeps the four together, and each of its members is a uniform: `material.diffuse`.

Look at: six balls of the same shape under the same lamp. Lacquer and rubber share a colour and
differ in highlight alone; copper's highlight is copper, jade's is white. What none of them can do
is mirror the room: for that the light has to be more than one lamp.
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
    value,
)
from shaderlab.assets.order import any_order, both_ways
from shaderlab.reference.lighting import lit_material
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

from ..scenes.studio import finished

EYE = (0.0, 1.6, 9.0)
# ambient, diffuse, specular, shininess; linear light.
MATERIALS = {
    "copper": ((0.10, 0.035, 0.018), (0.38, 0.12, 0.055), (1.0, 0.50, 0.32), 24.0),
    "jade": ((0.02, 0.07, 0.045), (0.10, 0.36, 0.21), (0.35, 0.38, 0.36), 18.0),
    "lacquer": ((0.06, 0.004, 0.006), (0.45, 0.020, 0.030), (0.95, 0.95, 0.95), 220.0),
    "rubber": ((0.06, 0.004, 0.006), (0.45, 0.020, 0.030), (0.10, 0.06, 0.06), 5.0),
    "chalk": ((0.14, 0.14, 0.13), (0.70, 0.70, 0.66), (0.0, 0.0, 0.0), 1.0),
    "gold": ((0.12, 0.075, 0.012), (0.46, 0.28, 0.05), (1.0, 0.80, 0.38), 60.0),
}
GROUND = ((0.02, 0.022, 0.028), (0.09, 0.10, 0.125), (0.06, 0.06, 0.06), 12.0)
BALL = assets.sphere(segments=96, rings=48)
CORAL, HALF, WHITE = (1.0, 0.5, 0.31), (0.5, 0.5, 0.5), (1.0, 1.0, 1.0)


def thing(geometry, model, material):
    """One thing of one material under the lamp."""
    ambient, diffuse, specular, shininess = material
    return Draw(
        vertex="ch05_lighting/lit.vert",
        fragment="ch05_lighting/material.frag",
        mesh=Mesh(**geometry).only("aPos", "aNormal"),
        uniforms={
            "model": model,
            "normalMatrix": normal_matrix(model),
            "view": look_at(EYE, (0.0, 0.0, 0.0)),
            "projection": perspective(radians(31.0), 1.0, 0.1, 60.0),
            "viewPos": EYE,
            "material.ambient": ambient,
            "material.diffuse": diffuse,
            "material.specular": specular,
            "material.shininess": shininess,
            "light.position": (-3.5, 5.5, 5.0),
            "light.ambient": (0.7, 0.75, 0.85),
            "light.diffuse": (1.0, 0.97, 0.92),
            "light.specular": (1.0, 0.98, 0.95),
        },
        state=State(depth=Depth()),
    )


def shelf(name, **target):
    """Three balls above three balls, before a wall."""
    wall = translate((0.0, 0.0, -1.1)) @ rotate(radians(90.0), (1.0, 0.0, 0.0))
    draws = [thing(assets.plane(40.0), wall, GROUND)]
    for k, material in enumerate(MATERIALS.values()):
        place = translate((1.6 * (k % 3 - 1), 0.9 - 1.8 * (k // 3), 0.0))
        turned = rotate(radians(25.0), (1.0, 0.0, 1.0)) @ scale((0.74, 0.74, 0.74))
        draws.append(thing(BALL, place @ turned, material))
    return Pass(name=name, target=Target(depth="depth24", **target), draws=draws)


POINT = {
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 0.0, 1.0),
    "viewPos": (0.0, 0.0, 3.0),
    "material.ambient": CORAL,
    "material.diffuse": CORAL,
    "material.specular": HALF,
    "material.shininess": 32.0,
    "light.position": (1.2, 1.0, 2.0),
    "light.ambient": WHITE,
    "light.diffuse": WHITE,
    "light.specular": WHITE,
}

case = Case(
    title="Materials",
    section="5.3",
    math=r"C = L_a \odot M_a + d\, L_d \odot M_d + s\, L_s \odot M_s, \qquad "
    r"s = \max(R \cdot V, 0)^{M_n}",
    passes=(
        *both_ways(shelf("scene", size=(1024, 1024), colors={"FragColor": "rgba16f"})),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        *both_ways(shelf("judged")),
    ),
    picture="picture.FragColor",
    expect=[
        formula("gl_Position", clip_position, draw=0),
        formula("FragPos", world_position, draw=0),
        formula("Normal", world_normal, draw=0),
        *(
            formula("FragColor", lit_material, draw=k, name=name)
            for k, name in enumerate(("wall", *MATERIALS))
        ),
        formula("picture.FragColor", finished(texture), name="the picture"),
        any_order("scene.FragColor"),
        any_order("judged.FragColor"),
        value(
            "FragColor",
            at=POINT,
            equals=(1.788356, 0.894301, 0.554560, 1.0),
            digits=6,
            name="colour at the point",
            note="past 1: a white ambient light is as strong as the lamp",
        ),
        value(
            "FragColor",
            at={**POINT, "viewPos": (2.0, 0.0, 1.215), "material.shininess": 0.5},
            equals=(1.823648, 0.929593, 0.589852, 1.0),
            digits=6,
            name="nearly 90° from the mirrored ray",
        ),
    ],
)
