"""Filtering: what a texture shows between its texels.

A texel is a sample at its centre. GL_NEAREST takes the texel that the point lies in. GL_LINEAR
mixes the four whose centres are around it, by how near they are: along s first, then along t. The
centre of texel i of n is at (i + ½)/n, so half a texel is subtracted before the weights are
computed. The hardware decides how precise the weights are: 8 bits are usual, and the band is as
wide as that. A texture has two filters: GL_TEXTURE_MAG_FILTER where a pixel covers less than a
texel, and GL_TEXTURE_MIN_FILTER where it covers more. Here each texture minifies with the word that
it does not magnify with.

Look at: the same small fruit, of 12 × 12 texels, with NEAREST on the left and LINEAR on the right.
In the row below are five texels of one line: steps, and straight ramps from centre to centre that
stay level outside of the outermost.

Try: in `ch02_basics/textured.frag` write `texture(image, (floor(12.0 * TexCoords) + 0.5) / 12.0)`
for `texture(image, TexCoords)`: every pixel reads at the centre of a texel, so both fruits look
alike.
"""

import numpy as np

from shaderlab import Case, Erratum, Target, Texture, formula, fullscreen, gl_call
from shaderlab.engine.expectations.gl_call import Object, call
from shaderlab.glslmath import swizzle, vec2
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.filtering import linear_sample

from ..scenes.figures import each_draw, figure, figures
from ..scenes.panels import WHOLE, cell, panel, picture

FRUIT = (
    "......##....",
    ".....#......",
    "....##......",
    "..rrrrrrrr..",
    ".rwwrrrrrrr.",
    "rrwrrrrrrrrr",
    "rrrrrrrrrrrr",
    "rrrrrrrrrrdr",
    ".rrrrrrrrddr",
    ".rrrrrrrrdr.",
    "..rrrrrrdd..",
    "...rrr.rr...",
)
INK = {
    ".": (0.93, 0.92, 0.88), "#": (0.28, 0.42, 0.16), "r": (0.83, 0.19, 0.16),
    "w": (1.00, 0.86, 0.78), "d": (0.58, 0.08, 0.14),
}  # fmt: skip
APPLE = np.array([[(*INK[c], 1.0) for c in line] for line in reversed(FRUIT)])
LINE = np.array([[0.1, 0.9, 0.35, 0.6, 0.2]])[..., None] * np.ones(4)
TEXELS = np.random.default_rng(243).random((4, 5, 4))
WORDS = ("nearest", "linear")


def filtered(image, word):
    """A texture that one filter magnifies and the other minifies, and that ends at its edges."""
    other = WORDS[1 - WORDS.index(word)]
    return Texture(image=image, filter=(other, word), wrap=("clamp_to_edge", "clamp_to_edge"))


def magnified(image, word, **state):
    """A texture over one field of the target, much larger than it is."""
    textures = {"image": filtered(image, word)}
    return panel("ch02_basics/textured.frag", WHOLE, textures=textures, **state)


def line_of(word):
    """Five texels in a row, for the curves."""
    return fullscreen(
        "ch02_basics/textured.frag",
        name=f"line-{word}",
        textures={"image": filtered(LINE, word)},
        target=Target(size=(64, 1)),
    )


def sampled(image, TexCoords):
    """The specification's equations. A pixel covers less than a texel: the level is below 0."""
    return texture(image, TexCoords, lod=-1.0)


def minified(image, TexCoords):
    """The same where a pixel covers more than a texel."""
    return texture(image, TexCoords, lod=1.0)


def in_place(left, bottom, width, height):
    """The same by the pixel's place in the picture, which has the texture in this rectangle."""

    def seen(image, frag_coord):
        from_corner = swizzle(frag_coord, "xy") - vec2(left, bottom)
        return texture(image, from_corner / vec2(width, height), lod=-1.0)

    return seen


