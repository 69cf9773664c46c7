"""What samplers read: textures of every shape, and the attachments of earlier passes. Pure data."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.checked import Checked
from shaderlab.model.state import COMPARISONS, check_choice

from .frame import Array

COLOR_FORMATS = (
    "r8", "rg8", "rgba8", "srgb8_alpha8", "r16f", "rg16f", "rgba16f", "r32f", "rg32f", "rgba32f",
    "r32i", "rg32i", "rgba32i", "r32ui", "rg32ui", "rgba32ui",
)  # fmt: skip
DEPTH_FORMATS = ("depth16", "depth24", "depth32f", "depth24_stencil8", "depth32f_stencil8")
TEXTURE_FORMATS = (*COLOR_FORMATS, "rgb8", "rgb32f", *DEPTH_FORMATS[:3])
FILTERS = (
    "nearest", "linear", "nearest_mipmap_nearest", "linear_mipmap_nearest",
    "nearest_mipmap_linear", "linear_mipmap_linear",
)  # fmt: skip
TEXTURE_UPLOADS = ("data", "map")
WRAPS = ("repeat", "mirrored_repeat", "clamp_to_edge", "clamp_to_border")
# Bytes of a block of 4 × 4 texels.
BLOCK_BYTES = {"etc2_rgb8": 8, "etc2_eac_rgba8": 16, "bc1": 8, "bc3": 16, "bc7": 16}
FACES = ("+X", "−X", "+Y", "−Y", "+Z", "−Z")
ANY_LEVEL = (-1000.0, 1000.0)

Filters = tuple[str, str]
Wraps = tuple[str, str] | tuple[str, str, str]
Pixels = Array | Callable[[], Array] | str | Path
Levels = bool | Sequence[Array]


@dataclass(frozen=True, kw_only=True)
class Sampling(Checked):
    """How a texture is sampled.

    Args:
        filter: for minifying and for magnifying; a mipmap filter can only be the first.
        wrap: what coordinates outside 0…1 mean, along s and t; of a `Texture3D` along r as well.
        border: the colour beyond the edge under "clamp_to_border".
        compare: a depth comparison for a shadow sampler, `reference func texel`; None for all
            others.
        lod: the least and the greatest mipmap level that sampling may choose.
    """

    filter: Filters = ("nearest", "nearest")
    wrap: Wraps = ("repeat", "repeat")
    border: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    compare: str | None = None
    lod: tuple[float, float] = ANY_LEVEL
    _AXES: ClassVar[str] = "st"

    def __post_init__(self) -> None:
        owner = type(self).__name__
        check_choice(owner, "filter[0] (minifying)", self.filter[0], FILTERS)
        check_choice(owner, "filter[1] (magnifying)", self.filter[1], FILTERS[:2])
        if len(self.wrap) != len(self._AXES):
            raise CaseError(f"{owner}: wrap has {len(self.wrap)} words, not {len(self._AXES)}")
        for axis, word in zip(self._AXES, self.wrap, strict=True):
            check_choice(owner, f"wrap along {axis}", word, WRAPS)
        if self.compare is not None:
            check_choice(owner, "compare", self.compare, COMPARISONS)
        if self.lod[0] > self.lod[1]:
            raise CaseError(f"{owner}: lod runs from {self.lod[0]} down to {self.lod[1]}")

    def _check_format(self, format: str) -> None:
        owner = type(self).__name__
        check_choice(owner, "format", format, TEXTURE_FORMATS)
        if format.endswith("i") and any(word != "nearest" for word in self.filter):
            raise CaseError(
                f"{owner}: OpenGL filters no integers; a {format} texture is incomplete",
                remedy='filter=("nearest", "nearest")',
            )
        if self.compare is not None and format not in DEPTH_FORMATS:
            raise CaseError(
                f"{owner}: compare={self.compare!r} compares depths; {format} is not a depth",
                remedy=f"format= one of {', '.join(DEPTH_FORMATS[:3])}",
            )

    def _check_levels(self, mipmaps: Levels) -> None:
        if self.filter[0] not in FILTERS[:2] and mipmaps is False:
            raise CaseError(
                f"{type(self).__name__}: {self.filter[0]!r} reads mipmap levels and there are "
                "none: the texture is incomplete, and every sample is black",
                remedy="mipmaps=True, or give the levels",
            )


@dataclass(frozen=True, kw_only=True)
class Texture(Sampling):
    """A two-dimensional texture.

    `image` is an array (height, width, channels) whose row 0 is the bottom one, a function that
    makes such an array when the case runs, or an image file's path (relative to the case file;
    files are flipped so that their lowest row comes first). `mipmaps` are made by the driver
    (True) or given: all smaller levels, each half as large as the one before (rounded down).

    `upload` is "data" where OpenGL reads the image from the program's memory, "map" where it is
    written into a mapped pixel buffer (GL_PIXEL_UNPACK_BUFFER) that the texture is filled from.
    """

    image: Pixels
    format: str = "rgba32f"
    mipmaps: Levels = False
    upload: str = "data"

    def __post_init__(self) -> None:
        check_choice("Texture", "upload", self.upload, TEXTURE_UPLOADS)
        self._check_format(self.format)
        self._check_levels(self.mipmaps)


@dataclass(frozen=True)
class Output(Sampling):
    """An output of an earlier pass, used as a texture: `Output("shadow.FragColor")`.

    "shadow.depth" is the depth attachment of a pass whose target has one, unless a shader has an
    output of that name. Read by a `sampler2DMS`, the output of a multisampled target gives its
    samples; by any other sampler, their mean. `mipmaps=True` has the driver make the smaller
    levels.
    """

    path: str
    wrap: Wraps = field(default=("clamp_to_edge", "clamp_to_edge"), kw_only=True)
    mipmaps: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        if not self.pass_name or not self.name:
            raise CaseError(
                f"Output: {self.path!r} names no output of a pass",
                remedy='the pass and the output: Output("shadow.FragColor")',
            )
        self._check_levels(self.mipmaps)

    @property
    def pass_name(self) -> str:
        """The pass: what stands before the last dot."""
        return self.path.rpartition(".")[0]

    @property
    def name(self) -> str:
        """The output's own name: what stands after the last dot."""
        return self.path.rpartition(".")[2]


