"""Arguments of OpenGL's functions as text: constants by their names, objects by what they are."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from .api import constants

# Parameters whose numbers stand for constants, and those that join bits.
_ENUMS = {
    "target", "mode", "cap", "func", "usage", "type", "format", "internalformat", "internalFormat",
    "pname", "attachment", "face", "sfactor", "dfactor", "sfactorRGB", "dfactorRGB", "sfactorAlpha",
    "dfactorAlpha", "modeRGB", "modeAlpha", "fail", "zfail", "zpass", "sfail", "dpfail", "dppass",
    "renderbuffertarget", "textarget", "filter", "buffer", "texture", "shaderType", "src",
    "primitiveMode",
}  # fmt: skip
_FLAGS = {"flag", "normalized", "transpose", "red", "green", "blue", "alpha"}
_MASKS = {"glClear", "glBlitFramebuffer", "glMapBufferRange"}
# What an object's number is a name of, by the parameter that takes it.
_OBJECTS = {
    "program": "program", "shader": "shader", "array": "vertex array", "framebuffer": "framebuffer",
    "renderbuffer": "renderbuffer", "sampler": "sampler", "buffer": "buffer", "texture": "texture",
    "id": "query",
}  # fmt: skip
_PREFERRED = {
    "mode": ("GL_POINTS", "GL_LINES"), "func": ("GL_NEVER",), "fail": ("GL_ZERO", "GL_KEEP"),
    "attachment": ("GL_COLOR_ATTACHMENT0",),
}  # fmt: skip
_BITS = ("COLOR", "DEPTH", "STENCIL", "READ", "WRITE", "INVALIDATE", "UNSYNCHRONIZED", "FLUSH")
_VENDORS = (
    "_ARB", "_EXT", "_NV", "_AMD", "_ATI", "_SGIS", "_SGIX", "_OES", "_APPLE", "_INTEL", "_IBM",
    "_HP", "_3DFX", "_MESA", "_KHR", "_SUN", "_OVR", "_PGI", "_QCOM", "_INGR",
)  # fmt: skip
_LONGEST = 40


def word(function: str, name: str, value: Any) -> str:
    """The argument of a function for its parameter `name` as text."""
    constant = getattr(value, "name", None)
    if isinstance(constant, str):  # PyOpenGL's constants know their own names
        return constant
    if isinstance(value, bool | np.bool_):
        return "GL_TRUE" if value else "GL_FALSE"
    if isinstance(value, int | np.integer):
        return _number(function, name, int(value))
    if isinstance(value, ctypes.c_void_p):
        value = value.value
        if value is not None:
            return f"byte {value}" if value < 1 << 31 else "a pointer"
    if value is None:
        return "NULL"
    if name == "bufs":
        return f"[{' '.join(constant_for(function, 'attachment', int(x)) for x in value)}]"
    if isinstance(value, float | np.floating):
        return f"{value:g}"
    if isinstance(value, bytes | bytearray | memoryview):
        return f"{len(value)} bytes"
    if isinstance(value, np.ndarray):
        text = " ".join(str(x) if x.dtype.kind in "iu" else f"{x:g}" for x in value.ravel()[:17])
        return f"[{text}]" if value.size <= 16 else f"{value.size} values"
    text = " ".join(str(value).split())
    return text if len(text) <= _LONGEST else f"{len(text)} characters"


def _number(function: str, name: str, value: int) -> str:
    if name in _FLAGS and value in (0, 1):
        return ("GL_FALSE", "GL_TRUE")[value]
    if function in _MASKS and name in ("mask", "access"):
        return _bits(function, value)
    if name in ("mask", "ref") and value > 0xFFFF:
        return f"0x{value:X}"
    known = constant_for(function, name, value) if name in _ENUMS else ""
    if known:
        return known
    if name in _OBJECTS:
        return f"{_OBJECTS[name]} {value}" if value else "0"
    return str(value) if abs(value) < 1 << 31 else "a pointer"


def constant_for(function: str, name: str, value: int) -> str:
    """The constant that a parameter's number stands for; "" for none."""
    if name in ("buffer", "texture") and function not in ("glClearBufferfv", "glActiveTexture"):
        return ""  # an object's number
    known = _constants_by_number().get(value, ())
    for word in (*_PREFERRED.get(name, ()), "GL_ZERO" if "factor" in name else "GL_NONE"):
        if word in known:
            return word
    plain = [w for w in known if not w.endswith(_VENDORS) and not w.endswith("_BIT")]
    return min(plain or known, key=len, default="")


@cache
def _constants_by_number() -> Mapping[int, Sequence[str]]:
    """The names of the constants of each number."""
    found: dict[int, list[str]] = {}
    for word, number in constants().items():
        found.setdefault(number, []).append(word)
    return found


def _bits(function: str, value: int) -> str:
    """The bits of a mask by name."""
    like = "GL_MAP_" if function.startswith("glMap") else "GL_"
    found: dict[int, str] = {}
    for word, number in constants().items():
        single = number and not number & (number - 1)
        ours = word.startswith(like) and word.endswith("_BIT") and any(b in word for b in _BITS)
        if ours and single and value & number:
            found.setdefault(number, word)
    return " | ".join(found.values()) or str(value)


def makes_objects(function: str) -> bool:
    """Whether a function makes objects: glGenerateMipmap does not."""
    return function.startswith(("glGen", "glCreate")) and not function.startswith("glGenerate")


def object_numbers(value: Any) -> str:
    """What a function that makes objects returned: their numbers."""
    return ", ".join(str(int(number)) for number in np.ravel(value))
