"""Colour is a product: what one sees is the light times what the surface throws back.

A coral red ball throws back all of the red, half of the green and a third of the blue light that
falls on it. Under a white lamp that is its colour. Under a green one there is no red and no blue
to throw back, and what is left is a dark green: light · object, channel by channel.

Look at: each row is a room with a lamp of another colour, on the same white wall with the same
four balls. The white wall shows the lamp's own colour. Read a column downward: the coral ball is
green in the green room and nearly black in the blue one, and the sky blue one turns black where
only red is left. Nothing about the balls has changed.
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
from shaderlab.glslmath import dot, normalize, vec3, vec4
from shaderlab.reference.lighting import reflected_color
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    perspective,
    scale,
    translate,
    world_normal,
    world_position,
)
from shaderlab.sampling import texture

from ..scenes.studio import finished

WHITE, GREEN = (1.0, 1.0, 1.0), (0.0, 1.0, 0.0)
ROOMS = (WHITE, (1.0, 0.06, 0.03), (0.03, 0.9, 0.08), (0.04, 0.09, 1.0))
CORAL, LEMON, LEAF, SKY = (1.0, 0.5, 0.31), (0.95, 0.8, 0.1), (0.15, 0.55, 0.2), (0.1, 0.45, 0.9)

BALL = Mesh(**assets.sphere(0.4, segments=64, rings=32)).only("aPos", "aNormal")
WALL = Mesh(**assets.quad()).only("aPos", "aNormal")


def thing(mesh, place, size, lamp, color):
    """One thing in one room's light."""
    model = translate(place) @ scale(size)
    return Draw(
        vertex="ch05_lighting/lit.vert",
        fragment="ch05_lighting/colour_product.frag",
        mesh=mesh,
        uniforms={
            "model": model,
            "normalMatrix": normal_matrix(model),
            "view": look_at((0.0, 0.0, 30.0), (0.0, 0.0, 0.0)),
            "projection": perspective(radians(7.7), 1.0, 20.0, 40.0),
            "lightColor": lamp,
            "objectColor": color,
        },
        state=State(depth=Depth()),
    )


def room(row, lamp):
    """A white wall and four balls under one lamp."""
    y = 1.5 - row
    yield thing(WALL, (0.0, y, -0.45), (4.4, 0.97, 1.0), lamp, (0.7, 0.7, 0.7))
    for column, color in enumerate((CORAL, LEMON, LEAF, SKY)):
        yield thing(BALL, (column - 1.5, y, 0.0), (1.0, 1.0, 1.0), lamp, color)


def rooms(name, **target):
    """All four rooms, one above the other."""
    draws = [draw for row, lamp in enumerate(ROOMS) for draw in room(row, lamp)]
    return Pass(name=name, target=Target(depth="depth24", **target), draws=draws)


def product(lightColor, objectColor):
    """The colour with an alpha of 1."""
    return vec4(reflected_color(lightColor, objectColor), 1.0)


def rounded(Normal, lightColor, objectColor):
    """The picture's colour: it fades where a ball turns away from the upper left."""
    facing = 0.5 + 0.5 * dot(normalize(Normal), vec3(-0.36, 0.48, 0.80))
    color = reflected_color(lightColor, objectColor)
    return vec4(color * (0.08 + 0.92 * facing * facing), 1.0)


case = Case(
    title="Colour of light times colour of object",
    section="5.1",
    math=r"C = L \odot O = (L_r O_r,\ L_g O_g,\ L_b O_b)",
    passes=(
        *both_ways(rooms("scene", size=(1024, 1024), colors={"shaded": "rgba16f"})),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "shaded")},
        ),
        *both_ways(rooms("rooms")),
    ),
    picture="picture.FragColor",
    expect=[
        formula("gl_Position", clip_position),
        formula("FragPos", world_position),
        formula("Normal", world_normal),
        value(
            "Normal",
            at={"aNormal": (1.0, 2.0, 3.0), "normalMatrix": [[1, 2, 2], [0, 1, 2], [2, 0, 1]]},
            equals=(11.0, 8.0, 5.0),
            digits=6,
            name="a normal by the matrix given",
        ),
        formula("FragColor", product, draw=1, name="coral in white light"),
        formula("FragColor", product, draw=14, name="sky blue in green light"),
        formula("shaded", rounded, draw=1, name="rounded, coral in white light"),
        formula("shaded", rounded, draw=13, name="rounded, green in green light"),
        formula("picture.FragColor", finished(texture), name="the picture"),
        any_order("scene.shaded"),
        any_order("rooms.shaded"),
        value(
            "FragColor",
            at={"Normal": (0.0, 0.0, 1.0), "lightColor": WHITE, "objectColor": CORAL},
            equals=(1.0, 0.5, 0.31, 1.0),
            digits=6,
            reference=product,
            name="coral in white light, by the notes",
        ),
        value(
            "FragColor",
            at={"Normal": (0.0, 0.0, 1.0), "lightColor": GREEN, "objectColor": CORAL},
            equals=(0.0, 0.5, 0.0, 1.0),
            digits=6,
            reference=product,
            name="coral in green light, by the notes",
        ),
    ],
)
