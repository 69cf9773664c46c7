"""Formats of attachments and textures, and GLSL types, as NumPy has them.

Source: OpenGL 4.5 core profile specification, tables 8.10 to 8.13 (sized internal formats).
"""

import functools
import math
import struct
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Variable
from shaderlab.errors import AssetError, CaseError, suggest
from shaderlab.files import read_regular
from shaderlab.model.checked import require_unmasked
from shaderlab.model.frame import Array, Image
from shaderlab.model.textures import (
    BLOCK_BYTES,
    DEPTH_FORMATS,
    CompressedTexture,
    CubeTexture,
    Output,
    Texture,
    Texture3D,
    TextureArray,
    TextureSource,
    level_sizes,
)


@dataclass(frozen=True)
class Format:
    """`components` numbers of the type `numpy` a texel; unsigned bytes are codes for 0…1."""

    components: int
    numpy: Any
    stencil: bool = False

    @property
    def integer(self) -> bool:
        """Whether shaders write plain integers to it."""
        return self.numpy in (np.int32, np.uint32)

    @property
    def scalar(self) -> str:
        """The letter that a sampler of such a texture begins with: "", "i" or "u"."""
        return np.dtype(self.numpy).kind if self.integer else ""


_CHANNELS = {"r": 1, "rg": 2, "rgb": 3, "rgba": 4}
_NUMBERS = {"8": np.uint8, "16f": np.float16, "32f": np.float32, "32i": np.int32, "32ui": np.uint32}
COLOR = {
    f"{channels}{numbers}": Format(count, kind)
    for channels, count in _CHANNELS.items()
    for numbers, kind in _NUMBERS.items()
} | {"srgb8_alpha8": Format(4, np.uint8)}

# Depths are uploaded and read as floats, whatever their format.
DEPTH = {word: Format(1, np.float32, stencil="stencil" in word) for word in DEPTH_FORMATS}


def format_of(word: str) -> Format:
    return DEPTH[word] if word in DEPTH else COLOR[word]


def output_format(glsl_type: str) -> str:
    """The 32-bit format that holds a fragment output of this GLSL type without loss.

    There is no renderable three-component format, so a vec3 takes four.

    >>> output_format("float"), output_format("vec3"), output_format("uvec2")
    ('r32f', 'rgba32f', 'rg32ui')
    """
    channels = {1: "r", 2: "rg", 3: "rgba", 4: "rgba"}[components_of(glsl_type)]
    return f"{channels}32" + {"i": "i", "u": "ui"}.get(glsl_type[0], "f")


def components_of(glsl_type: str) -> int:
    """Number of components of a GLSL scalar, vector or matrix type.

    >>> components_of("vec3"), components_of("float"), components_of("mat3")
    (3, 1, 9)
    """
    return math.prod(shape_of(glsl_type))


def shape_of(glsl_type: str) -> tuple[int, ...]:
    """The array shape of one value of a GLSL type.

    >>> shape_of("float"), shape_of("vec3"), shape_of("mat4"), shape_of("mat2x3")
    ((1,), (3,), (4, 4), (3, 2))
    """
    if "mat" in glsl_type:
        columns, _, rows = glsl_type.partition("mat")[2].partition("x")
        return int(rows or columns), int(columns)
    return (int(glsl_type[-1]) if glsl_type[-1].isdigit() else 1,)


def numpy_type(glsl_type: str) -> Any:
    """The NumPy type a uniform or attribute of this GLSL type is uploaded as."""
    letters = {"i": np.int32, "b": np.int32, "u": np.uint32, "d": np.float64}
    return letters.get(glsl_type[0], np.float32)


_HEADER, _EXTENDED = 128, 20
_FOUR_CC = {b"DXT1": "bc1", b"DXT5": "bc3"}
_DXGI = {71: "bc1", 77: "bc3", 98: "bc7"}
_KNOWN = "DXT1, DXT5, and of DX10 files BC1, BC3 and BC7 (UNORM)"


@dataclass(frozen=True)
class Blocks:
    """A compressed image: its format, size (width, height) and the bytes of each level."""

    format: str
    size: tuple[int, int]
    levels: tuple[bytes, ...]


