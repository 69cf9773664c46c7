"""Compressed textures: blocks of 4 × 4 texels in 8 or 16 bytes, decoded while they are sampled.

A graphics card has to find any texel at once, so every block has the same size: 4 or 8 bits a texel
instead of 32. What is lost is lost when the image is compressed; decoding is arithmetic with whole
numbers, and ETC1, ETC2 and BC7 leave nothing open about it. A block of ETC holds a base colour for
each half and a table of brightness steps. One of BC1 holds two colours and for each texel one of
four points on the line between them, thirds that may be rounded either way; BC3 adds alpha in the
same manner, and BC7 has eight modes to choose from. ETC1 is a part of ETC2: its blocks are read as
ETC2. Files keep the blocks behind a header, as DDS files do, and nothing has to be decoded to
upload them.

Look at: the emblem in six formats. The lower row has ETC1, ETC2 and ETC2 with alpha, the upper one
BC1, BC3 and BC7; over each is what it lost, eight times as large, on grey. Losses have the shape of
blocks, and most are at the rays' edges, where a block holds only two or four colours. BC7 loses
next to nothing.

Try: in `ch02_basics/texture_loss.frag` write `64.0` for `8.0`: even the smooth sky turns into
blocks, of BC7 as well.
"""

from pathlib import Path

import numpy as np

from shaderlab import Case, CompressedTexture, Target, Texture, exact, fullscreen, measure
from shaderlab.glslmath import swizzle, vec4
from shaderlab.glslmath.sampling import texture as texel

from ..scenes import painted_textures
from ..scenes.block_codecs import between_ends, compressed, decoded_blocks
from ..scenes.figures import each_draw
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, square

# A format's name: what made its blocks, what they are read as.
FORMATS = {
    "ETC1": ("etc1", "etc2_rgb8"),
    "ETC2 RGB8": ("etc2_rgb8", "etc2_rgb8"),
    "ETC2 with EAC alpha": ("etc2_eac_rgba8", "etc2_eac_rgba8"),
    "BC1": ("bc1", "bc1"),
    "BC3": ("bc3", "bc3"),
    "BC7": ("bc7", "bc7"),
}
# How far thirds of a colour and sevenths of alpha may be off: OpenGL leaves it open. Direct3D has a
# code and 3 % of the line between two colours (11.3 functional specification, 19.5), and an NVIDIA
# H200 uses all of it. Mesa keeps the ends in whole codes, half a code off, and cuts off the thirds.
GIVE, CODES = 0.03, 1.5
ROUNDED = ("BC1", "BC3")
SIZE = (64, 64)
IN_FILES = ("BC1", "BC3", "BC7")
FOLDER = Path(__file__).parent / "texture_compression"


def mixed_image():
    """The emblem, and in its lower half noise and ramps that drive a compressor to its limits."""
    image = painted_textures.emblem(64).copy()
    t, s = np.mgrid[0:24, 0:64] / 64.0
    image[:24, :, 0], image[:24, :, 1], image[:24, :, 2] = s, 2.6 * t, 1.0 - s
    image[:12, 32:] = np.random.default_rng(245).random((12, 32, 4))
    image[12:24, :, 3] = s[12:24]
    return image


IMAGE = mixed_image()


def texture(kind, image=None):
    """The image as this format's blocks; without one, IMAGE, of BC formats from a DDS file."""
    by, read_as = FORMATS[kind]
    if image is None and kind in IN_FILES:
        return CompressedTexture(file=FOLDER / f"{by}.dds")
    image = IMAGE if image is None else image
    size = image.shape[:2]
    return CompressedTexture(blocks=lambda: [compressed(image, by)], format=read_as, size=size)


def decoded(kind, read=decoded_blocks):
    """What another library reads out of the same blocks, or `read`."""
    by, _ = FORMATS[kind]
    blocks = compressed(IMAGE, by)
    if kind in IN_FILES:  # they end the file
        blocks = (FOLDER / f"{by}.dds").read_bytes()[-len(blocks) :]
    return read(blocks, by, SIZE)


def off_line(kind):
    """How many codes the worst channel is off, beyond its part of the line between two colours."""

    def furthest(image):
        exact, apart = decoded(kind, between_ends)
        return np.max(np.abs(image - exact) - GIVE * apart)

    return furthest


def name_of(kind):
    """The pass that shows a format."""
    return kind.split(" with")[0].replace(" ", "-").lower() + "-alpha" * ("alpha" in kind)


def judged(kind):
    """The image in one format, texel by texel."""
    return fullscreen(
        "ch02_basics/texture_compression.frag",
        name=name_of(kind),
        domain={},
        textures={"image": texture(kind)},
        target=Target(size=SIZE, colors={"FragColor": "rgba8"}),
    )


def sampled(image, TexCoords):
    """The texel that a place is in, as the format's blocks say."""
    return texel(image, TexCoords)


def loss(image, original, TexCoords):
    """What a format lost at a place, eight times as large, on grey."""
    lost = texel(image, TexCoords) - texel(original, TexCoords)
    return vec4(0.5 + 8.0 * swizzle(lost, "rgb"), 1.0)


def shown(k, kind):
    """The emblem in one format, and above it what that lost."""
    emblem, place = painted_textures.emblem(96), {"TexCoords": square(0.003, 0.996)}
    textures = {"image": texture(kind, emblem)}
    below = 6 * (k // 3) + k % 3
    yield panel("ch02_basics/textured.frag", place, textures=textures, cell=cell(below, 3, 4))
    textures = {**textures, "original": Texture(image=emblem)}
    yield panel(
        "ch02_basics/texture_loss.frag", place, textures=textures, cell=cell(below + 3, 3, 4)
    )


case = Case(
    title="Compressed textures",
    section="2.4.5",
    math=r"\text{BC1: } c_k = \tfrac13\left((3 - k)\,c_0 + k\,c_1\right), \qquad "
    r"\frac{8\ \text{bytes}}{16\ \text{texels}} = 4\ \text{bits a texel}",
    passes=(
        *enlarged((d for k, kind in enumerate(FORMATS) for d in shown(k, kind)), (129, 172), 5),
        *(one for kind in FORMATS for one in judged(kind)),
    ),
    picture="picture.FragColor",
    rows=("lost, × 8", "BC1, BC3, BC7", "lost, × 8", "ETC1, ETC2, ETC2 with alpha"),
    expect=[
        enlarged_check(),
        *each_draw(
            "small.FragColor",
            sampled,
            {2 * k: f"{kind}, on show" for k, kind in enumerate(FORMATS)},
        ),
        *each_draw(
            "small.FragColor", loss, {2 * k + 1: f"{kind}, lost" for k, kind in enumerate(FORMATS)}
        ),
        *(
            exact(f"{name_of(kind)}.FragColor", decoded(kind), name=f"{kind}, another decoder")
            for kind in FORMATS
            if kind not in ROUNDED
        ),
        *(
            measure(
                f"{kind}: codes off its colours, beyond {GIVE:.0%} of the line between two",
                off_line(kind),
                reads={"image": f"{name_of(kind)}.FragColor"},
                at_most=CODES,
            )
            for kind in ROUNDED
        ),
    ],
)
