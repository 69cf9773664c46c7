"""Vulkan's functions, as the package `vulkan` declares them, and its structures.

Source: Khronos, Vulkan 1.3 Specification.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from shaderlab.errors import DeviceLostError, DriverError

try:
    import vulkan
except (ImportError, OSError) as error:  # OSError: there is no loader
    raise DriverError(
        f"no Vulkan loader, or not the package for it ({error})",
        remedy="pip install 'shaderlab[vulkan]' · Debian/Ubuntu: apt-get install libvulkan1",
    ) from error

ffi: Any = vulkan.ffi
lib: Any = vulkan.lib
NULL = ffi.NULL

_LOST = -4


def constant(name: str) -> int:
    """A constant by its name without "VK_"."""
    return int(getattr(vulkan, f"VK_{name}"))


def check(result: int, what: str) -> None:
    """Raise for a result that is an error.

    Raises:
        DeviceLostError: the device is lost; nothing more can be done with it.
        MemoryError: memory ran out.
        DriverError: any other error.
    """
    if result >= 0:
        return
    if result == _LOST:
        raise DeviceLostError(f"the device was lost: {what}")
    if result in (-1, -2):
        raise MemoryError(f"{what}: the driver ran out of memory")
    raise DriverError(f"{what}: {result_name(result)}")


def result_name(result: int) -> str:
    """A result code's name."""
    error = vulkan.exception_codes.get(result)
    return error.__name__ if error is not None else f"VkResult {result}"


class Structs:
    """Makes structures, and keeps all that they point to as long as it is there itself.

    `structs("Viewport", width=8.0)` is a pointer to a new VkViewport, its sType set. A list or an
    array for a pointer becomes a C array, a text a C string, and a pointer to a structure is copied
    where a structure is wanted.
    """

    def __init__(self) -> None:
        self._kept: list[Any] = []

    def __call__(self, name: str, **fields: Any) -> Any:
        made = ffi.new(f"Vk{name} *")
        types = _fields(name)
        if "sType" in types:
            made.sType = _structure_type(name)
        for field, value in fields.items():
            setattr(made, field, self._value(types[field], value))
        self._kept.append(made)
        return made

    def array(self, kind: str, values: Sequence[Any]) -> Any:
        """A C array, such as `array("VkBuffer", [a, b])`; NULL for no values."""
        return self._value(ffi.typeof(f"{kind} *"), list(values))

    def _value(self, kind: Any, value: Any) -> Any:
        if kind.kind == "pointer":
            return ffi.cast(kind, self._pointer(kind, value))
        if kind.kind in ("struct", "union") and isinstance(value, ffi.CData):
            return value[0] if ffi.typeof(value).kind == "pointer" else value
        return value

    def _pointer(self, kind: Any, value: Any) -> Any:
        if isinstance(value, str):
            value = ffi.new("char[]", value.encode())
        elif isinstance(value, list | tuple):
            items = [self._value(kind.item, item) for item in value]
            value = ffi.new(f"{kind.item.cname}[]", items) if items else NULL
        elif isinstance(value, np.ndarray | bytes):
            value = ffi.from_buffer(value)
        self._kept.append(value)
        return value


@functools.cache
def _fields(name: str) -> dict[str, Any]:
    return {field: known.type for field, known in ffi.typeof(f"Vk{name}").fields}


@functools.cache
def _structure_type(name: str) -> int:
    words = re.sub(r"(?<=[a-z])(?=[A-Z0-9])|(?<=\d)(?=[A-Z][a-z])", "_", name)
    return constant(f"STRUCTURE_TYPE_{words.upper()}")
