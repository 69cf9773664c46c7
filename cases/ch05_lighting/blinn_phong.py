"""Phong and Blinn–Phong: two ways to draw the highlight of a glossy surface.

Phong reflects the light about the normal and compares the mirrored ray with the direction to the
viewer. Where these two are more than 90° apart the cosine is negative and the highlight ends, on a
line. Blinn compares the normal with the halfway vector between light and viewer, and that angle
stays below 90° while light and viewer are above the surface: nothing is cut off.

Look at: a ball in a ring and the floor before it, Phong on the left, Blinn on the right. With a low
shininess the highlights on the left have edges. For the same shininess Blinn's are the larger ones,
because the halfway vector turns only half as fast as the mirrored ray.

Try: in `ch05_lighting/blinn_phong.frag` write `blinnLobe(normal, lightDir, viewDir, 4.0 *
shininess)` for `blinnLobe(normal, lightDir, viewDir, shininess)`: Blinn's highlight becomes about
as small as Phong's.
"""

from math import cos, radians, sin, tan

import numpy as np

from shaderlab import Case, Erratum, Variant, across, any_order, formula, measure, reading, sweep
from shaderlab.assets import meshes
from shaderlab.glslmath import dot, max, normalize, swizzle, vec3, vec4, where
from shaderlab.reference import lighting as lobes
from shaderlab.reference.transforms import rotate, translate

from ..scenes import lit
from ..scenes.cameras import camera
from ..scenes.drawing import encoded
from ..scenes.draws import twins
from ..scenes.figures import figure, results
from ..scenes.laws import gated_or_not
from ..scenes.panels import cell, panel_pass, picture

EYE, LAMP = (0.0, 1.5, 4.6), (0.0, 1.1, 0.4)
CAMERA = camera(EYE, (0.0, 0.15, 0.4), 39.0, 0.5, far=20.0)
# The still life is built along x, and a quarter turn takes it behind the lamp.
MODEL = rotate(radians(90.0), (0.0, 1.0, 0.0))
FLOOR = meshes.plane(size=12.0)
STILL_LIFE = meshes.joined(
    FLOOR,
    meshes.moved(meshes.torus(0.56, 0.2), translate((0.6, 0.2, 0.0))),
    meshes.moved(meshes.sphere(0.46), translate((0.6, 0.55, 0.0))),
)


def half(column, blinn):
    """One half of the picture: the still life with one of the two lobes."""
    uniforms = {"lightPos": LAMP, "viewPos": EYE, "shininess": 8.0, "blinn": blinn}
    shader = "ch05_lighting/blinn_phong.frag"
    return lit.thing(shader, STILL_LIFE, MODEL, CAMERA, uniforms, cell=cell(column, 2))


HALVES = (half(0, blinn=False), half(1, blinn=True))


def turned_away(name, blinn):
    """The floor with the lamp below it, behind the middle."""
    uniforms = {"lightPos": (0.0, -0.3, -3.0), "viewPos": EYE, "shininess": 8.0, "blinn": blinn}
    draw = lit.thing("ch05_lighting/blinn_phong.frag", FLOOR, MODEL, CAMERA, uniforms)
    of, colors = f"{name}, lamp below", {"specular": "r32f"}
    return picture([draw], (32, 32), of, colors=colors, depth="depth24")


def over_slopes(name, degrees):
    """Both lobes for viewers at slopes to both sides, the lamp so high above the surface."""
    angle = radians(degrees)
    uniforms = {"lightDir": (cos(angle), sin(angle), 0.0), "shininess": 8.0}
    slopes = {"slope": across(-4.0, 4.0)}
    return panel_pass(name, "ch05_lighting/blinn_phong_lobes.frag", slopes, uniforms)


def mirrored(FragPos, Normal, lightPos, viewPos, shininess, highlight=lobes.phong):
    """Phong's lobe at a fragment."""
    return highlight(Normal, lightPos - FragPos, viewPos - FragPos, shininess)


def halfway(FragPos, Normal, lightPos, viewPos, shininess, highlight=lobes.blinn):
    """Blinn's lobe at a fragment."""
    return highlight(Normal, lightPos - FragPos, viewPos - FragPos, shininess)


def shaded(FragPos, Normal, lightPos, lobe):
    """The picture's colour: an ambient and a diffuse part, the lobe, and the display's gamma."""
    cosine = max(dot(normalize(Normal), normalize(lightPos - FragPos)), 0.0)
    surface = where(swizzle(FragPos, "y") > 0.001, vec3(0.55, 0.16, 0.12), vec3(0.10, 0.14, 0.20))
    return vec4(encoded(surface * (0.06 + 0.9 * cosine) + vec3(0.55) * lobe), 1.0)


def shaded_by(lobe):
    """The colour of the half of the picture that has this lobe."""

    def color(FragPos, Normal, lightPos, viewPos, shininess):
        inputs = {"lightPos": lightPos, "viewPos": viewPos, "shininess": shininess}
        return shaded(FragPos, Normal, lightPos, lobe(FragPos=FragPos, Normal=Normal, **inputs))

    return color


BY_PHONG = gated_or_not(mirrored, highlight=lobes.mirrored_lobe)
BY_BLINN = gated_or_not(halfway, highlight=lobes.halfway_lobe)


def strongest(specular):
    """Of all places."""
    return specular.max()


def ungated(lobe, degrees):
    """What a lobe without a gate gives for a lamp 5° below the surface and a viewer so many degrees
    above the other side; shininess 8."""
    eye = np.array([cos(radians(degrees)), 0.0, sin(radians(degrees))])
    return lobe(np.array(lit.GRAZING["Normal"]), np.array(lit.BELOW), eye, 8.0)


