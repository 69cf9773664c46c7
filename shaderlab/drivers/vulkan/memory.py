"""Objects on the device that are released together, and buffers that this process can write."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from shaderlab.model.frame import Array

from .api import NULL, Structs, check, constant, ffi, lib
from .device import Device

_HOST = 0x2 | 0x4  # visible to this process, without flushing
_CACHED = 0x8
_DEVICE_LOCAL = 0x1


@dataclass(frozen=True)
class Buffer:
    """A buffer, mapped: `bytes` are its contents, which can be read and written."""

    handle: Any
    bytes: Array


class Resources:
    """Makes objects on the device, and releases all of them together, the last one first."""

    def __init__(self, device: Device) -> None:
        self.device = device
        self._made: list[tuple[str, Any]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def release(self) -> None:
        """Release everything; the device must be done with it."""
        while self._made:
            kind, handle = self._made.pop()
            if kind == "Memory":
                lib.vkFreeMemory(self.device.handle, handle, NULL)
            else:
                self.device.destroy(kind, handle)

    def create(self, kind: str, info: Any) -> Any:
        """A new object, such as `create("Sampler", info)`."""
        handle = self.device.create(kind, info)
        return self.own(kind, handle)

    def own(self, kind: str, handle: Any) -> Any:
        """Release this object, too, in the end."""
        self._made.append((kind, handle))
        return handle

    def buffer(self, usage: str, data: bytes | Array | None = None, *, size: int = 0) -> Buffer:
        """A buffer of `size` zeros, or of `data`, for a usage such as "uniform_buffer"."""
        given = np.frombuffer(b"" if data is None else data, np.uint8)
        length = max(size, given.nbytes, 16)
        structs = Structs()
        bits = constant(f"BUFFER_USAGE_{usage.upper()}_BIT")
        handle = self.create("Buffer", structs("BufferCreateInfo", size=length, usage=bits))
        needs = ffi.new("VkMemoryRequirements *")
        lib.vkGetBufferMemoryRequirements(self.device.handle, handle, needs)
        memory = self._allocate(needs, _HOST, _CACHED)
        check(lib.vkBindBufferMemory(self.device.handle, handle, memory, 0), "binding a buffer")
        at = ffi.new("void **")
        check(lib.vkMapMemory(self.device.handle, memory, 0, length, 0, at), "mapping a buffer")
        contents = np.frombuffer(ffi.buffer(at[0], length), np.uint8)
        contents[: given.nbytes] = given
        contents[given.nbytes :] = 0
        return Buffer(handle, contents)

    def bind_image_memory(self, image: Any) -> None:
        """Give a new image its memory."""
        needs = ffi.new("VkMemoryRequirements *")
        lib.vkGetImageMemoryRequirements(self.device.handle, image, needs)
        memory = self._allocate(needs, 0, _DEVICE_LOCAL)
        check(lib.vkBindImageMemory(self.device.handle, image, memory, 0), "binding an image")

    def _allocate(self, needs: Any, required: int, preferred: int) -> Any:
        fitting = [
            (number, flags) for number, flags in enumerate(self.device.memory_types)
            if needs.memoryTypeBits >> number & 1 and flags & required == required
        ]  # fmt: skip
        number = max(fitting, key=lambda kind: bool(kind[1] & preferred))[0]
        info = Structs()("MemoryAllocateInfo", allocationSize=needs.size, memoryTypeIndex=number)
        made = ffi.new("VkDeviceMemory *")
        what = f"allocating {needs.size} bytes"
        check(lib.vkAllocateMemory(self.device.handle, info, NULL, made), what)
        return self.own("Memory", made[0])
