"""Shininess: the exponent that makes a highlight small, and nothing else.

The cosine between the mirrored ray and the viewer is raised to the power of the shininess s. At the
peak it is 1, and 1 stays 1: the highlight gets narrower, not brighter. Half of it is left where
cosˢ = ½, that is 45° off for s = 2, 11.9° for 32 and 4.2° for 256: each doubling of s makes the
highlight about √2 times narrower.

Look at: the strip, s = 2, 4, 8 … 256 from left to right. Below each ball is its lobe over the
angle, from −50° to 50° off the mirrored ray; amber is what is above one half, so its width is the
half-power angle, twice. A real polished ball would reflect more than a dull one in the middle: the
plain Phong lobe does not know that.
"""

from math import acos, radians, tan

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    across,
    any_order,
    assets,
    both_ways,
    computed,
    formula,
    fullscreen,
    sweep,
    up,
    value,
)
from shaderlab.glslmath import vec3, vec4, where
from shaderlab.reference.blinn_phong import phong
from shaderlab.reference.lighting import half_power_angle, phong_color, specular_factor
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

from ..scenes.studio import finished

SHININESS = (2, 4, 8, 16, 32, 64, 128, 256)
HALF_POWER = (45.0, 32.765100, 23.508050, 16.743653, 11.882461, 8.417365, 5.957353, 4.214387)
EYE = (0.0, 0.0, 9.0)
BALL = Mesh(**assets.sphere(0.98, segments=96, rings=48)).only("aPos", "aNormal")
SMALL_BALL = Mesh(**assets.sphere(0.98, segments=24, rings=12)).only("aPos", "aNormal")
MODEL = translate((0.02, 0.03, -0.1)) @ rotate(radians(30.0), (1.0, 1.0, 0.0))


def ball(mesh, column, shininess):
    """One ball of the strip."""
    return Draw(
        vertex="ch05_lighting/lit.vert",
        fragment="ch05_lighting/specular.frag",
        mesh=mesh,
        uniforms={
            "model": MODEL,
            "normalMatrix": normal_matrix(MODEL),
            "view": look_at(EYE, (0.0, 0.0, 0.0)),
            "projection": perspective(radians(14.5), 1.0, 1.0, 20.0),
            "objectColor": (0.30, 0.62, 0.72),
            "lightColor": (1.0, 0.97, 0.92),
            "lightPos": (-4.0, 5.0, 8.0),
            "viewPos": EYE,
            "ambientStrength": 0.04,
            "diffuseStrength": 0.42,
            "specularStrength": 1.1,
            "shininess": float(shininess),
        },
        state=State(depth=Depth(), cell=Cell(column=column, row=1, columns=8, rows=2)),
    )


def profile(column, shininess):
    """The lobe over the angle, below its ball."""
    return Draw(
        fragment="ch05_lighting/shininess_profile.frag",
        domain={"slope": across(-tan(radians(50.0)), tan(radians(50.0))), "level": up(-0.05, 1.2)},
        uniforms={"shininess": float(shininess)},
        state=State(cell=Cell(column=column, row=0, columns=8, rows=2)),
    )


def strip(name, mesh, size, **target):
    """Eight balls, and their lobes below them."""
    draws = [draw for k, s in enumerate(SHININESS) for draw in (ball(mesh, k, s), profile(k, s))]
    backdrop = (0.012, 0.014, 0.02, 1.0)
    return Pass(
        name=name, target=Target(size=size, depth="depth24", clear=backdrop, **target), draws=draws
    )


def lobe(slope, shininess):
    """Phong's lobe for a light along the normal and a viewer at this slope from it."""
    upward = vec3(0.0, 1.0, 0.0)
    return phong(upward, upward, vec3(slope, 1.0, 0.0), shininess)


def profile_color(slope, level, shininess):
    """Grey below the base line; under the curve amber where it is above one half, else blue."""
    height = lobe(slope, shininess)
    filled = where(height < 0.5, vec3(0.06, 0.13, 0.26), vec3(0.90, 0.42, 0.06))
    over_base = where(level < height, filled, vec3(0.012, 0.014, 0.02))
    return vec4(where(level < 0.0, vec3(0.25), over_base), 1.0)


def half_power(shininess, angle):
    """The angle by the formula, and the shader's lobe there."""
    at = {"slope": tan(radians(angle)), "level": 0.5, "shininess": float(shininess)}
    return [
        computed(
            f"half-power angle of {shininess}, degrees",
            lambda: half_power_angle(shininess),
            equals=angle,
            digits=6,
        ),
        value("lobe", at=at, equals=0.5, digits=6, name=f"the lobe of {shininess} there"),
    ]


case = Case(
    title="Shininess",
    section="5.2.3",
    math=r"s(\alpha) = \cos^n \alpha, \qquad \alpha_{1/2} = \arccos\!\left(2^{-1/n}\right)",
    passes=(
        *both_ways(strip("scene", BALL, (2048, 512), colors={"FragColor": "rgba16f"})),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
            target=Target(size=(1024, 256)),
        ),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="small",
            textures={"scene": Output("scene", "FragColor")},
        ),
        *both_ways(strip("balls", SMALL_BALL, (192, 48))),
        *fullscreen(
            "ch05_lighting/shininess_profile.frag",
            domain={"slope": across(-1.2, 1.2), "level": up(-0.05, 1.2)},
            uniforms={"shininess": 8.0},
        ),
    ),
    picture="picture.FragColor",
    expect=[
        formula("balls.gl_Position", clip_position, draw=14),
        formula("balls.FragPos", world_position, draw=14),
        formula("balls.Normal", world_normal, draw=14),
        formula("balls.spec", specular_factor, draw=0, name="lobe of 2 on its ball"),
        formula("balls.spec", specular_factor, draw=8, name="lobe of 32 on its ball"),
        formula("balls.spec", specular_factor, draw=14, name="lobe of 256 on its ball"),
        formula("balls.FragColor", phong_color, draw=0, name="ball of 2"),
        formula("balls.FragColor", phong_color, draw=8, name="ball of 32"),
        formula("balls.FragColor", phong_color, draw=14, name="ball of 256"),
        formula("lobe", lobe),
        formula("FragColor", profile_color, name="the lobe, filled"),
        formula("small.FragColor", finished(texture), name="the picture, small"),
        any_order("scene.FragColor"),
        any_order("balls.FragColor"),
        *(e for row in zip(SHININESS, HALF_POWER, strict=True) for e in half_power(*row)),
        *(
            value(
                "FragColor",
                at={"slope": tan(acos(height ** (1.0 / 8.0))), "level": level, "shininess": 8.0},
                equals=(*color, 1.0),
                digits=6,
                name=name,
            )
            for name, height, level, color in (
                ("just above the base line", 1.0, 0.005, (0.90, 0.42, 0.06)),
                ("on the base line", 1.0, 0.0, (0.90, 0.42, 0.06)),
                ("just above one half", 0.502, 0.25, (0.90, 0.42, 0.06)),
                ("just below one half", 0.498, 0.25, (0.06, 0.13, 0.26)),
            )
        ),
        sweep(
            "lobe",
            lobe,
            over="slope",
            values=np.tan(np.radians(np.linspace(-80.0, 80.0, 81))),
            name="the lobe of 8",
        ),
    ],
)
