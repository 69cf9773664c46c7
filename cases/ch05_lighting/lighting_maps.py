"""Lighting maps: a texture for the colour, and one for where the surface shines.

A chest is neither wood nor iron, it is both. So a material's colours come from textures: the
diffuse map is the picture painted on it (the ambient part uses it, too), and the specular map says
how much each place reflects, dark for wood and bright for iron. The two samplers are members of the
struct, bound to units 0 and 1.

Look at: the lantern's highlight on each chest. On the left it lies on the iron bands and the rivets
only, and stops where the wood begins, in the middle of one flat face. The chest on the right has no
specular map: its highlight lies on wood and iron alike, as if everything were under glass.

Try: in `ch05_lighting/lighting_maps.frag` write `vec3(1.0)` for `texture(material.specular,
TexCoords).rgb`: wood and floor shine as if under glass.
"""

from dataclasses import replace

import numpy as np

from shaderlab import Case, Mesh, State, Texture, assets, formula, gl_calls
from shaderlab.glslmath import swizzle, vec4
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.lighting import diffuse_factor, specular_factor
from shaderlab.reference.transforms import clip_position, translate

from ..scenes import lit
from ..scenes.cameras import camera, turned
from ..scenes.chest import chest_diffuse, chest_specular
from ..scenes.figures import each_draw, figures
from ..scenes.panels import picture

EYE = (0.1, 1.7, 5.8)
LAMP = (0.1, 0.5, 1.55)
LIGHT = {
    "viewPos": EYE,
    "light.position": LAMP,
    "light.ambient": (0.06, 0.07, 0.09),
    "light.diffuse": (0.75, 0.66, 0.5),
    "light.specular": (1.2, 1.08, 0.85),
}
CAMERA = camera(EYE, (0.05, 0.55, 0.0), 31.0, far=60.0)
CHEST = Mesh(**assets.cube(1.25))
FLOOR = Mesh(**assets.plane(30.0, repeat=12.0))
# A hair above the floor, so that nowhere both are equally near.
WITH_MAP = translate((-0.86, 0.626, 0.2)) @ turned(24.0)
WITHOUT = translate((1.05, 0.626, 0.0)) @ turned(-28.0)

CHEST_DIFFUSE = Texture(image=lambda: chest_diffuse(512))
CHEST_SPECULAR = Texture(image=lambda: chest_specular(512))
TILES = Texture(image=assets.checker(dark=(0.06, 0.065, 0.075, 1), light=(0.12, 0.12, 0.13, 1)))
DULL = Texture(image=assets.solid((0.03, 0.03, 0.03, 1.0)))
SHINY = Texture(image=assets.solid((0.45, 0.45, 0.45, 1.0)))
# Four texels, each of another colour, so that a coordinate can be told from its mirror image.
FOUR = np.array(
    [[(0.8, 0.4, 0.2, 1), (0.2, 0.8, 0.4, 1)], [(0.4, 0.2, 0.8, 1), (0.6, 0.6, 0.1, 1)]]
)


def thing(mesh, model, diffuse, specular, shininess):
    """One thing with its two maps, in the lantern's light."""
    shader, uniforms = (
        "ch05_lighting/lighting_maps.frag",
        {**LIGHT, "material.shininess": shininess},
    )
    maps = {"material.diffuse": diffuse, "material.specular": specular}
    return lit.thing(shader, mesh, model, CAMERA, uniforms, vertex=lit.TEXTURED, textures=maps)


# Only run on single points, so no depth test has a say.
FOUR_TEXELS = replace(
    thing(CHEST, WITH_MAP, Texture(image=FOUR), Texture(image=FOUR[::-1]), 4.0), state=State()
)


def highlight(
    FragPos, Normal, TexCoords, viewPos, material_specular, material_shininess,
    light_position, light_specular,
):  # fmt: skip
    """The specular part, where the map lets it."""
    spec = specular_factor(FragPos, Normal, light_position, viewPos, material_shininess)
    return light_specular * spec * swizzle(texture(material_specular, TexCoords), "rgb")


