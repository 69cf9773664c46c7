"""A point light: a bulb in the middle of the scene. Its light has a direction, and it fades.

Every point sees the lamp in another direction, so it is computed for each fragment: lightPos −
FragPos. All three parts of the light fade on the way, by 1 / (Kc + Kl·d + Kq·d²): a far wall gets
less diffuse light, but also less ambient light.

Look at: the plaza of the directional light at night, with one bulb in its midst. All balls show
their lit sides to the bulb, each another side. The tiles around it are bright and the corners
nearly dark; even the ambient light ends there, because it fades as well.

Try: in `ch05_lighting/point_light.frag` write `CalcPointLight(light, surface) / factor` for
`CalcPointLight(light, surface)`: the light no longer fades, and the corners are as bright as the
middle.
"""

from shaderlab import Case, formula, sweep
from shaderlab.reference import light_sources
from shaderlab.reference.lighting import mirrored_lobe
from shaderlab.reference.transforms import clip_position

from ..scenes import lit, plaza
from ..scenes.figures import figure, figures
from ..scenes.laws import gated_or_not, opaque

LAMP = (1.1, 1.25, 0.95)
BULB = {
    "light.position": LAMP,
    "light.constant": 1.0,
    "light.linear": 0.35,
    "light.quadratic": 0.44,
    "light.ambient": (0.16, 0.14, 0.11),
    "light.diffuse": (2.6, 2.2, 1.5),
    "light.specular": (2.2, 2.0, 1.5),
}
COLOR = opaque(light_sources.point)
POINT = {
    **lit.CORAL_POINT,
    "shininess": 32.0,
    "light.position": lit.POINT_LAMP,
    "light.linear": 0.09,
    "light.quadratic": 0.032,
    **lit.POINT_LIGHT,
}
NO_RAYS = {"light.diffuse": (0.0, 0.0, 0.0), "light.specular": (0.0, 0.0, 0.0)}

case = Case(
    title="Point light",
    section="5.5.2",
    math=r"C = F(d)\,(L_a \odot M_d + n\,L_d \odot M_d + s\,L_s \odot M_s), \qquad "
    r"F(d) = \frac{1}{K_c + K_l\,d + K_q\,d^2}",
    passes=(
        lit.glow((1.0, 0.95, 0.80)),
        *plaza.photographed(
            "ch05_lighting/point_light.frag",
            BULB,
            clear=(0.003, 0.004, 0.008, 1.0),
            bulbs=[lit.bulb(LAMP, (1.0, 0.95, 0.80), 0.11, plaza.CAMERA)],
        ),
    ),
    picture="picture.FragColor",
    expect=[
        *lit.vertex_stage_checks("gl_Position"),
        formula("gl_Position", clip_position, draw=0, name="where the bulb is"),
        *lit.vertex_stage_checks("FragPos", "Normal", "Color"),
        formula("factor", light_sources.fading),
        formula("FragColor", gated_or_not(COLOR, highlight=mirrored_lobe)),
        formula("FragColor", lit.glowing, draw=0, name="the bulb"),
        lit.glow_check(),
        *lit.picture_checks(),
        figure("factor", "left at the point, 2.537716 away", POINT, 0.697119),
        figure("factor", "left there with Kc = 2", {**POINT, "light.constant": 2.0}, 0.410766),
        *figures(
            "FragColor",
            {
                "colour at the point": ({}, (0.414298, 0.207235, 0.128551, 1.0)),
                "its ambient part fades as well": (NO_RAYS, (0.139424, 0.069712, 0.043221, 1.0)),
                lit.TURNED_AWAY: (
                    {**lit.GRAZING, "light.position": lit.BELOW, "shininess": 8.0},
                    (0.178253, 0.089127, 0.055258, 1.0),
                ),
            },
            at=POINT,
            reference=COLOR,
        ),
        sweep(
            "FragColor",
            COLOR,
            over="light.quadratic",
            values=[0.0001 * 10.0 ** (k / 12.0) for k in range(49)],
            at=POINT,
            log_x=True,
            name="colour over the quadratic term",
        ),
        figure(
            "FragColor",
            "nearly 90° from the mirrored ray",
            {**POINT, "viewPos": lit.ASIDE, "shininess": 0.5},
            (0.438901, 0.231838, 0.153153, 1.0),
        ),
    ],
)
