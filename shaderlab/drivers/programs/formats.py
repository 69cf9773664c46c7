"""Formats of attachments and textures, and GLSL types, as NumPy has them.

Source: OpenGL 4.5 core profile specification, tables 8.10 to 8.13 (sized internal formats).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.model.textures import DEPTH_FORMATS


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
    """A colour or depth format by its name."""
    return DEPTH[word] if word in DEPTH else COLOR[word]


def for_output(glsl_type: str) -> str:
    """The 32-bit format that holds a fragment output of this GLSL type without loss.

    There is no renderable three-component format, so a vec3 takes four.

    >>> for_output("float"), for_output("vec3"), for_output("uvec2")
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
