"""Sums, products and quotients of bands hold every float32 result, and are no wider than needed."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from shaderlab import glslmath as g
from shaderlab.bands import Band, Rules
from shaderlab.errors import FormulaError

F32 = np.float32
AS_WRITTEN = Rules(rearrange=False)
KEPT = Rules(rearrange=False, flush=False)
LARGEST = float(np.finfo(F32).max)
SPECIAL = np.array(
    [
        *(0.0, -0.0, 1.0, -1.0, 1.5, 0.1, -0.3, 3.0, 2.0**-126, 2.0**-140, -(2.0**-149)),
        *(2.0**-100, 2.0**100, 2.0**126, 2.0**127, 1e30, 1e-30, LARGEST, -LARGEST),
        *(np.inf, -np.inf, np.nan, 16777216.0, 1.0 - 2.0**-24, 1.0 + 2.0**-23),
    ],
    F32,
)


def pairs(seed: int = 0, count: int = 2000) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of special values, and random bit patterns (NaN and denormals among them)."""
    rng = np.random.default_rng(seed)
    bits = rng.integers(0, 2**32, (2, count), dtype=np.uint64).astype(np.uint32)
    near = rng.normal(size=(2, count)).astype(F32)
    grid = np.array(list(product(SPECIAL, SPECIAL)), F32).T
    a, b = np.concatenate([bits.view(F32), near, grid], axis=1)
    return a[:, None], b[:, None]


OPERATIONS = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.parametrize("rules", [Rules(), AS_WRITTEN, KEPT])
def test_what_numpy_computes_in_float32_is_inside(name: str, rules: Rules) -> None:
    a, b = pairs()
    with np.errstate(all="ignore"):
        measured = OPERATIONS[name](a, b)
    band = OPERATIONS[name](Band.exact(a, rules), Band.exact(b, rules))
    outside = ~band.contains(measured)
    assert not outside.any(), (a[outside][:3], b[outside][:3], measured[outside][:3])


@pytest.mark.parametrize("name", ["+", "-", "*"])
def test_both_neighbours_of_the_exact_result_and_nothing_else(name: str) -> None:
    a, b = pairs(1, 300)
    finite = (np.isfinite(a) & np.isfinite(b))[:, 0]
    a, b = a[finite], b[finite]
    band = OPERATIONS[name](Band.exact(a, KEPT), Band.exact(b, KEPT))
    for x, y, lo, hi in zip(a[:, 0], b[:, 0], band.lo[:, 0], band.hi[:, 0], strict=True):
        exact = OPERATIONS[name](Fraction(float(x)), Fraction(float(y)))
        # inf stands for everything beyond the largest float
        assert lo == -np.inf or Fraction(lo) <= exact
        assert hi == np.inf or exact <= Fraction(hi)
        if lo == hi:
            assert exact == Fraction(lo)
        else:
            with np.errstate(over="ignore"):
                assert F32(hi) == np.nextafter(F32(lo), F32(np.inf)), "one step wide"


def test_division_allows_two_and_a_half_ulp_and_no_more() -> None:
    third = Band.exact([1.0]) / Band.exact([3.0])
    step = float(np.spacing(F32(1 / 3)))
    assert third.contains([1 / 3 + 2.4 * step]) and third.contains([1 / 3 - 2.4 * step])
    assert not third.contains([1 / 3 + 3.6 * step])
    assert not third.contains([1 / 3 - 3.6 * step])


@pytest.mark.parametrize("divisor", [0.0, -0.0, 2.0**-127, 2.0**127, np.inf])
def test_division_out_of_range_allows_anything_and_says_so(divisor: float) -> None:
    band = Band.exact([1.0]) / Band.exact([divisor])
    assert band.vacuous.all() and band.nan.all()
    assert band.contains([np.nan]) and band.contains([-5.0])


def test_exact_results_stay_single_points() -> None:
    x = Band.exact([[0.1], [3.0], [-7.5]])
    for band, truth in (
        (x * 2.0, x.lo * 2),
        (x + 0.0, x.lo),
        (x * 0.0, x.lo * 0),
        (x * 1.0, x.lo),
        (x - x, x.lo * 0),
        (-x, -x.lo),
        (abs(x), np.abs(x.lo)),
        ((x * 0.5) * 4.0, x.lo * 2.0),
        (Band.exact([0.5]) + 0.25, np.array([0.75])),
    ):
        np.testing.assert_array_equal(band.lo, truth)
        np.testing.assert_array_equal(band.hi, truth)


