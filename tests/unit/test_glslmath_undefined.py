"""Where GLSL leaves a result undefined, a band allows anything and counts it; beside it, not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from shaderlab import glslmath as g
from shaderlab.bands import Band

# Functions with arguments for which GLSL (4.60, chapter 8) defines no result, and others.
UNDEFINED: dict[str, tuple[Callable[..., Any], tuple[float, ...], tuple[float, ...]]] = {
    "smoothstep": (g.smoothstep, (0.75, 0.25, 0.5), (0.25, 0.75, 0.5)),
    "smoothstep of equal edges": (g.smoothstep, (0.5, 0.5, 0.25), (0.25, 0.5, 0.25)),
    "clamp": (g.clamp, (0.5, 1.0, 0.0), (0.5, 0.0, 1.0)),
    "pow(0, 0)": (g.pow, (0.0, 0.0), (0.0, 1.0)),
    "pow of a negative base": (g.pow, (-1.0, 2.0), (1.0, 2.0)),
    "atan(0, 0)": (g.atan, (0.0, 0.0), (0.0, 1.0)),
    "normalize": (g.normalize, (0.0,), (2.0,)),
    "mod": (g.mod, (1.0, 0.0), (1.0, 2.0)),
    "sqrt": (g.sqrt, (-0.5,), (0.0,)),
    "inversesqrt": (g.inversesqrt, (0.0,), (0.5,)),
    "log": (g.log, (0.0,), (0.5,)),
    "log2": (g.log2, (-1.0,), (0.5,)),
    "asin": (g.asin, (1.5,), (1.0,)),
    "acos": (g.acos, (-1.5,), (-1.0,)),
}


@pytest.mark.parametrize("name", UNDEFINED)
def test_anything_is_allowed_and_counted_where_nothing_is_defined(name: str) -> None:
    function, undefined, defined = UNDEFINED[name]
    band = function(*(Band.exact([value]) for value in undefined))
    assert band.vacuous.all()
    assert band.contains([1e30]).all() and band.contains([-7.5]).all() and band.contains([np.nan])
    beside = function(*(Band.exact([value]) for value in defined))
    assert not beside.vacuous.any() and not beside.contains([1e30]).any()


def test_only_the_values_that_are_undefined_are_free() -> None:
    edge = Band.exact([[0.25], [0.75]])
    band = g.smoothstep(edge, 0.5, 0.375)
    assert band.vacuous.ravel().tolist() == [False, True]
    assert band.contains([[0.5], [9.0]]).all()


def test_a_clamp_between_a_value_and_itself_is_defined() -> None:
    edge = Band.between([0.25], [0.5])
    assert not g.clamp(2.0, edge, edge).vacuous.any()
