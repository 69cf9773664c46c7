"""OpenGL's and moderngl's numbers for formats.

Source: OpenGL 4.5 core profile specification, tables 8.10 to 8.13 (sized internal formats).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shaderlab.programs.formats import COLOR, DEPTH


@dataclass(frozen=True)
class Transfer:
    """A format's internal number, and the components and type of the pixels that it comes in."""

    internal: int
    components: int
    type: int


_COLOR = {
    "r8": 0x8229, "rg8": 0x822B, "rgb8": 0x8051, "rgba8": 0x8058, "srgb8_alpha8": 0x8C43,
    "r16f": 0x822D, "rg16f": 0x822F, "rgba16f": 0x881A,
    "r32f": 0x822E, "rg32f": 0x8230, "rgb32f": 0x8815, "rgba32f": 0x8814,
    "r32i": 0x8235, "rg32i": 0x823B, "rgba32i": 0x8D82,
    "r32ui": 0x8236, "rg32ui": 0x823C, "rgba32ui": 0x8D70,
}  # fmt: skip
_DEPTH = {
    "depth16": 0x81A5, "depth24": 0x81A6, "depth32f": 0x8CAC,
    "depth24_stencil8": 0x88F0, "depth32f_stencil8": 0x8CAD,
}  # fmt: skip
_COMPONENTS = {1: 0x1903, 2: 0x8227, 3: 0x1907, 4: 0x1908}
_INTEGERS = {1: 0x8D94, 2: 0x8228, 3: 0x8D98, 4: 0x8D99}
_TYPE = {
    np.uint8: 0x1401, np.float16: 0x140B, np.float32: 0x1406, np.int32: 0x1404, np.uint32: 0x1405,
}  # fmt: skip
_DEPTH_COMPONENT, _DEPTH_STENCIL = 0x1902, 0x84F9
_PACKED = {"depth24_stencil8": 0x84FA, "depth32f_stencil8": 0x8DAD}
_MODERNGL = {
    np.uint8: "f1", np.float16: "f2", np.float32: "f4", np.int32: "i4", np.uint32: "u4",
}  # fmt: skip


def transfer(word: str) -> Transfer:
    """How a colour or depth format is uploaded and read; depths as floats.

    >>> hex(transfer("rgba8").internal), hex(transfer("depth24").components)
    ('0x8058', '0x1902')
    """
    if word in DEPTH:
        return Transfer(_DEPTH[word], _DEPTH_COMPONENT, _TYPE[np.float32])
    kind = COLOR[word]
    names = _INTEGERS if kind.integer else _COMPONENTS
    return Transfer(_COLOR[word], names[kind.components], _TYPE[kind.numpy])


def depth_storage(word: str) -> Transfer:
    """How an empty depth texture is made: with its stencil packed beside each depth."""
    if word in _PACKED:
        return Transfer(_DEPTH[word], _DEPTH_STENCIL, _PACKED[word])
    return transfer(word)


def moderngl_type(word: str) -> str:
    """The `dtype` that moderngl has for a colour format."""
    return _MODERNGL[COLOR[word].numpy]


def moderngl_internal(word: str) -> int | None:
    """The internal format to give moderngl, where components and type don't tell it."""
    return _COLOR[word] if word == "srgb8_alpha8" else None
