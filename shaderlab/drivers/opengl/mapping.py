"""Buffers written through a mapping, whatever they are bound for."""

from __future__ import annotations

import ctypes

from shaderlab.errors import DriverError

from .pyopengl import GL


def write_mapped(target: int, whole: bytes) -> None:
    """Fill the buffer that is bound to a target.

    Raises:
        DriverError: it can't be mapped, or its contents are lost.
    """
    address = GL.glMapBufferRange(target, 0, len(whole), GL.GL_MAP_WRITE_BIT)
    if not address:
        raise DriverError(f"the driver does not map a buffer of {len(whole)} bytes")
    ctypes.memmove(address, whole, len(whole))
    if not GL.glUnmapBuffer(target):
        raise DriverError("the driver lost a buffer's contents while it was mapped")
