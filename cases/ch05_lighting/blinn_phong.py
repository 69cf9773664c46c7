"""Phong and Blinn–Phong: two ways to draw the highlight of a glossy surface.

Phong mirrors the light at the normal and compares the mirrored ray with the direction to the
viewer. Where these two are more than 90° apart the cosine is negative and the highlight ends, on a
line. Blinn compares the normal with the halfway vector between light and viewer, and that angle
stays below 90° while light and viewer are above the surface: nothing is cut off.

Look at: the floor behind the lamp, Phong on the left, Blinn on the right. With a low shininess the
left one has an edge. For the same shininess Blinn's highlight is the larger one, because the
halfway vector turns only half as fast as the mirrored ray.
"""

from math import cos, radians, sin, tan

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Depth,
    Draw,
    Mesh,
    Pass,
    State,
    Target,
    Variant,
    across,
    any_order,
    assets,
    both_ways,
    formula,
    fullscreen,
    sweep,
    value,
)
from shaderlab.glslmath import clamp, dot, max, normalize, pow, swizzle, vec3, vec4, where
from shaderlab.reference import lighting as lobes
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

EYE, LAMP = (0.0, 1.5, 4.6), (0.0, 1.1, 0.4)
# The still life is built along x, and a quarter turn has it face the viewer.
MODEL = rotate(radians(90.0), (0.0, 1.0, 0.0))
STILL_LIFE = Mesh(
    **assets.joined(
        assets.plane(size=12.0),
        assets.moved(assets.torus(0.34, 0.15), translate((-1.5, 0.15, 0.0))),
        assets.moved(assets.sphere(0.3), translate((1.2, 0.42, 0.0))),
    )
).only("aPos", "aNormal")


def half(column, blinn):
    """One half of the picture: the still life with one of the two lobes."""
    return Draw(
        vertex="ch05_lighting/blinn_phong.vert",
        fragment="ch05_lighting/blinn_phong.frag",
        mesh=STILL_LIFE,
        uniforms={
            "model": MODEL,
            "normalMatrix": normal_matrix(MODEL),
            "view": look_at(EYE, (0.0, 0.0, 0.9)),
            "projection": perspective(radians(42.0), 0.5, 0.1, 20.0),
            "lightPos": LAMP,
            "viewPos": EYE,
            "shininess": 8.0,
            "blinn": blinn,
        },
        state=State(depth=Depth(), cell=Cell(column=column, row=0, columns=2, rows=1)),
    )


def mirrored(FragPos, Normal, lightPos, viewPos, shininess):
    """Phong's lobe at a fragment."""
    return lobes.phong(Normal, lightPos - FragPos, viewPos - FragPos, shininess)


def halfway(FragPos, Normal, lightPos, viewPos, shininess):
    """Blinn's lobe at a fragment."""
    return lobes.blinn(Normal, lightPos - FragPos, viewPos - FragPos, shininess)


def shaded(FragPos, Normal, lightPos, lobe):
    """The picture's colour: an ambient and a diffuse part, the lobe, and the display's gamma."""
    cosine = max(dot(normalize(Normal), normalize(lightPos - FragPos)), 0.0)
    surface = where(swizzle(FragPos, "y") > 0.001, vec3(0.55, 0.16, 0.12), vec3(0.10, 0.14, 0.20))
    light = surface * (0.06 + 0.9 * cosine) + vec3(0.55) * lobe
    return vec4(pow(clamp(light, 1.0e-6, 1.0), 1.0 / 2.2), 1.0)


def shaded_mirrored(FragPos, Normal, lightPos, viewPos, shininess):
    """The left half's colour."""
    lobe = mirrored(FragPos, Normal, lightPos, viewPos, shininess)
    return shaded(FragPos, Normal, lightPos, lobe)


def shaded_halfway(FragPos, Normal, lightPos, viewPos, shininess):
    """The right half's colour."""
    lobe = halfway(FragPos, Normal, lightPos, viewPos, shininess)
    return shaded(FragPos, Normal, lightPos, lobe)


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
        value("phong", at=at, equals=0.0, digits=6, name="Phong past 90°"),
        value("blinn", at=at, equals=blinn, digits=6, name="Blinn past 90°"),
    ]


def out_of_the_plane():
    """A light that is not in one plane with viewer and normal, nor given as a unit vector."""
    at = {"slope": 0.5, "lightDir": (-0.6, 1.2, 0.4), "shininess": 8.0}
    return [
        value("phong", at=at, equals=0.711321, digits=6, name="Phong, light from aside"),
        value("blinn", at=at, equals=0.899891, digits=6, name="Blinn, light from aside"),
    ]


case = Case(
    title="Blinn–Phong beside Phong",
    section="5.7.2",
    math=r"H = \frac{L + V}{\lVert L + V \rVert}, \qquad "
    r"\text{Blinn} = (N \cdot H)^s, \quad \text{Phong} = (R \cdot V)^s",
    passes=(
        *both_ways(
            Pass(
                name="picture",
                target=Target(depth="depth24", clear=(0.16, 0.20, 0.26, 1.0)),
                draws=(half(0, blinn=False), half(1, blinn=True)),
            )
        ),
        *fullscreen(
            "ch05_lighting/blinn_phong_lobes.frag",
            name="lobes",
            domain={"slope": across(-4.0, 4.0)},
            uniforms={"lightDir": (sin(radians(60.0)), cos(radians(60.0)), 0.0), "shininess": 8.0},
        ),
    ),
    picture="picture.FragColor",
    expect=[
        formula("picture.gl_Position", clip_position),
        formula("picture.FragPos", world_position),
        formula("picture.Normal", world_normal),
        formula("picture.specular", mirrored, draw=0, name="Phong, left half"),
        formula("picture.specular", halfway, draw=1, name="Blinn, right half"),
        formula("picture.FragColor", shaded_mirrored, draw=0, name="colour, left half"),
        formula("picture.FragColor", shaded_halfway, draw=1, name="colour, right half"),
        any_order("picture.FragColor"),
        formula("phong", phong_over_slope),
        formula("blinn", blinn_over_slope),
        sweep("phong", phong_over_slope, over="slope", values=SLOPES),
        sweep("blinn", blinn_over_slope, over="slope", values=SLOPES),
        *out_of_the_plane(),
    ],
    variants=[
        Variant("shininess 0.5", {"shininess": 0.5}, expect=past_the_edge(0.780232)),
        Variant("shininess 8", {"shininess": 8.0}, expect=past_the_edge(0.018862)),
        Variant("shininess 32", {"shininess": 32.0}, expect=past_the_edge(0.0)),
    ],
)
