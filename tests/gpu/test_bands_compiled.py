"""Formulas of the catalogue give the same bands by compiled passes and by NumPy alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.bands import band_of, jobs
from shaderlab.bands import Band, compiled

CASES = ("blinn-phong", "pbr")


def arrays(value: Any) -> list[Any]:
    """The bounds and flags of a formula's value, of all its parts."""
    if isinstance(value, tuple | list):
        return [array for part in value for array in arrays(part)]
    return [value.lo, value.hi, *value.flags] if isinstance(value, Band) else []


@pytest.mark.skipif(compiled.KERNELS is None, reason="no compiled passes (see shaderlab doctor)")
def test_formulas_of_the_catalogue_are_numpy_s() -> None:
    compared = set()
    for job in jobs(16, CASES):
        got = arrays(band_of(job))
        with compiled.numpy_alone():
            expected = arrays(band_of(job))
        for ours, theirs in zip(got, expected, strict=True):
            np.testing.assert_array_equal(ours, theirs, strict=True)
        if got:
            compared.add((job.case, job.check.name))
    assert {case for case, _ in compared} == set(CASES) and len(compared) > 12
