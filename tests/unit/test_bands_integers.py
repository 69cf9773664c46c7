"""Integers are exact, wrap at 32 bits, and become floats as a device rounds them."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from shaderlab import glslmath as g
from shaderlab.bands import Band, Integer, Rules, TriBool
from shaderlab.engine.judging.banded import judge_band
from shaderlab.engine.judging.references import Inputs
from shaderlab.errors import FormulaError

RULES = Rules()
CORNERS = (0, 1, 2, 7, 31, 2**15, 2**24 + 1, 2**31 - 1, -1, -7, -(2**24) - 1, -(2**31))
OPERATIONS: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "%": operator.mod,
    "&": operator.and_,
    "|": operator.or_,
    "^": operator.xor,
    "<<": operator.lshift,
    ">>": operator.rshift,
}


def truth_of(name: str, a: int, b: int) -> int | None:
    """By Python's integers of any size; None where GLSL defines nothing."""
    if name == "/":
        return None if b == 0 else abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)
    if name == "%":
        return None if a < 0 or b <= 0 else a % b
    if name in ("<<", ">>"):
        return None if not 0 <= b < 32 else OPERATIONS[name](a, b)
    return OPERATIONS[name](a, b)


@pytest.mark.parametrize("unsigned", [False, True])
@pytest.mark.parametrize("name", OPERATIONS)
def test_operators_wrap_as_32_bits_do(name: str, unsigned: bool) -> None:
    numbers = [n for n in CORNERS if n >= 0 or not unsigned]
    least = 0 if unsigned else -(2**31)
    for a in numbers:
        for b in numbers:
            found = OPERATIONS[name](Integer(a, unsigned=unsigned), Integer(b, unsigned=unsigned))
            expected = truth_of(name, a, b)
            if expected is None:
                assert found.anything.all(), (a, b)
            else:
                wrapped = (expected - least) % 2**32 + least
                assert not found.anything.any()
                assert found.lo.tolist() == found.hi.tolist() == [wrapped], (a, b)


@pytest.mark.parametrize("name", [n for n in OPERATIONS if n != "/"])
def test_an_interval_holds_what_its_integers_give(name: str) -> None:
    rng = np.random.default_rng(5)
    for _ in range(60):
        low, high = np.sort(rng.integers(0, 40, 2))
        other = int(rng.integers(1, 20))
        wide = OPERATIONS[name](Integer([low], [high]), other)
        for n in range(low, high + 1):
            found = int(OPERATIONS[name](Integer(n), other).lo[0])
            assert wide.anything.all() or wide.lo[0] <= found <= wide.hi[0]


def test_large_integers_are_judged_exactly() -> None:
    """In float32, n - 16777216 of n = 16777217 is 0: the right 1 was rejected, the wrong 0 not."""
    inputs = Inputs(shared={"n": np.array([16777217], np.int32)})

    def reference(n: Any) -> Any:
        return g.float(n - 16777216)

    def verdict(measured: float) -> str:
        values = np.array([[measured]], np.float32)
        return judge_band(values, reference, inputs, rules=None).verdict()[0]

    assert (verdict(1.0), verdict(0.0)) == ("pass", "fail")


def test_a_formula_over_integers_is_judged_to_the_last_one() -> None:
    n = np.array([[5], [2**24 + 1], [-(2**31)]], np.int32)
    inputs = Inputs(shared={}, each={"n": n})
    right = (n.astype(np.int64) * 3 + 1).astype(np.int32)
    for format, measured in (("r32i", right), ("rgba32f", right)):
        banded = judge_band(measured, lambda n: n * 3 + 1, inputs, rules=None, format=format)
        assert banded.verdict() == ("pass", "") and banded.band.vacuous == 0
        wrong = judge_band(measured + 1, lambda n: n * 3 + 1, inputs, rules=None, format=format)
        assert wrong.outside == 3
    unsigned = judge_band(
        right.view(np.uint32), lambda n: g.uint(n * 3 + 1), inputs, rules=None, format="r32ui"
    )
    assert unsigned.verdict()[0] == "pass"
    with pytest.raises(FormulaError, match="the attachment holds r32i"):
        judge_band(right, lambda n: g.float(n), inputs, rules=None, format="r32i")


