"""Two lobes in one drawing: how much of a ray is reflected where, by Phong and by Blinn.

Phong measures the angle between the mirrored ray and the viewer, Blinn the one between the normal
and the halfway vector. In the plane of light and normal the second is exactly half of the first, so
with the same exponent Blinn's lobe is twice as wide. Since (cos α/2)⁴ is nearly cos α, four times
the exponent makes the two alike near the middle. They part at grazing angles, where Blinn's lobe
does not stop at the surface's horizon.

Look at: a point on a surface, the lamp's ray in yellow, the normal and the mirrored ray in grey.
How far a lobe reaches in a direction is how bright the point looks from there: amber where both do,
blue where only Blinn's does. Below both have the exponent 8, and Blinn's lobe ends flat on the
ground; above it has 32, and a thin blue rim is all that is left. There is no red, which would be
Phong's alone: ((1 + cos α) / 2)² is never below cos α.

Try: in `ch05_lighting/phong_vs_blinn.frag` write `4.0 * blinnExponent)` for `blinnExponent)`: the
lower lobe becomes what the upper one was, and above, Phong's shows in red.
"""

from math import cos, radians, sin

import numpy as np

from shaderlab import Case, Ramp, sweep
from shaderlab.glslmath import abs, dot, length, swizzle, vec2, vec3, vec4, where
from shaderlab.reference import lighting

from ..scenes import lit
from ..scenes.figures import each_draw, figures, results
from ..scenes.panels import cell, panel, picture

LIGHT = (-sin(radians(40.0)), cos(radians(40.0)), 0.0)
UP = np.array([0.0, 1.0, 0.0])
# A unit of light is this many of the drawing's units.
DRAWING = Ramp((-1.1, -0.05), (2.2, 0.0), (0.0, 1.1))


def drawings(name, size, **target):
    """Equal exponents below, matched lobes above."""
    draws = [
        panel(
            "ch05_lighting/phong_vs_blinn.frag",
            {"place": DRAWING},
            {"lightDir": LIGHT, "shininess": 8.0, "blinnExponent": exponent},
            cell=cell(row, 1, 2),
        )
        for row, exponent in enumerate((8.0, 32.0))
    ]
    return picture(draws, size, name, **target)


def phong(place, lightDir, shininess):
    """Phong's lobe for a viewer in this direction."""
    return lighting.phong(UP, lightDir, vec3(place, 0.0), shininess)


def blinn(place, lightDir, blinnExponent):
    """Blinn's lobe, likewise."""
    return lighting.blinn(UP, lightDir, vec3(place, 0.0), blinnExponent)


def on_ray(place, direction):
    """1 where the drawing has a ray from the middle, else 0."""
    x, y = swizzle(place, "x"), swizzle(place, "y")
    aside = abs(x * swizzle(direction, "y") - y * swizzle(direction, "x"))
    near = where(aside < 0.006, 1.0, 0.0)
    return near * where(dot(place, direction) > 0.0, 1.0, 0.0)


def drawing(place, lightDir, shininess, blinnExponent):
    """The drawing's colour, layer upon layer."""
    away = length(place)
    incoming = swizzle(lightDir, "xy")
    mirrored = vec2(-swizzle(lightDir, "x"), swizzle(lightDir, "y"))
    grey = on_ray(place, mirrored) + on_ray(place, vec2(0.0, 1.0))
    by_phong = away < phong(place, lightDir, shininess)
    by_blinn = away < blinn(place, lightDir, blinnExponent)
    both = where(by_phong, vec3(0.85, 0.48, 0.12), vec3(0.03, 0.17, 0.42))
    one = where(by_phong, vec3(0.75, 0.05, 0.03), vec3(0.012, 0.015, 0.022))
    color = where(by_blinn, both, one)
    color = where(on_ray(place, incoming) > 0.5, vec3(0.95, 0.85, 0.45), color)
    color = where(grey > 0.5, vec3(0.30, 0.32, 0.36), color)
    return vec4(where(swizzle(place, "y") < 0.0, vec3(0.10, 0.11, 0.12), color), 1.0)


def past_the_mirrored_ray(degrees):
    """The viewer so many degrees from the mirrored ray, towards the ground."""
    angle = radians(40.0 + degrees)
    return {"place": (sin(angle), cos(angle))}


