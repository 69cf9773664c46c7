"""Gamma: a display does not show twice the light for twice the number.

A pixel value v becomes roughly v^2.2 of the display's light, which spends the 256 steps where the
eye can tell them apart. A shader calculates with light, so its result has to be encoded at the end,
by the power 1/2.2 or by the exact sRGB curve. An sRGB framebuffer does the latter by itself, and an
sRGB texture undoes it when it is read: whichever half the shader does, all 256 codes come back.

Look at: the stripes, at full size and from a few steps away. The dithered ones mix black and white
dots, so their light is right on any display. The middle stripe is encoded and matches them; the
outer ones are raw numbers, and too dark. Half of the dots white is a grey of 188, not of 128. (A
smaller picture mixes numbers instead of light, and then the outer stripes seem to match.)

Try: in `lib/gamma.glsl` write `pow(linear, 1.0 / 2.2)` for `1.055 * pow(linear, 1.0 / 2.4) -
0.055`: that is too near for an eye, but not for the checks.
"""

import numpy as np

from shaderlab import Case, Ramp, Texture, across, assets, boundaries, exact, formula, sweep, up
from shaderlab.glslmath import abs, floor, step, vec3, vec4, where
from shaderlab.reference.gamma import gamma_encode, srgb_decode, srgb_encode

from ..scenes.colour_science import srgb_by_colour_science
from ..scenes.drawing import bayer_threshold
from ..scenes.figures import figure, figures, results
from ..scenes.laws import renamed
from ..scenes.panels import WHOLE, panel, panel_pass, picture

CODES = np.arange(256) / 255.0
# Each channel in an order of its own, so that no two of them can be taken for one another.
ALL_CODES = np.stack([CODES, CODES[::-1], np.roll(CODES, 85), np.ones(256)], axis=-1)[None]
CODE_BY_CODE = np.rint(ALL_CODES * 255.0).astype(np.uint8)
GREY_BY_GREY = CODE_BY_CODE[..., [0, 0, 0, 3]]

SRGB_TEXTURE = Texture(image=ALL_CODES, format="srgb8_alpha8")
FLOAT_TEXTURE = Texture(image=ALL_CODES, format="rgba32f")
CHECKS = assets.checker(size=2, cells=2, dark=(0, 0, 0, 1), light=(1, 1, 1, 1))
BLACK_AND_WHITE = Texture(image=CHECKS, format="srgb8_alpha8", filter=("linear", "linear"))
RAMP = {"linear": across(0.0, 1.0)}
STRIPES = {**RAMP, "stripe": up(0.0, 5.0)}
LIGHT = {
    f"light of code {code}": ({"code": code + 0.5}, (light, light, light, 1.0))
    for code, light in ((8, 0.002428), (128, 0.215861))
}
MIDDLE = {"TexCoords": Ramp((0.5, 0.5))}


# The shader puts the same ramp through the way back.
decode = renamed(srgb_decode, encoded="linear")


def converted(shader, name, format="srgb8_alpha8", domain=WHOLE, **inputs):
    """256 codes through one of the shaders into a framebuffer; sRGB ones encode."""
    fragment, encodes = f"ch05_lighting/{shader}.frag", format.startswith("srgb")
    draw = panel(fragment, domain, srgb=encodes, **inputs)
    return picture([draw], (256, 16), name, colors={"FragColor": format})


def around(threshold):
    """The whole range, and closely where the line meets the curve: they are so alike there that a
    threshold 1 % too low shows within that 1 % only, and 0.00313, as some write it, just below."""
    near = np.concatenate([np.linspace(0.965, 1.3, 68), np.linspace(0.99978, 0.99997, 7)])
    return np.sort(np.concatenate([np.geomspace(0.0005, 1.0, 64), threshold * near]))


def stripes(linear, stripe, frag_coord):
    """The picture: light in 24 steps, raw outside, encoded in the middle, dithered between."""
    light = (floor(linear * 24.0) + 0.5) / 24.0
    band = abs(floor(stripe) - 2.0)
    dithered = step(bayer_threshold(frag_coord), light)
    shown = where(band < 0.5, srgb_encode(light), where(band < 1.5, dithered, light))
    return vec4(vec3(1.0) * shown, 1.0)


case = Case(
    title="Gamma correction",
    section="5.8",
    math=r"v = c^{1/2.2}, \qquad v_{\mathrm{sRGB}} = \begin{cases} 12.92\,c & c \le 0.0031308 \\"
    r" 1.055\,c^{1/2.4} - 0.055 & \text{otherwise} \end{cases}",
    passes=(
        panel_pass("picture", "ch05_lighting/gamma_picture.frag", STRIPES),
        converted("gamma_framebuffer", "framebuffer", domain={"code": across(0.0, 256.0)}),
        converted("gamma_encoded", "texture", "rgba8", textures={"image": SRGB_TEXTURE}),
        converted("gamma_texture", "there-and-back", textures={"image": SRGB_TEXTURE}),
        converted("gamma_texture", "floats", "rgba32f", textures={"image": FLOAT_TEXTURE}),
        converted("gamma_texture", "dither", domain=MIDDLE, textures={"image": BLACK_AND_WHITE}),
        panel_pass("main", "ch05_lighting/gamma.frag", RAMP, {"gamma": 2.2}),
    ),
    picture="picture.FragColor",
    expect=[
        formula("picture.FragColor", stripes, name="the picture"),
        boundaries("picture.FragColor", stripes, name="the stripes' edges"),
        formula("power", gamma_encode),
        formula("srgb", srgb_encode, also={"colour-science": srgb_by_colour_science}),
        formula("decoded", decode),
        figure("power", "half, by the power", {"linear": 0.5}, 0.729740),
        figure("srgb", "half, by sRGB", {"linear": 0.5}, 0.735357),
        sweep("power", gamma_encode, over="linear", values=np.linspace(0.005, 1.0, 64)),
        sweep("srgb", srgb_encode, over="linear", values=around(0.0031308), log_x=True),
        sweep("decoded", decode, over="linear", values=around(0.04045), log_x=True),
        *figures("framebuffer.FragColor", LIGHT),
        exact("framebuffer.FragColor", GREY_BY_GREY, name="an sRGB framebuffer encodes"),
        exact("texture.FragColor", CODE_BY_CODE, name="an sRGB texture decodes"),
        # Light that is .2 % more has the same code; 32 bits tell.
        exact("floats.FragColor", ALL_CODES.astype(np.float32), name="floats stay as they are"),
        exact("there-and-back.FragColor", CODE_BY_CODE, name="both together change nothing"),
        formula("dither.FragColor", lambda: vec4(vec3(0.5), 1.0), name="half of the pixels white"),
        *results({"… is a grey of": (255.0 * srgb_encode(0.5), 188.0)}, digits=0),
    ],
)
