"""A textured quad: each corner says where in the image it lies, and the texels follow.

Texture coordinates are an attribute like any other. The vertex shader hands them on, rasterising
mixes them from corner to corner, and the fragment shader asks the sampler for the texel that is
there. Corners may carry a colour as well: multiplied, texel and colour tint each other, and white
leaves the texel as it is.

Look at: the crate on the left as it is, all of its corners white. On the right its corners are
red, green, blue and yellow, and the same planks take the colour of the corner that is nearest.
"""

import numpy as np

from shaderlab import Case, Draw, Mesh, Pass, Target, Texture, assets, coverage, formula, value
from shaderlab.glslmath import vec4
from shaderlab.sampling import texture

from ..scenes.figures import each_draw
from ..scenes.panels import enlarged, enlarged_check

PLACES = np.array([(0.5, 0.5, 0.0), (0.5, -0.5, 0.0), (-0.5, -0.5, 0.0), (-0.5, 0.5, 0.0)])
CORNERS = np.array([(1.0, 1.0), (1.0, 0.0), (0.0, 0.0), (0.0, 1.0)])
TINTS = np.array([(1.0, 0.45, 0.4), (0.45, 1.0, 0.45), (0.45, 0.6, 1.0), (1.0, 1.0, 0.4)])
NOISE = np.random.default_rng(246).random((8, 8, 4))


def square(colors, scale=(1.0, 1.0, 1.0), offset=(0.0, 0.0, 0.0)):
    """The notes' quad, with a colour at each corner."""
    return Mesh(
        attributes={
            "aPos": PLACES * np.array(scale) + np.array(offset),
            "aColor": colors,
            "aTexCoord": CORNERS,
        },
        indices=np.array([0, 1, 3, 1, 2, 3]),
    )


def textured(mesh, image):
    """One quad with one texture."""
    return Draw(
        vertex="ch02_basics/textured_quad.vert",
        fragment="ch02_basics/textured_quad.frag",
        mesh=mesh,
        textures={"ourTexture": Texture(image=image)},
    )


def tinted(ourTexture, TexCoord, ourColor):
    """Texel times colour, channel by channel."""
    return texture(ourTexture, TexCoord) * vec4(ourColor, 1.0)


def in_place(aPos):
    """Positions are device coordinates already."""
    return vec4(aPos, 1.0)


def colors_handed_on(aColor):
    """The vertex shader changes no colour."""
    return aColor


def places_handed_on(aTexCoord):
    """Nor a texture coordinate."""
    return aTexCoord


case = Case(
    title="A textured quad",
    section="2.4.6",
    math=r"\text{FragColor} = \tau(s, t) \cdot \text{ourColor}",
    passes=(
        *enlarged(
            (
                textured(square(TINTS * 0.0 + 1.0, (0.86, 1.72, 1.0), (-0.5, 0, 0)), assets.crate),
                textured(square(TINTS, (0.86, 1.72, 1.0), (0.5, 0, 0)), assets.crate),
            ),
            (112, 56),
            9,
            clear=(0.16, 0.19, 0.22, 1.0),
        ),
        Pass(name="judged", target=Target(size=(64, 64)), draws=(textured(square(TINTS), NOISE),)),
    ),
    picture="picture.FragColor",
    expect=[
        enlarged_check(),
        *each_draw("small.FragColor", tinted, {0: "in white light", 1: "in four colours"}),
        coverage(1024, pass_name="judged", name="the quad covers a quarter of 64 × 64"),
        formula("judged.gl_Position", in_place),
        formula("judged.ourColor", colors_handed_on),
        formula("judged.TexCoord", places_handed_on),
        formula("judged.FragColor", tinted),
        *(
            value(
                "judged.FragColor",
                at={"TexCoord": tuple((corner * 7.0 + 0.5) / 8.0), "ourColor": (1.0, 1.0, 1.0)},
                equals=NOISE[tuple((corner[::-1] * 7).astype(int))].tolist(),
                digits=6,
                name=f"the corner ({corner[0]:g}, {corner[1]:g}) in white light",
            )
            for corner in CORNERS
        ),
        value(
            "judged.FragColor",
            at={"TexCoord": (0.5625, 0.5625), "ourColor": (0.0, 0.0, 0.0)},
            equals=(0.0, 0.0, 0.0, NOISE[4, 4, 3]),
            digits=6,
            name="black leaves alpha alone",
        ),
    ],
)
