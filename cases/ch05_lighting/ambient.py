"""Ambient light: a little of the lamp's colour everywhere, for what no ray reaches directly.

In a real room light bounces from wall to wall and reaches behind things. The cheapest stand-in is
a constant: a tenth of the lamp's colour times the object's, (0.1, 0.05, 0.031) for coral under
white. It ignores the surface's direction, so it can't show a shape.

Look at: the same ring, box and ball at the strengths 0.1, 0.4 and 1, from below. They become
brighter, and stay paper cut-outs all the same: only outlines tell the ball from a disc, and where a
thing stands before another of the same colour they melt into one. Shape begins with the diffuse
part.

Try: in `ch05_lighting/ambient.frag` write `ambient + objectColor` for `ambient * objectColor`:
light that is added makes colours paler, where a dim lamp should make them darker.
"""

from shaderlab import Case, assets, formula
from shaderlab.reference.lighting import ambient_color
from shaderlab.reference.transforms import translate

from ..scenes import lit
from ..scenes.cameras import camera, turned
from ..scenes.figures import each_draw, figures
from ..scenes.laws import opaque
from ..scenes.panels import cell

CORAL, TEAL, STONE, WHITE = lit.CORAL, (0.16, 0.55, 0.6), (0.55, 0.57, 0.62), lit.WHITE
CAMERA = camera((0.0, 2.1, 5.2), (0.0, 0.75, 0.0), 20.5, 3.0, near=2.0, far=200.0)
UPRIGHT = translate((-0.55, 0.66, -0.5)) @ turned(76.0, (1.0, 0.0, 0.25))
# A hair above the floor, so that nowhere both are equally near.
TURNED = translate((0.75, 0.451, -0.1)) @ turned(33.0)

THINGS = [
    (assets.plane(300.0), translate((0.0, 0.0, 0.0)), STONE),
    (assets.torus(0.72, 0.24), UPRIGHT, CORAL),
    (assets.cube(0.9), TURNED, TEAL),
    (assets.sphere(0.42), translate((-0.35, 0.42, 0.55)), CORAL),
]

# The still life at three strengths, one above the other.
ROWS = [
    lit.thing(
        "ch05_lighting/ambient.frag",
        geometry,
        model,
        CAMERA,
        {"objectColor": color, "lightColor": WHITE, "ambientStrength": strength},
        cell=cell(row, 1, 3),
    )
    for row, strength in enumerate((0.1, 0.4, 1.0))
    for geometry, model, color in THINGS
]
COLOR = opaque(ambient_color)

case = Case(
    title="Ambient light",
    section="5.2.1",
    math=r"C = k_a \, L \odot O",
    passes=lit.photographed(ROWS, clear=(0.0, 0.0, 0.0, 1.0)),
    picture="picture.FragColor",
    rows=("strength 1", "0.4", "0.1"),
    expect=[
        *lit.vertex_stage_checks(draw=1),
        *each_draw("FragColor", COLOR, {1: "ring at 0.1", 6: "box at 0.4", 8: "floor at 1"}),
        formula("FragColor", COLOR, name="ball at 1"),
        *lit.picture_checks(),
        *figures(
            "FragColor",
            {
                "coral under white at 0.1": ({}, (0.1, 0.05, 0.031, 1.0)),
                "coral under a blue lamp at 0.1": (
                    {"lightColor": (0.25, 0.5, 1.0)},
                    (0.025, 0.025, 0.031, 1.0),
                ),
            },
            at={"objectColor": CORAL, "lightColor": WHITE, "ambientStrength": 0.1},
            reference=COLOR,
        ),
    ],
)
