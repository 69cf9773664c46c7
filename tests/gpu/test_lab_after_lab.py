"""Labs in one process do not disturb each other: one after the other, or in turn."""

from __future__ import annotations

import numpy as np

from shaderlab.drivers import open_backend
from shaderlab.drivers.opengl.buffers import DeviceBuffer
from shaderlab.drivers.opengl.device import GL


def test_devices_are_used_in_turn() -> None:
    """Both give the same numbers to their buffers."""
    first, second = open_backend("llvmpipe"), open_backend("llvmpipe")
    try:
        one, other = first.device, second.device  # type: ignore[attr-defined]
        with one.in_use():
            ours = DeviceBuffer(np.arange(4, dtype="f4"))
        with other.in_use():
            theirs = DeviceBuffer(np.zeros(4, "f4"))
            assert theirs.glo == ours.glo  # the first buffer of each context
            with one.in_use():
                assert np.frombuffer(ours.read(), "f4").tolist() == [0.0, 1.0, 2.0, 3.0]
            assert np.frombuffer(theirs.read(), "f4").tolist() == [0.0] * 4
    finally:
        first.close()
        second.close()


def test_a_device_within_its_own_use_gives_back_the_one_between() -> None:
    """As where a driver's verdict is asked for while calls are recorded."""
    first, second = open_backend("llvmpipe"), open_backend("llvmpipe")
    try:
        one, other = first.device, second.device  # type: ignore[attr-defined]
        with one.in_use(), other.in_use():
            with one.in_use():
                pass
            made = DeviceBuffer(np.arange(4, dtype="f4"))
        with one.in_use():
            theirs = DeviceBuffer(np.zeros(4, "f4"))
            assert theirs.glo == made.glo  # the first buffer of each context
        with other.in_use():
            assert np.frombuffer(made.read(), "f4").tolist() == [0.0, 1.0, 2.0, 3.0]
    finally:
        first.close()
        second.close()


def test_checks_stay_suspended_after_the_use_of_another_device_within() -> None:
    """PyOpenGL has one check for the process: the inner device's end must not turn it on again."""
    first, second = open_backend("llvmpipe"), open_backend("llvmpipe")
    try:
        one, other = first.device, second.device  # type: ignore[attr-defined]
        with one.in_use():
            with other.in_use():
                pass
            GL.glEnable(GL.GL_TEXTURE_BUFFER_BINDING)  # no capability
            assert GL.glGetError() == GL.GL_INVALID_ENUM
    finally:
        first.close()
        second.close()
