"""Diffuse light from a whole sky: nine colours are enough.

A matte surface gathers light from the half of the sky above it, each direction by its cosine. That
mean is so wide that it hardly shows any detail: written as waves over the sphere, the spherical
harmonics, the cosine multiplies those of order 0, 1, 2, 3 and 4 by π, 2π/3, π/4, 0 and −π/24. The
first three orders are nine colours, and hold all of the light but a few per cent. They are sums
over the sky's texels, made once, each texel by the solid angle that it covers: one in the corner of
a cube's face covers a fifth of one in its middle. Where that is left out, as it easily is, a sky
max(z, 0) counts its corners too much: nine coefficients then give 2.052 under it instead of 2.078.
All orders together give 2π/3.

Look at: a ring, a ball and a vase of chalk in the morning. No lamp is there, and none of them asks
the sky: blue comes from above, warm light from the sun's side, green from the meadow below.

Try: in `lib/harmonics.glsl` write `1.570796` for `2.094395`: the light comes from all sides more
evenly, and the things look flat.
"""

import math
from functools import partial

import numpy as np

from shaderlab import Case, CubeTexture, Depth, Output, assets, formula, measure
from shaderlab.glslmath import dot, floor, normalize, sqrt, swizzle, vec4
from shaderlab.glslmath.sampling import texelFetch, textureLod
from shaderlab.reference.transforms import translate

from ..scenes import lit
from ..scenes.cameras import camera, camera_rays, turned
from ..scenes.draws import twins
from ..scenes.figures import each_draw, figure, results
from ..scenes.harmonics import harmonics, irradiance, smoothing_of, texels_of
from ..scenes.laws import entry, sampled
from ..scenes.panel_checks import filled_check
from ..scenes.panels import panel, panel_pass, picture
from ..scenes.pottery import vase
from ..scenes.sky import directions, skies, sky_light

# The sun stands to the right, a little behind the viewer.
TURN = turned(80.0)
CAMERA = camera((TURN @ (0.0, 0.35, 6.4, 1.0))[:3], (0.0, 0.0, 0.0), 30.0, 2.0, far=100.0)
RAYS = {"TexCoords": camera_rays(**CAMERA)}
CHALK = (0.86, 0.84, 0.80)
FACES = 16
SKY = CubeTexture(faces=[lambda k=k: sky_light(k, 128) for k in range(6)], filter=("linear",) * 2)
NOISE = skies(seed=15)[1]
# Skies that are projected: the morning's, random texels, one that is 1 everywhere, max(z, 0).
SKIES = {
    "morning": lambda k, size: sky_light(k, size, sun=40.0),
    "noise": lambda k, size: np.random.default_rng(k).uniform(0.0, 4.0, (size, size, 4)),
    "white": lambda k, size: np.ones((size, size, 4)),
    "half": lambda k, size: np.repeat(np.maximum(directions(k, size)[..., 2:], 0.0), 4, axis=-1),
}
SIZES = {"morning": FACES, "noise": 3, "white": 1, "half": FACES}
THINGS = [
    (assets.torus(0.78, 0.30, 128, 64), translate((-2.3, 0.0, 0.0)) @ turned(62.0, (1, 0.35, 0.1))),
    (assets.sphere(1.08, 128, 64), translate((0.0, 0.02, 0.0))),
    (vase(), translate((2.1, -1.15, 0.0))),
]


def projected(name):
    """A pass that writes a sky's nine coefficients, side by side."""
    faces = [SKIES[name](k, SIZES[name]) for k in range(6)]
    textures = {"sky": CubeTexture(faces=faces)}
    return panel_pass(
        name, "ch15_beyond/ibl_diffuse_project.frag", {}, size=(9, 1), textures=textures
    )


def chalk(solid, model, sky, albedo=CHALK):
    """One thing in the light of a sky that was projected."""
    textures = {"coefficients": Output(f"{sky}.coefficient")}
    of = {"vertex": lit.PLACED, "textures": textures}
    uniforms = {"albedo": albedo}
    return lit.thing("ch15_beyond/ibl_diffuse.frag", solid, TURN @ model, CAMERA, uniforms, **of)


def under(sky):
    """A pass with a white ball under a sky."""
    return picture([chalk(*THINGS[1], sky, (1.0, 1.0, 1.0))], (8, 4), f"{sky}-lit")


def behind(sky):
    """The sky itself, as far away as can be."""
    farthest = {"depth": Depth(func="lequal"), "depth_range": (1, 1)}
    return panel("ch13_skybox/skybox.frag", RAYS, textures={"skybox": sky}, **farthest)


