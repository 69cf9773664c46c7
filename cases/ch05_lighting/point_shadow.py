"""Shadows of a lamp: a shadow map on all six faces of a cube.

A lamp throws shadows in every direction, and no single picture from it shows them all. Six do: the
views from the lamp along ±x, ±y and ±z, each 90° wide, fill the faces of a cube map. A fragment
needs no matrix to find its texel, only its direction from the lamp. What is stored is the distance
itself, in parts of the far plane: a window depth would be another one on each face. The bias is a
part of the distance as well, since texels grow with it.

Look at: the courtyard at night with a lamp in its middle. The shadows run away from it on all
sides, and nothing shows where one face of the cube ends and the next begins.
"""

from dataclasses import replace
from math import radians

import numpy as np

from shaderlab import (
    Case,
    CubeTexture,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    any_order,
    assets,
    both_ways,
    formula,
    fullscreen,
    measure,
    reading,
    value,
)
from shaderlab.glslmath import dot, length, max, normalize, swizzle, vec3, vec4
from shaderlab.reference.shadows import shadow, slope_bias
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    perspective,
    rotate,
    translate,
    world_normal,
    world_position,
)
from shaderlab.sampling import texture

from ..scenes.courtyard import boxes, courtyard
from ..scenes.courtyard_light import light_position, seen_place, unit_normal
from ..scenes.shadow_stage import PICTURED
from ..scenes.shadow_truth import blocked, hidden_share, wrongly_bright, wrongly_dark
from ..scenes.studio import finished, handed_on

LAMP, FAR = (0.12, 0.85, 0.1), 25.0
MODEL = rotate(radians(6.0), (0.0, 1.0, 0.0))
BOXES = [MODEL @ box for box in boxes()]
EYE = (-3.0, 4.1, 4.0)
VIEW = look_at(EYE, (0.1, 0.1, 0.2))
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


def face(name, size):
    """One face of the cube: distances from the lamp."""
    towards, up = FACES[name]
    view = look_at(LAMP, tuple(np.add(LAMP, towards)), up=up)
    draw = Draw(
        vertex="ch05_lighting/point_shadow_depth.vert",
        fragment="ch05_lighting/point_shadow_depth.frag",
        mesh=Mesh(**courtyard()).only("aPos"),
        uniforms={
            "model": MODEL,
            "lightSpaceMatrix": perspective(radians(90.0), 1.0, 0.02, 60.0) @ view,
            "lightPos": LAMP,
            "farPlane": FAR,
        },
        state=State(depth=Depth()),
    )
    return Pass(
        name=f"{name}-{size}", target=Target(size=(size, size), depth="depth32f"), draws=(draw,)
    )


def courtyard_by(size, bias):
    """The courtyard in the lamp's light."""
    return Draw(
        vertex="ch05_lighting/lit_painted.vert",
        fragment="ch05_lighting/point_shadow.frag",
        mesh=Mesh(**courtyard()),
        uniforms={
            "model": MODEL,
            # Half as long as they were: the fragment shader is to make them whole again.
            "normalMatrix": 0.5 * normal_matrix(MODEL),
            "view": VIEW,
            "projection": perspective(radians(44.0), 1.0, 0.1, 40.0),
            "lightPos": LAMP,
            "farPlane": FAR,
            **bias,
        },
        textures={
            "shadowMap": CubeTexture(
                faces=[Output(f"{name}-{size}", "depth") for name in FACES], format="depth32f"
            )
        },
        state=State(depth=Depth()),
    )


def bulb():
    """The lamp itself, a bright ball."""
    return Draw(
        vertex="ch05_lighting/lamp.vert",
        fragment="ch05_lighting/lamp.frag",
        mesh=Mesh(**assets.sphere(0.06)).only("aPos"),
        uniforms={
            "model": translate(LAMP),
            "view": VIEW,
            "projection": perspective(radians(44.0), 1.0, 0.1, 40.0),
            "glow": (1.0, 0.9, 0.7),
        },
        state=State(depth=Depth()),
    )


def lit(name, side, bias, *more, **target):
    """A pass from the camera."""
    target = Target(depth="depth24", **target)
    return Pass(name=name, target=target, draws=(courtyard_by(side, bias), *more))