def largest_gap(factor):
    """The largest difference of the two lobes if Blinn's exponent is `factor` times Phong's."""
    off = np.radians(np.linspace(-50.0, 50.0, 2001))
    return np.max(np.abs(np.cos(off) ** 8 - np.cos(off / 2.0) ** (8 * factor)))


NARROW = {"place": (0.35, 0.20), "blinnExponent": 256.0}
LAMP_ASIDE = {"place": (0.6, 0.8), "lightDir": (-0.48, 0.6, 0.64), "shininess": 2.0}
ALONG_GROUND = {"place": (0.8074, -0.59), "lightDir": (0.0, 0.6, 0.8), "blinnExponent": 0.5}
# The lamp 5° below the ground on the right.
BELOW = {"place": (0.2, 0.04), "lightDir": (-cos(radians(5.0)), -sin(radians(5.0)), 0.0)}
GREY, DARK = (0.30, 0.32, 0.36, 1.0), (0.012, 0.015, 0.022, 1.0)
RED, YELLOW = (0.75, 0.05, 0.03, 1.0), (0.95, 0.85, 0.45, 1.0)
AT_20 = past_the_mirrored_ray(20.0)
SAME_EXPONENT = {**AT_20, "blinnExponent": 8.0}

case = Case(
    title="Phong and Blinn, two lobes",
    section="5.7.1",
    math=r"\angle(N, H) = \tfrac12\,\angle(R, V), \qquad "
    r"\cos^{4n}\tfrac{\alpha}{2} \approx \cos^n \alpha",
    passes=(
        drawings("drawing", (1024, 1024), colors={"FragColor": "rgba16f"}),
        *lit.picture("drawing"),
        drawings("judged", (96, 96)),
    ),
    picture="picture.FragColor",
    rows=("exponents 8 and 32", "8 and 8"),
    expect=[
        *each_draw("phong", phong, {0: "Phong's lobe, below", 1: "Phong's lobe, above"}),
        *each_draw("blinn", blinn, {0: "Blinn's lobe, same exponent", 1: "… matched"}),
        *each_draw("FragColor", drawing, {0: "the drawing below", 1: "the drawing above"}),
        lit.picture_check(),
        *figures(
            "phong",
            {
                "Phong, 20° off": (AT_20, 0.607976),
                "Phong, the lamp beside the drawing's plane": (LAMP_ASIDE, 0.589824),
                "Phong's peak": (past_the_mirrored_ray(0.0), 1.0),
            },
        ),
        *figures(
            "blinn",
            {
                "Blinn with the same exponent, 20° off": (
                    {**AT_20, "blinnExponent": 8.0},
                    0.884732,
                ),
                "Blinn, 20° off, four times it": (AT_20, 0.612698),
                "Blinn, halfway along the ground": (ALONG_GROUND, 0.093789),
                "Blinn's peak": (past_the_mirrored_ray(0.0), 1.0),
            },
        ),
        *figures(
            "FragColor",
            {
                "on the normal": ({"place": (0.00597, 0.5)}, GREY),
                "beside the normal": ({"place": (0.00603, 0.5)}, DARK),
                "red, if Blinn's is too narrow": (NARROW, RED),
                "in the middle, above the ground": ({"place": (0.003, 0.004)}, GREY),
                "where the ground begins": ({"place": (-0.003, 0.0)}, YELLOW),
                lit.TURNED_AWAY: (BELOW, DARK),
                "beyond both": ({**NARROW, "place": (0.87, 0.48)}, DARK),
            },
        ),
        *results(
            {
                "largest gap with the same exponent": (largest_gap(1), 0.4904),
                "largest gap with four times it": (largest_gap(4), 0.0180),
            },
            digits=4,
        ),
        *(
            sweep(
                name.lower(),
                lobe,
                over=exponent,
                values=np.geomspace(1.0, 256.0, 33),
                at=AT_20,
                log_x=True,
                name=f"{name} over the exponent, 20° off",
            )
            for name, lobe, exponent in (
                ("Phong", phong, "shininess"),
                ("Blinn", blinn, "blinnExponent"),
            )
        ),
    ],
)
