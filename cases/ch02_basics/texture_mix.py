"""Two textures on one quad: mix(a, b, w) takes 1 − w of the first and w of the second.

Each sampler reads from a texture unit of its own. With a weight of 0.2 the crate shows through
the emblem that is painted on it; over red and blue it gives (0.8, 0, 0.2).

Look at: the sun, which is only faintly there, and how it takes the place of the wood in the curve
over the weight, in a straight line from one texture to the other.

Try: in `ch02_basics/texture_mix.frag` write `texture(texture2, TexCoords), 1.0 - mixValue` for
`texture(texture2, TexCoords), mixValue`: the emblem covers the crate.
"""

import numpy as np

from shaderlab import Case, Erratum, Pixel, Texture, Variant, assets, formula, gl_call, sweep, value
from shaderlab.engine.expectations.gl_call import call
from shaderlab.glslmath import mix
from shaderlab.glslmath.sampling import texture

from ..scenes import painted_textures
from ..scenes.api import limits
from ..scenes.draws import drawn
from ..scenes.figures import ground
from ..scenes.laws import device_place, unchanged
from ..scenes.panels import picture

GROUND = (0.2, 0.3, 0.3, 1.0)


def mixed(texture1, texture2, TexCoords, mixValue):
    """a·(1 − w) + b·w, texel by texel."""
    return mix(texture(texture1, TexCoords), texture(texture2, TexCoords), mixValue)


def one_texel(*color):
    """A texture that has the same colour everywhere."""
    return Texture(image=assets.solid(color))


RED, BLUE = one_texel(1.0, 0.0, 0.0, 1.0), one_texel(0.0, 0.0, 1.0, 1.0)
MIXED = drawn(
    "ch02_basics/texture_mix",
    assets.quad(size=1.8),
    {"mixValue": 0.2},
    only=("aPos", "aTexCoords"),
    textures={
        "texture1": Texture(image=painted_textures.crate),
        "texture2": Texture(image=painted_textures.emblem),
    },
)

case = Case(
    title="Mixing two textures",
    section="2.4.6",
    math=r"\operatorname{mix}(a, b, w) = a\,(1 - w) + b\,w",
    passes=(picture([MIXED], None, "main", clear=GROUND),),
    expect=[
        formula("gl_Position", device_place),
        formula("TexCoords", unchanged("aTexCoords")),
        formula("FragColor", mixed),
        ground("FragColor", GROUND),
        *limits({"textures that a fragment shader may read": ("GL_MAX_TEXTURE_IMAGE_UNITS", 16)}),
        gl_call("glActiveTexture", "GL_TEXTURE16", name="the seventeenth unit"),
        gl_call(
            "glGetIntegerv",
            "GL_ACTIVE_TEXTURE",
            before=(call("glActiveTexture", "GL_TEXTURE16"),),
            returns="GL_TEXTURE16",
            name="which is the active one then",
        ),
    ],
    errata=[
        Erratum(
            section="2.4.6",
            says="at most 16 textures are mixed",
            truth="16 is the least that OpenGL 3.3 lets a driver offer to a fragment shader, 48 to "
            "all stages together; GL_MAX_TEXTURE_IMAGE_UNITS tells how many it has",
            proof="the seventeenth unit",
        )
    ],
    variants=[
        Variant("crate and emblem"),
        Variant("half and half", {"mixValue": 0.5}),
        Variant(
            "red and blue",
            {"texture1": RED, "texture2": BLUE},
            expect=[
                value("FragColor", at=Pixel(32, 32), equals=(0.8, 0.0, 0.2, 1.0), digits=6),
                sweep(
                    "FragColor",
                    mixed,
                    over="mixValue",
                    values=np.linspace(0.0, 1.0, 21),
                    at={"TexCoords": (0.5, 0.5)},
                ),
            ],
        ),
        Variant(
            "weight 0 is the first",
            {"texture1": RED, "texture2": BLUE, "mixValue": 0.0},
            expect=[value("FragColor", at=Pixel(32, 32), equals=(1.0, 0.0, 0.0, 1.0), digits=6)],
        ),
    ],
)
