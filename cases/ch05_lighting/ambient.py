"""Ambient light: a little of the lamp's colour everywhere, for what no ray reaches directly.

In a real room light goes from wall to wall and finds its way behind things. The cheapest stand-in
is a constant: a tenth of the lamp's colour times the object's, (0.1, 0.05, 0.031) for coral under
white. It knows nothing of the surface's direction, so it can't show a shape.

Look at: the same ring, box and ball at the strengths 0.1, 0.4 and 1, from below. They become
brighter, and stay paper cut-outs all the same: only outlines tell the ball from a disc, and where a
thing stands before another of the same colour they melt into one. Shape begins with the diffuse
part.
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
from shaderlab.glslmath import vec4
from shaderlab.reference.lighting import ambient_color
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    perspective,
    rotate,
    translate,
)
from shaderlab.sampling import texture

from ..scenes.studio import finished

CORAL, TEAL, STONE = (1.0, 0.5, 0.31), (0.16, 0.55, 0.6), (0.55, 0.57, 0.62)
UPRIGHT = translate((-0.55, 0.66, -0.5)) @ rotate(radians(76.0), (1.0, 0.0, 0.25))
# A hair above the floor, so that nowhere both are equally near.
TURNED = translate((0.75, 0.451, -0.1)) @ rotate(radians(33.0), (0.0, 1.0, 0.0))

THINGS = [
    (assets.plane(60.0), translate((0.0, 0.0, 0.0)), STONE),
    (assets.torus(0.72, 0.24), UPRIGHT, CORAL),
    (assets.cube(0.9), TURNED, TEAL),
    (assets.sphere(0.42), translate((-0.35, 0.42, 0.55)), CORAL),
]


def thing(geometry, model, color, strength, row):
    """One thing in one row, in ambient light alone."""
    return Draw(
        vertex="ch05_lighting/lit.vert",
        fragment="ch05_lighting/ambient.frag",
        mesh=Mesh(**geometry).only("aPos", "aNormal"),
        uniforms={
            "model": model,
            "normalMatrix": normal_matrix(model),
            "view": look_at((0.0, 1.9, 5.2), (0.0, 0.62, 0.0)),
            "projection": perspective(radians(25.0), 3.0, 0.1, 20.0),
            "objectColor": color,
            "lightColor": (1.0, 1.0, 1.0),
            "ambientStrength": strength,
        },
        state=State(depth=Depth(), cell=Cell(column=0, row=row, columns=1, rows=3)),
    )


def rows(name, **target):
    """The still life at three strengths, one above the other."""
    draws = [
        thing(geometry, model, color, strength, row)
        for row, strength in enumerate((0.1, 0.4, 1.0))
        for geometry, model, color in THINGS
    ]
    return Pass(
        name=name, target=Target(depth="depth24", clear=(0.0, 0.0, 0.0, 1.0), **target), draws=draws
    )


def color(lightColor, objectColor, ambientStrength):
    """The ambient part with an alpha of 1."""
    return vec4(ambient_color(lightColor, objectColor, ambientStrength), 1.0)


case = Case(
    title="Ambient light",
    section="5.2.1",
    math=r"C = k_a \, L \odot O",
    passes=(
        *both_ways(rows("scene", size=(1024, 1024), colors={"FragColor": "rgba16f"})),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        *both_ways(rows("judged")),
    ),
    picture="picture.FragColor",
    expect=[
        formula("gl_Position", clip_position),
        formula("FragColor", color, draw=1, name="ring at 0.1"),
        formula("FragColor", color, draw=6, name="box at 0.4"),
        formula("FragColor", color, draw=8, name="floor at 1"),
        formula("FragColor", color, name="ball at 1"),
        formula("picture.FragColor", finished(texture), name="the picture"),
        any_order("scene.FragColor"),
        any_order("judged.FragColor"),
        value(
            "FragColor",
            at={
                "objectColor": CORAL,
                "lightColor": (1.0, 1.0, 1.0),
                "ambientStrength": 0.1,
            },
            equals=(0.1, 0.05, 0.031, 1.0),
            digits=6,
            reference=color,
            name="coral under white at 0.1",
        ),
        value(
            "FragColor",
            at={
                "objectColor": CORAL,
                "lightColor": (0.25, 0.5, 1.0),
                "ambientStrength": 0.1,
            },
            equals=(0.025, 0.025, 0.031, 1.0),
            digits=6,
            reference=color,
            name="coral under a blue lamp at 0.1",
        ),
    ],
)
