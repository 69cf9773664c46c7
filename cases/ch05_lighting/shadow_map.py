"""Shadow mapping: what the light does not see is in shadow.

The scene is drawn from the light first, and only the depths are kept: the shadow map. Then it is
drawn from the camera. For each fragment, the same light-space matrix gives its place in that map,
(x, y, z)/w from −1…1 to 0…1, and the fragment is in shadow if something nearer to the light is
stored there. A small bias keeps surfaces from shadowing themselves. Whatever lies outside the map
was never drawn, so it must count as lit: a border of 1 around the map, and no shadow past its far
plane. Ambient light comes from everywhere; a shadow does not take it away.

Look at: the courtyard, its box that hangs in the air and throws a shadow on nothing it touches, and
below it the shadow map itself among the passes. The sun stands on the right. Shadows are as light
as the ambient term makes them, never black.

Try: in `ch05_lighting/shadow_map.frag` write `vec4((1.0 - shadow) * (ambient +` for `vec4((ambient
+ (1.0 - shadow) *`: shadows become black: the ambient light is shadowed, too.
"""

import numpy as np

from shaderlab import Case, Erratum, Output, formula, measure, reading
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.shadows import shadow_coordinates
from shaderlab.reference.transforms import look_at, orthographic

from ..scenes import shadow_stage as courtyard
from ..scenes.cameras import camera
from ..scenes.courtyard_light import courtyard_references
from ..scenes.figures import figure, figures, results
from ..scenes.shadow_stage import BOXES, EYE, LIGHT_VIEW, MODEL, SHADOW, SUN, WHITE, reads
from ..scenes.shadow_truth import against_rays, told_wrongly

LIGHT_PROJECTION = orthographic(-10.0, 10.0, -10.0, 10.0, 1.0, 7.5)
LIGHT_SPACE = LIGHT_PROJECTION @ LIGHT_VIEW
AS_PRINTED = LIGHT_PROJECTION @ look_at(SUN, (0.0, 0.0, 0.0), up=(1.0, 1.0, 1.0))
CAMERA = camera(EYE, (-0.42, 0.45, 0.0), 34.5, far=60.0)
# A wider look, past the edges of the map.
FROM_ABOVE = camera((0.0, 46.0, 0.1), (0.0, 0.0, 0.0), 58.0, far=90.0)
BIAS = {"leastBias": 0.004, "mostBias": 0.02}
STEADY = {"leastBias": 0.02, "mostBias": 0.0}
REPEATED = {"wrap": ("repeat", "repeat")}
GREY = (0.5, 0.5, 0.5)


def scene(name, camera=CAMERA, wrap=WHITE, uniforms=BIAS, **target):
    """The courtyard with the shadow map."""
    shadow_map, view = Output("shadow.depth", **wrap), tuple(camera.values())
    return courtyard.lit(name, shadow_map, LIGHT_SPACE, MODEL, view, uniforms, **target)


def in_light(matrix):
    """Where the point (1, 0, 2) is in the map: (u, v, depth)."""
    return shadow_coordinates(matrix @ (1.0, 0.0, 2.0, 1.0))


def dark_outside(shadow, place):
    """The share of dark places among those that the map does not cover."""
    seen = place @ LIGHT_SPACE[:3, :3].T + LIGHT_SPACE[:3, 3]
    return np.mean(shadow[..., 0][(np.abs(seen) > 1.001).any(axis=-1)])


def outside(name):
    """What of two passes tells it: they look from the same place."""
    return reads("wide", "place", shadow=f"{name}.shadow")


LAWS = courtyard_references(texture)
IN_SHADOW = {
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (-2.0, 4.0, -1.0),
    "Color": GREY,
    "FragPosLightSpace": LIGHT_SPACE @ MODEL @ (-0.9, 0.0, 0.4, 1.0),
}
PLACE = IN_SHADOW["FragPosLightSpace"]
AT = {
    "the place by w, which need not be 1": ({"FragPosLightSpace": 20.0 * PLACE}, 1.0),
    "just past the far plane": ({"FragPosLightSpace": (*PLACE[:2], 1.0002, 1.0)}, 0.0),
}

