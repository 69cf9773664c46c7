"""Pixel transfers from and to NumPy arrays, as they lie in memory.

PyOpenGL's own wrappers of these calls convert and copy what they are given, and know neither
half floats nor packed depth and stencil.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from shaderlab.backends.opengl.formats import Transfer
from shaderlab.backends.opengl.pyopengl import GL, GL_1_0, GL_1_2, GL_1_3
from shaderlab.frame import Array


def tex_image_2d(
    target: int, level: int, size: tuple[int, int], form: Transfer, values: Array | None
) -> None:
    """glTexImage2D; `values` is None for an empty image."""
    data = None if values is None else np.ascontiguousarray(values)
    with tightly():
        GL_1_0.glTexImage2D(
            target, level, form.internal, *size, 0, form.components, form.type, _address(data)
        )


def tex_image_3d(
    target: int, level: int, size: tuple[int, int, int], form: Transfer, values: Array
) -> None:
    """glTexImage3D of (layers, height, width, components)."""
    data = np.ascontiguousarray(values)
    with tightly():
        GL_1_2.glTexImage3D(
            target, level, form.internal, *size, 0, form.components, form.type, _address(data)
        )


def compressed_tex_image_2d(
    target: int, level: int, internal: int, size: tuple[int, int], blocks: bytes
) -> None:
    """glCompressedTexImage2D of blocks."""
    data = np.frombuffer(blocks, np.uint8)
    GL_1_3.glCompressedTexImage2D(
        target, level, internal, *size, 0, len(blocks), _address(np.ascontiguousarray(data))
    )


def get_tex_image(target: int, level: int, form: Transfer, values: Array) -> None:
    """glGetTexImage into a contiguous array of the right size and type."""
    with tightly():
        GL_1_0.glGetTexImage(target, level, form.components, form.type, _address(values))


def read_pixels(size: tuple[int, int], place: tuple[int, int], values: Array) -> None:
    """glReadPixels of the whole framebuffer that is bound, likewise."""
    with tightly():
        GL_1_0.glReadPixels(0, 0, *size, *place, _address(values))


@contextmanager
def tightly() -> Iterator[None]:
    """Rows one after the other, without padding."""
    words = (GL.GL_PACK_ALIGNMENT, GL.GL_UNPACK_ALIGNMENT)
    for word in words:
        GL.glPixelStorei(word, 1)
    try:
        yield
    finally:
        for word in words:
            GL.glPixelStorei(word, 4)


def _address(values: Array | None) -> ctypes.c_void_p | None:
    if values is None:
        return None
    assert values.flags.c_contiguous
    return ctypes.c_void_p(values.ctypes.data)
