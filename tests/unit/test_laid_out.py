"""Judged values at their pixels: any part is that of the whole, and no other value is asked for."""

from __future__ import annotations

import numpy as np
import pytest

from shaderlab.engine.expectations.formula import PixelMap

PARTS = [(0, 9, 0, 7), (2, 5, 1, 4), (8, 9, 6, 7), (0, 1, 0, 7), (3, 9, 0, 2)]


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_a_part_is_that_of_the_whole(share: float) -> None:
    random = np.random.default_rng(7)
    covered = random.random((9, 7)) < share
    values = random.random((int(covered.sum()), 3))
    asked: list[int] = []

    def some(rows: np.ndarray | slice) -> np.ndarray:
        asked.append(len(values[rows]))
        return values[rows]

    laid_out = PixelMap(covered, some, -1.0)
    whole = np.full((9, 7, 3), -1.0)
    whole[covered] = values
    assert np.array_equal(np.asarray(laid_out), whole)
    for bottom, top, left, right in PARTS:
        part = slice(bottom, top), slice(left, right)
        assert np.array_equal(laid_out[part], whole[part])
        assert asked[-1] == np.count_nonzero(covered[part])