def default_of(parameter, number):
    """What a texture says of one of its filters before it is told any."""
    return gl_call(
        "glGetTexParameteriv",
        "GL_TEXTURE_2D",
        parameter,
        before=[call("glBindTexture", "GL_TEXTURE_2D", Object("texture"))],
        returns=number,
        name=f"the default of {parameter}",
    )


PLACES = [(320 * k, 80, 320, 320) for k in range(2)]
BEFORE_A_CENTRE = {"TexCoords": (0.25, 0.5)}

case = Case(
    title="Nearest and linear filtering",
    section="2.4.3",
    math=r"\tau = (1-\alpha)(1-\beta)\,\tau_{i_0 j_0} + \alpha(1-\beta)\,\tau_{i_1 j_0} + "
    r"(1-\alpha)\beta\,\tau_{i_0 j_1} + \alpha\beta\,\tau_{i_1 j_1}, \qquad "
    r"\alpha = \operatorname{frac}(s\,w - \tfrac12)",
    passes=(
        picture(
            (
                *(magnified(LINE, word, cell=cell(k, 2, 5)) for k, word in enumerate(WORDS)),
                *(
                    magnified(APPLE, word, viewport=place)
                    for word, place in zip(WORDS, PLACES, strict=True)
                ),
            ),
            (640, 400),
        ),
        picture(
            (magnified(TEXELS, word, cell=cell(k, 2)) for k, word in enumerate(WORDS)),
            (128, 62),
            "judged",
        ),
        picture(
            (magnified(TEXELS, word, cell=cell(k, 2)) for k, word in enumerate(WORDS)),
            (4, 2),
            "minified",
        ),
        *line_of("nearest"),
        *line_of("linear"),
    ),
    picture="picture.FragColor",
    columns=("NEAREST", "LINEAR"),
    expect=[
        formula("judged.FragColor", sampled, draw=0, name="NEAREST, every pixel"),
        formula(
            "judged.FragColor",
            sampled,
            draw=1,
            also={"NumPy, equation 8.17": linear_sample},
            name="LINEAR, every pixel",
        ),
        *each_draw(
            "minified.FragColor",
            minified,
            {0: "minified by the other one: LINEAR", 1: "minified by the other one: NEAREST"},
        ),
        *(formula(f"line-{word}.FragColor", sampled, name=f"a line, {word}") for word in WORDS),
        *figures(
            "line-linear.FragColor",
            {
                "LINEAR at a texel's centre is that texel": ({"TexCoords": (0.3, 0.5)}, (0.9,) * 4),
                "LINEAR between two texels is their mean": ({"TexCoords": (0.2, 0.5)}, (0.5,) * 4),
                "LINEAR a quarter before a centre": (BEFORE_A_CENTRE, (0.7,) * 4),
            },
            reference=sampled,
        ),
        figure(
            "line-nearest.FragColor",
            "NEAREST a quarter before a centre",
            BEFORE_A_CENTRE,
            (0.9,) * 4,
            reference=sampled,
        ),
        *each_draw(
            "picture.FragColor", sampled, {0: "five texels, NEAREST", 1: "five texels, LINEAR"}
        ),
        *(
            formula(
                "picture.FragColor",
                in_place(*PLACES[k]),
                draw=2 + k,
                name=f"the fruit with {word.upper()}, in its place",
            )
            for k, word in enumerate(WORDS)
        ),
        default_of("GL_TEXTURE_MIN_FILTER", 0x2702),
        default_of("GL_TEXTURE_MAG_FILTER", 0x2601),
    ],
    errata=[
        Erratum(
            says="GL_NEAREST is OpenGL's default filter",
            truth="minifying starts as GL_NEAREST_MIPMAP_LINEAR (0x2702), which is black without "
            "mipmaps, magnifying as GL_LINEAR (0x2601)",
            proof="the default of GL_TEXTURE_MIN_FILTER",
        )
    ],
)
