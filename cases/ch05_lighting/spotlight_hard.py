"""A spotlight with a hard edge: a lamp in a tube. Inside the cone it shines, outside it does not.

A fragment is inside if the ray that reaches it is less than the cut-off angle away from the spot's
axis. Comparing angles takes an arccosine. Comparing their cosines takes none, but reverses the
comparison: the larger cosine is the smaller angle, so inside means θ > cutOff. Outside, the ambient
part remains; without it, there would be a hole in the picture.

Look at: the sharp ellipse that the cone cuts out of the ground, and its edge on the balls. Within a
single pixel full light becomes none: that is why lamps got a second, outer cone.

Try: in `ch05_lighting/spotlight_hard.frag` write `theta < light.cutOff` for `theta > light.cutOff`:
the cone is dark, and everything else is lit.
"""

from math import cos, radians

from shaderlab import Case, formula
from shaderlab.reference import light_sources
from shaderlab.reference.spotlight import spot_cosine

from ..scenes import lit, plaza
from ..scenes.figures import figure, figures
from ..scenes.laws import opaque

SPOT = {
    "light.position": (-3.2, 5.4, 3.4),
    "light.direction": (3.0, -5.0, -3.1),
    "light.cutOff": cos(radians(18.0)),
    "light.ambient": (0.05, 0.07, 0.13),
    "light.diffuse": (1.1, 1.02, 0.85),
    "light.specular": (1.1, 1.0, 0.85),
}
# The test point's lamp; its direction turns it towards the point or away.
POINT = {
    **lit.CORAL_POINT,
    "shininess": 32.0,
    "light.position": lit.POINT_LAMP,
    "light.cutOff": cos(radians(12.5)),
    **lit.POINT_LIGHT,
}
AT_IT = {"light.direction": (-1.2, -1.0, -2.0)}
PAST_IT = {"light.direction": (0.0, 0.0, -1.0)}

case = Case(
    title="Spotlight with a hard edge",
    section="5.5.3",
    math=r"\cos\theta = L \cdot (-D), \qquad C = \begin{cases} A + d\,L_d \odot M_d + "
    r"s\,L_s \odot M_s & \cos\theta > \cos\varphi \\ A & \text{otherwise} \end{cases}, \quad "
    r"A = L_a \odot M_d",
    passes=plaza.photographed(
        "ch05_lighting/spotlight_hard.frag", SPOT, clear=(0.004, 0.006, 0.012, 1.0)
    ),
    picture="picture.FragColor",
    expect=[
        *lit.vertex_stage_checks("gl_Position", "FragPos", "Normal", "Color"),
        formula("theta", spot_cosine),
        formula("FragColor", opaque(light_sources.hard_spot)),
        *lit.picture_checks(),
        *figures(
            "FragColor",
            {
                "the point inside the cone": (AT_IT, (0.594301, 0.297273, 0.184402, 1.0)),
                "the point outside: ambient only": (PAST_IT, (0.2, 0.1, 0.062, 1.0)),
                lit.TURNED_AWAY: (
                    {
                        **lit.GRAZING,
                        "light.position": lit.BELOW,
                        "light.direction": lit.TOWARDS_BELOW,
                        "shininess": 8.0,
                    },
                    (0.2, 0.1, 0.062, 1.0),
                ),
            },
            at=POINT,
        ),
        figure("theta", "its cosine, 38° off the axis", {**POINT, **PAST_IT}, 0.788110),
        figure(
            "FragColor",
            "nearly 90° from the mirrored ray",
            {**POINT, **AT_IT, "viewPos": lit.ASIDE, "shininess": 0.5},
            (0.629593, 0.332565, 0.219695, 1.0),
        ),
    ],
)
