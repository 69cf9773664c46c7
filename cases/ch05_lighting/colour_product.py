"""Colour is a product: what you see is the light times what the surface reflects.

A coral red ball reflects all of the red, half of the green and a third of the blue light that falls
on it. Under a white lamp that is its colour. Under a green one there is no red and no blue to
reflect, and what remains is a dark green: light · object, channel by channel.

Look at: each row is a room with a lamp of another colour, on the same white wall with the same four
balls. The white wall shows the lamp's own colour. Read a column downward: the coral ball is green
in the green room and a dull violet in the blue one, and the sky blue one is darkest where little
but red is left. Nothing about the balls has changed.

Try: in `ch05_lighting/colour_product.frag` write `min(lightColor, objectColor)` for `lightColor *
objectColor`: where a lamp has all or nothing of a channel the colours stay, and elsewhere they do
not.
"""

from shaderlab import Case, Mesh, assets
from shaderlab.glslmath import dot, normalize, vec3, vec4
from shaderlab.reference.lighting import reflected_color
from shaderlab.reference.transforms import scale, translate

from ..scenes import lit
from ..scenes.cameras import camera
from ..scenes.figures import each_draw, figure, figures
from ..scenes.laws import opaque

WHITE, GREEN = lit.WHITE, (0.0, 1.0, 0.0)
LAMPS = (WHITE, (1.0, 0.06, 0.03), (0.03, 0.9, 0.08), (0.04, 0.09, 1.0))
CORAL, LEMON, LEAF, SKY = lit.CORAL, (0.95, 0.8, 0.1), (0.15, 0.55, 0.2), (0.1, 0.45, 0.9)

CAMERA = camera((0.0, 0.0, 30.0), (0.0, 0.0, 0.0), 7.7, near=20.0, far=40.0)
BALL = Mesh(**assets.sphere(0.4, segments=64, rings=32))
WALL = Mesh(**assets.quad())


def thing(mesh, model, lamp, color):
    """One thing in one room's light."""
    uniforms = {"lightColor": lamp, "objectColor": color}
    return lit.thing("ch05_lighting/colour_product.frag", mesh, model, CAMERA, uniforms)


def room(row, lamp):
    """A white wall and four balls under one lamp."""
    y = 1.5 - row
    wall = translate((0.0, y, -0.45)) @ scale((4.4, 0.97, 1.0))
    yield thing(WALL, wall, lamp, (0.7, 0.7, 0.7))
    for column, color in enumerate((CORAL, LEMON, LEAF, SKY)):
        yield thing(BALL, translate((column - 1.5, y, 0.0)), lamp, color)


NAMES = [
    f"{what} in {light} light"
    for light in ("white", "red", "green", "blue")
    for what in ("white", "coral", "lemon", "green", "sky blue")
]
PRODUCT = opaque(reflected_color)


def rounded(Normal, lightColor, objectColor):
    """The picture's colour: it fades where a ball turns away from the upper left."""
    facing = 0.5 + 0.5 * dot(normalize(Normal), vec3(-0.36, 0.48, 0.80))
    color = reflected_color(lightColor, objectColor)
    return vec4(color * (0.08 + 0.92 * facing * facing), 1.0)


case = Case(
    title="Colour of light times colour of object",
    section="5.1",
    math=r"C = L \odot O = (L_r O_r,\ L_g O_g,\ L_b O_b)",
    passes=lit.photographed(
        [draw for row, lamp in enumerate(LAMPS) for draw in room(row, lamp)],
        output="shaded",
        name="rooms",
    ),
    picture="picture.FragColor",
    expect=[
        *lit.vertex_stage_checks(),
        figure(
            "Normal",
            "a normal by the matrix given",
            {"aNormal": (1.0, 2.0, 3.0), "normalMatrix": [[1, 2, 2], [0, 1, 2], [2, 0, 1]]},
            (11.0, 8.0, 5.0),
        ),
        *each_draw("FragColor", PRODUCT, {k: f"product, {name}" for k, name in enumerate(NAMES)}),
        *each_draw("shaded", rounded, {k: f"rounded, {NAMES[k]}" for k in (1, 13)}),
        *lit.picture_checks("shaded", judged="rooms"),
        *figures(
            "FragColor",
            {
                "coral in white light": ({}, (1.0, 0.5, 0.31, 1)),
                "coral in green light": ({"lightColor": GREEN}, (0.0, 0.5, 0.0, 1)),
            },
            at={"Normal": (0.0, 0.0, 1.0), "lightColor": WHITE, "objectColor": CORAL},
            reference=PRODUCT,
        ),
    ],
)
