"""A light with a colour for each part: how much of it is everywhere, how much comes from the lamp.

With white for all three, the ambient part alone is as bright as the lamp, and everything is washed
out. The struct gives the light's own share of each part, and 0.2, 0.5 and 1 are a sensible start:
(1.788356, 0.894301, 0.554560) at the point becomes (0.594301, 0.297273, 0.184402). The lamp has a
position, and a colour only through these three.

Look at: the same vase of one material in four lights. Upper left all three parts are white: flat
and overexposed. Upper right is 0.2, 0.5, 1. Lower left is a candle, whose shadows are deep and
warm; lower right a blue evening sky with a weak lamp. The material has not changed.

Try: in `ch05_lighting/material.frag` write `vec3(0.0)` for `light.ambient * material.ambient`: what
no lamp reaches is black in all four pictures.
"""

from shaderlab import Case, assets
from shaderlab.reference.lighting import lit_material
from shaderlab.reference.transforms import scale, translate

from ..scenes import lit
from ..scenes.cameras import camera, turned
from ..scenes.figures import each_draw, figures
from ..scenes.lit import CORAL, HALF, WHITE
from ..scenes.panels import cell
from ..scenes.pottery import vase

EYE = (0.0, 2.1, 6.0)
CAMERA = camera(EYE, (0.0, 0.85, 0.0), 27.0, far=60.0)

# From the lower left to the upper right: place, ambient, diffuse, specular.
LIGHTS = [
    ((-1.6, 1.3, 1.2), (0.02, 0.012, 0.008), (1.0, 0.52, 0.2), (1.0, 0.6, 0.3)),
    ((2.5, 4.0, 2.0), (0.08, 0.17, 0.36), (0.36, 0.33, 0.27), (0.5, 0.5, 0.5)),
    ((-2.0, 3.2, 3.0), WHITE, WHITE, WHITE),
    ((-2.0, 3.2, 3.0), (0.2, 0.2, 0.2), (0.5, 0.5, 0.5), WHITE),
]
# A wall, a floor and the vase: shape, place, colour.
UPRIGHT = translate((0.0, 0.0, -1.6)) @ turned(90.0, (1.0, 0.0, 0.0))
THINGS = [
    (assets.plane(30.0), UPRIGHT, (0.42, 0.44, 0.46)),
    (assets.plane(30.0), translate((0.0, 0.0, 0.0)), (0.5, 0.46, 0.4)),
    (vase(), turned(20.0) @ scale((0.92, 1.0, 0.92)), CORAL),
]


def thing(geometry, model, color, quarter):
    """One thing in one of the lights."""
    position, ambient, diffuse, specular = LIGHTS[quarter]
    uniforms = {
        "viewPos": EYE,
        "material.ambient": tuple(0.95 * channel for channel in color),
        "material.diffuse": color,
        "material.specular": HALF,
        "material.shininess": 32.0,
        "light.position": position,
        "light.ambient": ambient,
        "light.diffuse": diffuse,
        "light.specular": specular,
    }
    shader = "ch05_lighting/material.frag"
    return lit.thing(shader, geometry, model, CAMERA, uniforms, cell=cell(quarter, 2, 2))


POINT = {
    **lit.POINT,
    "material.ambient": CORAL,
    "material.diffuse": CORAL,
    "material.specular": HALF,
    "light.position": lit.POINT_LAMP,
}
ALL_WHITE = {"light.ambient": WHITE, "light.diffuse": WHITE}
NAMES = {
    2: "vase by candlelight",
    5: "vase under the sky",
    8: "vase, all white",
    9: "wall in the light of 0.2, 0.5, 1",
    10: "floor in the light of 0.2, 0.5, 1",
    -1: "vase in the light of 0.2, 0.5, 1",
}

case = Case(
    title="Light properties",
    section="5.3.3",
    math=r"C = L_a \odot M_a + d\, L_d \odot M_d + s\, L_s \odot M_s",
    passes=lit.photographed([thing(*one, quarter) for quarter in range(4) for one in THINGS]),
    picture="picture.FragColor",
    rows=("all white; 0.2, 0.5, 1", "a candle; a blue sky"),
    expect=[
        *lit.vertex_stage_checks(),
        *each_draw("FragColor", lit_material, NAMES),
        *lit.picture_checks(),
        *figures(
            "FragColor",
            {
                "0.2, 0.5, 1 at the point": ({}, (0.594301, 0.297273, 0.184402, 1.0)),
                "all white at the point": (ALL_WHITE, (1.788356, 0.894301, 0.554560, 1.0)),
                "nearly 90° from the mirrored ray": (
                    {"viewPos": lit.ASIDE, "material.shininess": 0.5},
                    (0.629593, 0.332565, 0.219695, 1.0),
                ),
                lit.TURNED_AWAY: (
                    {**lit.GRAZING, "light.position": lit.BELOW, "material.shininess": 8.0},
                    (0.2, 0.1, 0.062, 1.0),
                ),
            },
            at=POINT,
        ),
    ],
)