def coefficient(sky, frag_coord):
    """∫ L Y dω over the texels of a sky, each by its solid angle."""
    size, number = sky.texels.values.shape[-2], floor(swizzle(frag_coord, "x"))
    places = (2.0 * np.arange(size) + 1.0) / size - 1.0
    toward = []
    for face, y, x in np.ndindex(6, size, size):
        at = [places[x], places[y]]
        at.insert(face // 2, 1.0)
        toward.append(np.array(at) * (1.0 - 2.0 * (face % 2)))
    texels = np.array(toward)[:, None]  # all at once
    area = 1.0 / (dot(texels, texels) * sqrt(dot(texels, texels)))
    light = swizzle(textureLod(sky, texels, 0.0), "rgb")
    parts = area * entry(number, harmonics(normalize(texels))) * light
    covered, total = 0.0, 0.0
    for k in range(len(toward)):
        covered, total = covered + area[k], total + parts[k]
    return 12.566371 / covered * total


def color(Normal, coefficients, albedo):
    """Light of a matte surface: albedo / π times what falls on it."""
    nine = [swizzle(texelFetch(coefficients, np.array([k, 0])), "rgb") for k in range(9)]
    return vec4(albedo / 3.141593 * irradiance(normalize(Normal), nine), 1.0)


def furthest(name):
    """How far coefficients lie from NumPy's by exact solid angles, as a share of the first one."""

    def share(coefficient):
        toward, area, light = texels_of(SKIES[name], SIZES[name])
        truth = np.stack(
            [np.sum((area * np.ravel(y))[:, None] * light, 0) for y in harmonics(toward)]
        )
        return np.abs(coefficient[0] - truth).max() / truth[0].max()

    return share


def farthest(depth):
    """The greatest depth in a picture."""
    return depth.max()


def counted_alike():
    """What falls on a surface under max(z, 0) where all texels of a cube count the same."""
    toward, _, light = texels_of(SKIES["half"], FACES)
    same = [np.mean(np.ravel(y)[:, None] * light, 0) * 4.0 * math.pi for y in harmonics(toward)]
    return irradiance(np.array([0.0, 0.0, 1.0]), same)[0]


def facing(name, sky, normal, equals, **more):
    """Light of a surface of albedo 1 under a sky that was projected."""
    at = {"Normal": normal, "albedo": (1.0, 1.0, 1.0)}
    return figure(f"{sky}-lit.FragColor", name, at, (*equals, 1.0), reference=color, **more)


LARGE = [behind(SKY), *(chalk(*one, "morning") for one in THINGS)]
SMALL = [behind(NOISE), chalk(*THINGS[0], "noise"), chalk(*THINGS[2], "noise")]
LIGHT = {"FragColor": "rgba16f"}

case = Case(
    title="Diffuse light from a sky",
    section="15.1",
    math=r"E(\mathbf n) = \sum_{l \le 2} \sum_m A_l\, L_{lm}\, Y_{lm}(\mathbf n), \qquad "
    r"A_l = \pi,\ \tfrac{2\pi}{3},\ \tfrac{\pi}{4}, \qquad L_{lm} = \int L\, Y_{lm}\, d\omega",
    passes=(
        *map(projected, SKIES),
        *twins(picture(LARGE, (768, 384), "scene", colors=LIGHT, depth="depth24")),
        *lit.picture(size=(384, 192)),
        *twins(picture(SMALL, (64, 32), "judged", depth="depth24")),
        *(under(sky) for sky in ("white", "half")),
    ),
    picture="picture.FragColor",
    expect=[
        formula("noise.coefficient", coefficient, name="nine coefficients of random texels"),
        formula("white.coefficient", coefficient, name="nine coefficients of a white sky"),
        *(
            measure(
                f"{name}: coefficients against exact solid angles",
                furthest(name),
                reads={"coefficient": f"{name}.coefficient"},
                at_most=0.004,
                note="the largest difference as a share of the first coefficient",
            )
            for name in ("morning", "half")
        ),
        *each_draw("judged.FragColor", color, {1: "the ring", 2: "the vase"}, "light of {}"),
        formula("judged.FragColor", sampled("skybox"), draw=0, name="the sky behind"),
        filled_check("scene"),
        measure("depth of the sky", farthest, reads={"depth": "scene.depth"}, equals=1.0, digits=9),
        *lit.vertex_stage_checks(pass_name="judged"),
        *lit.picture_checks(),
        facing("a white sky lights as white", "white", (0.0, 3.0, 4.0), (1.0, 1.0, 1.0), digits=5),
        facing("under max(z, 0)", "half", (0.0, 0.0, 1.0), (0.661531,) * 3),
        *results(
            {
                "E under max(z, 0), all orders": (2.0 * math.pi / 3.0, 2.094395),
                "E under max(z, 0), all texels alike": (counted_alike, 2.051570),
                **{
                    f"a cosine times order {order}": (partial(smoothing_of, order), factor)
                    for order, factor in enumerate((3.141593, 2.094395, 0.785398, 0.0, -0.1309))
                },
            }
        ),
    ],
)
