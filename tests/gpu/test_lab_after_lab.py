"""Labs one after the other in one process do not disturb each other."""

from __future__ import annotations

import gc

import numpy as np

from shaderlab.backends import open_backend


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