UNGATED = (
    ("Phong", 10, ungated(lobes.mirrored_lobe, 10), 0.757792),
    ("Blinn", 10, ungated(lobes.halfway_lobe, 10), 0.933574),
    ("Blinn", 70, ungated(lobes.halfway_lobe, 70), 0.156940),
)


def phong_over_slope(slope, lightDir, shininess):
    """Phong's lobe for a viewer at a slope from the normal (0, 1, 0)."""
    return lobes.phong(vec3(0.0, 1.0, 0.0), lightDir, vec3(slope, 1.0, 0.0), shininess)


def blinn_over_slope(slope, lightDir, shininess):
    """Blinn's lobe, likewise."""
    return lobes.blinn(vec3(0.0, 1.0, 0.0), lightDir, vec3(slope, 1.0, 0.0), shininess)


# The viewer from 72° on the mirrored side to 72° on the light's own side.
SLOPES = np.tan(np.radians(np.linspace(-72.0, 72.0, 70)))


def past_the_edge(blinn):
    """Light 60° and viewer 45° off the normal on one side: mirrored ray and viewer 105° apart."""
    at = {"slope": tan(radians(45.0))}
    return [
        figure("phong", "Phong past 90°", at, 0.0),
        figure("blinn", "Blinn past 90°", at, blinn),
    ]


# A light that is not in one plane with viewer and normal, nor given as a unit vector.
ASIDE = {"slope": 0.5, "lightDir": (-0.6, 1.2, 0.4), "shininess": 8.0}
# The lamp in the surface's own plane, and a little above it; the viewer on the mirrored side.
LEVEL = {"slope": -2.0, "lightDir": (1.0, 0.0, 0.0), "shininess": 8.0}
RISEN = {**LEVEL, "lightDir": (1.0, 0.0005, 0.0)}
ABOVE_FLOOR = {"FragPos": (0.0, 0.005, 0.9), "Normal": (0.0, -1.0, 0.0)}

case = Case(
    title="Blinn–Phong beside Phong",
    section="5.7.2",
    math=r"H = \frac{L + V}{\lVert L + V \rVert}, \qquad "
    r"\text{Blinn} = (N \cdot H)^s, \quad \text{Phong} = (R \cdot V)^s",
    passes=(
        *twins(picture(HALVES, None, depth="depth24", clear=(0.16, 0.20, 0.26, 1.0))),
        turned_away("Phong", blinn=False),
        turned_away("Blinn", blinn=True),
        over_slopes("below", -5.0),
        over_slopes("lobes", 30.0),
    ),
    picture="picture.FragColor",
    columns=("Phong", "Blinn"),
    expect=[
        *lit.vertex_stage_checks(pass_name="picture"),
        formula("picture.specular", BY_PHONG, draw=0, name="Phong, left half"),
        formula("picture.specular", BY_BLINN, draw=1, name="Blinn, right half"),
        formula("picture.FragColor", shaded_by(BY_PHONG), draw=0, name="colour, left half"),
        formula("picture.FragColor", shaded_by(BY_BLINN), draw=1, name="colour, right half"),
        measure(
            lit.TURNED_AWAY,
            strongest,
            readings=[
                reading(label, reads={"specular": output}, equals=0.0, digits=6)
                for lobe in ("Phong", "Blinn")
                for label, output in (
                    (f"{lobe}, on the floor", f"{lobe}, lamp below.specular"),
                    (f"{lobe}, over the slope", f"below.{lobe.lower()}"),
                )
            ],
        ),
        *results(
            {
                f"{name} without a gate on a face turned away, seen {degrees}° above it": made
                for name, degrees, *made in UNGATED
            }
        ),
        any_order("picture.FragColor"),
        formula("phong", phong_over_slope),
        formula("blinn", blinn_over_slope),
        sweep("phong", phong_over_slope, over="slope", values=SLOPES),
        sweep("blinn", blinn_over_slope, over="slope", values=SLOPES),
        figure("phong", "Phong, light from aside", ASIDE, 0.711321),
        figure("blinn", "Blinn, light from aside", ASIDE, 0.899891),
        figure("phong", "Phong, lamp level with the surface", LEVEL, 0.0),
        figure("blinn", "Blinn, lamp level with the surface", LEVEL, 0.0),
        figure("phong", "Phong, lamp just risen", RISEN, 0.410420),
        figure("blinn", "Blinn, lamp just risen", RISEN, 0.805372),
        figure(
            "picture.FragColor",
            "just above the floor",
            ABOVE_FLOOR,
            (0.212128, 0.121018, 0.106184, 1.0),
        ),
    ],
    variants=[
        Variant("shininess 8", {"shininess": 8.0}, expect=past_the_edge(0.018862)),
        Variant("shininess 0.5", {"shininess": 0.5}, expect=past_the_edge(0.780232)),
        Variant("shininess 32", {"shininess": 32.0}, expect=past_the_edge(0.0)),
    ],
    errata=[
        Erratum(
            section="5.9.1",
            says="the specular term is max(N·H, 0) to a power, on whatever side of the surface "
            "the lamp is (and likewise R·V in 5.2.3)",
            truth="a face turned away from the lamp has no highlight; without the gate, seen "
            "from 10° above with the lamp 5° below, Phong gives 0.757792 and Blinn 0.933574",
            proof=lit.TURNED_AWAY,
        )
    ],
)
