"""A picture from disk: decoded by a library, turned upside down, uploaded.

OpenGL reads no files. A library, here OpenImageIO, decodes a PNG, JPEG or other file into rows of
texels. Files begin with the top row and textures with the bottom row, so the rows have to be
reversed. The shader reads bytes 0 … 255 as 0 … 1: each divided by 255. A texture of three channels
has an alpha of 1.

Look at: the letter, the right way up, on a field that grows red to the right and green downward.

Try: in `ch02_basics/textured.frag` write `texture(image, TexCoords).bgra` for `texture(image,
TexCoords)`: red and blue change places, as in a file whose bytes are blue, green and red.
"""

from pathlib import Path

import numpy as np

from shaderlab import Case, Target, Texture, formula, fullscreen, measure, reading
from shaderlab.engine.expectations.gl_call import call

from ..scenes.api import answers
from ..scenes.figures import figures
from ..scenes.laws import sampled
from ..scenes.objects import rows_of_nine_bytes

FOLDER = Path(__file__).parent / "image_file"
WIDTH, HEIGHT = 40, 30
NEAREST = {"filter": ("nearest", "nearest")}


TEXELS = call("glGetTexImage", "GL_TEXTURE_2D", 0, "GL_RGB", "GL_UNSIGNED_BYTE")


def bytes_unlike(FragColor):
    """How many channels are not the bytes of the same picture as a PPM file, which are read here
    without any library: they end the file, the top row first. And alpha is 1."""
    data = (FOLDER / "letter.ppm").read_bytes()
    rows = np.frombuffer(data[-3 * WIDTH * HEIGHT :], np.uint8).reshape(HEIGHT, WIDTH, 3)[::-1]
    there = np.dstack([rows, np.full((HEIGHT, WIDTH), 255)])
    return np.count_nonzero(np.abs(255.0 * FragColor - there) > 255.0 * 2.0**-23)


def shown(name, file, size, format="rgb32f"):
    """The file's texture over a target of this size."""
    return fullscreen(
        "ch02_basics/textured.frag",
        name=name,
        textures={"image": Texture(image=f"image_file/{file}", format=format, **NEAREST)},
        target=Target(size=size),
    )


def texel(x, row):
    """The middle of a texel, its row counted from above, as files count."""
    return {"TexCoords": ((x + 0.5) / WIDTH, 1.0 - (row + 0.5) / HEIGHT)}


case = Case(
    title="A picture from disk",
    section="2.4.6",
    math=r"\text{texel}(i, j) = \frac{\text{byte}(i,\ h - 1 - j)}{255}",
    passes=(
        *shown("picture", "letter.png", (8 * WIDTH, 8 * HEIGHT)),
        *shown("ppm", "letter.ppm", (WIDTH, HEIGHT)),
        *shown("bytes", "letter.png", (WIDTH, HEIGHT), "rgb8"),
        *shown("texels", "letter.png", (WIDTH, HEIGHT)),
    ),
    picture="picture.FragColor",
    expect=[
        formula("picture.FragColor", sampled("image")),
        measure(
            "channels that are not the file's bytes, read by hand",
            bytes_unlike,
            readings=[
                reading(label, reads={"FragColor": f"{name}.FragColor"})
                for name, label in (
                    ("texels", "PNG, as floats"),
                    ("ppm", "PPM, as floats"),
                    ("bytes", "PNG, as bytes"),
                )
            ],
            equals=0,
            digits=0,
        ),
        *answers(
            {
                "rows of nine bytes, GL_UNPACK_ALIGNMENT 1": (
                    TEXELS,
                    (*range(1, 10), *range(10, 19)),
                    rows_of_nine_bytes(1),
                ),
                "the default, 4: three bytes are skipped": (
                    TEXELS,
                    (*range(1, 10), *range(13, 22)),
                    rows_of_nine_bytes(),
                ),
            }
        ),
        *figures(
            "texels.FragColor",
            {
                "upper left": (texel(0, 0), (40 / 255, 40 / 255, 200 / 255, 1.0)),
                "lower left": (texel(0, 29), (40 / 255, 214 / 255, 200 / 255, 1.0)),
                "in the letter's upper bar": (texel(29, 5), (1.0, 248 / 255, 220 / 255, 1.0)),
            },
            reference=sampled("image"),
        ),
    ],
)
