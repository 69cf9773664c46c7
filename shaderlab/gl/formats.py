"""Attachment and texture formats: OpenGL's numbers and NumPy's types for each name.

Source: OpenGL 4.5 core profile specification, tables 8.10 to 8.13 (sized internal formats).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class ColorFormat:
    """`components` and moderngl's `dtype` ("f1" is unsigned normalised); `internal` if moderngl
    can't tell the format from those two alone."""

    components: int
    dtype: str
    numpy: type[np.generic]
    internal: int | None = None

    @property
    def integer(self) -> bool:
        """Whether shaders write plain integers to it."""
        return self.dtype in ("i4", "u4")

    @property
    def scalar(self) -> str:
        """The letter that a sampler of such a texture begins with: "", "i" or "u"."""
        return self.dtype[0] if self.integer else ""


COLOR: dict[str, ColorFormat] = {
    "r8": ColorFormat(1, "f1", np.uint8),
    "rg8": ColorFormat(2, "f1", np.uint8),
    "rgb8": ColorFormat(3, "f1", np.uint8),
    "rgba8": ColorFormat(4, "f1", np.uint8),
    "srgb8_alpha8": ColorFormat(4, "f1", np.uint8, 0x8C43),
    "r16f": ColorFormat(1, "f2", np.float16),
    "rg16f": ColorFormat(2, "f2", np.float16),
    "rgba16f": ColorFormat(4, "f2", np.float16),
    "r32f": ColorFormat(1, "f4", np.float32),
    "rg32f": ColorFormat(2, "f4", np.float32),
    "rgb32f": ColorFormat(3, "f4", np.float32),
    "rgba32f": ColorFormat(4, "f4", np.float32),
    "r32i": ColorFormat(1, "i4", np.int32),
    "rg32i": ColorFormat(2, "i4", np.int32),
    "rgba32i": ColorFormat(4, "i4", np.int32),
    "r32ui": ColorFormat(1, "u4", np.uint32),
    "rg32ui": ColorFormat(2, "u4", np.uint32),
    "rgba32ui": ColorFormat(4, "u4", np.uint32),
}


@dataclass(frozen=True)
class Transfer:
    """How OpenGL names a format: as it is kept, and the components and type it comes in."""

    internal: int
    components: int
    type: int


_KEPT = {
    "r8": 0x8229, "rg8": 0x822B, "rgb8": 0x8051, "rgba8": 0x8058, "srgb8_alpha8": 0x8C43,
    "r16f": 0x822D, "rg16f": 0x822F, "rgba16f": 0x881A,
    "r32f": 0x822E, "rg32f": 0x8230, "rgb32f": 0x8815, "rgba32f": 0x8814,
    "r32i": 0x8235, "rg32i": 0x823B, "rgba32i": 0x8D82,
    "r32ui": 0x8236, "rg32ui": 0x823C, "rgba32ui": 0x8D70,
}  # fmt: skip
_COMPONENTS = {1: 0x1903, 2: 0x8227, 3: 0x1907, 4: 0x1908}
_INTEGERS = {1: 0x8D94, 2: 0x8228, 3: 0x8D98, 4: 0x8D99}
_TYPE = {"f1": 0x1401, "f2": 0x140B, "f4": 0x1406, "i4": 0x1404, "u4": 0x1405}
_DEPTH_COMPONENT, _FLOAT = 0x1902, 0x1406


def transfer(word: str) -> Transfer:
    """How a colour or depth format is uploaded and read; depths as floats.

    >>> hex(transfer("rgba8").internal), hex(transfer("depth24").components)
    ('0x8058', '0x1902')
    """
    if word in DEPTH:
        return Transfer(DEPTH[word][0], _DEPTH_COMPONENT, _FLOAT)
    kind = COLOR[word]
    names = _INTEGERS if kind.integer else _COMPONENTS
    return Transfer(_KEPT[word], names[kind.components], _TYPE[kind.dtype])


# name: (internal format, has stencil)
DEPTH: dict[str, tuple[int, bool]] = {
    "depth16": (0x81A5, False),
    "depth24": (0x81A6, False),
    "depth32f": (0x8CAC, False),
    "depth24_stencil8": (0x88F0, True),
    "depth32f_stencil8": (0x8CAD, True),
}


def for_output(glsl_type: str) -> str:
    """The 32-bit format that holds a fragment output of this GLSL type without loss.

    There is no renderable three-component format, so a vec3 takes four.
    """
    base, size = glsl_type, 1
    for prefix, scalar in (("vec", "float"), ("ivec", "int"), ("uvec", "uint")):
        if glsl_type.startswith(prefix):
            base, size = scalar, int(glsl_type[len(prefix)])
    kind = {"float": "f", "int": "i", "uint": "ui"}[base]
    return {1: "r", 2: "rg", 3: "rgba", 4: "rgba"}[size] + "32" + kind


def components_of(glsl_type: str) -> int:
    """Number of components of a GLSL scalar or vector type (16 for a mat4).

    >>> components_of("vec3"), components_of("float"), components_of("mat3")
    (3, 1, 9)
    """
    if glsl_type.startswith("mat"):
        columns = int(glsl_type[3])
        rows = int(glsl_type[5]) if "x" in glsl_type else columns
        return columns * rows
    return int(glsl_type[-1]) if glsl_type[-1].isdigit() else 1


def numpy_type(glsl_type: str) -> Any:
    """The NumPy type a uniform or attribute of this GLSL type is uploaded as."""
    if glsl_type in ("int", "bool") or glsl_type.startswith(("ivec", "bvec")):
        return np.int32
    if glsl_type == "uint" or glsl_type.startswith("uvec"):
        return np.uint32
    if glsl_type == "double" or glsl_type.startswith(("dvec", "dmat")):
        return np.float64
    return np.float32


def depth_storage(word: str) -> tuple[int, int]:
    """The components and type that an empty depth texture of this format is made with."""
    return {
        "depth24_stencil8": (0x84F9, 0x84FA),
        "depth32f_stencil8": (0x84F9, 0x8DAD),
    }.get(word, (_DEPTH_COMPONENT, _FLOAT))