def stored(FragPos, lightPos, farPlane):
    """The distance from the lamp, in parts of the far plane."""
    return length(FragPos - lightPos) / farPlane


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
    sky, lamp = vec3(0.035, 0.04, 0.055), vec3(1.0, 0.84, 0.62)
    return vec4(Color * (sky + (1.0 - told) * lambert * lamp), 1.0)


def glowing(glow):
    """The lamp's own light."""
    return vec4(glow, 1.0)


def counted(statistic):
    """A statistic of the places that face the lamp, by rays that end in it."""

    def share(FragColor, shadow, place, upright):
        ray = np.asarray(LAMP) - place
        there = (FragColor[..., 3] > 0.0) & ((upright * ray).sum(axis=-1) > 0.0)
        return statistic(shadow[..., 0], blocked(place, ray, BOXES, reach=1.0), there)

    return share


def table(label, statistic, bounds):
    """One statistic with and without a bias."""
    outputs = ("FragColor", "shadow", "place", "upright")
    return measure(
        label,
        counted(statistic),
        readings=[
            reading(name, reads={output: f"{where}.{output}" for output in outputs}, between=bound)
            for (name, where), bound in zip(SEEN.items(), bounds, strict=True)
        ],
    )


SEEN = {"faces of 256²": "small", "faces of 512²": "judged", "256², no bias": "bare"}

case = Case(
    title="Shadows of a lamp",
    section="5.9.2",
    math=r"s = \left[\lVert p - l \rVert (1 - b) > z_{\text{cube}}(p - l)\right]",
    passes=(
        *(face(name, 256) for name in FACES),
        *(one for name in FACES for one in both_ways(face(name, 512))),
        *both_ways(
            lit(
                "scene",
                512,
                BIAS,
                bulb(),
                size=(1024, 1024),
                colors=PICTURED,
                clear=(0.003, 0.004, 0.007, 0.0),
            )
        ),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        Pass(name="bulb", target=Target(), draws=(replace(bulb(), state=State()),)),
        lit("judged", 512, BIAS, size=(96, 96)),
        lit("small", 256, BIAS, size=(96, 96)),
        lit("bare", 256, {"leastBias": 0.0, "mostBias": 0.0}, size=(96, 96)),
    ),
    picture="picture.FragColor",
    expect=[
        *(formula(f"{name}-256.depth", stored, name=f"distances on {name}") for name in FACES),
        *(any_order(f"{name}-512.depth") for name in FACES),
        formula("+x-256.gl_Position", light_position),
        formula("+x-256.FragPos", world_position),
        formula("judged.gl_Position", clip_position),
        formula("judged.FragPos", world_position),
        formula("judged.Normal", world_normal),
        formula("judged.Color", handed_on),
        formula("judged.place", seen_place),
        formula("judged.upright", unit_normal),
        formula("judged.shadow", dark),
        formula("small.shadow", dark),
        formula("judged.FragColor", color),
        any_order("scene.FragColor"),
        formula("picture.FragColor", finished(texture), name="the picture"),
        formula("bulb.gl_Position", clip_position, name="where the lamp is"),
        formula("bulb.FragColor", glowing, name="colour of the lamp"),
        value(
            "judged.shadow",
            at={"FragPos": (0.12, 0.85, 40.0), "Normal": (0, 0, -1), "Color": (1, 1, 1)},
            equals=0.0,
            digits=6,
            name="past the far plane nothing is dark",
        ),
        measure(
            "places hidden from the eye",
            hidden_share(EYE, BOXES, step=1),
            readings=[
                reading(name, reads={key: f"{name}.{key}" for key in ("FragColor", "place")})
                for name in ("judged", "small", "bare")
            ],
            at_most=0.002,
        ),
        measure(
            "places hidden from the eye, in the large picture",
            hidden_share(EYE, BOXES, step=8),
            reads={key: f"scene.{key}" for key in ("FragColor", "place")},
            at_most=0.004,
        ),
        table("wrongly dark", wrongly_dark, [(0.0025, 0.0045), (0.0005, 0.0015), (0.48, 0.53)]),
        table("wrongly bright", wrongly_bright, [(0.002, 0.0045), (0.002, 0.0045), (0.001, 0.003)]),
        value(
            "judged.FragColor",
            at={"FragPos": (0.12, 0.0, 0.1), "Normal": (0.0, 1.0, 0.0), "Color": (0.5, 0.5, 0.5)},
            equals=(1.323741, 1.117242, 0.837369, 1.0),
            digits=6,
            name="grey below the lamp",
        ),
    ],
)