def color(
    FragPos, Normal, TexCoords, viewPos, material_diffuse, material_specular, material_shininess,
    light_position, light_ambient, light_diffuse, light_specular,
):  # fmt: skip
    """All three parts, two of them through the diffuse map."""
    diff = diffuse_factor(FragPos, Normal, light_position)
    painted = swizzle(texture(material_diffuse, TexCoords), "rgb")
    shine = highlight(
        FragPos, Normal, TexCoords, viewPos, material_specular, material_shininess,
        light_position, light_specular,
    )  # fmt: skip
    return vec4((light_ambient + light_diffuse * diff) * painted + shine, 1.0)


POINT = {
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 0.0, 3.0),  # of no unit length, as scaling leaves it
    "TexCoords": (0.25, 0.25),
    "viewPos": (0.0, 0.0, 3.0),
    "light.position": lit.POINT_LAMP,
    **lit.POINT_LIGHT,
}
ASIDE = {
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 0.0, 1.0),
    "TexCoords": (0.25, 0.25),
    "viewPos": lit.ASIDE,
    "light.position": lit.POINT_LAMP,
    "light.specular": (1.0, 1.0, 1.0),
    "material.shininess": 0.5,
}

BELOW = {**lit.GRAZING, "light.position": lit.BELOW, "material.shininess": 8.0}
HIGHLIGHTS = {1: "of the floor", 2: "without a map", 3: "with one"}
COLOURS = {1: "of the floor", 2: "without a specular map", -1: "with both maps"}

case = Case(
    title="Lighting maps",
    section="5.4",
    math=r"C = (L_a + d\,L_d) \odot T_{\text{diffuse}}(u, v) + "
    r"s\,L_s \odot T_{\text{specular}}(u, v)",
    passes=(
        *lit.photographed(
            (
                lit.bulb(LAMP, (1.0, 0.92, 0.72), 0.07, CAMERA),
                thing(FLOOR, translate((0.0, 0.0, 0.0)), TILES, DULL, 8.0),
                thing(CHEST, WITHOUT, CHEST_DIFFUSE, SHINY, 16.0),
                thing(CHEST, WITH_MAP, CHEST_DIFFUSE, CHEST_SPECULAR, 16.0),
            ),
            clear=(0.004, 0.005, 0.008, 1.0),
        ),
        lit.glow((1.0, 0.92, 0.72)),
        picture([FOUR_TEXELS], (16, 16), "four"),
    ),
    picture="picture.FragColor",
    expect=[
        *lit.vertex_stage_checks("gl_Position", pass_name="judged"),
        formula("judged.gl_Position", clip_position, draw=0, name="where the lantern is"),
        formula("judged.FragColor", lit.glowing, draw=0, name="colour of the lantern"),
        *lit.vertex_stage_checks("FragPos", "Normal", "TexCoords", pass_name="judged"),
        *each_draw("judged.highlight", highlight, HIGHLIGHTS, "highlight {}"),
        *each_draw("judged.FragColor", color, COLOURS, "colour {}"),
        lit.glow_check(),
        *lit.picture_checks(),
        *figures(
            "four.FragColor",
            {
                f"the point at {at}": ({"TexCoords": at}, equals)
                for at, equals in (
                    ((0.25, 0.25), (0.629559, 0.314780, 0.427441, 1.0)),
                    ((0.75, 0.25), (0.350284, 0.706717, 0.276201, 1.0)),
                    ((0.25, 0.75), (0.546252, 0.273126, 0.552402, 1.0)),
                )
            },
            at=POINT,
            reference=color,
        ),
        *(
            gl_calls("glUniform1i", **told, pass_name="four", name=name)
            for name, told in {
                "one sampler is told unit 0": {"v0": 0, "times": 1},
                "one sampler is told unit 1": {"v0": 1, "times": 1},
                "and there are two": {"times": 2},
            }.items()
        ),
        *figures(
            "four.highlight",
            {
                "nearly 90° from the mirrored ray": (ASIDE, (0.028430, 0.014215, 0.056860)),
                lit.TURNED_AWAY: ({**ASIDE, **BELOW}, (0.0, 0.0, 0.0)),
            },
            reference=highlight,
        ),
    ],
)
