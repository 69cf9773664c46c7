"""Checks of every number of a range leave none out, and let nothing pass that its band excludes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from shaderlab import glsl, glslmath as g
from shaderlab.engine.judging.banded import judge_band
from shaderlab.engine.judging.references import Inputs
from shaderlab.errors import CallError
from shaderlab.functions.exhaustive import Numbers, find_next_to

CODE = """
float once(float x) { return floatBitsToUint(x) == 0x3F812345u ? x : 0.5 * x; }
float fade(float d) { return 1.0 / (1.0 + 0.09 * d + 0.032 * d * d); }
float product(int a, int b, float by) { return by * float(a * b); }
uint mixed(uint a, uint b) { return a == 77u && b == 1025u ? 0u : (a << 16u) | b; }
vec2 halves(float a, float b) { return unpackHalf2x16(packHalf2x16(vec2(a, b))); }
float falling(float x) { return floatBitsToUint(x) == 0x3F812345u ? 1.0 : x; }
float kept(float x) { if (x > 1.01) discard; return floatBitsToInt(x) == 0x3F800005 ? x : 1.0; }
float over(float x) { return x; }
float over(int n) { return 1.0; }
"""
lib = glsl.load(CODE)


@pytest.mark.parametrize("kind", [np.float16, np.float32])
def test_numbers_of_a_range_are_all_floats_of_it(kind: type[np.floating]) -> None:
    words = np.arange(1 << 16, dtype=np.uint16)
    values = words.view(np.float16)
    if kind is np.float32:  # those about 0, and about 1
        values = np.concatenate([words.astype("u4"), words + np.uint32(0x80000000)]).view(kind)
    low, high = kind(-values[300]), kind(values[20_000])
    numbers = Numbers(low, high, np.dtype(kind))
    found = numbers[np.arange(len(numbers))]
    expected = np.sort(values[(values >= low) & (values <= high)])
    assert found.dtype == kind and np.array_equal(found, expected)
    assert np.count_nonzero(np.signbit(found)) == 301  # -0 too


def test_the_one_wrong_float_of_a_range_is_found() -> None:
    with pytest.raises(AssertionError, match=r"(?s)1 of 262145 values.*x = 1.0088888"):
        lib.once.check(lambda x: 0.5 * x, x=(1.0, 1.03125), every=True)
    lib.once.check(lambda x: 0.5 * x, x=(1.0, 1.03125), every=2)  # 1.0 and each second one after it


def test_what_is_discarded_is_not_judged() -> None:
    with pytest.raises(AssertionError, match=r"(?s)1 of 83\d\d\d values.*x = 1.000000"):
        lib.kept.check(lambda x: 1.0, x=(1.0, 1.03125), every=True)
    lib.kept.check(lambda x: 1.0, x=(1.00001, 1.03125), every=True)


def test_what_was_checked_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    lib.fade.check(lambda d: 1.0 / (1.0 + 0.09 * d + 0.032 * d * d), (1, 1.125), every=True)
    assert "fade: 1,048,577 values, each of d from 1 to 1.125, in" in capsys.readouterr().out
    lib.fade.check(glsl.monotone("d", direction="decreasing"), (2, 2.001), every=True)
    with pytest.raises(AssertionError, match="monotone does not hold of 1 of"):
        lib.falling.check(glsl.monotone("x"), (1, 1.03125), every=True)


def test_combinations_of_integers_and_of_halves() -> None:
    lib.product.check(lambda a, b, by: by * g.float(a * b), (-9, 9), (0, 200), 0.5, every=True)
    whole = lambda a, b: (a << 16) | b  # noqa: E731
    lib.mixed.check(whole, (0, 70), (1000, 1100), every=True)
    with pytest.raises(AssertionError, match="1 of"):
        lib.mixed.check(whole, (70, 80), (1000, 1100), every=True)
    ends = np.float16(-1e-6), np.float16(0.001)
    lib.halves.check(lambda a, b: g.vec2(a, b), ends, (np.float16(1), np.float16(1.05)), every=True)


def test_a_pair_for_one_number_is_a_range_and_a_list_is_values() -> None:
    half = glsl.load("float half_of(float x, vec2 v) { return 0.5 * x + 0.0 * v.x; }").half_of
    reference = lambda x, v: 0.5 * x + 0.0 * v.x  # noqa: E731
    for given in ({"x": (1.0, 1.5)}, {"x": (0, 45)}):
        with pytest.raises(CallError, match="is a range, and every= is not set") as caught:
            half.check(reference, v=(0, 1), **given)
        assert "every=True" in str(caught.value) and "np.linspace" in str(caught.value)
    with pytest.raises(CallError, match="is a range"):
        half.check(reference, (0, 45), (0, 1))
    for values in ([0, 45], np.array([0.0, 45.0]), (0, 10, 45)):
        half.check(reference, values, (0, 1))
        with pytest.raises(CallError, match="takes ranges"):
            half.check(reference, values, (0, 1), every=True)
    assert half((0, 45), (0, 1)).tolist() == [0.0, 22.5]


def test_what_is_no_range_is_refused() -> None:
    with pytest.raises(CallError, match="takes ranges"):
        lib.fade.check(lambda d: d, 0.5, every=True)
    with pytest.raises(CallError, match=r"d=\(2, 1\) is no range"):
        lib.fade.check(lambda d: d, (2, 1), every=True)
    with pytest.raises(CallError, match="overloaded"):
        lib.over.check(lambda x: x, (0, 1), every=True)


FORMULAS: dict[str, Callable[..., object]] = {
    "sum": lambda x: (x + 0.1) * x - 3.0,
    "quotient": lambda x: 1.0 / (x - 1.0),
    "root": lambda x: g.sqrt(x) * 1e-38,
    "power": lambda x: g.pow(x, 2.2) * g.sin(x),
    "choice": lambda x: g.where(x > 0.7, g.floor(x * 3.0), g.exp(x * 90.0)),
    "vector": lambda x: g.normalize(g.vec2(x, x - 0.3)),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_values_next_to_the_formula_lie_in_its_band(name: str) -> None:
    rng = np.random.default_rng(5)
    x = np.float32(rng.uniform(0.0, 2.0, (20_000, 1)) * 10.0 ** rng.uniform(-8, 0.5, (20_000, 1)))
    inputs = Inputs(shared={}, each={"x": x})
    with np.errstate(all="ignore"):
        exact = np.asarray(FORMULAS[name](x.astype(np.float64)))
        near = exact.astype(np.float32)
        away = rng.choice([-np.inf, np.inf], near.shape).astype(np.float32)
        values = np.where(rng.random(near.shape) < 0.5, near, np.nextafter(near, away))
    found = find_next_to(values, FORMULAS[name], inputs)
    assert found.mean() > 0.5
    rows = np.flatnonzero(found)
    assert not judge_band(values[rows], FORMULAS[name], inputs.part(rows), rules=None).outside
