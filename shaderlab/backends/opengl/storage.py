"""Storage buffers, which shaders write to from any invocation."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from shaderlab.backends.opengl.device import Device
from shaderlab.backends.opengl.pyopengl import GL
from shaderlab.errors import UnsupportedError
from shaderlab.frame import Array


@contextmanager
def bound(device: Device, count: int) -> Iterator[Callable[[], Array]]:
    """See `shaderlab.backends.Backend.storage`."""
    extensions = device.context.extensions
    for name in ("GL_ARB_shader_storage_buffer_object", "GL_ARB_shader_image_load_store"):
        if name not in extensions:
            raise UnsupportedError(f"storage buffers: this driver lacks {name}")
    buffer = device.context.buffer(np.zeros(count, np.uint32))

    def read() -> Array:
        GL.glMemoryBarrier(GL.GL_BUFFER_UPDATE_BARRIER_BIT)
        return np.frombuffer(buffer.read(), np.uint32)

    try:
        buffer.bind_to_storage_buffer(0)
        yield read
    finally:
        buffer.release()
