"""Shadows of a lamp: a shadow map on all six faces of a cube.

A lamp throws shadows in every direction, and no single picture from it shows them all. Six do: the
views from the lamp along ±x, ±y and ±z, each 90° wide, fill the faces of a cube map. A fragment
needs no matrix to find its texel, only its direction from the lamp. The map stores the distance
itself, as a fraction of the far plane, because each face has a window depth of its own. The bias is
a fraction of the distance as well, since texels grow with it.

Look at: the courtyard at night with a lamp in its middle. The shadows run away from it on all
sides, and nothing shows where one face of the cube ends and the next begins.

Try: in `ch05_lighting/point_shadow.frag` write `float bias = 0.0 *` for `float bias = current *`:
stripes cover everything that the lamp lights.
"""

from dataclasses import replace

import numpy as np

from shaderlab import (
    Case,
    CubeTexture,
    Output,
    State,
    any_order,
    both_ways,
    formula,
    measure,
    reading,
)
from shaderlab.glslmath import dot, length, max, normalize, swizzle, vec3, vec4
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.shadows import shadow, slope_bias
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    perspective,
    world_position,
)

from ..scenes import lit, shadow_stage
from ..scenes.cameras import camera
from ..scenes.courtyard import courtyard
from ..scenes.courtyard_light import light_position, seen_place, unit_normal
from ..scenes.draws import tested
from ..scenes.figures import figure
from ..scenes.panels import picture
from ..scenes.shadow_stage import BOXES, MODEL, SHADOW, reads
from ..scenes.shadow_truth import against_rays, nearest_distances, wrongly_bright, wrongly_dark

LAMP, FAR = (0.12, 0.85, 0.1), 25.0
EYE = (1.0, 4.0, 4.4)
CAMERA = camera(EYE, (-0.1, 0.2, 0.15), 40.0, far=40.0)
# +X −X +Y −Y +Z −Z, and what is upwards on each face.
FACES = {
    "+x": ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0)),
    "-x": ((-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)),
    "+y": ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "-y": ((0.0, -1.0, 0.0), (0.0, 0.0, -1.0)),
    "+z": ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0)),
    "-z": ((0.0, 0.0, -1.0), (0.0, -1.0, 0.0)),
}
BIAS = {"leastBias": 0.002, "mostBias": 0.035}
NO_BIAS = dict.fromkeys(BIAS, 0.0)
BULB = lit.bulb(LAMP, (1.0, 0.9, 0.7), 0.06, CAMERA)


def face(name, size):
    """One face of the cube: distances from the lamp."""
    towards, up = FACES[name]
    view = look_at(LAMP, tuple(np.add(LAMP, towards)), up=up)
    draw = tested(
        "ch05_lighting/point_shadow_depth",
        courtyard(),
        {
            "model": MODEL,
            "lightSpaceMatrix": perspective(np.radians(90.0), 1.0, 0.02, 60.0) @ view,
            "lightPos": LAMP,
            "farPlane": FAR,
        },
        only=("aPos",),
    )
    return picture([draw], (size, size), f"{name}-{size}", depth="depth32f")


def by_lamp(name, side, bias, *more, size=None, **target):
    """The courtyard in the lamp's light, from the camera."""
    distances = [Output(f"{face}-{side}.depth") for face in FACES]
    draw = tested(
        (lit.PAINTED, "ch05_lighting/point_shadow.frag"),
        courtyard(),
        {
            "model": MODEL,
            # Half as long as they were: the fragment shader is to make them whole again.
            "normalMatrix": 0.5 * normal_matrix(MODEL),
            **CAMERA,
            "lightPos": LAMP,
            "farPlane": FAR,
            **bias,
        },
        textures={"shadowMap": CubeTexture(faces=distances, format="depth32f")},
    )
    return picture([draw, *more], size, name, depth="depth24", **target)


def stored(FragPos, lightPos, farPlane):
    """The distance from the lamp, in parts of the far plane."""
    return length(FragPos - lightPos) / farPlane


def beyond(FragPos, lightPos, farPlane):
    """What the depth test keeps out: nothing lies behind the far plane."""
    return length(FragPos - lightPos) >= farPlane


def dark(FragPos, Normal, lightPos, farPlane, shadowMap, leastBias, mostBias):
    """What the cube says of a fragment."""
    ray = FragPos - lightPos
    current = length(ray) / farPlane
    bias = current * slope_bias(Normal, -ray, leastBias, mostBias)
    return shadow(current, swizzle(texture(shadowMap, ray), "x"), bias)


def color(FragPos, Normal, Color, lightPos, farPlane, shadowMap, leastBias, mostBias):
    """A little blue light from everywhere, and the lamp's."""
    ray = FragPos - lightPos
    told = dark(FragPos, Normal, lightPos, farPlane, shadowMap, leastBias, mostBias)
    lambert = max(dot(normalize(Normal), normalize(-ray)), 0.0) * 4.5 / (1.0 + dot(ray, ray))
    sky, lamp = vec3(0.07, 0.08, 0.11), vec3(1.0, 0.84, 0.62)
    return vec4(Color * (sky + (1.0 - told) * lambert * lamp), 1.0)


