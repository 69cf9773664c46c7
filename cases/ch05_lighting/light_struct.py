"""A light with a colour for each part: how much it is everywhere, how much it is a lamp.

With white for all three, the ambient part alone is as bright as the lamp, and everything is washed
out. The notes' struct gives the light's own share of each part, and 0.2, 0.5 and 1 are a sensible
start: (1.788356, 0.894301, 0.554560) at the point becomes (0.594301, 0.297273, 0.184402). The lamp
has a position, and a colour only through these three.

Look at: the same vase of one material in four lights. Upper left all three parts are white: flat
and overexposed. Upper right is the notes' 0.2, 0.5, 1. Lower left is a candle, whose shadows are
deep and warm; lower right a bright blue sky with a weak lamp. The material has not changed.
"""

from math import radians

from shaderlab import (
    Case,
    Cell,
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

from ..scenes.pottery import vase
from ..scenes.studio import finished

EYE = (0.0, 2.1, 6.0)
CORAL, HALF, WHITE = (1.0, 0.5, 0.31), (0.5, 0.5, 0.5), (1.0, 1.0, 1.0)

# From the lower left to the upper right: place, ambient, diffuse, specular.
LIGHTS = [
    ((-1.6, 1.3, 1.2), (0.02, 0.012, 0.008), (1.0, 0.52, 0.2), (1.0, 0.6, 0.3)),
    ((2.5, 4.0, 2.0), (0.18, 0.30, 0.55), (0.18, 0.17, 0.15), (0.35, 0.4, 0.5)),
    ((-2.0, 3.2, 3.0), WHITE, WHITE, WHITE),
    ((-2.0, 3.2, 3.0), (0.2, 0.2, 0.2), (0.5, 0.5, 0.5), WHITE),
]


def thing(geometry, model, color, cell):
    """One thing in one of the lights."""
    position, ambient, diffuse, specular = LIGHTS[cell]
    return Draw(
        vertex="ch05_lighting/lit.vert",
        fragment="ch05_lighting/material.frag",
        mesh=Mesh(**geometry).only("aPos", "aNormal"),
        uniforms={
            "model": model,
            "normalMatrix": normal_matrix(model),
            "view": look_at(EYE, (0.0, 0.85, 0.0)),
            "projection": perspective(radians(27.0), 1.0, 0.1, 60.0),
            "viewPos": EYE,
            "material.ambient": tuple(0.95 * channel for channel in color),
            "material.diffuse": color,
            "material.specular": HALF,
            "material.shininess": 32.0,
            "light.position": position,
            "light.ambient": ambient,
            "light.diffuse": diffuse,
            "light.specular": specular,
        },
        state=State(depth=Depth(), cell=Cell(column=cell % 2, row=cell // 2, columns=2, rows=2)),
    )


def quarters(name, **target):
    """A vase on a floor before a wall, four times."""
    upright = translate((0.0, 0.0, -1.6)) @ rotate(radians(90.0), (1.0, 0.0, 0.0))
    slender = rotate(radians(20.0), (0.0, 1.0, 0.0)) @ scale((0.92, 1.0, 0.92))
    draws = []
    for cell in range(4):
        draws.append(thing(assets.plane(30.0), upright, (0.42, 0.44, 0.46), cell))
        draws.append(thing(assets.plane(30.0), translate((0.0, 0.0, 0.0)), (0.5, 0.46, 0.4), cell))
        draws.append(thing(vase(), slender, CORAL, cell))
    return Pass(name=name, target=Target(depth="depth24", **target), draws=draws)


POINT = {
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 0.0, 1.0),
    "viewPos": (0.0, 0.0, 3.0),
    "material.ambient": CORAL,
    "material.diffuse": CORAL,
    "material.specular": HALF,
    "light.position": (1.2, 1.0, 2.0),
}

case = Case(
    title="Light properties",
    section="5.3.3",
    math=r"C = L_a \odot M_a + d\, L_d \odot M_d + s\, L_s \odot M_s",
    passes=(
        *both_ways(quarters("scene", size=(1024, 1024), colors={"FragColor": "rgba16f"})),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        *both_ways(quarters("judged")),
    ),
    picture="picture.FragColor",
    expect=[
        formula("gl_Position", clip_position),
        formula("FragPos", world_position),
        formula("Normal", world_normal),
        formula("FragColor", lit_material, draw=2, name="vase by candlelight"),
        formula("FragColor", lit_material, draw=5, name="vase under the sky"),
        formula("FragColor", lit_material, draw=8, name="vase, all white"),
        formula("FragColor", lit_material, draw=9, name="wall in the notes' light"),
        formula("FragColor", lit_material, draw=10, name="floor in the notes' light"),
        formula("FragColor", lit_material, name="vase in the notes' light"),
        formula("picture.FragColor", finished(texture), name="the picture"),
        any_order("scene.FragColor"),
        any_order("judged.FragColor"),
        value(
            "FragColor",
            at=POINT,
            equals=(0.594301, 0.297273, 0.184402, 1.0),
            digits=6,
            name="0.2, 0.5, 1 at the point",
        ),
        value(
            "FragColor",
            at={**POINT, "light.ambient": WHITE, "light.diffuse": WHITE},
            equals=(1.788356, 0.894301, 0.554560, 1.0),
            digits=6,
            name="all white at the point",
        ),
        value(
            "FragColor",
            at={**POINT, "viewPos": (2.0, 0.0, 1.215), "material.shininess": 0.5},
            equals=(0.629593, 0.332565, 0.219695, 1.0),
            digits=6,
            name="nearly 90° from the mirrored ray",
        ),
    ],
)
