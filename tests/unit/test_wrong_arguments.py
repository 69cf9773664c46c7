"""Odd arguments of what tests of functions call: each ends in a sentence or in a verdict, and never
in an error from inside the lab or NumPy."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import ShaderlabError, glsl
from shaderlab.errors import CallError

TEXT = """
struct Light { vec3 at; float power; };
uniform float gain;
float f(float k) { return k * 2.0; }
int whole(int k) { return k + 1; }
vec3 half_of(vec3 k) { return k * 0.5; }
float power(Light k) { return k.power; }
float sum(float a, float b) { return a + b; }
float scaled(float k) { return k * gain; }
float over(float k) { return k; }
float over(vec2 k) { return k.x; }
"""
LIB = glsl.load(TEXT)
ODD: list[Any] = [
    None, "x", "", b"x", True, -1, 1e39, float("nan"), 3 + 4j, object(), Path("x"), {},
    {"x": 1}, {"power": (0, 1)}, {"nosuch": glsl.floats(0, 1)}, set(), [], (),
    [0, 1], [[1], [2, 3]], (1, 0), (0, 1), (0, 1, 2), ("0", "1"), (None, 1), (float("nan"), 1),
    (-np.inf, np.inf), ((0, 1), (0, 1)), np.zeros(0), np.array(["x"]), np.array([object()]),
    np.ma.masked_array([1.0, 2.0], [0, 1]), slice(0, 1), glsl.floats(0, 1), glsl.ints(0, 3),
    glsl.bools(), glsl.directions(), glsl.one_of(1.0, 2.0),
]  # fmt: skip
FUNCTIONS = ["f", "whole", "half_of", "power", "scaled", "over"]


def said(call: Callable[[], Any]) -> str:
    """How a call ends: in a value, a failed check, or an error that is a sentence."""
    try:
        call()
    except ShaderlabError as error:
        assert len(error.message.split()) > 2, error
        return str(error)
    except AssertionError as error:
        return str(error)
    return ""


def given(function: Any, test: Any = lambda result: None, /, **domains: Any) -> Any:
    return lambda: glsl.given(function, **domains)(test)()


def attempts(odd: Any) -> Iterator[Callable[[], Any]]:
    for name in FUNCTIONS:
        function, more = LIB[name], {"gain": 1.0} if name == "scaled" else {}
        yield lambda f=function, m=more: f.check(lambda k: k * 2.0, odd, **m)
        yield lambda f=function, m=more: f.check(lambda k: k, k=odd, every=1 << 28, **m)
        yield lambda f=function: f.prove(lambda y: y >= -1e30, k=odd)
        yield given(function, k=odd, **more)
    yield lambda: LIB.f.prove(odd, k=(0, 1))
    yield lambda: LIB.f.check(odd, 1.0)
    yield lambda: LIB.f.check(lambda k: 2.0 * k, k=(np.float16(0), np.float16(1)), every=odd)
    yield given(odd, k=glsl.floats(0, 1))
    yield given(LIB.sum, lambda a, y: None, a=glsl.floats(0, 1), b=odd)
    yield lambda: given(LIB.f, k=glsl.one_of(1.0, odd))()
    for load in ({"defines": odd}, {"gain": odd}):
        yield lambda load=load: glsl.load(TEXT, **load).scaled(1.0)
    yield lambda: glsl.load(odd)
    for make in (glsl.floats, glsl.ints):
        yield lambda make=make: make(odd, 1)
        yield lambda make=make: make(0, odd)
    for law in (glsl.monotone, glsl.bounded, glsl.even, glsl.symmetric, glsl.idempotent,
                glsl.table, glsl.inverse, glsl.same_as):  # fmt: skip
        yield lambda law=law: LIB.f.check(law(odd), np.linspace(0, 1, 9))
        yield lambda law=law: LIB.f.check(law(odd), 1.0)
    yield lambda: LIB.f.check(glsl.inverse(LIB.f, within=odd), 0.0)


@pytest.mark.parametrize("odd", ODD, ids=[f"{n}-{type(odd).__name__}" for n, odd in enumerate(ODD)])
def test_an_odd_argument_is_a_sentence_or_a_verdict(odd: Any) -> None:
    for attempt in attempts(odd):
        said(attempt)


@pytest.mark.parametrize(
    ("attempt", "message"),
    [
        (
            given(LIB.f, k=(1, 0)),
            "given: k=(1, 0) is no range\n  → give two numbers, the lower one",
        ),
        (given(LIB.f, k=2.0), "nothing of f is searched\n  → k=(0, 1)"),
        (given(LIB.f, k="unit"), "glsl.directions() are of vectors"),
        (
            given(LIB.power, k={"at": "unit", "powr": (0, 1)}),
            "takes no 'k.powr'\n  → did you mean power?",
        ),
        (given(LIB.f, 3, k=(0, 1)), "glsl.given is written above a test, not 3"),
        (lambda: LIB.over[3], "__getitem__: types is 3; expected str"),
        (lambda: LIB[3], "__getitem__: name is 3; expected str"),
        (given(3, k=(0, 1)), "given: function is 3; expected Function"),
        (lambda: LIB.f.prove(lambda y: y > 0.0, k=1.0), "k: '1.0' is no range"),
        (lambda: LIB.f.prove(lambda y: 1.0, k=(0, 1)), "no truth value for each input"),
        (lambda: LIB.f.check(glsl.table([1.0, 2.0]), 1.0), "table: has shape (2,)"),
        (lambda: LIB.f.check("monotone", 1.0), "check: law is 'monotone'; expected Law or"),
        (lambda: LIB.f.check(glsl.bounded(0, "x"), 1.0), "bounded: high is 'x'; expected float or"),
        (lambda: LIB.f.check(glsl.bounded([0, 1]), 1.0), "not numbers of shape ()"),
        (lambda: LIB.whole.check(lambda k: k, k=(0, 0.5), every=True), "whole: k is int; given"),
        (lambda: glsl.floats(0, 1e39), "floats(0, 1e+39): give two floats, the lower first"),
        (lambda: glsl.ints(0, 2**40), "give two of 32 bits, the lower first"),
        (lambda: glsl.load(5), "load: shader is 5; expected str or PathLike"),
    ],
)
def test_listed_mistakes(attempt: Callable[[], Any], message: str) -> None:
    assert message in said(attempt)


def test_a_pair_is_a_range_everywhere() -> None:
    seen: list[Any] = []

    def inside(a: Any, b: Any) -> Any:
        seen.append(a)
        return (a >= 0.0) & (a <= 1.0) & (b >= 2.0) & (b <= 3.0)

    given(LIB.sum, inside, a=(0, 1), b=(np.float64(2), 3))()
    assert any(isinstance(a, np.ndarray) and len(a) > 1 for a in seen)
    given(LIB.power, k={"at": "unit", "power": (0, 1)})()
    given(LIB.whole, lambda k, y: bool(np.all(y == k + 1)), k=(0, 9))()
    with pytest.raises(AssertionError, match="k=3"):
        given(LIB.whole, lambda k, y: bool(np.all(k < 3)), k=(0, 9))()
    LIB.f.prove(lambda y: (y >= 0.0) & (y <= 2.0), k=(np.float32(0), np.float64(1)))
    LIB.f.check(lambda k: 2.0 * k, k=(0, 1), every=1 << 24)


def test_laws_hold_of_single_numbers() -> None:
    LIB.f.check(glsl.table(2.0), 1.0)
    LIB.f.check(glsl.inverse(lambda y: y / 2.0), 1.0)


def test_what_does_not_fit_fails_each_time() -> None:
    """Also where the test is proved, of which samples are drawn but once."""

    @glsl.given(LIB.whole, k=glsl.floats(0, 1))
    def always(result: Any) -> None: ...

    for _ in range(2):
        with pytest.raises(CallError, match="k is int; given was an array of float32"):
            always()
