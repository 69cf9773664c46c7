"""Large frames are judged piece by piece, with the same result and in little memory."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

from shaderlab.checks import banded
from shaderlab.checks.banded import judge_band
from shaderlab.checks.inputs import Inputs
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
    monkeypatch.setattr(banded, "CHUNK", chunk)
    pieces = judge_band(values, shaded, given, rules=None)
    for name in ("reference", "low", "high", "widths", "inside", "vacuous", "undecided"):
        np.testing.assert_array_equal(getattr(pieces, name), getattr(whole, name))
    assert pieces.worst() == whole.worst() or repr(pieces.worst()) == repr(whole.worst())


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
