"""Labs in one process do not disturb each other: one after the other, or in turn."""

from __future__ import annotations

import gc

import numpy as np

from shaderlab.drivers import open_backend
from shaderlab.drivers.opengl.calls import fresh_context
from shaderlab.drivers.opengl.device import GL


def test_what_outlives_its_device_deletes_nothing_of_the_next_one() -> None:
    """Two devices give the same numbers to their buffers; only the lab can tell them apart."""
    first = open_backend("llvmpipe")
    stale = [first.device.context.buffer(np.full(4, 1.0, "f4")) for _ in range(8)]  # type: ignore[attr-defined]
    first.close()
    second = open_backend("llvmpipe")
    try:
        values = np.arange(4, dtype="f4")
        fresh = [second.device.context.buffer(values) for _ in range(8)]  # type: ignore[attr-defined]
        assert {b.glo for b in fresh} & {b.glo for b in stale}
        del stale
        gc.collect()
        assert [np.frombuffer(b.read(), "f4").tolist() for b in fresh] == [values.tolist()] * 8
    finally:
        second.close()


def test_devices_are_used_in_turn() -> None:
    """Each draws in its own context, and gives back only there what Python drops elsewhere."""
    first, second = open_backend("llvmpipe"), open_backend("llvmpipe")
    try:
        values = np.arange(4, dtype="f4")
        with first.device.in_use():  # type: ignore[attr-defined]
            stale = [first.device.context.buffer(values) for _ in range(8)]  # type: ignore[attr-defined]
        with second.device.in_use():  # type: ignore[attr-defined]
            with first.device.in_use():  # type: ignore[attr-defined]
                pass
            fresh = [second.device.context.buffer(values) for _ in range(8)]  # type: ignore[attr-defined]
            assert {b.glo for b in fresh} & {b.glo for b in stale}
            del stale[4:]
            gc.collect()
            assert [np.frombuffer(b.read(), "f4").tolist() for b in fresh] == [values.tolist()] * 8
        waiting = first.device.context.objects  # type: ignore[attr-defined]
        assert len(waiting) == 4
        with second.device.in_use(), first.device.in_use():  # type: ignore[attr-defined]
            assert not waiting
            assert [np.frombuffer(b.read(), "f4").tolist() for b in stale] == [values.tolist()] * 4
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
            made = other.context.buffer(np.arange(4, dtype="f4"))
        with one.in_use():
            theirs = one.context.buffer(np.zeros(4, "f4"))
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
            assert one.context.error == "GL_INVALID_ENUM"
    finally:
        first.close()
        second.close()


def test_what_is_dropped_beside_a_fresh_context_is_given_back_afterwards() -> None:
    """One of two buffers had been released before Python dropped it."""
    backend = open_backend("llvmpipe")
    try:
        device = backend.device  # type: ignore[attr-defined]
        released, dropped = device.context.buffer(reserve=4), device.context.buffer(reserve=4)
        released.release()
        with fresh_context(device):
            del released, dropped
            gc.collect()
            assert len(device.context.objects) == 2
        assert not device.context.objects
    finally:
        backend.close()