def test_what_no_integer_operation_defines_counts_as_vacuous() -> None:
    n = np.array([[1], [40]], np.int32)
    inputs = Inputs(shared={}, each={"n": n})
    banded = judge_band(n, lambda n: 1 << n, inputs, rules=None, format="r32i")
    assert banded.band.vacuous == banded.measured.size / 2


def test_a_reference_outside_its_own_band_is_said() -> None:
    def reference(x: Any) -> Any:
        return x if isinstance(x, Band) else x + 1.0

    inputs = Inputs(shared={}, each={"x": np.ones((3, 1), np.float32)})
    with pytest.raises(FormulaError, match="float64 value lies outside its band: 2 is not in"):
        judge_band(np.ones((3, 1), np.float32), reference, inputs, rules=None).worst()


def test_an_integer_becomes_the_float_next_to_it_on_either_side() -> None:
    band = g.float(Integer([2**24 + 1], rules=RULES))
    assert (band.lo[0], band.hi[0]) == (2.0**24, 2.0**24 + 2.0)
    exact = g.float(Integer([2**24], rules=RULES))
    assert exact.lo is exact.hi and exact.lo[0] == 2.0**24


def test_floats_become_integers_by_truncation_within_their_range() -> None:
    x = Band.between([-1.75, 2.5], [-1.25, 3.5])
    assert (g.int(x).lo.tolist(), g.int(x).hi.tolist()) == ([-1, 2], [-1, 3])
    assert g.uint(Band.exact([-1.0])).anything.all() and g.int(Band.exact([3e9])).anything.all()
    assert g.uint(Integer([-1])).lo.tolist() == [2**32 - 1]


def test_functions_of_integers_are_exact_and_stay_integers() -> None:
    n = Integer([[-5], [3]], rules=RULES)
    assert g.abs(n).lo.ravel().tolist() == [5, 3]
    assert g.sign(n).lo.ravel().tolist() == [-1, 1]
    assert g.clamp(n, -1, 1).lo.ravel().tolist() == [-1, 1]
    assert g.where(n > 0, n, 7).lo.ravel().tolist() == [7, 3]
    assert g.ivec3(n, 1, 2).zyx.lo.tolist() == [[2, 1, -5], [2, 1, 3]]
    assert isinstance(n < 4, TriBool) and isinstance(n * 0.5, Band) and isinstance(0.5 + n, Band)


def test_components_are_attributes_of_all_values_that_references_get() -> None:
    inputs = Inputs(
        shared={"k": np.array([1, 2], np.int32)},
        each={"v": np.arange(6, dtype=np.float32).reshape(2, 3)},
    )

    def reference(v: Any, k: Any) -> Any:
        return g.normalize(g.where(v.x > 1.0, v, v * 2.0)).zyx.xy + k.yx

    measured = np.array([[1.0 + 2 * 0.5, 0.0], [0.0, 0.0]], np.float32)
    banded = judge_band(measured, reference, inputs, rules=None)
    assert banded.reference[0, 0] == pytest.approx(2.0 + 2.0 / np.sqrt(5.0))
    with pytest.raises(AttributeError, match="xw"):
        Band.exact([1.0, 2.0]).xw  # noqa: B018


@pytest.mark.parametrize(
    ("name", "a", "b", "found"),
    [
        ("mul", 3_000_000_000, 4_000_000_001, 3_000_000_000 * 4_000_000_001 % 2**32),
        ("mod", 3_000_000_000, 7, 3_000_000_000 % 7),
        ("xor", 3_000_000_000, 5, 3_000_000_000 ^ 5),
    ],
)
def test_a_number_stays_one_beside_another_that_is_undecided(
    name: str, a: int, b: int, found: int
) -> None:
    low, high = np.array([[a], [5]]), np.array([[a], [6]])
    second = Integer(np.array([[b], [3]]), unsigned=True)
    result = getattr(Integer(low, high, unsigned=True), f"__{name}__")(second)
    assert result.lo[0, 0] == result.hi[0, 0] == found
    assert result.lo[1, 0] < result.hi[1, 0]
