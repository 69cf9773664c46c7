"""Distances from a band's middle: every kind of band, in blocks, and who is furthest."""

from __future__ import annotations

import numpy as np
import pytest

from shaderlab.bands import Band
from shaderlab.bands.bounds import contains, widths
from shaderlab.engine.judging import banded
from shaderlab.engine.judging.banded import BoundedValues

INF, NAN = np.inf, np.nan
# low, high, whether NaN is legal, measured
KINDS = [
    (0.0, 2.0, False, 1.0), (0.0, 2.0, False, 0.25), (0.0, 2.0, False, 2.0), (0.0, 2.0, False, 2.5),
    (0.0, 2.0, False, NAN), (0.0, 2.0, True, NAN), (0.0, 2.0, True, -1.0), (3.0, 3.0, False, 3.0),
    (3.0, 3.0, False, 3.0000002), (3.0, 3.0, False, INF), (0.0, INF, False, 7.0),
    (0.0, INF, False, INF), (0.0, INF, False, -1.0), (-INF, 0.0, False, 0.5),
    (-INF, INF, True, 0.5), (-INF, INF, True, NAN), (INF, INF, False, INF), (INF, INF, False, 1.0),
    (0.0, 0.0, False, 0.0), (-3e38, 3e38, False, 1e38),
]  # fmt: skip


def placed(kinds: np.ndarray, components: int, unit: float | None = None) -> BoundedValues:
    low, high, nan, measured = (column.reshape(-1, components) for column in kinds.T)
    inside = contains(low, high, nan.astype(bool), measured)
    narrow = (a.astype(np.float32) for a in (measured, low, high))
    m, lo, hi = narrow if unit is None else (measured, low, high)
    return BoundedValues(measured=m, low=lo, high=hi, inside=inside, unit=unit)


def plainly(kinds: np.ndarray, components: int, unit: float | None) -> np.ndarray:
    """The same for all values at once: at most 1 inside, at least 1 outside."""
    given = kinds if unit else kinds.astype(np.float32).astype(float)
    low, high, nan, measured = (column.reshape(-1, components) for column in given.T)
    found = widths(low, high, nan.astype(bool), measured, unit or 0.0)
    found = np.where(np.isnan(found), INF, found)
    inside = contains(low, high, nan.astype(bool), measured)
    return np.where(inside, np.minimum(found, 1.0), np.maximum(found, 1.0))


@pytest.mark.parametrize("block", [1, 3, 100])
@pytest.mark.parametrize("unit", [None, 1.0])
@pytest.mark.parametrize("components", [1, 2, 4])
def test_blocks_give_what_all_at_once_gives(
    monkeypatch: pytest.MonkeyPatch, block: int, unit: float | None, components: int
) -> None:
    monkeypatch.setattr(banded, "BLOCK", block)
    generator = np.random.default_rng(2)
    for _ in range(6):
        kinds = np.array(KINDS)[generator.integers(0, len(KINDS), 60)]
        seen, expected = placed(kinds, components, unit), plainly(kinds, components, unit)
        size = np.where(seen.inside, expected, INF).max(axis=1)
        np.testing.assert_array_equal(np.abs(seen.measure_distances()), size)
        # Whatever comes first in the order of distances is found, wherever the array begins.
        for first in (0, 1, len(expected) // 2):
            rest = placed(kinds[first * components :], components, unit)
            row, component = rest.furthest()
            assert row * components + component == int(np.argmax(expected[first:]))


@pytest.mark.parametrize(("low", "high", "nan", "measured"), KINDS)
def test_one_value_has_the_width_that_its_band_says(
    low: float, high: float, nan: bool, measured: float
) -> None:
    kinds = np.array([[low, high, nan, measured]])
    bounds = (np.array([v], np.float32).astype(float) for v in (low, high))
    lo, hi = bounds
    value = np.array([measured], np.float32).astype(float)
    assert placed(kinds, 1).widths_at(0, 0) == widths(lo, hi, np.array([nan]), value)[0]


@pytest.mark.parametrize(
    ("low", "high", "measured", "distance"),
    [
        *((-INF, 1.5, 1.5, 0.0), (-INF, 1.5, -1e30, 0.0), (-INF, 1.5, -INF, 0.0)),
        *((-INF, 1.5, 1.5 + 3 * 2.0**-23, 4.0), (-INF, -1.5, -1.5 + 5 * 2.0**-23, 6.0)),
        *((1.5, INF, 1.5, 0.0), (1.5, INF, 1e30, 0.0), (1.5, INF, INF, 0.0)),
        *((1.5, INF, 1.5 - 3 * 2.0**-23, 4.0), (-1.5, INF, -1.5 - 5 * 2.0**-23, 6.0)),
        *((-INF, INF, 7.0, 0.0), (-INF, 1.5, NAN, INF), (1.5, INF, NAN, INF)),
    ],
)
def test_beyond_the_end_of_a_band_with_one_end_the_distance_counts_ulps(
    low: float, high: float, measured: float, distance: float
) -> None:
    band = Band.between([low], [high])
    assert band.widths([measured]) == distance
    assert band.contains([measured]) == (distance == 0.0)


def test_a_value_outside_outranks_all_inside() -> None:
    kinds = np.array([(0.0, 2.0, False, 2.0), (0.0, 2e30, False, -1e-30), (0.0, 2.0, False, 0.0)])
    assert placed(kinds, 1).furthest() == (0, 0)  # all are at 1: the first
    kinds[1, 3] = -1e25
    assert placed(kinds, 1).furthest() == (1, 0)


def test_signs_say_on_which_side_of_the_middle() -> None:
    kinds = np.array([(0.0, 2.0, False, v) for v in (0.5, 1.75, -9.0, 9.0)])
    assert placed(kinds, 1).measure_distances().tolist() == [-0.5, 0.75, -INF, INF]