SEEN = {"faces of 256²": "small", "faces of 512²": "judged", "256², no bias": "bare"}


def told_otherwise(shadow, place, upright, size, biases):
    """The share of places that face the lamp of which the cube tells something else than one that
    is made by rays, of the same texels with the same bias."""
    ray = place - LAMP
    current = np.linalg.norm(ray, axis=-1)
    cosine = -(upright * ray).sum(axis=-1) / current
    bias = current * np.maximum(biases[1] * (1.0 - cosine), biases[0])
    nearest = nearest_distances(ray, LAMP, int(size), BOXES)
    dark = (current <= FAR) & (current - bias > nearest)
    return np.mean((dark != (shadow[..., 0] > 0.5))[cosine > 0.0])


def surfaces(of):
    """What a pass says of the surfaces that all of them show."""
    return reads("judged", "place", "upright", shadow=f"{of}.shadow")


def by_rays(name, of, size, bias):
    """The cube of a pass against one of rays."""
    given = {"size": size, "biases": tuple(bias.values())}
    return reading(name, reads=surfaces(of), given=given)


def table(label, statistic, **none):
    """A statistic of the places that face the lamp, by rays that end in it, for each map. Without a
    bias it is bounded by `none`; what the others must be follows from `by_rays`."""
    bounds = {"bare": none}
    readings = [reading(n, reads=surfaces(of), **bounds.get(of, {})) for n, of in SEEN.items()]
    against = against_rays(statistic, LAMP, BOXES, lamp=True)
    return measure(label, against, readings=readings, own_types=True)


PAST = {"FragPos": (0.12, 0.85, 40.0), "Normal": (0, 0, -1), "Color": (1, 1, 1)}
# In the shadow of a box, and turned straight to the lamp: the slope has no part in the bias.
UPRIGHT = {**PAST, "FragPos": (1.2, 0, 1.2), "Normal": (-1.08, 0.85, -1.1), "mostBias": 100.0}
BELOW = {"FragPos": (0.12, 0.0, 0.1), "Normal": (0.0, 1.0, 0.0), "Color": (0.5, 0.5, 0.5)}
NIGHT = (0.003, 0.004, 0.007, 0.0)

case = Case(
    title="Shadows of a lamp",
    section="5.9.2",
    math=r"s = \left[\lVert p - l \rVert (1 - b) > z_{\text{cube}}(p - l)\right]",
    passes=(
        *(one for name in FACES for one in both_ways(face(name, 256))),
        *(face(name, 512) for name in FACES),
        *shadow_stage.photographed(by_lamp("", 512, BIAS, BULB).draws, clear=NIGHT),
        picture([replace(BULB, state=State())], None, "bulb"),
        lit.glow((1.0, 0.9, 0.7)),
        by_lamp("judged", 512, BIAS, size=(96, 96)),
        by_lamp("small", 256, BIAS, size=(96, 96), colors=SHADOW),
        by_lamp("bare", 256, NO_BIAS, size=(96, 96), colors=SHADOW),
    ),
    picture="picture.FragColor",
    expect=[
        *(
            formula(f"{name}-256.depth", stored, discards=beyond, name=f"distances on {name}")
            for name in FACES
        ),
        # Nothing casts a shadow there, so no other check would miss what these two faces hold.
        *(formula(f"{name}-512.depth", stored, discards=beyond) for name in ("+y", "-y")),
        *(any_order(f"{name}-256.depth") for name in FACES),
        formula("+x-256.gl_Position", light_position),
        formula("+x-256.FragPos", world_position),
        *lit.vertex_stage_checks("gl_Position", "FragPos", "Normal", "Color", pass_name="judged"),
        formula("judged.place", seen_place),
        formula("judged.upright", unit_normal),
        *(formula(f"{name}.shadow", dark) for name in SEEN.values()),
        formula("judged.FragColor", color),
        formula("bulb.gl_Position", clip_position, name="where the lamp is"),
        formula("bulb.FragColor", lit.glowing, name="colour of the lamp"),
        lit.glow_check(),
        figure("judged.shadow", "past the far plane nothing is dark", PAST, 0.0),
        figure("judged.shadow", "in upright light the least bias counts", UPRIGHT, 1.0),
        *shadow_stage.surface_checks(EYE, BOXES, "judged", ("small", "bare")),
        *shadow_stage.picture_checks(EYE, BOXES, hidden=0.004),
        measure(
            "told otherwise than by a cube of rays",
            told_otherwise,
            readings=[
                by_rays("faces of 256²", "small", 256, BIAS),
                by_rays("faces of 512²", "judged", 512, BIAS),
                by_rays("256², no bias", "bare", 256, NO_BIAS),
            ],
            # As in shadow-acne: only places next to an edge or to equality may differ.
            at_most=0.001,
        ),
        # Without a bias, half of the places that face the lamp: see shadow-acne.
        table("wrongly dark", wrongly_dark, between=(0.47, 0.53)),
        table("wrongly bright", wrongly_bright, at_most=0.05),
        figure(
            "judged.FragColor", "grey below the lamp", BELOW, (1.341241, 1.137242, 0.864869, 1.0)
        ),
    ],
)
