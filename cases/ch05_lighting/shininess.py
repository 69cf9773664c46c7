"""Shininess: the exponent that makes a highlight small, and nothing else.

The cosine between the mirrored ray and the viewer is raised to the power of the shininess s. At the
peak it is 1, and 1 stays 1: the highlight gets narrower, not brighter. Half of it is left where
cosˢ = ½, that is 45° off for s = 2, 11.9° for 32 and 4.2° for 256: each doubling of s makes the
highlight about √2 times narrower.

Look at: the strip, s = 2, 4, 8 … 256 from left to right. Below each ball is its lobe over the
angle, from −50° to 50° off the mirrored ray; amber is what is above one half, so its width is the
half-power angle, twice. A real polished ball would reflect more than a dull one in the middle: the
plain Phong lobe does not know that.

Try: in `lib/reflection.glsl` write `pow(cosine, 0.5 * shininess)` for `pow(cosine, shininess)`:
each ball gets the highlight and the lobe of its left neighbour.
"""

from math import acos, radians, tan

import numpy as np

from shaderlab import Case, Mesh, across, any_order, assets, formula, sweep, up
from shaderlab.glslmath import vec3, vec4, where
from shaderlab.reference.lighting import half_power_angle, phong, phong_color, specular_factor
from shaderlab.reference.transforms import translate

from ..scenes import lit
from ..scenes.cameras import camera, turned
from ..scenes.draws import twins
from ..scenes.figures import each_draw, figure, figures, results
from ..scenes.panels import cell, panel, panel_pass, picture

SHININESS = (2, 4, 8, 16, 32, 64, 128, 256)
HALF_POWER = (45.0, 32.765100, 23.508050, 16.743653, 11.882461, 8.417365, 5.957353, 4.214387)
EYE = (0.0, 0.0, 9.0)
CAMERA = camera(EYE, (0.0, 0.0, 0.0), 14.5, near=1.0)
BALL = Mesh(**assets.sphere(0.98, segments=96, rings=48))
SMALL_BALL = Mesh(**assets.sphere(0.98, segments=24, rings=12))
MODEL = translate((0.02, 0.03, -0.1)) @ turned(30.0, (1.0, 1.0, 0.0))
PROFILE, LEVELS = "ch05_lighting/shininess_profile.frag", {"level": up(-0.05, 1.2)}
MOST, SLOPES = tan(radians(50.0)), np.tan(np.radians(np.linspace(-80.0, 80.0, 81)))


def ball(mesh, column, shininess):
    """One ball of the strip."""
    uniforms = {
        "objectColor": (0.30, 0.62, 0.72),
        "lightColor": (1.0, 0.97, 0.92),
        "lightPos": (-4.0, 5.0, 8.0),
        "viewPos": EYE,
        "ambientStrength": 0.04,
        "diffuseStrength": 0.42,
        "specularStrength": 1.1,
        "shininess": float(shininess),
    }
    place = cell(8 + column, 8, 2)
    return lit.thing("ch05_lighting/specular.frag", mesh, MODEL, CAMERA, uniforms, cell=place)


def profile(column, shininess):
    """The lobe over the angle, below its ball."""
    domain, place = {**LEVELS, "slope": across(-MOST, MOST)}, cell(column, 8, 2)
    return panel(PROFILE, domain, {"shininess": float(shininess)}, cell=place)


def strip(name, mesh, size, **target):
    """Eight balls, and their lobes below them."""
    draws = [draw for k, s in enumerate(SHININESS) for draw in (ball(mesh, k, s), profile(k, s))]
    clear = (0.012, 0.014, 0.02, 1.0)
    return twins(picture(draws, size, name, depth="depth24", clear=clear, **target))


def lobe(slope, shininess):
    """Phong's lobe for a light along the normal and a viewer at this slope from it."""
    upward = vec3(0.0, 1.0, 0.0)
    return phong(upward, upward, vec3(slope, 1.0, 0.0), shininess)


def profile_color(slope, level, shininess):
    """Grey below the base line; under the curve amber where it is above one half, else blue."""
    height = lobe(slope, shininess)
    filled = where(height < 0.5, vec3(*BLUE), vec3(*AMBER))
    over_base = where(level < height, filled, vec3(0.012, 0.014, 0.02))
    return vec4(where(level < 0.0, vec3(0.25), over_base), 1.0)


AMBER, BLUE = (0.90, 0.42, 0.06), (0.06, 0.13, 0.26)


def half_power(shininess, angle):
    """The angle by the formula, and the shader's lobe there."""
    at = {"slope": tan(radians(angle)), "level": 0.5, "shininess": float(shininess)}
    return (
        *results(
            {f"half-power angle of {shininess}, degrees": (half_power_angle(shininess), angle)}
        ),
        figure("lobe", f"the lobe of {shininess} there", at, 0.5),
    )


BALLS = {2 * k: s for k, s in enumerate(SHININESS)}


def where_high(height, level):
    """Where the lobe of 8 is so high, and a level of the drawing."""
    return {"slope": tan(acos(height ** (1.0 / 8.0))), "level": level, "shininess": 8.0}


case = Case(
    title="Shininess",
    section="5.2.3",
    math=r"s(\alpha) = \cos^n \alpha, \qquad \alpha_{1/2} = \arccos\!\left(2^{-1/n}\right)",
    passes=(
        *strip("scene", BALL, (2048, 512), colors={"FragColor": "rgba16f"}),
        *lit.picture(size=(1024, 256)),
        *strip("balls", SMALL_BALL, (192, 48), colors={"FragColor": "rgba32f", "spec": "r32f"}),
        panel_pass("main", PROFILE, {**LEVELS, "slope": across(-1.2, 1.2)}, {"shininess": 8.0}),
    ),
    picture="picture.FragColor",
    columns=[f"s = {2**k}" for k in range(1, 9)],
    expect=[
        *lit.vertex_stage_checks(pass_name="balls", draw=14),
        *each_draw("balls.spec", specular_factor, BALLS, "lobe of {} on its ball"),
        *each_draw(
            "balls.FragColor", phong_color, {2 * k: f"ball of {SHININESS[k]}" for k in (0, 4, 7)}
        ),
        formula("lobe", lobe),
        formula("FragColor", profile_color, name="the lobe, filled"),
        lit.picture_check(),
        any_order("scene.FragColor"),
        any_order("balls.FragColor"),
        *(e for row in zip(SHININESS, HALF_POWER, strict=True) for e in half_power(*row)),
        *figures(
            "FragColor",
            {
                "just above the base line": (where_high(1.0, 0.005), (*AMBER, 1.0)),
                "on the base line": (where_high(1.0, 0.0), (*AMBER, 1.0)),
                "just above one half": (where_high(0.502, 0.25), (*AMBER, 1.0)),
                "just below one half": (where_high(0.498, 0.25), (*BLUE, 1.0)),
            },
        ),
        sweep("lobe", lobe, over="slope", values=SLOPES, name="the lobe of 8"),
    ],
)
