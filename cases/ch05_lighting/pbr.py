"""Physically based shading: a rough surface is a landscape of tiny mirrors.

Three questions decide what such a surface reflects. D: how many of its mirrors face halfway between
light and viewer, all of them on a polished surface, few in any one direction on a rough one. G: how
many of those block each other. F: how much one mirror reflects, about 4 % of the light straight on
for anything that is not a metal, and everything at a grazing angle. The product over 4 (n·v)(n·l)
is the specular part; what was not reflected is refracted, and comes back as the diffuse part unless
the material is a metal.

Look at: the grid, roughness from 0.15 on the left to 1 on the right, from plastic below to metal
above. Four lamps hang before it. To the right the highlights spread and become fainter, because the
same light goes to more directions. Upward the diffuse part disappears, and the highlights take on
the material's colour. Metals look dark here: their world would be in their reflections.

Try: in `lib/microfacets.glsl` write `float alpha = roughness` for `float alpha = roughness *
roughness`: smooth balls get larger highlights, and the roughest column does not change.
"""

import numpy as np

from shaderlab import Case, Mesh, assets, formula, sweep
from shaderlab.glslmath import dot, max, normalize, vec4
from shaderlab.reference import microfacets
from shaderlab.reference.transforms import scale, translate

from ..scenes import lit
from ..scenes.cameras import camera, turned
from ..scenes.figures import figure, figures, results

EYE = (0.0, 0.0, 15.0)
CAMERA = camera(EYE, (0.0, 0.0, 0.0), 29.0, far=60.0)
COPPER = (0.91, 0.27, 0.13)
ROUGHNESS = (0.15, 0.32, 0.49, 0.66, 0.83, 1.0)
METALLIC = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
LAMPS = [(-5.0, 5.0, 7.0), (5.0, 5.0, 7.0), (-5.0, -5.0, 7.0), (5.0, -5.0, 7.0)]
LIGHT = [(300.0, 285.0, 255.0), (40.0, 52.0, 80.0), (30.0, 36.0, 48.0), (26.0, 20.0, 16.0)]
SMOOTH = Mesh(**assets.sphere(0.98, segments=48, rings=24))
COARSE = Mesh(**assets.sphere(0.98, segments=16, rings=8))
SOME = [(0, 5), (2, 3), (5, 0)]


def lamps(places, colors):
    """The four lamps' uniforms."""
    named = {f"lights[{k}].position": place for k, place in enumerate(places)}
    return {**named, **{f"lights[{k}].color": color for k, color in enumerate(colors)}}


def ball(mesh, column, row):
    """One ball: its roughness by its column, its metalness by its row."""
    place = translate((1.24 * (column - 2.5), 1.24 * (row - 2.5), 0.0))
    surface = {
        "camPos": EYE,
        "albedo": COPPER,
        "metallic": METALLIC[row],
        "roughness": ROUGHNESS[column],
        **lamps(LAMPS, LIGHT),
    }
    model = place @ turned(20.0, (1.0, 1.0, 0.0)) @ scale(0.57)
    return lit.thing("ch05_lighting/pbr.frag", mesh, model, CAMERA, surface)


def first(FragPos, Normal, camPos, lights_position):
    """Unit vectors to the viewer and the first lamp, halfway between them, and the normal."""
    view, light = normalize(camPos - FragPos), normalize(lights_position[0] - FragPos)
    return view, light, normalize(view + light), normalize(Normal)


def distribution(FragPos, Normal, camPos, lights_position, roughness):
    """D at a fragment."""
    _, _, half, normal = first(FragPos, Normal, camPos, lights_position)
    return microfacets.distribution_either(normal, half, roughness)


def distribution_as_printed(FragPos, Normal, camPos, lights_position, roughness):
    """D by the formula as it is usually printed, as an independent reference in float64."""
    _, _, half, normal = first(FragPos, Normal, camPos, lights_position)
    return microfacets.distribution(max(dot(normal, half), 0.0), roughness)


def geometry(FragPos, Normal, camPos, lights_position, roughness):
    """G at a fragment."""
    view, light, _, normal = first(FragPos, Normal, camPos, lights_position)
    cosines = max(dot(normal, view), 0.0), max(dot(normal, light), 0.0)
    return microfacets.geometry(*cosines, roughness)


def fresnel(FragPos, camPos, lights_position, Normal, albedo, metallic):
    """F at a fragment."""
    view, _, half, _ = first(FragPos, Normal, camPos, lights_position)
    f0 = microfacets.base_reflectance(albedo, metallic)
    return microfacets.fresnel(dot(half, view), f0)