TURNED = (0.544450, 0.592841, 0.685453)
KEPT = "grey in shadow keeps its ambient light"

case = Case(
    title="Shadow mapping",
    section="5.9.1",
    math=r"s = \begin{cases} 1 & z - b > z_{\text{map}}(x, y) \\ 0 & \text{else} \end{cases}, "
    r"\qquad c = \left(a + (1 - s)(d + h)\right) c_0",
    passes=(
        courtyard.cast("shadow", LIGHT_SPACE, MODEL, size=1024),
        *courtyard.photographed(scene("").draws, clear=(0.30, 0.40, 0.52, 0.0)),
        scene("judged", size=(96, 96)),
        scene("wide", FROM_ABOVE, uniforms={**BIAS, "radius": 2}, size=(96, 96)),
        scene("repeated", FROM_ABOVE, REPEATED, STEADY, size=(96, 96), colors=SHADOW),
    ),
    picture="picture.FragColor",
    expect=[
        *courtyard.map_checks("shadow"),
        *(
            formula(f"{name}.{output}", law)
            for name in ("judged", "wide")
            for output, law in LAWS.items()
        ),
        formula("repeated.shadow", LAWS["shadow"]),
        *courtyard.single_points("judged"),
        *courtyard.surface_checks(EYE, BOXES, "judged"),
        courtyard.same_surfaces("repeated", "wide"),
        *courtyard.picture_checks(EYE, BOXES),
        courtyard.map_of_rays_check(
            light_space=LIGHT_SPACE,
            reads=reads("judged", "shadow", "place", "upright"),
            given={"size": 1024, "biases": tuple(BIAS.values())},
        ),
        measure(
            "shadows told wrongly",
            against_rays(told_wrongly, SUN, BOXES),
            reads=reads("judged", "shadow", "place", "upright"),
            at_most=0.003,  # places within a texel of an edge, or within the bias
            note="a map of 1024², seen from near",
        ),
        measure(
            "dark outside the map",
            dark_outside,
            readings=[
                reading("a border of 1", reads=outside("wide"), equals=0.0, digits=6),
                reading("GL_REPEAT", reads=outside("repeated"), at_least=0.0005),
                # That is four pixels of 96 × 96: any is an error of the wrap mode.
            ],
        ),
        *results(
            {
                "(1, 0, 2) in the map": (in_light(LIGHT_SPACE), (0.567082, 0.578072, 0.685453)),
                "(1, 0, 2) in the map, with up = (1, 1, 1)": (in_light(AS_PRINTED), TURNED),
            }
        ),
        *results({"multiplied by the grey twice": (0.15 * GREY[0] * GREY[0], 0.0375)}, digits=4),
        figure("judged.FragColor", KEPT, IN_SHADOW, (0.075, 0.075, 0.075, 1.0)),
        *figures("judged.shadow", AT, at=IN_SHADOW),
    ],
    errata=[
        Erratum(
            says="ambient = 0.15 · color, and the sum of all parts times color once more",
            truth="the colour belongs to the light once: a grey of 0.5 in shadow is 0.075, not "
            "0.0375",
            proof=KEPT,
        ),
        Erratum(
            says="the shadow map wraps with GL_REPEAT",
            truth="what it does not cover would get the shadows of its other side; "
            "GL_CLAMP_TO_BORDER with a border of 1 leaves it lit",
            proof="dark outside the map",
        ),
        Erratum(
            says="the light's view has up = (1, 1, 1)",
            truth="any up that is not along the light works, but the map is turned; with +y the "
            "point (1, 0, 2) is at (0.567, 0.578)",
            proof="(1, 0, 2) in the map",
        ),
    ],
)
