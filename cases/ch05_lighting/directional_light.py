"""Directional light: a lamp so far away that its rays are parallel, like the sun.

It needs a direction but no position: every point sees it at the same angle, and nothing fades. The
direction is the way the light travels, (−0.2, −1, −0.3) in the notes; the formulas want the way
back to the light, so it is reversed and normalised: (0.188144, 0.940721, 0.282216). Forgetting the
minus lights the world from below.

Look at: nine balls on a plaza in a low sun, and how alike they are. The line between light and
shade lies at the same place on each of them, and the tiles are equally bright from corner to
corner. (There are no shadows on the ground yet: each point is lit as if it were alone.)

Try: in `ch05_lighting/directional_light.frag` write `CalcDirLight(DirLight(-light.direction,
light.ambient, light.diffuse, light.specular), surface), 1.0` for `CalcDirLight(light, surface),
1.0`: the world is lit from below.
"""

from shaderlab import Case, formula
from shaderlab.reference import light_sources

from ..scenes import lit, plaza
from ..scenes.figures import figure, figures
from ..scenes.laws import opaque

EVENING = {
    "light.direction": (0.9, -0.62, -0.38),
    "light.ambient": (0.10, 0.13, 0.20),
    "light.diffuse": (1.25, 0.95, 0.62),
    "light.specular": (1.2, 1.0, 0.75),
}
POINT = {
    **lit.CORAL_POINT,
    "light.direction": (-0.2, -1.0, -0.3),
    **lit.POINT_LIGHT,
    "shininess": 4.0,
}
ASIDE = {"viewPos": lit.ASIDE, "light.direction": (-1.2, -1.0, -2.0), "shininess": 0.5}

case = Case(
    title="Directional light",
    section="5.5.1",
    math=r"L = -\frac{D}{\lVert D \rVert}, \qquad "
    r"C = (L_a + d\,L_d) \odot M_d + s\,L_s \odot M_s",
    passes=plaza.photographed(
        "ch05_lighting/directional_light.frag", EVENING, clear=(0.30, 0.38, 0.50, 1.0)
    ),
    picture="picture.FragColor",
    expect=[
        *lit.vertex_stage_checks("gl_Position", "FragPos", "Normal", "Color"),
        formula("lightDir", light_sources.direction_to_light),
        formula("FragColor", opaque(light_sources.directional)),
        *lit.picture_checks(),
        figure("lightDir", "the direction, turned around", POINT, (0.188144, 0.940721, 0.282216)),
        *figures(
            "FragColor",
            {
                "colour at the point": ({}, (0.344280, 0.173726, 0.108915, 1.0)),
                "nearly 90° from the mirrored ray": (ASIDE, (0.629593, 0.332565, 0.219695, 1.0)),
                lit.TURNED_AWAY: (
                    {**lit.GRAZING, "light.direction": lit.TOWARDS_BELOW, "shininess": 8.0},
                    (0.2, 0.1, 0.062, 1.0),
                ),
            },
            at=POINT,
        ),
    ],
)
