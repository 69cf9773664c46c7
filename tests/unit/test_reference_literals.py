"""Bands of formulas hold what a device makes of their constants, however Python folds them."""

from __future__ import annotations

import functools
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from shaderlab import glslmath as g
from shaderlab.bands import Band, Rules
from shaderlab.engine.judging.references import Inputs, evaluate
from shaderlab.reference import gamma

HALF = 0.52 - 0.02
ONE_AND_A_HALF = HALF * 3.0
X = np.linspace(0.1, 1.0, 512).astype(np.float32)[:, None]
F = np.float32


def difference(x: Any) -> Any:
    return (0.52 - 0.02) * x


def product(x: Any) -> Any:
    return 0.02 * 0.77 * x


def quotient(x: Any) -> Any:
    return 0.3 / 0.7 * x


def power(x: Any) -> Any:
    return g.pow(0.9, 100.0) * x


def of_module(x: Any) -> Any:
    return HALF * x


def of_modules(x: Any) -> Any:
    return -ONE_AND_A_HALF * x


def scaled(x: Any, by: float = 0.3) -> Any:
    return x * by * 0.02 * 0.77


def by_helper(x: Any) -> Any:
    return scaled(x)


def of_closure(by: float) -> Callable[[Any], Any]:
    return lambda x: (by - 0.02) * x


def within(x: Any) -> Any:
    def half(y: Any) -> Any:
        return (0.52 - 0.02) * y

    return half(x)


# What a device makes of them in float32, operation by operation.
COMPUTED: dict[str, tuple[Callable[..., Any], Any]] = {
    "difference": (difference, (F(0.52) - F(0.02)) * X),
    "product": (product, F(0.02) * F(0.77) * X),
    "quotient": (quotient, F(0.3) / F(0.7) * X),
    "power": (power, F(0.9) ** F(100.0) * X),
    "of a module": (of_module, (F(0.52) - F(0.02)) * X),
    "of two constants": (of_modules, -((F(0.52) - F(0.02)) * F(3.0)) * X),
    "by a helper": (by_helper, X * F(0.3) * F(0.02) * F(0.77)),
    "of a closure": (of_closure(0.52), (F(0.52) - F(0.02)) * X),
    "a function within": (within, (F(0.52) - F(0.02)) * X),
    "partial": (functools.partial(scaled, by=0.25), X * F(0.25) * F(0.02) * F(0.77)),
}


def band_of(reference: Callable[..., Any]) -> Band:
    found = evaluate(reference, Inputs(shared={}, each={"x": X}), rules=Rules(), decimal=False)
    assert isinstance(found, Band)
    return found


@pytest.mark.parametrize("name", COMPUTED)
def test_a_band_holds_constants_computed_in_float32_and_in_float64(name: str) -> None:
    reference, measured = COMPUTED[name]
    band = band_of(reference)
    assert band.contains(measured).all()
    folded = evaluate(reference, Inputs(shared={}, each={"x": X}), rules=None, decimal=False)
    assert band.contains(folded.astype(np.float32)).all(), "a compiler may fold in float64"
    # The bound of pow is wide: 2^-21 of a logarithm, times 100.
    wrong = 1.001 if name == "power" else 1.00001
    assert not band.contains((measured * wrong).astype(np.float32)).any()


def test_every_pair_of_decimals_gives_a_band_that_holds_their_difference() -> None:
    """Before, one pair in twenty lay outside."""
    for tens in range(10, 100, 7):
        for others in range(1, tens, 5):
            a, b = tens / 100, others / 100
            computed = (F(a) - F(b)) * X
            assert band_of(of_two(a, b)).contains(computed).all(), (a, b)


def of_two(a: float, b: float) -> Callable[[Any], Any]:
    return lambda x: (a - b) * x


def test_float64_is_what_python_computes() -> None:
    found = evaluate(difference, Inputs(shared={}, each={"x": X}), rules=None, decimal=False)
    assert np.array_equal(found, 0.5 * X.astype(np.float64))


def test_constants_that_are_exact_in_float32_stay_exact() -> None:
    band = band_of(lambda x: (1.0 - 0.5) * 0.25 * x)
    assert np.array_equal(band.lo, band.hi)


def test_formulas_of_the_lab_are_taken_as_written_too() -> None:
    """`gamma.srgb_encode` computes with 1.0 / 2.4."""
    found = evaluate(
        lambda x: gamma.srgb_encode(x),
        Inputs(shared={}, each={"x": X}),
        rules=Rules(),
        decimal=False,
    )
    plain = gamma.srgb_encode(X.astype(np.float64))
    assert found.contains(plain.astype(np.float32)).all()


def test_a_formula_that_calls_itself_is_copied_once() -> None:
    def power_of(x: Any, n: int) -> Any:
        return x if n == 0 else (0.52 - 0.02) * power_of(x, n - 1)

    computed = X
    for _ in range(3):
        computed = (F(0.52) - F(0.02)) * computed
    assert band_of(lambda x: power_of(x, 3)).contains(computed).all()


def test_a_formula_without_source_or_with_a_memory_runs_as_it_is() -> None:
    made: dict[str, Any] = {}
    exec("def reference(x):\n    return 0.5 * x", made)
    band = band_of(made["reference"])
    assert np.array_equal(band.lo, 0.5 * X.astype(np.float64))
    calls = 0

    def counting(x: Any) -> Any:
        nonlocal calls
        calls += 1
        return 0.5 * x

    band_of(counting)
    assert calls == 1


def test_numbers_of_objects_stay_as_they_are() -> None:
    material = SimpleNamespace(ambient=0.3)
    assert band_of(lambda x: material.ambient * x).contains(F(0.3) * X).all()
