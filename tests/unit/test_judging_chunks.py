"""Large frames are judged piece by piece, with the same result and in little memory."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

from shaderlab.engine.judging import bands
from shaderlab.engine.judging.banded import judge_band
from shaderlab.engine.judging.references import Inputs
from shaderlab.errors import FormulaError
from shaderlab.glslmath import dot, max, normalize, pow, vec3, where


def shaded(normal: Any, light: Any, gain: Any) -> Any:
    cosine = max(dot(normalize(normal), normalize(light)), 0.0)
    return where(cosine > 0.5, vec3(pow(cosine, 8.0)), gain * cosine * vec3(1.0, 0.5, 0.25))


def inputs(count: int) -> Inputs:
    rng = np.random.default_rng(5)
    return Inputs(
        shared={"gain": np.array([0.7], np.float32)},
        each={name: rng.normal(size=(count, 3)).astype(np.float32) for name in ("normal", "light")},
    )


def measured(given: Inputs) -> np.ndarray:
    exact = {name: values.astype(float) for name, values in given.exact.items()}
    values = np.array(shaded(**exact), np.float32)
    values[11, 1] += np.float32(0.01)
    values[57, 2] = np.nan
    return values


@pytest.mark.parametrize("chunk", [1, 7, 99, 100])
def test_pieces_are_judged_as_the_whole(monkeypatch: pytest.MonkeyPatch, chunk: int) -> None:
    given = inputs(100)
    values = measured(given)
    whole = judge_band(values, shaded, given, rules=None)
    assert np.argwhere(~whole.inside).tolist() == [[11, 1], [57, 2]]
    monkeypatch.setattr(bands, "CHUNK", chunk)
    pieces = judge_band(values, shaded, given, rules=None)
    for name in ("reference", "low", "high", "inside"):
        np.testing.assert_array_equal(getattr(pieces, name), getattr(whole, name))
    assert pieces.band.vacuous == whole.band.vacuous
    assert pieces.band.undecided == whole.band.undecided
    np.testing.assert_array_equal(pieces.measure_distances(), whole.measure_distances())
    assert pieces.worst() == whole.worst() or repr(pieces.worst()) == repr(whole.worst())


def test_a_formula_that_fails_in_float64_only_is_no_pass() -> None:
    def fails(normal: Any, light: Any, gain: Any) -> Any:
        if isinstance(normal, np.ndarray):
            raise ValueError("not for arrays")
        return shaded(normal, light, gain)

    given = inputs(100)
    judged = judge_band(measured(given), fails, given, rules=None)
    with pytest.raises(FormulaError, match="not for arrays"):
        judged.worst()


def test_what_fails_on_plain_numbers_is_told_of_them() -> None:
    def fails(normal: Any, light: Any, gain: Any) -> Any:
        return shaded(normal, light, gain) if (normal > 0.0).all() else missing  # type: ignore[name-defined]  # noqa: F821

    given = inputs(100)
    with pytest.raises(FormulaError, match="NameError"):
        judge_band(measured(given), fails, given, rules=None)


def test_a_large_frame_takes_megabytes() -> None:
    count = 512 * 512
    given = inputs(count)
    values = measured(given)
    tracemalloc.start()
    judge_band(values, shaded, given, rules=None)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    result = 5 * values.size * 8  # what the judgement itself holds: five arrays of numbers
    assert peak < result + 150 * 2**20


def test_a_nan_is_explained_by_the_formula_and_not_by_a_band_without_an_end() -> None:
    given = inputs(100)
    given.each["normal"][:2] = [[2e-39, 1.0, 1.0], [0.0, 1.0, 1.0]]  # a denormal divisor, and 0/0
    given.each["light"][1] = 0.0

    def quotient(normal: Any, light: Any) -> Any:
        return light / normal

    with np.errstate(all="ignore"):
        values = np.divide(given.each["light"], given.each["normal"], dtype=np.float32)
    values[:2, 0] = np.nan
    judged = judge_band(values, quotient, given, rules=None)
    assert np.argwhere(~judged.inside).tolist() == [[0, 0]]
    values[0, 0] = np.inf
    assert judge_band(values, quotient, given, rules=None).inside.all()