def color(FragPos, Normal, camPos, albedo, metallic, roughness, lights_position, lights_color):
    """All four lamps, and a little light from everywhere."""
    normal, view = normalize(Normal), normalize(camPos - FragPos)
    total = 0.02 * albedo
    for place, strength in zip(lights_position, lights_color, strict=True):
        ray = place - FragPos
        lit = microfacets.radiance(normal, view, normalize(ray), albedo, metallic, roughness)
        total = total + lit * strength / dot(ray, ray)
    return vec4(total, 1.0)


def at_the_point(roughness, metallic=0.0):
    """The test point with one lamp, as strong as makes 1 at its distance of √6.44."""
    dark = (0.0, 0.0, 0.0)
    return {
        "FragPos": (0.0, 0.0, 0.0),
        "Normal": (0.0, 0.0, 1.0),
        "camPos": (0.0, 0.0, 3.0),
        **lamps([lit.POINT_LAMP, *LAMPS[1:]], [(6.44, 6.44, 6.44), dark, dark, dark]),
        "albedo": lit.CORAL,
        "roughness": roughness,
        "metallic": metallic,
    }


def reciprocity():
    """The largest relative difference when light and viewer change places."""
    random = np.random.default_rng(5)
    normal, albedo, worst = np.eye(3)[2], np.array(COPPER), 0.0
    for _ in range(200):
        one, other = random.normal(size=(2, 3))
        one[2], other[2] = abs(one[2]) + 0.1, abs(other[2]) + 0.1
        one, other = one / np.linalg.norm(one), other / np.linalg.norm(other)
        rough, metal = random.uniform(0.1, 1.0), random.uniform(0.0, 1.0)
        there = microfacets.radiance(normal, one, other, albedo, metal, rough) / other[2]
        back = microfacets.radiance(normal, other, one, albedo, metal, rough) / one[2]
        worst = np.fmax(worst, np.max(np.abs(there - back) / there))
    return worst


def checks(draw, column, row):
    """D, G, F and the colour of one ball."""
    where = f"roughness {ROUGHNESS[column]:g}, metal {METALLIC[row]:g}"
    printed = {"as printed": distribution_as_printed}
    return (
        formula("D", distribution, draw=draw, name=f"D, {where}", also=printed),
        formula("G", geometry, draw=draw, name=f"G, {where}"),
        formula("F", fresnel, draw=draw, name=f"F, {where}"),
        formula("FragColor", color, draw=draw, name=f"colour, {where}"),
    )


AT_HALF = at_the_point(0.5)
# Viewer and lamp half a hundredth above the surface: F is nearly 1, and 4 (n·v)(n·l) is small.
GRAZING = {
    **at_the_point(1.0),
    "camPos": (3.0, 0.0, 0.015),
    "lights[0].position": (-3.0, 0.0, 0.015),
    "lights[0].color": (9000.0, 9000.0, 9000.0),
}
OVER_D, OVER_G = np.geomspace(0.1, 1.0, 41), np.linspace(0.05, 1.0, 41)

case = Case(
    title="Physically based shading",
    section="5.13",
    math=r"f = \frac{k_d\,a}{\pi} + \frac{D\,F\,G}{4\,(n \cdot v)(n \cdot l)}, \qquad "
    r"D = \frac{\alpha^2}{\pi\left((n \cdot h)^2(\alpha^2 - 1) + 1\right)^2}",
    passes=lit.photographed(
        [ball(SMOOTH, column, row) for row in range(6) for column in range(6)],
        [ball(COARSE, column, row) for column, row in SOME],
        clear=(0.006, 0.007, 0.009, 1.0),
        size=(112, 112),
    ),
    picture="picture.FragColor",
    expect=[
        *lit.vertex_stage_checks(),
        *(check for k, place in enumerate(SOME) for check in checks(k, *place)),
        *lit.picture_checks(),
        figure("D", "D at the point", AT_HALF, 0.759711),
        figure("G", "G at the point", AT_HALF, 0.929700),
        figure("F", "F at the point", AT_HALF, (0.04, 0.04, 0.04)),
        *figures(
            "FragColor",
            {
                "plastic at the point": (AT_HALF, (0.267892, 0.137477, 0.087920, 1.0)),
                "metal at the point": (at_the_point(0.5, 1.0), (0.196570, 0.098285, 0.060937, 1.0)),
                "along the surface": (GRAZING, (0.826932, 0.798025, 0.787040, 1.0)),
            },
        ),
        *(
            sweep(output, law, over="roughness", values=values, at=AT_HALF, name=name)
            for output, law, values, name in (
                ("D", distribution, OVER_D, "D over the roughness"),
                ("G", geometry, OVER_G, "G over the roughness"),
            )
        ),
        *results(
            {
                f"integral of D, roughness {rough:g}": (
                    lambda rough=rough: microfacets.facing_share(rough),
                    1.0,
                )
                for rough in (0.15, 0.5, 1.0)
            }
        ),
        *results(
            {"light and viewer exchanged, largest relative difference": (reciprocity, 0.0)},
            digits=12,
        ),
    ],
)
