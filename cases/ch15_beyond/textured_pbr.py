"""Materials from textures: what a surface is, texel by texel.

A material of today (glTF's) is a few textures: a colour, which for a metal is what it reflects, and
roughness and metalness as two channels of one image. Each is multiplied by a factor: a white
texture leaves the factor as it is, and a texture of a single colour gives what the factor alone
would, to the bit. Colours are stored as a display expects them, and must be decoded once: the
sampler does it for sRGB formats, and a shader that raises them to 2.2 again makes them too dark.
Roughness and metalness are numbers, and are not decoded at all. A roughness of 0 makes the
well-known D of a halfway vector that faces straight 0 / 0, so it must be kept above.

Look at: a vase of blue glaze with gold laid in. One mesh, one material: only the textures know
where the gold is, and that the glaze is worn rough towards the foot.

Try: in `ch15_beyond/textured_pbr.frag` write `pow(texture(colorMap, TexCoords).rgb, vec3(2.2))` for
`texture(colorMap, TexCoords).rgb`: decoded twice, the glaze turns nearly black.
"""

import numpy as np

from shaderlab import Case, Mesh, Output, Texture, exact, formula, sweep
from shaderlab.glslmath import dot, max, normalize, swizzle, vec4
from shaderlab.glslmath.sampling import texture
from shaderlab.reference import microfacets

from ..scenes import lit
from ..scenes.cameras import camera, turned
from ..scenes.figures import results
from ..scenes.laws import unchanged
from ..scenes.panel_checks import smaller_check
from ..scenes.pottery import vase

EYE = (0.0, 1.5, 4.6)
CAMERA = camera(EYE, (0.0, 0.93, 0.0), 28.0)
LAMPS = [(-2.6, 3.6, 3.0), (3.0, 1.6, 2.4), (1.2, 3.0, -2.4)]
LIGHT = [(62.0, 58.0, 52.0), (16.0, 20.0, 30.0), (40.0, 34.0, 26.0)]
SMOOTH = {"filter": ("linear", "linear")}
MODEL = turned(20.0)
BLUE, GOLD = (0.10, 0.26, 0.55), (0.98, 0.80, 0.45)


def maps(size=512):
    """The vase's colour as a display wants it, and its roughness and metalness."""
    t, s = (np.mgrid[0:size, 0:size] + 0.5) / size
    bands = np.min([abs(t - at) for at in (0.16, 0.20, 0.62, 0.66, 0.97)], axis=0) < 0.008
    petal = abs(np.sin(10.0 * np.pi * s)) * 0.13
    petals = abs(abs(t - 0.41) - petal) < 0.012
    dots = np.hypot((20.0 * s) % 1.0 - 0.5, (t - 0.41) * 22.0) < 0.24
    gold = bands | petals | dots
    color = np.where(gold[..., None], GOLD, BLUE)
    rough = np.where(gold, 0.28, np.clip(0.72 - 0.9 * t, 0.18, 0.7))
    one = np.ones_like(t)
    surface = np.stack([0.0 * one, rough, 1.0 * gold, one], axis=-1)
    return np.concatenate([color, one[..., None]], axis=-1), surface


def decoded(code):
    """Light of a code of eight bits (IEC 61966-2-1), above the dark ones."""
    return ((code / 255.0 + 0.055) / 1.055) ** 2.4


def light_of(image):
    """Colours decoded, as the sampler does it."""
    return np.concatenate([decoded(255.0 * image[..., :3]), image[..., 3:]], axis=-1)


def one_texel(*values):
    """A texture that is the same everywhere, in floats."""
    return Texture(image=np.array(values, np.float32)[None, None])


WHITE = {"colorMap": one_texel(1.0, 1.0, 1.0, 1.0), "surfaceMap": one_texel(1.0, 1.0, 1.0, 1.0)}
ALIKE = {"colorMap": one_texel(0.3, 0.7, 0.2, 1.0), "surfaceMap": one_texel(0.0, 0.4, 0.6, 1.0)}
DRESSED = {
    "colorMap": Texture(image=lambda: maps()[0], format="srgb8_alpha8", **SMOOTH),
    "surfaceMap": Texture(image=lambda: maps()[1], format="rgba8", **SMOOTH),
}
FLOATS = {
    "colorMap": Texture(image=lambda: light_of(maps()[0]), **SMOOTH),
    "surfaceMap": Texture(image=lambda: maps()[1], **SMOOTH),
}
NO_FACTORS = {"color": (1.0, 1.0, 1.0), "roughness": 1.0, "metallic": 1.0}
FACTORS = {"color": (0.3, 0.7, 0.2), "roughness": 0.4, "metallic": 0.6}


