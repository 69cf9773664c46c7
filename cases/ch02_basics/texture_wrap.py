"""Wrap modes: what a texture shows outside of 0…1.

GL_REPEAT drops the integer part, so that the image begins anew at each integer. GL_MIRRORED_REPEAT
turns every other copy round. GL_CLAMP_TO_EDGE goes on with the outermost texel, and
GL_CLAMP_TO_BORDER with a colour of one's own; with GL_LINEAR the edge is mixed with that colour
over a texel's width. It is texels that are wrapped, by their numbers, not coordinates: so LINEAR
mixes across the seam, from the last texel to the first. A texture in three dimensions is a stack
of layers, with a wrap mode for r, the third coordinate, as well.

Look at: one image and u and v from −1.5 to 2.5, so that it fits four times. From left to right
stand REPEAT, MIRRORED_REPEAT, CLAMP_TO_EDGE and CLAMP_TO_BORDER, below with NEAREST and above with
LINEAR. Where copies meet, LINEAR blurs under REPEAT and has nothing to blur under the mirror.
"""

import numpy as np

from shaderlab import Case, Target, Texture, assets, formula, fullscreen, gl_call
from shaderlab.expectations.gl_call import Object, call
from shaderlab.reference.filtering import linear_sample

from ..scenes.figures import each_draw, figure
from ..scenes.laws import sampled
from ..scenes.panels import cell, enlarged, enlarged_check, panel, picture, square

WRAPS = ("repeat", "mirrored_repeat", "clamp_to_edge", "clamp_to_border")
FIELDS = [(word, wrap) for word in ("nearest", "linear") for wrap in WRAPS]

# The picture's image, and one of 5 × 3 texels that are all different, to be judged.
CHART = assets.uv_grid(64, 4)
TEXELS = np.random.default_rng(24).random((3, 5, 4))
# Two texels side by side, in three layers.
TEXELS_3D = bytes(range(24))
VOLUME = (
    call("glBindTexture", "GL_TEXTURE_3D", Object("texture")),
    call(
        "glTexImage3D",
        *("GL_TEXTURE_3D", 0, "GL_RGBA8", 2, 1, 3, 0, "GL_RGBA", "GL_UNSIGNED_BYTE", TEXELS_3D),
    ),
)
BORDER = (0.93, 0.55, 0.20, 1.0)


def wrapped(image):
    """Every wrap mode with every filter, in a field of its own."""
    for k, (word, wrap) in enumerate(FIELDS):
        texels = Texture(image=image, wrap=(wrap, wrap), filter=(word, word), border=BORDER)
        domain, textures = {"TexCoords": square(-1.497, 2.503)}, {"image": texels}
        yield panel("ch02_basics/textured.frag", domain, textures=textures, cell=cell(k, 4, 2))


def texels(name, wrap, row, word="nearest"):
    """A row of texels, for printed figures."""
    image = Texture(
        image=np.array(row)[None, :, None] * np.ones(4),
        wrap=(wrap, "repeat"),
        filter=(word, word),
        border=(1.0, 1.0, 1.0, 1.0),
    )
    return fullscreen(
        "ch02_basics/textured.frag",
        name=name,
        textures={"image": image},
        target=Target(size=(8, 1)),
    )


def at(name, u, equals, label):
    """What stands at u."""
    point = {"TexCoords": (u, 0.5)}
    return figure(f"{name}.FragColor", label, point, (equals,) * 4, reference=sampled("image"))


case = Case(
    title="Wrap modes",
    section="2.4.2",
    math=r"\text{repeat: } i \bmod n, \qquad \text{mirror: } (n - 1) - "
    r"\operatorname{mir}\bigl((i \bmod 2n) - n\bigr), \qquad "
    r"\text{edge: } \operatorname{clamp}(i, 0, n - 1)",
    passes=(
        *enlarged(wrapped(CHART), (116, 58), 9),
        # 40 and 32 pixels over 20 and 12 texels: none of them lies on a texel's edge or centre.
        picture(wrapped(TEXELS), (160, 64), "judged"),
        *texels("repeat", "repeat", (0.25, 0.75)),
        *texels("mirror", "mirrored_repeat", (0.25, 0.75)),
        *texels("edge", "clamp_to_edge", (0.25, 0.75)),
        *texels("border", "clamp_to_border", (10.0, 20.0, 30.0, 40.0), "linear"),
    ),
    picture="picture.FragColor",
    expect=[
        enlarged_check(),
        *each_draw(
            "small.FragColor",
            sampled("image"),
            {k: f"the chart, {wrap}, {word}" for k, (word, wrap) in enumerate(FIELDS)},
        ),
        *(
            formula(
                "judged.FragColor",
                sampled("image"),
                draw=k,
                name=f"{wrap}, {word}",
                also={"equation 8.17": linear_sample} if word == "linear" else {},
            )
            for k, (word, wrap) in enumerate(FIELDS)
        ),
        gl_call(
            "glGetTexImage",
            *("GL_TEXTURE_3D", 0, "GL_RGBA", "GL_UNSIGNED_BYTE"),
            before=VOLUME,
            returns=tuple(TEXELS_3D),
            name="a texture in three dimensions keeps its layers",
        ),
        gl_call(
            "glGetTexLevelParameteriv",
            *("GL_TEXTURE_3D", 0, "GL_TEXTURE_DEPTH"),
            before=VOLUME,
            returns=3,
            name="it has a depth",
        ),
        gl_call(
            "glTexParameteri",
            *("GL_TEXTURE_3D", "GL_TEXTURE_WRAP_R", "GL_MIRRORED_REPEAT"),
            before=VOLUME,
            name="and a third wrap mode, R",
        ),
        gl_call(
            "glTexImage2D",
            *("GL_TEXTURE_3D", 0, "GL_RGBA8", 1, 1, 0, "GL_RGBA", "GL_UNSIGNED_BYTE", None),
            before=VOLUME[:1],
            raises="invalid_enum",
            name="no image in two dimensions fits it: 0x0500",
        ),
        *(
            formula(f"{name}.FragColor", sampled("image"), name=f"a row of texels, {name}")
            for name in ("repeat", "mirror", "edge", "border")
        ),
        at("repeat", -0.25, 0.75, "REPEAT: −0.25 is 0.75"),
        at("repeat", 1.25, 0.25, "REPEAT: 1.25 is 0.25"),
        at("mirror", 1.25, 0.75, "MIRRORED_REPEAT: 1.25 is 0.75"),
        at("mirror", -0.25, 0.25, "MIRRORED_REPEAT: −0.25 is 0.25"),
        at("edge", -7.25, 0.25, "CLAMP_TO_EDGE: the first texel"),
        at("edge", 7.25, 0.75, "CLAMP_TO_EDGE: the last texel"),
        at("border", -0.05, 3.7, "LINEAR towards a border of 1, at −0.05"),
        at("border", 1.05, 12.7, "LINEAR towards a border of 1, at 1.05"),
    ],
)
