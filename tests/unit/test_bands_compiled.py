"""The compiled passes over bands give what NumPy gives, whatever the shapes and the values."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from shaderlab import glslmath
from shaderlab.bands import Band, Rules, arithmetic, compiled, exact, functions, rounding
from shaderlab.glslmath.vector import direction

needs_kernels = pytest.mark.skipif(
    compiled.KERNELS is None, reason="no compiled passes here (see shaderlab doctor)"
)

ODD = [0.0, -0.0, 1.0, -1.0, 0.5, 4.0, 2.0**-149, -(2.0**-130), 2.0**-126, 2.0**-63, -(2.0**-63),
       1e-30, 3e38, -3e38, np.inf, -np.inf, np.nan]  # fmt: skip
RULES = [Rules(), Rules(flush=False), Rules(rearrange=False)]
# The second operand's shape beside the first's: blocks of the passes hold 384 values.
SHAPES = [
    ((1,), (1,)), ((3,), (1,)), ((5, 3), (5, 3)), ((5, 3), (3,)), ((3,), (5, 3)), ((5, 3), (5, 1)),
    ((5, 1), (1, 3)), ((400, 1), (1,)), ((400, 3), (400, 1)), ((130, 3), (130, 3)), ((7, 5), (5,)),
    ((4, 4), (30, 1, 4)), ((30, 2, 2), (30, 2, 2)), ((0, 3), (3,)), ((90, 7), (90, 1)),
]  # fmt: skip

plain_floats = st.floats(-100.0, 100.0, width=32)
small_floats = st.sampled_from([0.0, 1.0, -3.0, 2.0**-40, -(2.0**-63), 1.1e-30, 1e25])
any_floats = st.one_of(plain_floats, st.sampled_from(ODD), st.floats(width=32))


@st.composite
def bands(draw: Any, shape: tuple[int, ...], rules: Rules, values: Any) -> Band:
    """A band: exact, an interval, a product, a sum with a pending slack, or a sum of products; its
    arrays as they come, reversed or transposed in memory."""

    def numbers() -> Any:
        drawn = draw(st.lists(values, min_size=1, max_size=12))
        return np.resize(np.array(drawn, np.float32), shape)

    def leaf() -> Band:
        first = numbers()
        if draw(st.booleans()):
            return Band.exact(first, rules)
        first, second = np.nan_to_num(first), np.nan_to_num(numbers())
        return Band.between(np.minimum(first, second), np.maximum(first, second), rules)

    with compiled.numpy_alone():
        return rearranged(draw, whole(draw, leaf, shape, rules))


def whole(draw: Any, leaf: Callable[[], Band], shape: tuple[int, ...], rules: Rules) -> Band:
    kind = draw(st.sampled_from(["leaf", "scale", "product", "sum", "sum of products"]))
    if kind == "scale":
        exponents = draw(st.lists(st.integers(-8, 8), min_size=1, max_size=5))
        return Band.exact(np.resize(2.0 ** np.array(exponents), shape), rules)
    if kind == "product":
        return leaf() * leaf()
    if kind == "sum":
        return leaf() + leaf()
    return leaf() * leaf() + leaf() * leaf() if kind == "sum of products" else leaf()


def rearranged(draw: Any, band: Band) -> Band:
    if draw(st.booleans()):
        return band[..., list(range(band.shape[-1]))[::-1]]
    return band[::-1] if draw(st.booleans()) else band


def assert_same(got: Band, expected: Band) -> None:
    """Bounds, what marks exact values, flags and terms; the sign of a zero apart."""
    assert (got.lo is got.hi) == (expected.lo is expected.hi)
    arrays = [(got.lo, expected.lo), (got.hi, expected.hi)]
    arrays += list(zip(got.flags, expected.flags, strict=True))
    assert (got.terms is None) == (expected.terms is None)
    if got.terms is not None and expected.terms is not None:
        assert got.terms.count == expected.terms.count
        for name in ("abs_sum", "slack", "flush_gain"):
            ours, theirs = getattr(got.terms, name), getattr(expected.terms, name)
            assert (ours is None) == (theirs is None), name
            if ours is not None:
                arrays.append((ours, np.broadcast_to(theirs, expected.shape)))
    for ours, theirs in arrays:
        np.testing.assert_array_equal(ours, theirs, strict=True)


def assert_numpy_s(operation: Callable[..., Any], *operands: Any) -> None:
    """That an operation gives the same with the passes and without."""
    got = operation(*operands)
    with compiled.numpy_alone():
        expected = operation(*operands)
    assert_same(got, expected)


@needs_kernels
@pytest.mark.parametrize(
    "values", [plain_floats, small_floats, any_floats], ids=["plain", "small", "any"]
)
@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_operations_are_numpy_s(values: Any, data: Any) -> None:
    rules = data.draw(st.sampled_from(RULES))
    shapes = data.draw(st.sampled_from(SHAPES))
    a, b = (data.draw(bands(shape, rules, values)) for shape in shapes)
    for operation in (arithmetic.add, arithmetic.subtract, arithmetic.multiply, arithmetic.divide):
        assert_numpy_s(operation, a, b)
    assert_numpy_s(arithmetic.square, a)
    assert_numpy_s(arithmetic.multiply, a, a)
    assert_numpy_s(arithmetic.sum_last, a)
    for root in (functions.inversesqrt, functions.sqrt):
        assert_numpy_s(root, a)
        assert_numpy_s(root, exact.absolute_value(a))
    assert_numpy_s(functions.logarithm, a, np.log2)
    assert_numpy_s(functions.power, exact.absolute_value(a), b)


@needs_kernels
@pytest.mark.parametrize("zero", [(0.0, 0.0), (-1.0, 0.0), (0.0, 1.0)])
@pytest.mark.parametrize("ends", [(-np.inf, 0.0), (0.0, np.inf), (-np.inf, 1.0)])
def test_infinity_times_zero_is_numpy_s(ends: tuple[float, float], zero: Any) -> None:
    a, b = (Band(np.array([lo]), np.array([hi]), Rules()) for lo, hi in (ends, zero))
    for operation in (arithmetic.multiply, arithmetic.divide, arithmetic.add):
        assert_numpy_s(operation, a, b)
    assert_numpy_s(arithmetic.multiply, b, a)


@needs_kernels
@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_bounds_are_numpy_s(data: Any) -> None:
    rules = data.draw(st.sampled_from(RULES))
    shape, _ = data.draw(st.sampled_from(SHAPES))
    a = data.draw(bands(shape, rules, any_floats))
    with np.errstate(all="ignore"):
        third, both = a.lo / 3.0, (a.lo / 3.0, a.hi / 3.0)
        calls: list[tuple[Any, ...]] = [
            (rounding.round_outward, a.lo, a.hi, True),
            (rounding.round_outward, third, third, False),
            (rounding.round_outward, *both, rules.flush),
        ]
        for function, *arguments in calls:
            got = function(*arguments)
            with compiled.numpy_alone():
                expected = function(*arguments)
            for ours, theirs in zip(got, expected, strict=True):
                np.testing.assert_array_equal(ours, theirs, strict=True)
            assert (got[0] is got[1]) == (expected[0] is expected[1])


@needs_kernels
@pytest.mark.parametrize(
    "values", [plain_floats, small_floats, any_floats], ids=["plain", "small", "any"]
)
@settings(max_examples=30, deadline=None)
@given(data=st.data())
def test_sums_of_products_are_numpy_s(values: Any, data: Any) -> None:
    rules = data.draw(st.sampled_from(RULES))
    terms = data.draw(st.integers(2, 4))
    rows = data.draw(st.sampled_from([(5,), (400,), (1,)]))
    vector, other = (data.draw(st.sampled_from([(terms,), (*rows, terms)])) for _ in range(2))
    matrix = data.draw(st.sampled_from([(3, terms), (*rows, 3, terms), (1, 3, terms)]))
    a, b, m = (data.draw(bands(shape, rules, values)) for shape in (vector, other, matrix))
    assert_numpy_s(arithmetic.dot, a, b)
    assert_numpy_s(arithmetic.dot, a, a)
    assert_numpy_s(arithmetic.times_vector, m, a)
    assert_numpy_s(arithmetic.times_vector, exact.transpose(exact.transpose(m)), b)
    assert_numpy_s(direction, a.without_terms())


@needs_kernels
@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_mixes_are_numpy_s(data: Any) -> None:
    rules = data.draw(st.sampled_from(RULES))
    shapes = data.draw(st.sampled_from(SHAPES))
    a, b = (data.draw(bands(shape, rules, any_floats)) for shape in shapes)
    rows = max(a.shape[:-1], b.shape[:-1])
    share = data.draw(bands((*rows, 1), rules, plain_floats))
    assert_numpy_s(lambda: glslmath.mix(a, b, share))


@needs_kernels
def test_common_values_are_not_left_to_numpy() -> None:
    x = Band.exact(np.linspace(0.5, 2.0, 12).reshape(4, 3))
    tiny = Band.exact([3.0 * 2.0**-61]) * Band.exact([3.0 * 2.0**-61])
    pairs = [
        (x, x.copy_independent()),
        (x * 3.0 + 1.0, x[..., 0:1] * x),
        (x, Band.exact([0.3])),
        (tiny, x),
    ]
    for operands in pairs:
        for name in ("add", "subtract", "multiply", "divide"):
            assert getattr(compiled.KERNELS, name)(*operands) is not None
        for name in ("square", "sum_last", "inversesqrt", "sqrt"):
            assert getattr(compiled.KERNELS, name)(x) is not None
    assert compiled.KERNELS.cut_to_ends(x + 0.5, x, x + 1.0, x * 0.3) is not None
    assert compiled.KERNELS.round_outward(x.lo / 3.0, x.hi / 3.0, True) is not None


@needs_kernels
def test_what_a_pass_can_t_take_is_left_to_numpy() -> None:
    x = Band.exact(np.linspace(0.5, 2.0, 12).reshape(4, 3))
    infinite, zero = (Band.exact([value]) for value in (np.inf, 0.0))
    assert compiled.KERNELS.add(x, infinite) is None
    assert compiled.KERNELS.divide(x, zero) is None
    assert compiled.KERNELS.inversesqrt(zero) is None
    assert compiled.KERNELS.multiply(x, infinite * infinite) is None
    assert compiled.KERNELS.multiply(x, Band.exact([0.5])) is None
    assert compiled.KERNELS.cut_to_ends(x + 0.3, infinite, x, x) is None
    assert compiled.KERNELS.round_outward(x.lo.astype(np.float32), x.hi, True) is None
    with pytest.raises(ValueError, match="broadcast"):
        x + Band.exact([1.0, 2.0])


def test_passes_of_older_sources_are_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(compiled.VARIABLE, raising=False)
    for number, used in ((compiled.INTERFACE, True), (compiled.INTERFACE - 1, False)):
        built = SimpleNamespace(INTERFACE=number)
        monkeypatch.setattr(compiled.importlib, "import_module", lambda name, built=built: built)
        assert (compiled._load() is built) == used


def test_numpy_does_without(repository: Path) -> None:
    """The same tests of the arithmetic, where the passes are left aside."""
    code = "import sys, pytest; from shaderlab.bands.compiled import KERNELS; "
    code += "sys.exit(KERNELS is not None or pytest.main(sys.argv[1:]))"
    tests = ["-q", "-n", "0", "-p", "no:cacheprovider", "tests/unit/test_bands_arithmetic.py"]
    done = subprocess.run(
        [sys.executable, "-c", code, *tests],
        cwd=repository,
        env={**os.environ, compiled.VARIABLE: "numpy"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
