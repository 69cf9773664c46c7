"""The chain of mipmaps: every level is half as large as the one before, down to a single texel.

A pixel of a distant surface covers hundreds of texels, and picking one of them makes the surface
flicker. So means are computed in advance: each texel of a level is the mean of four texels of the
level before. An image of 256 × 256 gets 9 levels, which hold 87 381 texels, a third more than the
image. OpenGL leaves the filter to the driver and recommends a box filter, which this case expects.

Look at: a wall of bricks and its eight smaller levels, each in half the size of the one before, and
four pixels a texel throughout. The joints go first, then the bricks, and a single brown is left.

Try: in `ch02_basics/mipmapped.frag` write `TexCoords, lod + 1.0` for `TexCoords, lod`: each field
shows the next smaller level, in texels twice as large.
"""

import numpy as np

from shaderlab import Case, Erratum, Ramp, Texture, formula, gl_calls
from shaderlab.glslmath import floor, swizzle, vec2
from shaderlab.glslmath.sampling import texelFetch
from shaderlab.reference.filtering import box, level_count, texel_count

from ..scenes import painted_textures
from ..scenes.figures import figure, results
from ..scenes.panels import WHOLE, panel, panel_pass, picture

SIDE, LEVELS = 256, level_count(256, 256)
NOISE = np.random.default_rng(244).random((SIDE, SIDE, 4))
STEPS = ("nearest_mipmap_nearest", "nearest")


def mean_of_four(level):
    """A level as the box filter makes it of the one below."""

    def texel(image, frag_coord):
        place = floor(swizzle(frag_coord, "xy"))
        corners = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0))
        return box(*(texelFetch(image, 2.0 * place + np.array(c), level - 1) for c in corners))

    return texel


def level_pass(level):
    """One level, a texel a pixel."""
    noise = {"image": Texture(image=NOISE, mipmaps=True, filter=STEPS)}
    shader, size = "ch02_basics/mipmap_chain.frag", (SIDE >> level,) * 2
    return panel_pass(f"level{level}", shader, {}, {"level": level}, size=size, textures=noise)


def rectangle(level):
    """Where a level is in the picture: the first at the left, the others above one another."""
    side = SIDE >> level
    left, top = (0, 0) if level == 0 else (SIDE, SIDE - 2 * side)
    return 2 * left, 2 * (SIDE - top - side), 2 * side, 2 * side


def in_its_place(level):
    """The texel of a level that a pixel of the picture shows: four pixels a texel."""
    left, bottom, _, _ = rectangle(level)

    def texel(image, frag_coord):
        from_corner = swizzle(frag_coord, "xy") - vec2(float(left), float(bottom))
        return texelFetch(image, floor(0.5 * from_corner), level)

    return texel


def shown(level):
    """A level in the picture."""
    bricks = {"image": Texture(image=painted_textures.brick_wall, mipmaps=True, filter=STEPS)}
    domain, place = {**WHOLE, "lod": Ramp(float(level))}, rectangle(level)
    return panel("ch02_basics/mipmapped.frag", domain, textures=bricks, viewport=place)


COUNTS = {
    "levels of 256 × 256": (level_count(256, 256), 9),
    "texels of all levels": (texel_count(256, 256), 87381),
    "levels of 5 × 3": (level_count(5, 3), 3),
}
SIZES = [(n, (float(SIDE >> n),) * 2) for n in range(1, LEVELS)]
EXTENT = "level {}'s width and height"
MEANS = {n: f"level {n} is the mean of level {n - 1}" for n in range(1, LEVELS)}
ALL, IN_IT = range(LEVELS), "level {} in the picture"
GENERATED = "one call of glGenerateMipmap makes all levels"

case = Case(
    title="The chain of mipmaps",
    section="2.4.4",
    math=r"\tau^{n+1}_{i,j} = \tfrac14\left(\tau^n_{2i,2j} + \tau^n_{2i+1,2j} + \tau^n_{2i,2j+1} + "
    r"\tau^n_{2i+1,2j+1}\right), \qquad 1 + \lfloor \log_2 256 \rfloor = 9",
    passes=(
        picture(map(shown, ALL), (3 * SIDE, 2 * SIDE), clear=(0.93, 0.93, 0.92, 1.0)),
        *map(level_pass, (*range(2, LEVELS), 1)),
    ),
    picture="picture.FragColor",
    expect=[
        *(formula(f"level{n}.FragColor", mean_of_four(n), name=mean) for n, mean in MEANS.items()),
        *(formula("picture.FragColor", in_its_place(n), draw=n, name=IN_IT.format(n)) for n in ALL),
        *(figure(f"level{n}.extent", EXTENT.format(n), {}, size) for n, size in SIZES),
        *results(COUNTS, digits=0),
        gl_calls("glGenerateMipmap", times=1, pass_name="level1", name=GENERATED),
    ],
    errata=[
        Erratum(
            section="2.4.4",
            says="glGenerateMipmaps makes the levels",
            truth="the function is called glGenerateMipmap, without an s; there is no other",
            proof=GENERATED,
        )
    ],
)
