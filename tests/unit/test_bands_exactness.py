"""What makes bands fast must not change a bit of them: each shortcut against the plain way."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shaderlab.bands import Band, Rules
from shaderlab.bands.arithmetic import multiply, sum_last
from shaderlab.bands.bounds import contains
from shaderlab.bands.rounding import (
    add_outward,
    round_down,
    round_up,
    ulp,
    widen_by_ulps,
)
from shaderlab.glslmath import normalize

Array = NDArray[np.float64]
SPECIAL = [0.0, 2.0**-149, 2.0**-150, 1.5 * 2.0**-149, 2.0**-126, 2.0**-127, 1.0, 1.0 + 2.0**-40,
           1.0 - 2.0**-40, 2.0**127 * 1.9999999, 3.4028235e38, 3.5e38, 1e300, np.inf]  # fmt: skip


def numbers(count: int = 4000) -> Array:
    random = np.random.default_rng(3)
    drawn = random.normal(size=count) * 2.0 ** random.integers(-155, 130, count)
    with np.errstate(over="ignore"):
        exact = drawn.astype(np.float32).astype(np.float64)
    both = np.concatenate([drawn, SPECIAL, exact])
    return np.concatenate([both, -both])


@pytest.mark.parametrize(("rounded", "end"), [(round_down, -np.inf), (round_up, np.inf)])
def test_rounding_outward_is_the_nearest_float_or_its_neighbour(rounded, end) -> None:  # type: ignore[no-untyped-def]
    x = numbers()
    with np.errstate(all="ignore"):
        nearest = x.astype(np.float32)
        past = nearest > x if end < 0 else nearest < x
        expected = np.where(past, np.nextafter(nearest, np.float32(end)), nearest)
        got = rounded(x)
    assert got.tobytes() == expected.astype(np.float64).tobytes()
    assert np.isnan(rounded(np.array([np.nan]))).all()


def test_a_sum_s_bounds_see_what_float64_loses() -> None:
    a, b = np.array([1.0, 1.0, -1.0, 0.5]), np.array([1e-30, -1e-30, 1e-30, 0.25])
    low, high = add_outward((a, a), (b, b))
    assert low.tolist() == [1.0, np.nextafter(1.0, 0.0), -1.0, 0.75]
    assert high.tolist() == [np.nextafter(1.0, 2.0), 1.0, np.nextafter(-1.0, 0.0), 0.75]


def widened_plainly(lo: Array, hi: Array, ulps: float) -> tuple[Array, Array]:
    """What `widen_by_ulps` does, value by value."""
    ends = []
    for one, other in zip(lo.tolist(), hi.tolist(), strict=True):
        out = [ulps * float(ulp(np.array([x]))[0]) + 2.0**-50 * min(abs(x), 3.4028234663852886e38)
               for x in (one, other)]  # fmt: skip
        down_by = min(max(out[1], out[0]), 2.0 * out[0]) if one > 0.0 else out[0]
        up_by = min(max(out[0], out[1]), 2.0 * out[1]) if other < 0.0 else out[1]
        ends.append(
            (
                max(one - down_by, 0.0) if one >= 0.0 else one - down_by,
                min(other + up_by, 0.0) if other <= 0.0 else other + up_by,
            )
        )
    return np.array([e[0] for e in ends]), np.array([e[1] for e in ends])


@pytest.mark.parametrize("ulps", [2.0, 2.5, 4096.0])
def test_widening_by_ulps_is_the_same_for_all_kinds_of_numbers(ulps: float) -> None:
    x = numbers(400)
    x = x[np.abs(x) < 3e38]
    ends = np.sort(np.stack([x, np.random.default_rng(9).permutation(x)]), axis=0)
    positive = np.abs(ends[:, (np.abs(ends) > 1e-30).all(axis=0)])
    for lo, hi in (ends, np.sort(positive, axis=0)):
        expected = widened_plainly(lo, hi, ulps)
        got = widen_by_ulps(lo, hi, ulps, ulps)
        assert [end.tolist() for end in got] == [end.tolist() for end in expected]


def test_an_ulp_leaves_its_argument_alone() -> None:
    x = numbers()
    kept = x.copy()
    with np.errstate(all="ignore"):
        size = np.clip(np.abs(x), 2.0**-149, 3.4028234663852886e38)
        exponent = np.frexp(size)[1] - 1 - (np.frexp(size)[0] == 0.5)
        expected = np.maximum(2.0 ** (exponent - 23.0), 2.0**-149)
        assert ulp(x).tolist() == expected.tolist()
    assert x.tobytes() == kept.tobytes()


@pytest.mark.parametrize("size", [2, 3, 4])
def test_sums_over_components_are_those_of_numpy(size: int) -> None:
    random = np.random.default_rng(size)
    values = random.normal(size=(500, size)) * 10.0 ** random.integers(-6, 6, (500, size))
    given = Band.exact(values)
    terms = sum_last(given).terms
    assert terms is not None
    assert terms.abs_sum.tolist() == np.abs(given.lo).sum(axis=-1, keepdims=True).tolist()


def test_a_direction_asked_for_again_is_the_same_but_no_square() -> None:
    v = Band.exact(np.random.default_rng(5).normal(size=(200, 3)))
    first, second, fresh = normalize(v), normalize(v), normalize(Band.exact(v.lo))
    assert first is not second
    for one in (first, second):
        assert one.lo.tobytes() == fresh.lo.tobytes() and one.hi.tobytes() == fresh.hi.tobytes()
    product, apart = multiply(first, second), multiply(fresh, normalize(Band.exact(v.lo)))
    assert product.lo.tobytes() == apart.lo.tobytes()
    assert product.hi.tobytes() == apart.hi.tobytes()


def test_constants_seen_before_have_the_same_bounds_whatever_the_rules() -> None:
    for value in (0.1, 1.0 / 2.2, (0.5, 0.3), 3.0):
        first, second = Band.literal(value), Band.literal(value)
        strict = Band.literal(value, Rules(rearrange=False))
        assert first is not second and strict.rules == Rules(rearrange=False)
        assert first.lo.tolist() == second.lo.tolist() == strict.lo.tolist()
        assert first.hi.tolist() == second.hi.tolist() == strict.hi.tolist()
    with pytest.raises(ValueError, match="read-only"):
        Band.literal(0.1).lo[0] = 0.0


def test_bounds_kept_as_float32_give_the_same_verdicts() -> None:
    random = np.random.default_rng(6)
    low = random.normal(size=(3000, 3)).astype(np.float32)
    high = low + random.choice([0.0, 1e-6, 1.0, np.inf], size=low.shape).astype(np.float32)
    measured = np.where(random.random(low.shape) < 0.5, low, high) + np.float32(1e-7)
    measured[:50] = np.nan
    for nan in (np.False_, random.random(low.shape) < 0.5):
        narrow = contains(low, high, nan, measured)
        wide = contains(low.astype(np.float64), high.astype(np.float64), nan, measured)
        assert narrow.tolist() == wide.tolist() and 0 < narrow.sum() < narrow.size


def test_a_signalling_nan_is_judged_without_a_warning() -> None:
    measured = np.array([[0x7F800001]], np.uint32).view(np.float32)
    band = Band.between([[0.0]], [[1.0]])
    with np.errstate(all="raise"):
        assert not band.contains(measured).any()
