"""Where a texture begins: (0, 0) is the first texel in memory, and OpenGL draws it lowest.

OpenGL knows nothing about the upper edge of a picture. The first row passed to glTexImage2D is t =
0, the last is t = 1, and a quad that has t grow upward shows the first row at its lower edge. Most
image files, and most loaders with them, put the top row first: the result is upside down unless the
rows are reversed before the upload (or t is, as 1 − t).

Look at: the field 00, which holds the texel that comes first. On the left the rows lie in memory as
OpenGL wants them, the lowest first. On the right they came as a loader delivers them, the top row
first: 00 is where 07 should be, and every figure stands on its head.

Try: in `ch02_basics/textured.frag` write `texture(image, vec2(TexCoords.s, 1.0 - TexCoords.t))` for
`texture(image, TexCoords)`: the right picture is upright, and the left one stands on its head.
"""

import numpy as np

from shaderlab import Case, Erratum, Pixel, Target, Texture, exact, formula, fullscreen

from ..scenes import painted_textures
from ..scenes.figures import each_draw, figure
from ..scenes.laws import sampled
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, square

# Twelve texels that say their column and row; the first row in memory is row 0.
COLUMN, ROW = np.meshgrid(np.arange(4.0), np.arange(3.0))
NUMBERED = np.stack([COLUMN, ROW, 0.0 * ROW, 1.0 + 0.0 * ROW], axis=-1)
PAPER = {"wrap": ("clamp_to_border",) * 2, "border": (0.93, 0.93, 0.92, 1.0)}


def numbered(name, image):
    """The twelve texels over a target of as many pixels."""
    return fullscreen(
        "ch02_basics/textured.frag",
        name=name,
        textures={"image": Texture(image=image)},
        target=Target(size=(4, 3)),
    )


def shown(column, image):
    """The chart in one half of the picture, with a margin around it."""
    domain = {"TexCoords": square(-0.04, 1.04)}
    textures = {"image": Texture(image=image, **PAPER)}
    return panel("ch02_basics/textured.frag", domain, textures=textures, cell=cell(column, 2))


ORIGIN = {"TexCoords": (0.0, 0.0)}

case = Case(
    title="Where a texture begins",
    section="2.4.1",
    math=r"\text{texel}(i, j) = \text{memory}[\,j \cdot \text{width} + i\,], \qquad "
    r"i = \lfloor s \cdot \text{width} \rfloor,\ j = \lfloor t \cdot \text{height} \rfloor",
    passes=(
        *enlarged(
            (
                shown(0, painted_textures.uv_grid),
                shown(1, lambda: painted_textures.uv_grid()[::-1]),
            ),
            (114, 57),
            9,
        ),
        *numbered("lowest-first", NUMBERED),
        *numbered("topmost-first", NUMBERED[::-1]),
    ),
    picture="picture.FragColor",
    columns=("lowest row first", "top row first"),
    expect=[
        enlarged_check(),
        *each_draw(
            "small.FragColor", sampled("image"), {0: "as OpenGL wants it", 1: "top row first"}
        ),
        formula("lowest-first.FragColor", sampled("image")),
        exact("lowest-first.FragColor", NUMBERED, name="the first row in memory is the lowest"),
        exact("topmost-first.FragColor", NUMBERED[::-1], name="a top-first image is upside down"),
        figure("lowest-first.FragColor", "(0, 0) is the first texel", ORIGIN, (0.0, 0.0, 0.0, 1.0)),
        figure(
            "topmost-first.FragColor",
            "(0, 0) of a top-first image is its upper left",
            ORIGIN,
            (0.0, 2.0, 0.0, 1.0),
            reference=sampled("image"),
        ),
        figure(
            "lowest-first.FragColor",
            "the last texel is upper right",
            Pixel(3, 2),
            (3.0, 2.0, 0.0, 1.0),
        ),
    ],
    errata=[
        Erratum(
            says="(0, 0) is the lower left corner of the picture",
            truth="(0, 0) is the first texel in memory; of an image whose loader puts the top row "
            "first, that is the upper left corner, and it is drawn upside down",
            proof="a top-first image is upside down",
        )
    ],
)
