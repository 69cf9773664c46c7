"""The lab's formats as Vulkan has them, and texels as they lie in a buffer.

Source: Vulkan 1.3 Specification, chapters Formats and Copy Commands.
"""

from __future__ import annotations

import functools

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, leading

from ..programs.formats import DEPTH, format_of
from .api import constant, ffi, lib
from .device import Device

_CHANNELS = {"r": "R{0}", "rg": "R{0}G{0}", "rgb": "R{0}G{0}B{0}A{0}", "rgba": "R{0}G{0}B{0}A{0}"}
_NUMBERS = {
    "8": (8, "UNORM"), "16f": (16, "SFLOAT"), "32f": (32, "SFLOAT"), "32i": (32, "SINT"),
    "32ui": (32, "UINT"),
}  # fmt: skip
_SPELT = {
    f"{channels}{numbers}": f"{pattern.format(bits)}_{kind}"
    for channels, pattern in _CHANNELS.items()
    for numbers, (bits, kind) in _NUMBERS.items()
} | {
    "srgb8_alpha8": "R8G8B8A8_SRGB",
    "depth16": "D16_UNORM",
    "depth24": "X8_D24_UNORM_PACK32",
    "depth32f": "D32_SFLOAT",
    "depth24_stencil8": "D24_UNORM_S8_UINT",
    "depth32f_stencil8": "D32_SFLOAT_S8_UINT",
    "bc1": "BC1_RGB_UNORM_BLOCK",
    "bc3": "BC3_UNORM_BLOCK",
    "bc7": "BC7_UNORM_BLOCK",
    "etc2_rgb8": "ETC2_R8G8B8_UNORM_BLOCK",
    "etc2_eac_rgba8": "ETC2_R8G8B8A8_UNORM_BLOCK",
}  # fmt: skip
_FINER = {"depth24": "depth32f", "depth24_stencil8": "depth32f_stencil8"}
COLOR_ASPECT, DEPTH_ASPECT, STENCIL_ASPECT = 1, 2, 4


def vulkan_format(word: str) -> int:
    """The VkFormat of a format; one of three channels has a fourth, since few devices draw to
    three."""
    return constant(f"FORMAT_{_SPELT[word]}")


def stored_as(device: Device, word: str, *uses: str) -> str:
    """The format that a device keeps an image of a format in: the same, or, for 24 bits of depth
    where it has none, 32.

    Args:
        device: where the image is to be.
        word: the format.
        uses: what the image must serve for, such as "color_attachment" or "sampled_image".

    Raises:
        UnsupportedError: the device has no such image.
    """
    for candidate in (word, _FINER.get(word, word)):
        if not lacking(device, candidate, *uses):
            return candidate
    what = ", ".join(use.replace("_", " ") for use in lacking(device, word, *uses))
    raise UnsupportedError(f"{word}: this device has no VK_FORMAT_{_SPELT[word]} as {what}")


def lacking(device: Device, word: str, *uses: str) -> list[str]:
    """Those of the uses that a device does not offer for a format, in optimal tiling."""
    found = ffi.new("VkFormatProperties *")
    lib.vkGetPhysicalDeviceFormatProperties(device.physical, vulkan_format(word), found)
    have = found.optimalTilingFeatures
    return [use for use in uses if not have & constant(f"FORMAT_FEATURE_{use.upper()}_BIT")]


def aspects(word: str) -> int:
    """The aspects that an image of a format has."""
    if word not in DEPTH:
        return COLOR_ASPECT
    return DEPTH_ASPECT | (STENCIL_ASPECT if DEPTH[word].stencil else 0)


@functools.cache
def _one(kind: type) -> int:
    return 255 if kind is np.uint8 else 1


def packed(word: str, values: Array) -> Array:
    """Texels as a buffer holds them: depths as codes, three channels with a fourth, which is 1."""
    if word in DEPTH:
        return _codes(word, values)
    kind = format_of(word)
    if kind.components != 3:
        return np.ascontiguousarray(values)
    padded = np.full((*values.shape[:-1], 4), _one(kind.numpy), kind.numpy)
    padded[..., :3] = values
    return padded


def unpacked(word: str, data: Array, shape: tuple[int, ...]) -> Array:
    """The texels that the bytes of a buffer are, (*shape, channels); the inverse of `packed`."""
    if word in DEPTH:
        return _depths(word, data).reshape(*shape, 1)
    kind = format_of(word)
    stored = 4 if kind.components == 3 else kind.components
    values = data.view(kind.numpy).reshape(*shape, stored)
    return leading(values, kind.components)


def texel_bytes(word: str) -> int:
    """How many bytes a texel takes in a buffer."""
    if word in DEPTH:
        return 2 if word == "depth16" else 4
    kind = format_of(word)
    count = 4 if kind.components == 3 else kind.components
    return count * int(np.dtype(kind.numpy).itemsize)


def _codes(word: str, values: Array) -> Array:
    if word.startswith("depth32f"):
        return np.ascontiguousarray(values, np.float32)
    most = 0xFFFF if word == "depth16" else 0xFFFFFF
    codes = np.rint(np.clip(values.astype(np.float64), 0.0, 1.0) * most)
    return np.ascontiguousarray(codes, np.uint16 if word == "depth16" else np.uint32)


def _depths(word: str, data: Array) -> Array:
    if word.startswith("depth32f"):
        return data.view(np.float32).copy()
    if word == "depth16":
        return (data.view(np.uint16) / 65535.0).astype(np.float32)
    return ((data.view(np.uint32) & 0xFFFFFF) / float(0xFFFFFF)).astype(np.float32)
