"""Environment maps: a mirror and a glass, whose colour is that of the sky where the ray goes.

The ray from the camera is mirrored at the normal, or bent by Snell's law, and a cube map tells the
colour in that direction. Only the direction counts, not the place: the surroundings are taken to be
far away. Glass of index 1.52 bends by the ratio 1/1.52 = 0.658 and mirrors besides, 4 % where one
looks straight at it and all at a grazing angle; after Schlick, with the fifth power.

Look at: a ring of metal on the left, a ball of glass in the middle, a vase of metal on the right.
In the ball the hills stand on their heads, as in any lens; its rim is a mirror. Beyond an angle of
41° no ray leaves the glass any more: `refract` then gives (0, 0, 0).
"""

from functools import partial
from math import radians, tan

import numpy as np

from shaderlab import (
    Case,
    CubeTexture,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    Ramp,
    State,
    Target,
    assets,
    exact,
    formula,
    fullscreen,
    value,
)
from shaderlab.glslmath import mix
from shaderlab.reference.cube_maps import bent, fresnel, mirrored
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    perspective,
    rotate,
    scale,
    translate,
    world_normal,
    world_position,
)
from shaderlab.sampling import textureLod

from ..scenes.pottery import vase
from ..scenes.sky import sky_face

EYE, AIM = (0.0, 0.35, 6.4), (0.0, 0.0, 0.0)
VIEW = look_at(EYE, AIM)
FOVY, ASPECT = radians(30.0), 2.0
PROJECTION = perspective(FOVY, ASPECT, 0.1, 100.0)
GLASS, METAL = 0.04, 0.85
SMOOTH = ("linear", "linear")

MORNING = CubeTexture(faces=[partial(sky_face, k) for k in range(6)], filter=SMOOTH)
NOISE = CubeTexture(faces=list(np.random.default_rng(74).random((6, 8, 8, 4))), filter=SMOOTH)

THINGS = [
    (
        assets.torus(0.78, 0.30, 128, 64),
        translate((-2.15, 0.0, 0.0)) @ rotate(radians(62.0), (1.0, 0.35, 0.1)),
        METAL,
    ),
    (assets.sphere(1.08, 128, 64), translate((0.0, 0.02, 0.0)), GLASS),
    (vase(), translate((2.1, -1.15, 0.0)) @ scale((1.0, 1.0, 1.0)), METAL),
]


def thing(geometry, model, base, sky):
    """One thing under this sky."""
    return Draw(
        vertex="ch07_maps/placed.vert",
        fragment="ch07_maps/environment_map.frag",
        mesh=Mesh(**geometry).only("aPos", "aNormal"),
        uniforms={
            "model": model, "normalMatrix": normal_matrix(model), "view": VIEW,
            "projection": PROJECTION, "cameraPos": EYE, "ratio": 1.0 / 1.52, "base": base,
        },
        textures={"sky": sky},
        state=State(depth=Depth()),
    )  # fmt: skip


def behind():
    """The sky itself, seen along each pixel's ray."""
    turn = VIEW[:3, :3].T
    right, above = tan(FOVY / 2.0) * ASPECT * turn[:, 0], tan(FOVY / 2.0) * turn[:, 1]
    return Draw(
        fragment="ch13_skybox/skybox.frag",
        domain={
            "TexCoords": Ramp(
                tuple(-turn[:, 2] - right - above), tuple(2.0 * right), tuple(2.0 * above)
            )
        },
        textures={"skybox": MORNING},
    )


def seen(FragPos, Normal, cameraPos, ratio, base, sky):
    """What is mirrored and what shines through, each by its share."""
    through = textureLod(sky, bent(FragPos, Normal, cameraPos, ratio), 0.0)
    back = textureLod(sky, mirrored(FragPos, Normal, cameraPos), 0.0)
    return mix(through, back, fresnel(FragPos, Normal, cameraPos, base))


STRAIGHT = {"FragPos": (0.0, 0.0, 0.0), "Normal": (0.0, 2.0, 0.0)}


def ray(output, reference, camera, equals, name, **changes):
    """One ray that meets a level surface in the origin."""
    return value(
        f"judged.{output}",
        at={**STRAIGHT, "cameraPos": camera, **changes},
        equals=equals,
        digits=6,
        reference=reference,
        name=name,
    )


NAMES = ("the ring", "the ball", "the vase")

case = Case(
    title="Environment mapping",
    section="7.4",
    math=r"\mathbf r = \mathbf i - 2(\mathbf n \cdot \mathbf i)\,\mathbf n, \qquad "
    r"\mathbf t = \eta\,\mathbf i - \left(\eta\,\mathbf n \cdot \mathbf i + \sqrt{1 - \eta^2"
    r"\left(1 - (\mathbf n \cdot \mathbf i)^2\right)}\right)\mathbf n",
    passes=(
        Pass(
            name="scene",
            target=Target(size=(1536, 768), depth="depth24", colors={"FragColor": "rgba8"}),
            draws=(behind(), *(thing(*one, MORNING) for one in THINGS)),
        ),
        *fullscreen(
            "ch03_transforms/soften.frag",
            name="picture",
            textures={"scene": Output("scene.FragColor")},
            target=Target(size=(768, 384)),
        ),
        Pass(
            name="judged",
            target=Target(size=(112, 56), depth="depth24"),
            draws=tuple(thing(*one, NOISE) for one in THINGS),
        ),
        Pass(
            name="reversed",
            target=Target(size=(112, 56), depth="depth24"),
            draws=tuple(thing(*one, NOISE) for one in reversed(THINGS)),
        ),
    ),
    picture="picture.FragColor",
    expect=[
        *(
            formula("judged.mirrored", mirrored, draw=k, name=f"mirrored in {name}")
            for k, name in enumerate(NAMES)
        ),
        *(
            formula("judged.bent", bent, draw=k, name=f"bent by {name}")
            for k, name in enumerate(NAMES)
        ),
        *(
            formula("judged.share", fresnel, draw=k, name=f"the share that {name} mirrors")
            for k, name in enumerate(NAMES)
        ),
        *(
            formula("judged.FragColor", seen, draw=k, name=f"the colour of {name}")
            for k, name in enumerate(NAMES)
        ),
        formula("judged.gl_Position", clip_position),
        formula("judged.FragPos", world_position),
        *(
            formula("judged.Normal", world_normal, draw=k, name=f"normals of {name}")
            for k, name in enumerate(NAMES)
        ),
        exact("judged.FragColor", Output("reversed.FragColor"), name="the order of drawing"),
        exact("reversed.FragColor", Output("judged.FragColor"), name="the other order"),
        exact("judged.depth", Output("reversed.depth"), name="depths in either order"),
        exact("reversed.depth", Output("judged.depth"), name="depths in the other order"),
        ray("mirrored", mirrored, (3.0, 4.0, 0.0), (-0.6, 0.8, 0.0), "mirrored from (3, 4, 0)"),
        ray("bent", bent, (3.0, 4.0, 0.0), (-0.394737, -0.918794, 0.0), "into glass"),
        ray("bent", bent, (0.0, 2.0, 0.0), (0.0, -1.0, 0.0), "straight in, nothing is bent"),
        ray(
            "bent",
            bent,
            (4.0, 3.0, 0.0),
            (0.0, 0.0, 0.0),
            "out of glass at 53°: nothing leaves",
            ratio=1.52,
        ),
        ray("share", fresnel, (0.0, 2.0, 0.0), 0.04, "straight at glass", base=GLASS),
        ray(
            "share", fresnel, (1.0, 0.0, 0.0), 1.0, "along the surface all is mirrored", base=GLASS
        ),
    ],
)