Image = Pixels | Output


@dataclass(frozen=True, kw_only=True)
class TextureArray(Sampling):
    """A stack of two-dimensional textures of one size, for `sampler2DArray`.

    Each of `layers` is what `Texture` takes as its image, or an `Output` of an earlier pass,
    which is copied. `mipmaps` are made by the driver, layer by layer.
    """

    layers: Sequence[Image]
    format: str = "rgba32f"
    mipmaps: bool = False

    def __post_init__(self) -> None:
        self._check_format(self.format)
        self._check_levels(self.mipmaps)
        object.__setattr__(self, "layers", tuple(self.layers))
        if not self.layers:
            raise CaseError(f"{type(self).__name__}: there are no layers")


@dataclass(frozen=True, kw_only=True)
class Texture3D(TextureArray):
    """A texture in three dimensions, for `sampler3D`: layers that LINEAR mixes as it does rows.

    The first layer is at r = 0. `wrap` has a word for r as well. There are no mipmaps, and
    minifying and magnifying have one filter.
    """

    wrap: Wraps = ("repeat", "repeat", "repeat")
    _AXES: ClassVar[str] = "str"

    def __post_init__(self) -> None:
        if self.mipmaps or self.filter[0] != self.filter[1]:
            raise CaseError(
                f"Texture3D: mipmaps={self.mipmaps}, filter={self.filter}: the lab has no mipmaps "
                "in three dimensions",
                remedy='mipmaps=False and one filter, such as filter=("linear", "linear")',
            )
        if self.format in DEPTH_FORMATS:
            raise CaseError(f"Texture3D: OpenGL has no {self.format} in three dimensions")


@dataclass(frozen=True, kw_only=True)
class CubeTexture(Sampling):
    """Six square textures around a point, for `samplerCube`: +X, −X, +Y, −Y, +Z, −Z.

    Each of `faces` is what `Texture` takes as its image, or an `Output` of an earlier pass, which
    is copied. Row 0 is the first one in memory, t = 0: seen from inside, with y upward, that is
    the upper edge of the four faces around, so a file's picture stands upright. `seamless` lets
    LINEAR mix texels across an edge.
    """

    faces: Sequence[Image]
    format: str = "rgba32f"
    wrap: Wraps = ("clamp_to_edge", "clamp_to_edge")
    mipmaps: bool = False
    seamless: bool = True

    def __post_init__(self) -> None:
        self._check_format(self.format)
        self._check_levels(self.mipmaps)
        object.__setattr__(self, "faces", tuple(self.faces))
        if len(self.faces) != len(FACES):
            raise CaseError(
                f"CubeTexture: there are {len(self.faces)} faces, not 6",
                remedy=f"one each for {', '.join(FACES)}",
            )


@dataclass(frozen=True, kw_only=True)
class CompressedTexture(Sampling):
    """A two-dimensional texture in blocks of 4 × 4 texels, as the device keeps it.

    Either `file` is a DDS file's path (relative to the case file), which says all the rest; or
    `blocks` are the bytes of each level, the largest first (or a function that gives them), of
    the `format` and `size` (width, height). ETC1 blocks are read as "etc2_rgb8".
    """

    file: str | Path | None = None
    blocks: Sequence[bytes] | Callable[[], Sequence[bytes]] = ()
    format: str = ""
    size: tuple[int, int] = (0, 0)

    def __post_init__(self) -> None:
        if (self.file is None) == (not self.blocks):
            raise CaseError("CompressedTexture: give either file or blocks, format and size")
        if self.compare is not None:
            raise CaseError("CompressedTexture: there are no compressed depths to compare")
        if self.file is None:
            check_choice("CompressedTexture", "format", self.format, tuple(BLOCK_BYTES))
            if min(self.size) < 1:
                raise CaseError(f"CompressedTexture: size must be positive, not {self.size}")


TextureSource = Texture | TextureArray | CubeTexture | CompressedTexture | Output


ImageValue = Pixels | Output


def outputs_read(source: object) -> Iterator[Output]:
    """The outputs of earlier passes that a texture, a buffer or an image is, or is made of."""
    parts: Sequence[object] = (source,)
    if isinstance(source, TextureArray):
        parts = source.layers
    elif isinstance(source, CubeTexture):
        parts = source.faces
    yield from (part for part in parts if isinstance(part, Output))


def level_sizes(width: int, height: int) -> list[tuple[int, int]]:
    """(width, height) of every mipmap level: halved, rounded down, until it is 1 × 1.

    >>> level_sizes(5, 2)
    [(5, 2), (2, 1), (1, 1)]
    """
    count = int(np.log2(max(width, height))) + 1
    return [(max(width >> k, 1), max(height >> k, 1)) for k in range(count)]
