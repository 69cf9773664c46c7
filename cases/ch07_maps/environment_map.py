"""Environment maps: a mirror and a lens show the colour of the sky in the direction of the ray.

The ray from the camera is reflected about the normal, or refracted by Snell's law, and a cube map
gives the colour in that direction, as if all were far away. Glass of index 1.52 bends by 1/1.52 =
0.658, and mirrors 4.3 % of the light straight on, all of it at a grazing angle (Schlick).

Look at: the ball of glass between two things of metal. The hills in it stand on their heads; its
rim is a mirror. Beyond 41° no ray leaves the glass: `refract` gives (0, 0, 0).

Try: in `ch07_maps/environment_map.frag` write `refract(ray, normal, 1.0)` for `refract(ray, normal,
ratio)`: you see straight through the ball, and only its rim still reflects.
"""

from shaderlab import Case, Depth, any_order, assets, formula, measure
from shaderlab.glslmath import mix
from shaderlab.glslmath.sampling import textureLod
from shaderlab.reference.cube_maps import bent, fresnel, mirrored
from shaderlab.reference.transforms import translate, world_normal

from ..scenes import lit
from ..scenes.cameras import camera, camera_rays, turned
from ..scenes.draws import twins
from ..scenes.figures import each_draw, figure
from ..scenes.laws import sampled
from ..scenes.panel_checks import filled_check, softened_check
from ..scenes.panels import panel, picture, softened_pass
from ..scenes.pottery import vase
from ..scenes.sky import skies

EYE = (0.0, 0.35, 6.4)
CAMERA = camera(EYE, (0.0, 0.0, 0.0), 30.0, 2.0, far=100.0)
RAYS = {"TexCoords": camera_rays(**CAMERA)}
RATIO = 1.0 / 1.52
# What glass mirrors straight on, by Fresnel: ((1 − n) / (1 + n))².
GLASS, METAL = ((1.0 - RATIO) / (1.0 + RATIO)) ** 2, 0.85
MORNING, NOISE = skies(seed=74)
RING_PLACE = translate((-2.15, 0.0, 0.0)) @ turned(62.0, (1.0, 0.35, 0.1))
THINGS = [
    (assets.torus(0.78, 0.30, 128, 64), RING_PLACE, METAL),
    (assets.sphere(1.08, 128, 64), translate((0.0, 0.02, 0.0)), GLASS),
    (vase(), translate((2.1, -1.15, 0.0)), METAL),
]


def thing(geometry, model, base, sky):
    """One thing under this sky."""
    uniforms, of = {"cameraPos": EYE, "ratio": RATIO, "base": base}, {"textures": {"sky": sky}}
    return lit.thing(
        "ch07_maps/environment_map.frag", geometry, model, CAMERA, uniforms, vertex=lit.PLACED, **of
    )


def behind(sky):
    """The sky itself, seen along each pixel's ray, as far away as can be."""
    farthest = {"depth": Depth(func="lequal"), "depth_range": (1, 1)}
    return panel("ch13_skybox/skybox.frag", RAYS, textures={"skybox": sky}, **farthest)


def under(sky, size, name, **target):
    """All things under this sky."""
    draws = (behind(sky), *(thing(*one, sky) for one in THINGS))
    return picture(draws, size, name, depth="depth24", **target)


def seen(FragPos, Normal, cameraPos, ratio, base, sky):
    """What is mirrored and what shines through, each by its share."""
    through = textureLod(sky, bent(FragPos, Normal, cameraPos, ratio), 0.0)
    back = textureLod(sky, mirrored(FragPos, Normal, cameraPos), 0.0)
    return mix(through, back, fresnel(FragPos, Normal, cameraPos, base))


def ray(output, reference, eye, equals, name, **more):
    """One ray that meets a level surface in the origin."""
    at = {"FragPos": (0.0, 0.0, 0.0), "Normal": (0.0, 2.0, 0.0), "cameraPos": eye, **more}
    return figure(f"judged.{output}", name, at, equals, reference=reference)


DEPTH = {"depth": "scene.depth"}
NAMES = {1: "the ring", 2: "the ball", 3: "the vase"}

case = Case(
    title="Environment mapping",
    section="7.4",
    math=r"c = \mathbf n \cdot \mathbf i, \qquad \mathbf r = \mathbf i - 2 c\,\mathbf n, \qquad "
    r"\mathbf t = \eta\,\mathbf i - \left(\eta c + \sqrt{1 - \eta^2 (1 - c^2)}\right)\mathbf n",
    passes=(
        *twins(under(MORNING, (1536, 768), "scene", colors={"FragColor": "rgba32f"})),
        *softened_pass("scene", (768, 384), domain={}),
        *twins(under(NOISE, (112, 56), "judged")),
    ),
    picture="picture.FragColor",
    expect=[
        softened_check(),
        formula("judged.FragColor", sampled("skybox"), draw=0, name="the sky behind"),
        *map(any_order, ("scene.FragColor", "judged.FragColor", "judged.depth")),
        filled_check("scene"),
        measure("depth of the sky", lambda depth: depth.max(), reads=DEPTH, equals=1.0, digits=9),
        *each_draw("judged.mirrored", mirrored, NAMES, "mirrored in {}"),
        *each_draw("judged.bent", bent, NAMES, "bent by {}"),
        *each_draw("judged.share", fresnel, NAMES, "the share mirrored by {}"),
        *each_draw("judged.FragColor", seen, NAMES, "the colour of {}"),
        *each_draw("judged.Normal", world_normal, NAMES, "normals of {}"),
        *lit.vertex_stage_checks("gl_Position", "FragPos", pass_name="judged"),
        ray("mirrored", mirrored, (3.0, 4.0, 0.0), (-0.6, 0.8, 0.0), "mirrored from (3, 4, 0)"),
        ray("bent", bent, (3.0, 4.0, 0.0), (-0.394737, -0.918794, 0.0), "into glass"),
        ray("bent", bent, (4.0, 3.0, 0.0), (0.0, 0.0, 0.0), "53°: no way out of glass", ratio=1.52),
        ray("share", fresnel, (0.0, 2.0, 0.0), 0.04258, "straight at glass", base=GLASS),
        ray("share", fresnel, (1.0, 0.0, 0.0), 1.0, "grazing, all is mirrored", base=GLASS),
    ],
)
