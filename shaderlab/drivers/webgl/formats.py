"""The lab's formats as WebGL2 has them, and texels as they are uploaded.

Source: OpenGL ES 3.0 specification, tables 3.2 and 3.13; WEBGL_compressed_texture_etc,
WEBGL_compressed_texture_s3tc and EXT_texture_compression_bptc.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array

from ..programs.formats import DEPTH, format_of
from .device import Device

_CHANNELS = {1: "RED", 2: "RG", 3: "RGB", 4: "RGBA"}
_TYPES = {
    np.uint8: "UNSIGNED_BYTE", np.float16: "HALF_FLOAT", np.float32: "FLOAT", np.int32: "INT",
    np.uint32: "UNSIGNED_INT",
}  # fmt: skip
_DEPTHS = {
    "depth16": ("DEPTH_COMPONENT16", "UNSIGNED_SHORT"),
    "depth24": ("DEPTH_COMPONENT24", "UNSIGNED_INT"),
    "depth32f": ("DEPTH_COMPONENT32F", "FLOAT"),
    "depth24_stencil8": ("DEPTH24_STENCIL8", "UNSIGNED_INT_24_8"),
    "depth32f_stencil8": ("DEPTH32F_STENCIL8", "FLOAT_32_UNSIGNED_INT_24_8_REV"),
}
COMPRESSED = {
    "etc2_rgb8": ("COMPRESSED_RGB8_ETC2", "WEBGL_compressed_texture_etc"),
    "etc2_eac_rgba8": ("COMPRESSED_RGBA8_ETC2_EAC", "WEBGL_compressed_texture_etc"),
    "bc1": ("COMPRESSED_RGB_S3TC_DXT1_EXT", "WEBGL_compressed_texture_s3tc"),
    "bc3": ("COMPRESSED_RGBA_S3TC_DXT5_EXT", "WEBGL_compressed_texture_s3tc"),
    "bc7": ("COMPRESSED_RGBA_BPTC_UNORM_EXT", "EXT_texture_compression_bptc"),
}
"""Each compressed format's constant, and the extension that it comes with."""


@dataclass(frozen=True)
class Stored:
    """The constants by which WebGL2 knows a format: as it is stored, and as texels come."""

    internal: str
    format: str
    type: str


def stored(word: str) -> Stored:
    """The constants of a colour or depth format."""
    if word in _DEPTHS:
        internal, kind = _DEPTHS[word]
        return Stored(internal, "DEPTH_STENCIL" if "stencil" in word else "DEPTH_COMPONENT", kind)
    found = format_of(word)
    channels = _CHANNELS[found.components] + ("_INTEGER" if found.integer else "")
    return Stored(word.upper(), channels, _TYPES[found.numpy])


def uploaded(word: str, values: Array) -> Array:
    """Texels as they are handed over: depths as codes, those of 24 bits as the nearest of 32."""
    if word not in DEPTH or word == "depth32f":
        return np.ascontiguousarray(values)
    most = 0xFFFF if word == "depth16" else 0xFFFFFF
    codes = np.rint(np.clip(values.astype(np.float64), 0.0, 1.0) * most).astype(np.uint32)
    return codes.astype(np.uint16) if word == "depth16" else codes << 8 | codes >> 16


def stored_depths(word: str, values: Array) -> Array:
    """Texels as shaders get them after `uploaded`: depths are those that their codes stand for."""
    if word not in DEPTH or word == "depth32f":
        return values
    codes = uploaded(word, values)
    return (codes / float(np.iinfo(codes.dtype).max)).astype(np.float32)


def read_as(word: str) -> tuple[str, str, str]:
    """The format and the type in which texels of an attachment are read, and the array they go
    into: in fours, floats whatever their size."""
    found = format_of(word)
    if found.numpy is np.uint8:
        return "RGBA", "UNSIGNED_BYTE", "Uint8Array"
    if found.numpy is np.int32:
        return "RGBA_INTEGER", "INT", "Int32Array"
    if found.numpy is np.uint32:
        return "RGBA_INTEGER", "UNSIGNED_INT", "Uint32Array"
    return "RGBA", "FLOAT", "Float32Array"


READ_TYPES = {
    "Uint8Array": np.uint8, "Int32Array": np.int32, "Uint32Array": np.uint32,
    "Float32Array": np.float32,
}  # fmt: skip


def require_filtered(device: Device, word: str, filters: tuple[str, str], compared: bool) -> None:
    """Raise UnsupportedError where WebGL2 does not filter a format: a texture of it would be
    incomplete."""
    if all(name in ("nearest", "nearest_mipmap_nearest") for name in filters):
        return
    if word in DEPTH and not compared:
        raise UnsupportedError(f"filtering {word}: WebGL2 filters depths only as it compares them")
    if word.endswith("32f") and word not in DEPTH:
        device.require("OES_texture_float_linear", f"filtering {word}")
