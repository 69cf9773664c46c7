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
