"""A band is evaluated once for the same inputs, and again where what it depends on differs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from shaderlab.bands import Band, Rules
from shaderlab.engine.judging.banded import Banded, judge_band
from shaderlab.engine.judging.bands import BandCache
from shaderlab.engine.judging.references import Inputs, Reference
from shaderlab.glslmath import dot, vec4
from shaderlab.glslmath.sampling import texture
from shaderlab.model.frame import Texels


class Counted:
    """A formula that counts how often it is evaluated as a band."""

    def __init__(self) -> None:
        self.bands = 0

    def __call__(self, normal: Any, light: Any, albedo: Any, gains: Any) -> Any:
        self.bands += isinstance(normal, Band)
        lit = dot(normal, light) * gains[1]
        return vec4(lit, lit, lit, 1.0) * texture(albedo, normal.xy)


def given() -> Inputs:
    rng = np.random.default_rng(3)
    texels = rng.integers(0, 255, (4, 4, 4)).astype(np.uint8)
    albedo = Texels(
        texels, ("nearest", "nearest"), ("repeat", "repeat"), (0.0,) * 4, format="rgba8"
    )
    return Inputs(
        shared={
            "light": np.array([0.0, 0.6, 0.8], np.float32),
            "gains": np.array([[0.5], [2.0]], np.float32),
            "unread": np.zeros(1, np.float32),
        },
        each={"normal": rng.random((50, 3), np.float32)},
        textures={"albedo": albedo},
        arrays=frozenset({"gains"}),
    )


def judged(
    reference: Reference, inputs: Inputs, rules: Rules | None = None, format: str = "rgba32f"
) -> Banded:
    return judge_band(np.zeros((50, 4), np.float32), reference, inputs, rules=rules, format=format)


def test_the_same_inputs_have_the_same_band() -> None:
    reference, bands = Counted(), BandCache()
    alone = judged(reference, given())
    with bands.in_use():
        first = judged(reference, given())
        again = judged(reference, given())
        wrong = judge_band(first.low + np.float32(9.0), reference, given(), rules=None)
    assert reference.bands == 2  # once alone, once remembered
    for name in ("low", "high", "inside", "reference"):
        np.testing.assert_array_equal(getattr(again, name), getattr(alone, name))
    assert again.band.informative_share == alone.band.informative_share
    assert repr(again.worst()) == repr(alone.worst())
    assert wrong.outside == wrong.measured.size and wrong.worst() != again.worst()


def other_normal(inputs: Inputs) -> Inputs:
    normal = inputs.each["normal"].copy()
    normal[49, 2] += np.float32(1e-5)
    return replace(inputs, each={"normal": normal})


def other_gain(inputs: Inputs) -> Inputs:
    return replace(inputs, shared={**inputs.shared, "gains": np.ones((2, 1), np.float32)})


def other_texel(inputs: Inputs) -> Inputs:
    values = inputs.textures["albedo"].values.copy()
    values[0, 0, 0] ^= 1
    return replace(inputs, textures={"albedo": replace(inputs.textures["albedo"], values=values)})


def other_filter(inputs: Inputs) -> Inputs:
    albedo = replace(inputs.textures["albedo"], filter=("linear", "linear"))
    return replace(inputs, textures={"albedo": albedo})


@pytest.mark.parametrize("changed", [other_normal, other_gain, other_texel, other_filter])
def test_other_inputs_have_a_band_of_their_own(changed: Callable[[Inputs], Inputs]) -> None:
    reference = Counted()
    with BandCache().in_use():
        before = judged(reference, given())
        after = judged(reference, changed(given()))
    assert reference.bands == 2
    assert (before.low != after.low).any()


def test_other_formulas_rules_and_formats_have_a_band_of_their_own() -> None:
    reference = Counted()
    with BandCache().in_use():
        judged(reference, given())
        judged(reference, given(), rules=Rules(rearrange=False))
        judged(reference, given(), format="rgba8")
        judged(Counted(), given())
    assert reference.bands == 3


def test_an_input_that_no_formula_reads_changes_nothing() -> None:
    reference, inputs = Counted(), given()
    with BandCache().in_use():
        judged(reference, inputs)
        judged(reference, replace(inputs, shared={**inputs.shared, "unread": np.ones(1)}))
    assert reference.bands == 1


def test_what_has_no_room_is_evaluated_each_time() -> None:
    reference = Counted()
    with BandCache(limit=100).in_use():
        judged(reference, given())
        judged(reference, given())
    assert reference.bands == 2
