"""Laws judged on made-up runs: what keeps a law passes, and each kind of breach is caught."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    across,
    bounded,
    even,
    fullscreen,
    glsl,
    monotone,
    odd,
    symmetric,
)
from shaderlab.engine.expectations.laws import OutputLaw
from shaderlab.engine.expectations.needs import Probe
from shaderlab.errors import CaseError
from shaderlab.model.frame import Bindings, Frame, Samples
from shaderlab.model.records import Outcome

XS = tuple(np.linspace(-2.0, 2.0, 41).tolist())


def judged(check: OutputLaw, shader: Callable[..., Any]) -> Outcome:
    """The property's outcome for a shader that is this function of its inputs."""
    names = list(dict.fromkeys(name for step in check.steps for name in step))
    inputs = {
        name: np.array([np.atleast_1d(step[name]) for step in check.steps], np.float32)
        for name in names
    }
    y = np.asarray(shader(**inputs), np.float32)
    frame = Frame(
        images={},
        order=("main",),
        bindings={("main", 0): Bindings()},
        answers={Probe(check): Samples(inputs=inputs, outputs={"y": y})},
    )
    passes = fullscreen("y.frag", domain={"x": across(0.0, 1.0)})
    case = Case(title="t", id="t", passes=passes, expect=[check])
    return check.judge(case.scene("default"), frame).outcome


def test_monotone() -> None:
    check = monotone("y", over="x", values=XS)
    assert judged(check, lambda x: x * x * x).status == "pass"
    assert judged(check, lambda x: np.floor(x)).status == "pass"
    fell = judged(check, lambda x: np.where(x > 1.0, x - 0.5, x))
    assert (fell.status, fell.outside, fell.kind) == ("fail", 1, "monotone")
    assert fell.worst is not None and "does not hold at 1 of 41 values" in fell.message
    assert fell.worst.inputs["x"][0] == pytest.approx(1.1)
    falling = monotone("y", over="x", values=XS, direction="decreasing")
    assert judged(falling, lambda x: -x).status == "pass"
    assert judged(falling, lambda x: x).status == "fail"


def test_strictly_monotone_refuses_a_plateau() -> None:
    check = monotone("y", over="x", values=XS, strict=True)
    assert judged(check, lambda x: x).status == "pass"
    flat = judged(check, lambda x: np.minimum(x, 1.0))
    assert flat.status == "fail" and flat.outside == 10


def test_each_component_is_monotone_by_itself() -> None:
    check = monotone("y", over="x", values=XS)
    outcome = judged(check, lambda x: np.concatenate([x, -x], axis=1))
    assert outcome.status == "fail" and outcome.outside == 40
    assert outcome.worst is not None and outcome.worst.component == 1


def test_bounded() -> None:
    check = bounded("y", 0.0, 1.0, over="x", values=XS)
    assert judged(check, lambda x: np.clip(x, 0.0, 1.0)).status == "pass"
    outcome = judged(check, lambda x: np.clip(x, 0.0, 1.0 + 2.0**-23))
    assert outcome.status == "fail" and outcome.worst is not None
    assert outcome.worst.inputs["x"][0] > 1.0 and outcome.worst.ulp == 1.0
    each = bounded("y", (0.0, -2.0), (2.0, 0.0), over="x", values=(1.0, 2.0))
    assert judged(each, lambda x: np.concatenate([x, -x], axis=1)).status == "pass"
    assert judged(each, lambda x: np.concatenate([-x, x], axis=1)).status == "fail"


def test_symmetric_in_sign() -> None:
    square = even("y", over="x", values=XS)
    assert judged(square, lambda x: x * x).status == "pass"
    skewed = judged(square, lambda x: x * x + np.where(x == 2.0, 1.0, 0.0))
    # ±2 are among the values, so that pair is there twice.
    assert (skewed.status, skewed.outside) == ("fail", 2)
    cubic = odd("y", over="x", values=XS)
    assert judged(cubic, lambda x: x * x * x).status == "pass"
    assert judged(cubic, lambda x: x * x).status == "fail"


def test_symmetric_under_exchange() -> None:
    pairs = [(a, b) for a in XS[::5] for b in XS[::7]]
    check = symmetric("y", over=("a", "b"), values=pairs)
    assert judged(check, lambda a, b: a * b).status == "pass"
    outcome = judged(check, lambda a, b: a * b + 0.25 * (a - b))
    assert outcome.status == "fail" and outcome.worst is not None
    assert set(outcome.worst.inputs) == {"a", "b"}
    turned = symmetric("y", over=("a", "b"), values=pairs, odd=True)
    assert judged(turned, lambda a, b: a - b).status == "pass"
    assert judged(turned, lambda a, b: a * b).status == "fail"


def test_ulps_are_what_two_runs_may_differ_by() -> None:
    def nearly(x: Any) -> Any:
        return np.where(x > 0.0, 1.0 + 2.0**-22, 1.0)  # two steps above 1

    for ulp, status in ((1, "fail"), (2, "pass")):
        check = even("y", over="x", values=(1.0,), ulp=ulp)
        assert judged(check, nearly).status == status


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_keeps_no_law(bad: float) -> None:
    for check in (
        monotone("y", over="x", values=XS),
        bounded("y", -9.0, 9.0, over="x", values=XS),
        even("y", over="x", values=XS),
    ):
        outcome = judged(check, lambda x: np.where(x == XS[7], bad, x))
        assert outcome.status == "fail" and "not finite" in outcome.message


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: monotone("y", over="x", values=(1.0,)),
        lambda: monotone("y", over="x", values=(1.0, 1.0)),
        lambda: monotone("y", over="x", values=(0.0, 1.0), direction="upward"),
        lambda: bounded("y", 1.0, 0.0, over="x", values=(0.0,)),
        lambda: bounded("y", 0.0, 1.0, over="x", values=()),
        lambda: even("y", over="x", values=()),
        lambda: even("y", over="x", values=(1.0,), ulp=-1),
    ],
)
def test_a_law_that_could_not_be_judged_is_refused(wrong: Callable[[], OutputLaw]) -> None:
    with pytest.raises(CaseError):
        wrong()


def test_a_law_that_would_hold_of_any_constant_fails() -> None:
    for check in (
        monotone("y", over="x", values=XS),
        even("y", over="x", values=XS),
        odd("y", over="x", values=XS),
    ):
        outcome = judged(check, lambda x: np.zeros_like(x))
        assert outcome.status == "fail" and "could hardly fail: it is the same" in outcome.message


@pytest.mark.parametrize(
    "make",
    [
        lambda: bounded("y", -np.inf, np.inf, over="x", values=XS),
        lambda: bounded("y", (0.0, -np.inf), (1.0, np.inf), over="x", values=XS),
        lambda: even("y", over="x", values=(0.0,)),
        lambda: symmetric("y", over=("a", "b"), values=((1.0, 1.0), (2.0, 2.0))),
        lambda: even("y", over="x", values=XS, ulp=2**30),
    ],
)
def test_laws_that_nothing_could_break_are_errors(make: Callable[[], OutputLaw]) -> None:
    with pytest.raises(CaseError):
        make()


@pytest.mark.parametrize(
    ("old", "now"),
    [
        (lambda: symmetric("y", over="x", values=XS), 'even(over="x")'),
        (lambda: glsl.symmetric("a", "b"), 'symmetric(over=("a", "b"))'),
    ],
)
def test_a_former_spelling_names_the_present_one(old: Callable[[], Any], now: str) -> None:
    with pytest.raises(CaseError) as error:
        old()
    assert now in str(error.value)