def test_the_residue_below_float64_is_seen() -> None:
    """1e30 + 1e-30 is 1e30 in float64 too, yet rounding upward gives the next float32."""
    band = Band.exact([1e30]) + Band.exact([1e-30])
    above = np.nextafter(F32(1e30), F32(np.inf))
    assert band.contains([above]) and band.contains([F32(1e30)])
    assert not band.contains([np.nextafter(F32(1e30), F32(0))])


def test_overflow_is_infinite_or_the_largest_float() -> None:
    band = Band.exact([LARGEST]) * 4.0
    assert band.contains([np.inf]) and band.contains([LARGEST])
    assert not band.contains([1e38]) and not band.vacuous.any()


@pytest.mark.parametrize(
    "make",
    [
        lambda: Band.exact([np.inf]) - Band.exact([np.inf]),
        lambda: Band.exact([0.0]) * Band.exact([np.inf]),
        lambda: Band.exact([0.0]) / Band.exact([0.0]),
        lambda: Band.exact([np.nan]) + 1.0,
    ],
)
def test_nan_is_tracked(make: object) -> None:
    band = make()  # type: ignore[operator]
    assert band.nan.all() and band.contains([np.nan])


def test_nan_and_infinity_are_illegal_elsewhere() -> None:
    band = Band.exact([1.0]) + 1e-9
    assert not band.contains([np.nan]) and not band.contains([np.inf])
    assert band.widths([np.nan]) == np.inf


def test_denormals_may_flush_unless_the_rules_keep_them() -> None:
    tiny = 2.0**-130
    assert Band.exact([tiny]).contains([0.0]) and Band.exact([tiny]).contains([tiny])
    assert not Band.exact([tiny], KEPT).contains([0.0])
    result = Band.exact([2.0**-100]) * Band.exact([2.0**-40])
    assert result.contains([0.0])
    assert not (Band.exact([2.0**-100], KEPT) * Band.exact([2.0**-40], KEPT)).contains([0.0])


def test_a_denormal_operand_may_flush_before_it_is_scaled_up() -> None:
    assert (Band.exact([2.0**-130]) * 2.0**40).contains([0.0])


def test_a_square_is_not_negative_but_a_product_of_two_may_be() -> None:
    x, y = Band.between([-1e-3], [1e-3]), Band.between([-1e-3], [1e-3])
    assert (x * x).lo == 0.0
    assert (x * y).lo < 0.0


def test_literals_are_the_hull_of_their_neighbours() -> None:
    tenth = Band.literal(0.1)
    assert tenth.hi - tenth.lo == np.spacing(F32(0.1))
    assert Band.literal(0.5).lo == Band.literal(0.5).hi
    computed = Band.literal(1.0 / 2.2)
    assert computed.contains([F32(1.0) / F32(2.2)])


def test_between_rounds_outward_and_refuses_the_wrong_order() -> None:
    band = Band.between([0.1], [0.1])
    assert band.lo < 0.1 < band.hi
    with pytest.raises(FormulaError, match="lower bound"):
        Band.between([2.0], [1.0])


def test_rearranging_is_allowed_by_default_and_not_as_written() -> None:
    """(a + b) - a may be b, and a·b + a·c may be a·(b + c): rounded in float32 both ways."""
    rng = np.random.default_rng(3)
    a, b, c = (rng.uniform(-1, 1, (500, 1)).astype(F32) for _ in range(3))
    band = [Band.exact(x) for x in (a, b, c)]
    assert ((band[0] + band[1]) - band[0]).contains(b).all()
    assert (band[0] * band[1] + band[0] * band[2]).contains(a * (b + c)).all()
    assert (band[0] * (band[1] + band[2])).contains(a * b + a * c).all()
    assert ((band[0] + band[1]) + band[2]).contains(a + (b + c)).all()
    strict = [Band.exact(x, AS_WRITTEN) for x in (a, b, c)]
    assert not ((strict[0] + strict[1]) + strict[2]).contains(a + (b + c)).all()


