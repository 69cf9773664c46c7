"""Where GLSL leaves a result undefined, a band allows anything and counts it; beside it, not."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from shaderlab import glslmath as g
from shaderlab.bands import Band, Rules

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


UNARY = [
    "abs",
    "acos",
    "asin",
    "atan",
    "ceil",
    "cos",
    "cosh",
    "exp",
    "exp2",
    "floor",
    "fract",
    "inversesqrt",
    "length",
    "log",
    "log2",
    "normalize",
    "round",
    "sign",
    "sin",
    "sinh",
    "sqrt",
    "tan",
    "tanh",
    "trunc",
]
BINARY = ["atan", "distance", "dot", "max", "min", "mod", "pow", "step"]
EXTREME = [-np.inf, -3.4e38, -1e20, -1.0, -1e-40, 0.0, 1e-45, 0.5, 1.0, 1e19, 3.4e38, np.inf]


@pytest.mark.parametrize("rules", [Rules(), Rules(ranges=True)])
def test_no_bound_is_nan(rules: Rules) -> None:
    ends = np.array(list(itertools.combinations_with_replacement(EXTREME, 2)))
    first, second = (i.ravel() for i in np.indices((len(ends), len(ends))))
    a, b = (Band.between(*ends[i].T[..., None], rules) for i in (first, second))
    point = Band.exact(np.float32(EXTREME)[:, None], rules)
    found = {name: getattr(g, name)(a) for name in UNARY}
    found |= {f"{name} of a point": getattr(g, name)(point) for name in UNARY}
    found |= {f"{name} of two": getattr(g, name)(a, b) for name in BINARY}
    found |= {"sum": a + b, "product": a * b, "quotient": a / b, "of terms": (a + b) * (a * b + b)}
    wrong = [name for name, band in found.items() if not (band.lo <= band.hi).all()]
    assert not wrong