def lamps(places, colors):
    """The lamps' uniforms."""
    named = {f"lights[{k}].position": place for k, place in enumerate(places)}
    return {**named, **{f"lights[{k}].color": color for k, color in enumerate(colors)}}


def thing(textures, factors, segments, rings):
    """The vase in a material."""
    uniforms = {"camPos": EYE, **lamps(LAMPS, LIGHT), **factors}
    of = {"vertex": lit.TEXTURED, "textures": textures}
    solid = Mesh(**vase(segments, rings))
    return lit.thing("ch15_beyond/textured_pbr.frag", solid, MODEL, CAMERA, uniforms, **of)


def small(name, textures, factors):
    """A pass of the vase, small."""
    return lit.photographed([thing(textures, factors, 24, 16)], name=name, size=(48, 48))[-1:]


def color_of(
    FragPos, Normal, TexCoords, colorMap, surfaceMap, color, roughness, metallic, camPos,
    lights_position, lights_color,
):  # fmt: skip
    """All lamps, on what the textures say."""
    albedo = color * swizzle(texture(colorMap, TexCoords), "rgb")
    surface = texture(surfaceMap, TexCoords)
    rough = max(roughness * swizzle(surface, "g"), 0.045)
    metal = metallic * swizzle(surface, "b")
    normal, view = normalize(Normal), normalize(camPos - FragPos)
    total = 0.12 * albedo
    for place, strength in zip(lights_position, lights_color, strict=True):
        ray = place - FragPos
        lit = reflected(normal, view, normalize(ray), albedo, metal, rough)
        total = total + lit * strength / dot(ray, ray)
    return vec4(total, 1.0)


def reflected(normal, view, light, albedo, metal, rough):
    """Of a lamp of strength 1; D as the shader has it, as nothing cancels then on smooth metal."""
    half = normalize(view + light)
    cosines = max(dot(normal, view), 0.0), max(dot(normal, light), 0.0)
    d, g = microfacets.distribution_of(normal, half, rough), microfacets.geometry(*cosines, rough)
    f = microfacets.fresnel(dot(half, view), microfacets.base_reflectance(albedo, metal))
    diffuse = (1.0 - f) * (1.0 - metal) * albedo / microfacets.PI
    return (diffuse + d * g * f / (4.0 * cosines[0] * cosines[1] + 0.0001)) * cosines[1]


def of_a_mirror():
    """Whether D of roughness 0, where the halfway vector faces straight, is no number."""
    with np.errstate(invalid="ignore"):
        return float(np.isnan(microfacets.distribution(np.array([1.0]), 0.0)).item())


DARK = (0.0, 0.0, 0.0)
# The viewer straight above a surface, and a lamp as far aside as the smoothest mirrors reflect it.
ASIDE = {
    "FragPos": (0.0, 0.0, 0.0), "Normal": (0.0, 0.0, 1.0), "TexCoords": (0.5, 0.5),
    "camPos": (0.0, 0.0, 2.0), "color": (1.0, 1.0, 1.0), "roughness": 0.0, "metallic": 0.0,
    **lamps([(0.01, 0.0, 1.0), LAMPS[1], LAMPS[2]], [(1.0, 1.0, 1.0), DARK, DARK]),
}  # fmt: skip

OVER = np.linspace(0.0, 0.3, 13)
VASES = [thing(DRESSED, NO_FACTORS, 96, 64)], [thing(FLOATS, NO_FACTORS, 24, 16)]

case = Case(
    title="Materials from textures",
    section="15.17",
    math=r"a = a_f\,\mathrm{decode}(a_t), \qquad r = \max(r_f\,r_t, 0.045), \qquad f_0 = "
    r"\operatorname{mix}(0.04, a, m_f\,m_t)",
    passes=(
        *lit.photographed(*VASES, clear=(0.30, 0.27, 0.24, 1.0), size=(64, 64), side=768),
        *small("factors", WHITE, FACTORS),
        *small("alike", ALIKE, NO_FACTORS),
    ),
    picture="picture.FragColor",
    expect=[
        *lit.vertex_stage_checks(pass_name="judged"),
        formula("judged.TexCoords", unchanged("aTexCoords")),
        formula("judged.FragColor", color_of, name="glaze and gold"),
        formula("factors.FragColor", color_of, name="factors alone"),
        exact("alike.FragColor", Output("factors.FragColor"), name="a texture of one colour"),
        *lit.picture_checks(),
        smaller_check("judged", "scene", edges=0.1),
        sweep("factors.FragColor", color_of, over="roughness", values=OVER, at=ASIDE, name="rough"),
        *results(
            {
                "code 188, decoded once": (lambda: decoded(188.0), 0.502886),
                "decoded twice": (lambda: decoded(188.0) ** 2.2, 0.220411),
                "D of a mirror is no number": (of_a_mirror, 1.0),
            }
        ),
    ],
)  # fmt: skip