def test_a_product_of_two_sums_may_be_expanded() -> None:
    """(a + b)·(c + d) where both sums cancel: the four products round at their own size."""
    rng = np.random.default_rng(9)
    a, c = rng.uniform(0.5, 1.0, (2, 4000, 1)).astype(F32)
    b, d = (-x * rng.uniform(0.9999, 1.0001, x.shape).astype(F32) for x in (a, c))
    expanded = ((a * c + a * d) + b * c) + b * d
    first, second = Band.exact(a) + Band.exact(b), Band.exact(c) + Band.exact(d)
    assert (first * second).contains(expanded).all()


def test_sums_of_squares_are_not_negative() -> None:
    x = Band.between([0.0, -1e-3], [0.5, 1e-3])
    squares = x * x + x * x + x * x
    assert (squares.lo >= 0.0).all()
    assert not g.sqrt(squares).vacuous.any()
    y = x - 1e-4
    assert (g.dot(y, y).lo >= 0.0).all()


def test_infinities_of_both_signs_in_one_sum_may_be_nan() -> None:
    infinite = Band.exact([[np.inf, -np.inf, 1.0], [np.inf, np.inf, 1.0]])
    total = g.dot(infinite, Band.exact([1.0, 1.0, 1.0]))
    assert total.nan[:, 0].tolist() == [True, False]


def test_matrix_products_agree_with_float32_in_any_order() -> None:
    rng = np.random.default_rng(4)
    m, n = rng.normal(size=(2, 4, 4)).astype(F32)
    v = rng.normal(size=4).astype(F32)
    assert (Band.exact(m) @ Band.exact(v)).contains(m @ v).all()
    assert (Band.exact(m) @ Band.exact(n)).contains(m @ n).all()
    backwards = (m[:, ::-1] * v[::-1]).astype(F32)
    total = backwards[:, 0]
    for j in range(1, 4):
        total = total + backwards[:, j]
    assert (Band.exact(m) @ Band.exact(v)).contains(total).all()
    unit = Band.exact(np.eye(4)) @ Band.exact(v)
    np.testing.assert_array_equal(unit.lo, unit.hi)


def test_indexing_and_broadcasting_keep_everything() -> None:
    x = Band.exact(np.arange(6.0).reshape(2, 3)) / Band.exact([[0.0], [2.0]])
    assert x[1, 0:1].shape == (1,) and x[..., 0:1].shape == (2, 1)
    assert x.vacuous.tolist() == [[True] * 3, [False] * 3]
    assert x[0].vacuous.all() and not x[1].vacuous.any()
    assert (x[..., 0:1] + x).shape == (2, 3)


def test_different_rules_do_not_mix() -> None:
    with pytest.raises(FormulaError, match="different rules"):
        Band.exact([1.0]) + Band.exact([1.0], AS_WRITTEN)
    with pytest.raises(FormulaError, match="scaled"):
        Rules(trig_outside="scale")  # type: ignore[arg-type]


def test_widths_are_one_on_a_bound_and_zero_in_the_middle() -> None:
    band = Band.between([1.0], [2.0])
    assert band.widths([1.5]) == 0.0 and band.widths([2.0]) == 1.0 and band.widths([2.5]) == 2.0
    point = Band.exact([1.0])
    assert point.widths([1.0]) == 0.0 and point.widths([np.nextafter(F32(1), F32(2))]) > 1.0
    anything = Band.exact([1.0]) / 0.0
    assert anything.widths([123.0]) == 0.0 and anything.widths([np.nan]) == 0.0
    overflow = Band.exact([LARGEST]) * 4.0
    assert overflow.widths([np.inf]) == 0.0 and overflow.widths([1.0]) > 1.0


def test_a_factor_may_be_taken_out_of_a_dot_product() -> None:
    rng = np.random.default_rng(5)
    a, x = (rng.uniform(-2.0, 2.0, (20_000, 1)).astype(np.float32) for _ in range(2))
    near = -a * (1.0 + rng.uniform(-1.0, 1.0, a.shape) * 2.0 ** -rng.integers(0, 20, a.shape))
    b = near.astype(np.float32)
    one, two, factor = (Band.exact(each.astype(np.float64)) for each in (a, b, x))
    assert g.dot(g.vec2(one, two), g.vec2(factor)).contains((a + b) * x).all()
