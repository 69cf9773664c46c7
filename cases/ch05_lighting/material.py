"""A material: how a surface answers each part of the light, three colours and a shininess.

One number for the whole object's colour can't tell brass from jade. So each part gets a colour of
its own: ambient and diffuse say what the body looks like, specular what its highlight looks like
(white on lacquer and stone, the metal's own colour on metals), and shininess how wide it is. The
struct keeps the four together, and each of its members is a uniform: `material.diffuse`.

Look at: six balls of the same shape under the same lamp. Lacquer and rubber share a colour and
differ in highlight alone; copper's highlight is copper, jade's is white. None of them can reflect
the room: for that, the light has to be more than one lamp.

Try: in `ch05_lighting/material.frag` write `spec * material.diffuse` for `spec *
material.specular`: all highlights take the colour of the body, as on metal.
"""

from shaderlab import Case, Mesh, assets
from shaderlab.reference.lighting import lit_material
from shaderlab.reference.transforms import scale, translate

from ..scenes import lit
from ..scenes.cameras import camera, turned
from ..scenes.figures import each_draw, figures
from ..scenes.lit import CORAL, HALF, WHITE

EYE = (0.0, 1.6, 9.0)
CAMERA = camera(EYE, (0.0, 0.0, 0.0), 31.0, far=60.0)
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
BALL = Mesh(**assets.sphere(segments=96, rings=48))
WALL = translate((0.0, 0.0, -1.1)) @ turned(90.0, (1.0, 0.0, 0.0))
TURNED = turned(25.0, (1.0, 0.0, 1.0)) @ scale((0.74, 0.74, 0.74))


def thing(geometry, model, material):
    """One thing of one material under the lamp."""
    ambient, diffuse, specular, shininess = material
    uniforms = {
        "viewPos": EYE,
        "material.ambient": ambient,
        "material.diffuse": diffuse,
        "material.specular": specular,
        "material.shininess": shininess,
        "light.position": (-3.5, 5.5, 5.0),
        "light.ambient": (0.7, 0.75, 0.85),
        "light.diffuse": (1.0, 0.97, 0.92),
        "light.specular": (1.0, 0.98, 0.95),
    }
    return lit.thing("ch05_lighting/material.frag", geometry, model, CAMERA, uniforms)


def place(k):
    """Three balls above three balls."""
    return translate((1.6 * (k % 3 - 1), 0.9 - 1.8 * (k // 3), 0.0)) @ TURNED


POINT = {
    **lit.POINT,
    "material.ambient": CORAL,
    "material.diffuse": CORAL,
    "material.specular": HALF,
    "material.shininess": 32.0,
    "light.position": lit.POINT_LAMP,
    **dict.fromkeys(("light.ambient", "light.diffuse", "light.specular"), WHITE),
}

case = Case(
    title="Materials",
    section="5.3",
    math=r"C = L_a \odot M_a + d\, L_d \odot M_d + s\, L_s \odot M_s, \qquad "
    r"s = \max(R \cdot V, 0)^{M_n}",
    passes=lit.photographed(
        [
            thing(assets.plane(40.0), WALL, GROUND),
            *(thing(BALL, place(k), material) for k, material in enumerate(MATERIALS.values())),
        ]
    ),
    picture="picture.FragColor",
    expect=[
        *lit.vertex_stage_checks(draw=0),
        *each_draw("FragColor", lit_material, enumerate(("wall", *MATERIALS))),
        *lit.picture_checks(),
        *figures(
            "FragColor",
            {
                "colour at the point": (
                    {},
                    (1.788356, 0.894301, 0.554560, 1.0),
                    "past 1: a white ambient light is as strong as the lamp",
                ),
                "nearly 90° from the mirrored ray": (
                    {"viewPos": lit.ASIDE, "material.shininess": 0.5},
                    (1.823648, 0.929593, 0.589852, 1.0),
                ),
                lit.TURNED_AWAY: (
                    {**lit.GRAZING, "light.position": lit.BELOW, "material.shininess": 8.0},
                    (*CORAL, 1.0),
                ),
            },
            at=POINT,
        ),
    ],
)
