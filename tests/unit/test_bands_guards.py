"""What would lose a band's interval raises and says what to use; choices have three values."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from shaderlab import glslmath as g
from shaderlab.bands import Band, TriBool
from shaderlab.errors import FormulaError

X = Band.exact(np.linspace(0.0, 1.0, 6).reshape(2, 3))


def added_in_place() -> None:
    array = np.ones(3)
    array += X[0]


@pytest.mark.parametrize(
    "misuse",
    [
        lambda: np.sin(X),
        lambda: np.maximum(1.0, X),
        lambda: np.power(X, 2.0),
        lambda: np.add.reduce(X),
        lambda: np.array(X),
        lambda: np.asarray(X, np.float32),
        lambda: np.concatenate([X, X]),
        lambda: np.where(True, X, X),
        lambda: np.dot(X, X),
        lambda: np.sum(X),
        lambda: float(X),
        lambda: int(X),
        lambda: math.sin(X),
        lambda: bool(X),
        lambda: bool(X < 1.0),
        lambda: 1.0 if X > 0.5 else 0.0,
        lambda: max(X, X),
        lambda: X**2,
        lambda: 2.0**X,
        lambda: X % 1.0,
        lambda: X // 1.0,
        lambda: round(X, 2),
        lambda: list(X),
        lambda: X * (X < 1.0),
        lambda: np.float64(1.0) % X,
        added_in_place,
    ],
)
def test_misuse_raises_and_names_the_way_out(misuse: Callable[[], Any]) -> None:
    with pytest.raises(FormulaError) as caught:
        misuse()
    assert caught.value.remedy


def test_power_names_glslmath_pow() -> None:
    with pytest.raises(FormulaError, match=r"glslmath\.pow"):
        X**2


def test_arrays_and_numpy_numbers_combine_on_either_side() -> None:
    array = np.full((2, 3), 0.25)
    for left, right in (
        (array * X, X * array),
        (array + X, X + array),
        (np.float32(0.5) * X, X * 0.5),
        (np.float64(2.0) + X, X + 2.0),
    ):
        np.testing.assert_array_equal(left.lo, right.lo)
        np.testing.assert_array_equal(left.hi, right.hi)
    np.testing.assert_array_equal((array - X).lo, (-(X - array)).lo)
    assert (np.ones(3) / (X + 1.0)).contains(1.0 / (X.lo + 1.0)).all()
    assert (array <= X).all_true.sum() == (X.lo >= 0.25).sum()
    assert (np.eye(3) @ X[0]).shape == (3,)


def test_comparisons_are_true_false_or_undecided() -> None:
    band = Band.between([[0.0], [0.0], [2.0]], [[0.5], [1.5], [3.0]])
    below = band < 1.0
    assert below.all_true[:, 0].tolist() == [True, False, False]
    assert below.undecided[:, 0].tolist() == [False, True, False]
    assert below.all_false[:, 0].tolist() == [False, False, True]
    assert (~below).all_true.tolist() == below.all_false.tolist()
    assert (below & (band > -1.0)).undecided.tolist() == below.undecided.tolist()
    assert (below | np.ones((3, 1), bool)).all_true.all()
    assert (np.zeros((3, 1), bool) & below).all_false.all()
    assert (band == band).undecided.all(), "equal bands need not be equal values"
    assert (Band.exact([1.0]) == 1.0).all_true.all()
    assert (Band.exact([1.0]) != 2.0).all_true.all()
    assert (Band.exact([np.nan]) < 1.0).undecided.all()


def test_a_choice_is_the_side_taken_or_the_hull_and_counts_it() -> None:
    band = Band.between([[0.0], [0.5], [2.0]], [[0.5], [1.5], [3.0]])
    chosen = g.where(band < 1.0, Band.exact([10.0]), 20.0)
    assert chosen.lo[:, 0].tolist() == [10.0, 10.0, 20.0]
    assert chosen.hi[:, 0].tolist() == [10.0, 20.0, 20.0]
    assert chosen.undecided[:, 0].tolist() == [False, True, False]
    swapped = g.where(band < 1.0, 20.0, Band.exact([10.0]))
    assert swapped.lo[1] == 10.0 and swapped.hi[1] == 20.0
    assert (chosen * 2.0).undecided[:, 0].tolist() == [False, True, False]
    literals = g.where(band < 1.0, 0.0, 1.0)
    assert isinstance(literals, Band) and literals.rules == band.rules


def test_a_choice_ignores_what_the_side_not_taken_allows() -> None:
    x = Band.exact([[0.0], [4.0]])
    safe = g.where(x > 0.0, 1.0 / x, 0.0)
    assert not safe.vacuous.any() and not safe.nan.any()


def test_a_compiler_may_move_a_term_across_a_comparison() -> None:
    """a + b < c may become a < c - b, which rounds where a + b is exact."""
    rng = np.random.default_rng(8)
    a = rng.uniform(0.5, 1.0, (4000, 1)).astype(np.float32)
    b = -a * rng.uniform(0.9999, 1.0001, a.shape).astype(np.float32)
    c = ((a + b) * rng.uniform(0.999, 1.001, a.shape)).astype(np.float32)
    below = Band.exact(a) + Band.exact(b) < Band.exact(c)
    differs = (a + b < c) != (a < c - b)
    assert differs.any() and below.undecided[differs].all()


def test_truths_over_components() -> None:
    truth = Band.exact([[1.0, 2.0], [3.0, 4.0]]) < Band.between([1.5, 1.0], [1.5, 5.0])
    assert g.any(truth).all_true.tolist() == [[True], [False]]
    assert g.all(truth).undecided.tolist() == [[True], [False]]
    assert isinstance(g.not_(truth), TriBool)
