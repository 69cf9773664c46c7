"""Checks that could hardly fail, and sound ones that look like them.

Each hostile check is held against what its formula itself gives, rounded to float32: nothing lies
outside, and all the same it must fail, since its bands exclude nothing plausible. Each sound one
must pass; and the wrong values given with it must not.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from shaderlab.bands import Rules
from shaderlab.engine.expectations.exact import exact
from shaderlab.engine.judging.banded import judge_band
from shaderlab.engine.judging.bands import to_format
from shaderlab.engine.judging.references import Inputs, evaluate
from shaderlab.errors import CaseError
from shaderlab.glslmath import (
    abs,
    acos,
    atan,
    clamp,
    cos,
    cross,
    dot,
    exp,
    exp2,
    floor,
    fract,
    inversesqrt,
    length,
    log,
    max,
    min,
    mix,
    mod,
    normalize,
    pow,
    sign,
    sin,
    smoothstep,
    sqrt,
    step,
    vec2,
    vec3,
    vec4,
    where,
)
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array
from shaderlab.model.textures import Output

Formula = Callable[..., Any]
COUNT = 41 * 41


def inputs() -> Inputs:
    """x and y from 0 to 1 at the centres of 41² pixels, p the two, and vectors of any direction."""
    x, y = (a.reshape(-1, 1) for a in np.meshgrid(*[(np.arange(41) + 0.5) / 41] * 2))
    ray = np.random.default_rng(3).normal(size=(COUNT, 3))
    each = {"x": x, "y": y, "p": np.hstack([x, y]), "ray": ray}
    return Inputs(shared={}, each={name: value.astype(np.float32) for name, value in each.items()})


def verdict(
    formula: Formula,
    *,
    measured: Any = None,
    format: str = "rgba32f",
    rules: Rules | None = None,
) -> tuple[str, str]:
    """What is said of the formula's own values, or of others, as an attachment of 32-bit floats or
    of codes holds them."""
    given = inputs()
    with np.errstate(all="ignore"):
        found = evaluate(formula, given, rules=None, decimal=False)
        shape = (COUNT, np.shape(found)[-1] if np.ndim(found) else 1)
        values = np.broadcast_to(found if measured is None else np.asarray(measured), shape)
        stored: Array = to_format(values.astype(np.float64), format)
        stored = np.rint(stored).astype(np.uint8) if format == "rgba8" else stored
        kept = stored if format == "rgba8" else stored.astype(np.float32)
    return judge_band(kept, formula, given, rules=rules, format=format).verdict()


SCALED = Rules(trig_outside="scaled")
HOSTILE: dict[str, tuple[Formula, Rules | None]] = {
    "noise by a sine": (
        lambda p: fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.5453), SCALED,
    ),
    "noise, out of the sine's range": (
        lambda p: fract(sin(dot(p, vec2(12.9898, 78.233)) * 9.0) * 43758.5453), None,
    ),
    "noise in one channel of four": (
        lambda p: vec4(0.5, fract(sin(dot(p, vec2(1.1, 2.3))) * 43758.5453), 0.25, 1.0), None,
    ),
    "noise of a product": (lambda x, y: fract(x * y * 3e9), None),
    "noise of a square root": (lambda x: fract(sqrt(x) * 1e8), None),
    "a choice that is never made": (
        lambda x: where(sin(x) - sin(x) * 1.0 > 0.0, 1.0, 0.0) + 0.0 * x, None,
    ),
    "a step at the value itself": (lambda x: step(x, cos(acos(x))), None),
    "a step of a cancellation": (lambda x: step(0.5, (x + 3e8) - 3e8), None),
    "a floor of whole numbers that were divided": (
        lambda x: floor(floor(x * 40.0) * 3.0 / 3.0) - floor(x * 40.0), None,
    ),
    "the sign of nothing": (lambda x: sign(sin(x) * sin(x) + cos(x) * cos(x) - 1.0), None),
    "exp of a sine of a large number": (lambda x: exp(2e6 * sin(x)), None),
    "exp2 up to infinity": (lambda x: exp2(1e5 * sin(3.0 * x)), None),
    "a cancellation that is left with nothing": (lambda x: (x + 1e8) - 1e8, None),
    "the same, clamped": (lambda x: clamp((x + 1e9) - 1e9, 0.0, 1.0), None),
    "a difference of squares": (lambda x: (1e5 + x) * (1e5 + x) - 1e10 - 2e5 * x, None),
    "a sum that saturates": (lambda x: min(max((x + 1e9) - 1e9, 0.0), 1.0) * 0.5 + 0.25, None),
    "sin² + cos² − 1, magnified": (lambda x: (sin(x) * sin(x) + cos(x) * cos(x) - 1.0) * 1e5, None),
    "a derivative by tiny steps": (lambda x: (sin(x + 1e-6) - sin(x)) / 1e-6, None),
    "a quotient of differences": (
        lambda x: ((x + 1e7) - 1e7) / ((x + 2e7) - 1e7 - 1e7 + 0.1), None,
    ),
    "an angle of nothing": (lambda x: atan((x + 1e8) - 1e8 - x, (x + 2e8) - 2e8 - x), None),
    "the direction of nothing": (
        lambda ray: normalize(vec3(1.0, 1.0, 1.0) * ((ray + 1e9) - 1e9)), None,
    ),
    "a modulus of a large number": (lambda x: mod(x * 1e9, 1.0), None),
    "a modulus of whole numbers, whose quotient may fall short": (
        lambda x, y: mod(floor(x * 4.1) + floor(y * 4.1), 2.0), None,
    ),
    "a power of a large number": (lambda x: pow(x + 2.0, 1e4 * sin(x)), None),
    "a slope that is a cliff": (
        lambda x: smoothstep(0.0, 1.0, ((x - 0.5) + 1e9) - 1e9 + 0.5), None,
    ),
    "a logarithm of almost one": (lambda x: log(x * 1e-9 + 1.0) * 1e9, None),
    "an infinity on one side": (lambda x: 1.0 / max(sin(3.0 * x) * 0.0, 0.0), None),
    "a quarter of the frame": (
        lambda x: where(x < 0.25, fract(sqrt(x) * 1e9), x), None,
    ),
    "two in a hundred": (lambda x: where(x < 0.04, fract(sqrt(x) * 1e9), x), None),
}  # fmt: skip
# Sound checks, each with wrong values that it must notice.
SOUND: dict[str, tuple[Formula, Any]] = {
    "a ramp": (lambda x: x * 0.8 + 0.1, 0.5),
    "a constant": (lambda x: 0.3 + 0.0 * x, 0.31),
    "nothing at all": (lambda x: 0.0 * x, 1e-3),
    "opaque black": (lambda x: vec4(0.0 * x, 0.0, 0.0, 1.0), (0.0, 0.001, 0.0, 1.0)),
    "a length that is always one": (lambda ray: length(normalize(ray)), 0.999),
    "a component that is zero but for rounding": (
        lambda x: vec3(5.0 * cos(0.0 * x + 1.5707964), 1.0, 5.0), (0.1, 1.0, 5.0),
    ),
    "a highlight on few pixels": (
        lambda x, y: pow(max(1.0 - length(vec2(x - 0.5, y - 0.5)), 0.0), 64.0), 0.0,
    ),
    "a dark picture": (lambda x: 1e-4 * x, 0.0),
    "large numbers": (lambda x: 1e9 * (1.0 + x), 1.5e9),
    "a choice with an edge": (lambda x: where(x > 0.503, 1.0, 0.0), 0.0),
    "a staircase": (lambda x: floor(x * 8.0 + 0.01) / 8.0, 0.5),
    "a checker": (lambda x, y: abs(floor(x * 4.1) - 2.0 * floor(floor(x * 4.1) * 0.5)), 0.0),
    "a cancellation that leaves much": (lambda x: (x + 1e3) - 1e3, 0.5),
    "a sine within its precision": (lambda x: sin(6.0 * x - 3.0), 0.0),
    "a coarse angle": (lambda p: atan(p[..., 1:2], p[..., 0:1]), 0.8),
    "a cross product": (lambda ray: cross(ray, vec3(0.0, 1.0, 0.0)), (0.0, 0.0, 0.0)),
    "an inverse square": (lambda x: inversesqrt(0.1 + x), 1.0),
    "a mix": (lambda x: mix(vec3(0.1, 0.2, 0.3), vec3(0.9, 0.8, 0.7), x), (0.5, 0.5, 0.5)),
    "half a percent undefined": (
        lambda x, y: where((x < 0.02) & (y < 0.2), fract(sqrt(x) * 1e9), abs(x - 0.4)), 0.2,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_a_check_whose_bands_exclude_nothing_fails(name: str) -> None:
    formula, rules = HOSTILE[name]
    status, message = verdict(formula, rules=rules)
    assert status == "fail"
    assert "outside" not in message, message
    assert "hardly fail" in message or "plausible" in message or "branch" in message


@pytest.mark.parametrize("name", SOUND)
def test_a_sound_check_passes_and_can_fail(name: str) -> None:
    formula, wrong = SOUND[name]
    assert verdict(formula) == ("pass", "")
    status, message = verdict(formula, measured=wrong)
    assert status == "fail" and "outside" in message


def test_noise_is_no_check_of_a_constant() -> None:
    """A shader that gives 0.5 everywhere, judged by a formula of noise."""
    for format in ("rgba32f", "rgba8"):
        status, message = verdict(
            lambda p: vec4(*[fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.5453)] * 4),
            measured=(0.5,) * 4, format=format, rules=SCALED,
        )  # fmt: skip
        assert status == "fail" and "plausible" in message, message


def test_codes_are_compared_with_all_that_a_format_holds() -> None:
    """Three codes of 255 that hardly vary are a sound check; all of them are none."""
    assert verdict(lambda x: vec4(0.01 + 0.001 * x, 0.0, 0.0, 1.0), format="rgba8") == ("pass", "")
    status, _ = verdict(lambda x: vec4((x + 1e9) - 1e9, 0.0, 0.0, 1.0), format="rgba8")
    assert status == "fail"


def test_an_output_is_not_compared_with_itself() -> None:
    from shaderlab import Case, across, fullscreen

    def scene(*expect: Any) -> Scene:
        domain = {"x": across(0.0, 1.0)}
        passes = [fullscreen("a.frag", name=name, domain=domain)[0] for name in ("one", "two")]
        passes += fullscreen("a.frag", name="other", domain={"x": across(0.0, 2.0)})
        return Case(title="t", id="t", passes=tuple(passes), expect=expect).scene("default")

    for wrong in (
        exact("one.o", Output("one.o")),
        exact("o", Output("other.o")),
        exact("one.o", Output("two.o")),
    ):
        with pytest.raises(CaseError, match="could not fail"):
            tuple(wrong.needs(scene(wrong), {}))
    for right in (exact("one.o", Output("other.o")), exact("one.o", Output("one.other"))):
        assert tuple(right.needs(scene(right), {})) == ()
