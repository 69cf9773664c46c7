"""A textured quad: each corner says where in the image it lies, and the texels follow.

Texture coordinates are an attribute like any other. The vertex shader passes them on, rasterisation
interpolates them from corner to corner, and the fragment shader samples the texture there. Corners
may carry a colour as well: multiplied, texel and colour tint each other, and white leaves the texel
as it is.

Look at: the crate on the left as it is, all of its corners white. On the right its corners are red,
green, blue and yellow, and the same planks take the colour of the corner that is nearest.

Try: in `ch02_basics/textured_quad.frag` write `texture(ourTexture, 2.0 * TexCoord)` for
`texture(ourTexture, TexCoord)`: four crates, each half as wide and half as high.
"""

import numpy as np

from shaderlab import Case, Mesh, Texture, coverage, formula
from shaderlab.glslmath import vec4
from shaderlab.glslmath.sampling import texture

from ..scenes import painted_textures
from ..scenes.draws import drawn
from ..scenes.figures import each_draw, figure, figures
from ..scenes.laws import device_place, unchanged
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import enlarged, picture

PLACES = np.array([(0.5, 0.5, 0.0), (0.5, -0.5, 0.0), (-0.5, -0.5, 0.0), (-0.5, 0.5, 0.0)])
CORNERS = np.array([(1.0, 1.0), (1.0, 0.0), (0.0, 0.0), (0.0, 1.0)])
TINTS = np.array([(1.0, 0.45, 0.4), (0.45, 1.0, 0.45), (0.45, 0.6, 1.0), (1.0, 1.0, 0.4)])
# 48 of 56 pixels: corners are on every driver's grid, in the small picture and in the large one.
SIZE = (6 / 7, 12 / 7, 1.0)
# Five texels a pixel: pixels lie in the middles of texels, where all drivers read the same one.
CRATE = painted_textures.crate(240)
NOISE = np.random.default_rng(246).random((8, 8, 4))


def square(colors, scale=(1.0, 1.0, 1.0), offset=(0.0, 0.0, 0.0)):
    """A quad with a colour at each corner."""
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
    return drawn("ch02_basics/textured_quad", mesh, textures={"ourTexture": Texture(image=image)})


def tinted(ourTexture, TexCoord, ourColor):
    """Texel times colour, channel by channel."""
    return texture(ourTexture, TexCoord) * vec4(ourColor, 1.0)


case = Case(
    title="A textured quad",
    section="2.4.6",
    math=r"\text{FragColor} = \tau(s, t) \cdot \text{ourColor}",
    passes=(
        *enlarged(
            (
                textured(square(TINTS * 0.0 + 1.0, SIZE, (-0.5, 0, 0)), CRATE),
                textured(square(TINTS, SIZE, (0.5, 0, 0)), CRATE),
            ),
            (112, 56),
            9,
            clear=(0.16, 0.19, 0.22, 1.0),
        ),
        picture([textured(square(TINTS), NOISE)], (64, 64), "judged"),
    ),
    picture="picture.FragColor",
    expect=[
        enlarged_check(),
        *each_draw("small.FragColor", tinted, {0: "in white light", 1: "in four colours"}),
        coverage(1024, pass_name="judged", name="the quad covers a quarter of 64 × 64"),
        formula("judged.gl_Position", device_place),
        formula("judged.ourColor", unchanged("aColor")),
        formula("judged.TexCoord", unchanged("aTexCoord")),
        formula("judged.FragColor", tinted),
        *figures(
            "judged.FragColor",
            {
                f"the corner ({corner[0]:g}, {corner[1]:g}) in white light": (
                    {"TexCoord": tuple((corner * 7.0 + 0.5) / 8.0), "ourColor": (1.0, 1.0, 1.0)},
                    NOISE[tuple((corner[::-1] * 7).astype(int))].tolist(),
                )
                for corner in CORNERS
            },
        ),
        figure(
            "judged.FragColor",
            "black leaves alpha alone",
            {"TexCoord": (0.5625, 0.5625), "ourColor": (0.0, 0.0, 0.0)},
            (0.0, 0.0, 0.0, NOISE[4, 4, 3]),
        ),
    ],
)