def level_bytes(format: str, size: tuple[int, int]) -> int:
    """How many bytes a level takes: its blocks, those at the edges whole.

    >>> level_bytes("bc1", (8, 8)), level_bytes("bc7", (5, 1))
    (32, 32)
    """
    width, height = size
    return -(-width // 4) * -(-height // 4) * BLOCK_BYTES[format]


def read_dds(path: Path) -> Blocks:
    """The blocks of a two-dimensional DDS file. Raises AssetError: there is no such file, it is no
    DDS file, it is cut short, or its format is none of those known here."""
    try:
        data = read_regular(path)
    except OSError as error:
        raise AssetError(f"can't read it ({error.strerror})", file=str(path)) from error
    if len(data) < _HEADER or data[:4] != b"DDS ":
        raise AssetError("this is no DDS file", file=str(path), remedy="it must begin with 'DDS '")
    height, width, count = struct.unpack_from("<2I8xI", data, 12)
    code = data[84:88]
    start, format = _HEADER, _FOUR_CC.get(code)
    if code == b"DX10" and len(data) >= _HEADER + _EXTENDED:
        (number,) = struct.unpack_from("<I", data, _HEADER)
        start, format = _HEADER + _EXTENDED, _DXGI.get(number)
        code = b"DXGI format %d" % number
    if format is None:
        said = code.decode("ascii", "replace").strip("\0") or "no compression"
        raise AssetError(f"a DDS file of {said}", file=str(path), remedy=f"known are {_KNOWN}")
    if not (1 <= width <= 16384 and 1 <= height <= 16384):
        raise AssetError(f"a DDS file of {width} × {height} texels", file=str(path))
    sizes = level_sizes(width, height)[: max(count, 1)]
    levels = []
    for number, size in enumerate(sizes):
        length = level_bytes(format, size)
        if start + length > len(data):
            raise AssetError(
                f"it is cut short: level {number} of {len(sizes)} needs {length} bytes, "
                f"there are {max(len(data) - start, 0)}",
                file=str(path),
            )
        levels.append(data[start : start + length])
        start += length
    return Blocks(format, (width, height), tuple(levels))


def load_blocks(source: CompressedTexture, folder: Path) -> Blocks:
    """The blocks of a texture, from its file or as it gives them. Raises CaseError: a level has
    another number of bytes than its size takes; AssetError: the file can't be read; see
    `read_dds`."""
    if source.file is not None:
        blocks = read_dds(folder / source.file)
    else:
        given = source.blocks() if callable(source.blocks) else source.blocks
        blocks = Blocks(source.format, source.size, tuple(given))
    sizes = level_sizes(*blocks.size)
    if len(blocks.levels) > len(sizes):
        raise CaseError(
            f"CompressedTexture: {len(blocks.levels)} levels, but {blocks.size[0]} × "
            f"{blocks.size[1]} has {len(sizes)}"
        )
    for number, data in enumerate(blocks.levels):
        wanted = level_bytes(blocks.format, sizes[number])
        if len(data) != wanted:
            raise CaseError(
                f"CompressedTexture: level {number} of {blocks.format}, {sizes[number][0]} × "
                f"{sizes[number][1]}, takes {wanted} bytes, not {len(data)}"
            )
    return blocks


Images = Mapping[tuple[str, str], Image]
"""What earlier passes have drawn, by (pass, output)."""


@dataclass(frozen=True)
class Contents:
    """What a texture is made of: `layers` of one size (one image, an array's, or a cube's six),
    each (height, width, channels) of the format's own type, and further levels of one image."""

    layers: Sequence[Array]
    smaller: Sequence[Array] = ()


def texture_contents(
    source: Texture | TextureArray | CubeTexture, folder: Path, images: Images
) -> Contents:
    """Return the values of a texture that are uploaded; `folder` is where paths of image files
    begin, and its layers may be copied from `images`. Raises CaseError: an image does not fit the
    format or the others, or does not exist; AssetError: an image file can't be read."""

    def values(image: Any, owner: str) -> Array:
        image = find_image(image, images) if isinstance(image, Output) else image
        return pixel_values(image, source.format, folder, owner)

    if isinstance(source, Texture):
        first = values(source.image, "Texture")
        if isinstance(source.mipmaps, bool):
            return Contents([first])
        smaller = [values(level, "Texture: a mipmap level") for level in source.mipmaps]
        _check_levels(first, smaller)
        return Contents([first], smaller)
    cube = isinstance(source, CubeTexture)
    owner = "CubeTexture: face" if cube else f"{type(source).__name__}: layer"
    given = source.faces if isinstance(source, CubeTexture) else source.layers
    layers = [values(image, f"{owner} {number}") for number, image in enumerate(given)]
    if cube:  # t runs down on a cube: files begin with the row that its faces begin with
        for number, image in enumerate(given):
            if isinstance(image, str | Path):
                layers[number] = np.ascontiguousarray(layers[number][::-1])
    height, width = layers[0].shape[:2]
    for number, image in enumerate(layers):
        if image.shape != layers[0].shape:
            raise CaseError(
                f"{owner} {number} is {image.shape[1]} × {image.shape[0]}, "
                f"the first one {width} × {height}"
            )
    if cube and height != width:
        raise CaseError(f"CubeTexture: its faces are {width} × {height}, not square")
    return Contents(layers)


def split_layers(image: Image) -> Contents:
    """What a texture of a dispatch's image is made of."""
    if not image.layers:
        return Contents([image.values])
    return Contents(list(image.values.reshape(image.layers, -1, *image.values.shape[1:])))


def find_image(source: Output, images: Images) -> Image:
    """The output of an earlier pass. Raises CaseError if there is none."""
    key = (source.pass_name, source.name)
    if key not in images:
        known = [f"{p}.{n}" for p, n in images]
        raise CaseError(f"no earlier pass gives {source.path}", remedy=suggest(source.path, known))
    return images[key]


def pixel_values(image: Any, format: str, folder: Path, owner: str) -> Array:
    """One image: an array, a function that makes one, a file's path, or an earlier pass's output.
    Floats for an 8-bit format are taken as 0…1 and rounded to the nearest code. Raises CaseError:
    it has another shape than the format takes; AssetError: a file can't be read."""
    wanted, channels = format_of(format).numpy, format_of(format).components
    if isinstance(image, str | Path):
        from shaderlab.model.pictures import load

        image = load(folder / image)
    elif callable(image):
        image = _call(image) if isinstance(image, Hashable) else np.asanyarray(image())
    if isinstance(image, Image):
        if image.layers:
            raise CaseError(f"{owner}: an image of {image.layers} layers is no layer of another")
        codes = image.values.dtype == np.uint8 and wanted is not np.uint8
        values = image.values / 255.0 if codes else image.values
    else:
        require_unmasked(image, owner)
        values = np.asarray(image)
    if values.ndim == 2:
        values = values[:, :, None]
    if values.ndim != 3 or values.shape[2] < channels or 0 in values.shape:
        raise CaseError(
            f"{owner}: a {format} texture takes (height, width, {channels}), not {values.shape}"
        )
    values = values[:, :, :channels]
    if wanted is np.uint8 and values.dtype.kind == "f":
        values = np.rint(np.clip(values, 0.0, 1.0) * 255.0)
    # What nobody can write to is what it was when it is uploaded: it needs no copy.
    return np.ascontiguousarray(values.astype(wanted, copy=values.flags.writeable))


@functools.lru_cache(maxsize=32)
def _call(function: Callable[[], Any]) -> Array:
    """Call a function that makes an image, once for the scenes that follow each other."""
    image: Array = np.array(function(), subok=True)  # a mask is to be seen
    image.flags.writeable = False
    return image


def _check_levels(first: Array, smaller: Sequence[Array]) -> None:
    """Raise CaseError unless these are all the levels below `first`, in order."""
    sizes = level_sizes(first.shape[1], first.shape[0])[1:]
    given = [(level.shape[1], level.shape[0]) for level in smaller]
    if given != sizes:
        listed = ", ".join(f"{w} × {h}" for w, h in given) or "nothing"
        raise CaseError(
            f"a texture of {first.shape[1]} × {first.shape[0]}: its smaller mipmap levels are "
            f"{listed}",
            remedy=f"mipmaps=True, or all of {', '.join(f'{w} × {h}' for w, h in sizes)}",
        )


def texture_kind(source: TextureSource, declared: str, samples: int, layers: int = 0) -> str:
    """Return the kind that a texture is to a sampler of the type `declared`: the output of a target
    of several `samples` is "2DMS" to a sampler2DMS, and "2D", its samples averaged, to all others;
    that of an image of several `layers` is an array."""
    if isinstance(source, CubeTexture):
        return "Cube"
    if isinstance(source, TextureArray):
        return "3D" if isinstance(source, Texture3D) else "2DArray"
    if layers:
        return "2DArray"
    return "2DMS" if samples and "2DMS" in declared and isinstance(source, Output) else "2D"


def check_sampler(
    program: str, variable: Variable, source: TextureSource, kind: str, format: str
) -> None:
    """Check that a sampler's type is that of its texture. Raises CaseError: it is another; names
    the sampler's type and the texture's."""
    shadow = source.compare is not None
    fitting = f"{format_of(format).scalar}sampler{kind}{'Shadow' * shadow}"
    if variable.type == fitting:
        return
    what = type(source).__name__
    described = f"{what}(compare={source.compare!r})" if shadow else what
    remedy = f"declare it {fitting}"
    if variable.type.endswith("Shadow") != shadow:
        remedy += ", or leave compare= out" if shadow else ', or give the texture compare="lequal"'
    raise CaseError(
        f"{program}: {variable.name!r} is a {variable.type}, but the {described} given for it, "
        f"{format}, is read by a {fitting}",
        remedy=remedy,
    )
