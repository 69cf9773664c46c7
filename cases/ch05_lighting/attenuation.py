"""Point light attenuation: the light fades as 1 / (Kc + Kl·d + Kq·d²).

The constant term keeps the factor at 1 next to the lamp. Of the other two the linear one is the
larger nearby, and the quadratic one, which is nature's, from d = Kl/Kq on. Solved for d, the same
law says how far a share of the light reaches: that is the radius of a light volume.

Look at: the picture, a lamp over a floor whose fields are a tenth of the table's d wide. Inside the
amber ring there is more than 5 % of the light, inside the blue ring more than 1 %. The thin white
ring is the table's d itself, and the blue one is larger in every row: "covered" does not mean that
it is dark beyond, some 1.1 to 1.3 % is always left.

Try: in `lib/attenuation.glsl` write `distance` for `(distance * distance)`: far away the light
fades much less, and the rings no longer tell how much is left.
"""

import numpy as np

from shaderlab import Case, Erratum, Ramp, Variant, across, formula, fullscreen, sweep, up
from shaderlab.glslmath import length, mix, vec3, vec4
from shaderlab.reference.attenuation import attenuation, crossover, reach

from ..scenes.drawing import AMBER, BLUE, chessboard, encoded, pixel_size, with_lines
from ..scenes.figures import figure, results
from ..scenes.panels import square

# d, Kl, Kq; the light left at d; where 5 % and 1 % are left; where the quadratic term takes over.
TABLE = [
    (7, 0.7, 1.8, 0.010626993, 3.060300, 7.224303, 0.388889),
    (13, 0.35, 0.44, 0.012514078, 6.185585, 14.607545, 0.795455),
    (20, 0.22, 0.20, 0.011709602, 9.212300, 21.705393, 1.100000),
    (32, 0.14, 0.07, 0.012960083, 15.505410, 36.620283, 2.000000),
    (50, 0.09, 0.032, 0.011695906, 23.001280, 54.233013, 2.812500),
    (65, 0.07, 0.017, 0.012924071, 31.435740, 74.280997, 4.117647),
    (100, 0.045, 0.0075, 0.012422360, 47.421556, 111.930414, 6.000000),
    (160, 0.027, 0.0028, 0.012987013, 77.694997, 183.275326, 9.642857),
    (200, 0.022, 0.0019, 0.012285012, 94.377976, 222.549706, 11.578947),
    (325, 0.014, 0.0007, 0.012580594, 155.054104, 366.202833, 20.000000),
    (600, 0.007, 0.0002, 0.012953368, 291.217104, 686.279973, 35.000000),
    (3250, 0.0014, 0.000007, 0.012580594, 1550.541037, 3662.028328, 200.000000),
]
CONSTANTS = np.linspace(0.5, 4.0, 15)
DISTANCES = np.geomspace(0.001, 2.0, 97)  # as shares of d
UNSET = {"light.constant": 1.0, "light.linear": 0.0, "light.quadratic": 0.0}


# The light left at each row's own d, in per cent.
LEFT = [100.0 * attenuation(d, 1.0, kl, kq) for d, kl, kq, *_ in TABLE]


def floor_in_light(
    FragPos, frag_coord, light_constant, light_linear, light_quadratic, coverage
):  # fmt: skip
    """The picture: the lamp's light on a chessboard, and rings at three distances."""
    light = (light_constant, light_linear, light_quadratic)
    size = pixel_size(FragPos, -1.25 * coverage, frag_coord)
    fields = mix(vec3(0.55), vec3(0.75), chessboard(FragPos * 10.0 / coverage))
    color = encoded(fields * vec3(1.0, 0.87, 0.66) * attenuation(length(FragPos), *light))
    at_5, at_1 = reach(0.05, *light), reach(0.01, *light)
    rings = (
        (lambda distance: distance - at_5, 2.0, AMBER, 1.0),
        (lambda distance: distance - at_1, 2.0, BLUE, 1.0),
        (lambda distance: distance - coverage, 1.0, (1.0, 1.0, 1.0), 0.6),
    )
    return vec4(with_lines(color, FragPos, size, rings, of=length), 1.0)


def row(d, kl, kq, at_d, five, one, takes_over):
    """One row of the table: the light's terms, the distances on show, the row's figures."""
    return Variant(
        f"{d}",
        {
            "light.linear": kl,
            "light.quadratic": kq,
            "coverage": float(d),
            "distance": across(0.0, d),
            "FragPos": square(-1.25 * d, 1.25 * d),
        },
        expect=[
            figure("factor", "left at d", {"distance": d}, at_d, digits=9),
            figure("reach", "5 % is left at", {"fraction": 0.05}, five),
            figure("reach", "1 % is left at", {"fraction": 0.01}, one),
            *results({"the quadratic term takes over at": (crossover(kl, kq), takes_over)}),
            sweep("factor", attenuation, over="distance", values=d * DISTANCES, log_x=True),
        ],
    )


case = Case(
    title="Point light attenuation",
    section="5.5.2",
    math=r"F(d) = \frac{1}{K_c + K_l\,d + K_q\,d^2}, \qquad "
    r"d(F) = \frac{2c}{K_l + \sqrt{K_l^2 + 4 K_q c}}, \quad c = \tfrac1F - K_c",
    passes=(
        *fullscreen(
            "ch05_lighting/attenuation_picture.frag",
            name="picture",
            domain={"FragPos": Ramp((0.0, 0.0))},
            uniforms={**UNSET, "coverage": 0.0},
        ),
        *fullscreen(
            "ch05_lighting/attenuation.frag",
            domain={"distance": across(0.0, 0.0), "fraction": up(0.01, 1.0)},
            uniforms=UNSET,
        ),
    ),
    picture="picture.FragColor",
    expect=[
        formula("factor", attenuation),
        formula("reach", reach),
        formula("picture.FragColor", floor_in_light, name="the picture"),
        *(
            sweep(output, law, over="light.constant", values=CONSTANTS, at=at, name=name)
            for output, law, at, name in (
                ("factor", attenuation, {"distance": 2.0}, "light over the constant term"),
                ("reach", reach, {"fraction": 0.05}, "reach over the constant term"),
            )
        ),
        *results(
            {
                "least light left at d, %": (min(LEFT), 1.06),
                "most light left at d, %": (max(LEFT), 1.30),
            },
            digits=2,
        ),
    ],
    variants=[row(*entries) for entries in TABLE],
    errata=[
        Erratum(
            section="5.5.2",
            says="d is the maximum distance that the light covers",
            truth="at d there is still 1.06 to 1.30 % of the light, depending on the row",
            proof="left at d",
        )
    ],
)
