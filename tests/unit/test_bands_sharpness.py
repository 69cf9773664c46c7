"""Bands catch mistakes: a small slip is outside, and widths stay within a few ULP of the value."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from shaderlab import glslmath as g
from shaderlab.bands import Band, Rules
from shaderlab.bands.rounding import ulp

COUNT = 64 * 64
RNG_SEED = 11
AS_WRITTEN = Rules(rearrange=False)


def attenuation(distance: Any, constant: Any, linear: Any, quadratic: Any) -> Any:
    return 1.0 / (constant + linear * distance + quadratic * distance * distance)


def blinn_phong(position: Any, normal: Any, light: Any, view: Any, shininess: float = 32.0) -> Any:
    n = g.normalize(normal)
    to_light = g.normalize(light - position)
    halfway = g.normalize(to_light + g.normalize(view - position))
    diffuse = g.max(g.dot(n, to_light), 0.0)
    specular = g.pow(g.max(g.dot(n, halfway), 0.0), shininess)
    return (0.1 + diffuse + 0.5 * specular) * g.vec3(1.0, 0.5, 0.31)


def scene() -> list[np.ndarray]:
    rng = np.random.default_rng(RNG_SEED)
    position = rng.uniform(-1.0, 1.0, (COUNT, 3)) * [1.0, 1.0, 0.2]
    normal = rng.normal(size=(COUNT, 3)) * 0.2 + [0.0, 0.0, 1.0]
    arrays = (position, normal, [1.2, 1.0, 2.0], [0.0, 0.0, 3.0])
    return [np.asarray(array, np.float32) for array in arrays]


def distances() -> np.ndarray:
    return np.linspace(0.1, 60.0, COUNT, dtype=np.float32)[:, None]


def half_widths_in_ulp(band: Band) -> np.ndarray:
    middle = (band.lo + band.hi) / 2.0
    return (band.hi - band.lo) / 2.0 / ulp(middle)


@pytest.mark.parametrize(("rules", "most"), [(Rules(), 12.0), (AS_WRITTEN, 8.0)])
def test_attenuation_is_known_to_a_few_ulp(rules: Rules, most: float) -> None:
    uniforms = [Band.exact(x, rules) for x in (1.0, 0.09, 0.032)]
    band = attenuation(Band.exact(distances(), rules), *uniforms)
    assert half_widths_in_ulp(band).max() <= most


def test_gamma_is_known_to_a_few_ulp() -> None:
    band = g.pow(Band.exact(np.linspace(0.01, 1.0, COUNT)[:, None]), 1.0 / 2.2)
    assert np.median(half_widths_in_ulp(band)) <= 10.0
    assert half_widths_in_ulp(band).max() <= 64.0


def test_lighting_is_known_to_a_relative_ten_thousandth() -> None:
    band = blinn_phong(*(Band.exact(x) for x in scene()))
    assert ((band.hi - band.lo) / band.hi).max() < 2e-4
    assert not band.vacuous.any() and not band.undecided.any()


def mean_outside(formula: Callable[..., Any], wrong: Callable[..., Any], *inputs: Any) -> float:
    """The share of pixels at which the wrong formula's float32 value is outside."""
    band = formula(*(Band.exact(x) for x in inputs))
    exact = [np.asarray(x, np.float32).astype(np.float64) for x in inputs]
    right = np.asarray(formula(*exact), np.float32)
    assert band.contains(right).all(), "the formula itself must be inside"
    return float((~band.contains(np.asarray(wrong(*exact), np.float32))).mean())


@pytest.mark.parametrize(
    "wrong",
    [
        lambda d: attenuation(d, 1.0, 0.09 * 1.01, 0.032),
        lambda d: attenuation(d, 1.0, 0.09, 0.032 * 0.99),
        lambda d: attenuation(d, 1.0, 0.09, 0.032) * (1.0 + 1e-5),
        lambda d: 1.0 / (1.0 + 0.09 * d + 0.032 * d),
    ],
)
def test_a_slip_in_attenuation_is_outside(wrong: Callable[..., Any]) -> None:
    def formula(d: Any) -> Any:
        return attenuation(d, 1.0, 0.09, 0.032)

    assert mean_outside(formula, wrong, distances()) > 0.95


def test_a_slip_in_lighting_is_outside() -> None:
    def shinier(*inputs: Any) -> Any:
        return blinn_phong(*inputs, shininess=32.3)

    assert mean_outside(blinn_phong, shinier, *scene()) > 0.85


def test_a_dropped_max_is_outside_wherever_it_matters() -> None:
    towards = np.linspace(-1.0, 1.0, COUNT, dtype=np.float32)[:, None]
    band = g.max(Band.exact(towards) * 0.8, 0.0)
    outside = ~band.contains((towards * 0.8).astype(np.float32))
    np.testing.assert_array_equal(outside, towards < 0.0)


def test_near_zero_a_clamped_cosine_stays_tight() -> None:
    n = Band.exact([0.0, 0.0, 1.0])
    light = g.normalize(Band.exact([[1.0, 0.0, 0.0], [1.0, 0.0, 1e-7]]))
    band = g.max(g.dot(n, light), 0.0)
    assert (band.lo >= 0.0).all() and (band.hi < 1.1e-7).all()
    assert band.hi[0] == 0.0, "no light at a right angle, exactly"


def test_constants_and_exact_functions_are_judged_to_the_last_bit() -> None:
    x = Band.exact([0.1, 0.7])
    for band in (g.clamp(x, 0.25, 0.5), g.vec4(1.0, 0.5, 0.25, 1.0), g.floor(x), g.min(x, 0.5)):
        lo = band.lo if isinstance(band, Band) else band
        hi = band.hi if isinstance(band, Band) else band
        np.testing.assert_array_equal(lo, hi)
    product = x * Band.exact([0.3, 0.9])
    assert ((product.hi - product.lo) <= ulp(product.hi) * 2.0).all()


def test_what_is_undefined_is_counted() -> None:
    x = Band.exact([[0.0], [1.0], [4.0]])
    assert g.log(x).vacuous[:, 0].tolist() == [True, False, False]
    assert g.clamp(1.0 / x, 0.0, 1.0).vacuous[:, 0].tolist() == [True, False, False]
    assert g.sin(x).vacuous[:, 0].tolist() == [False, False, True]
    assert g.sqrt(x - 1.0).vacuous[:, 0].tolist() == [True, False, False]
    assert g.pow(x, -1.0).vacuous[:, 0].tolist() == [True, False, False]
    assert g.pow(-x, 2.0).vacuous[:, 0].tolist() == [False, True, True]
    # Where x is 0 as well: a device's log2(0) may be finite (SwiftShader's is some -139).
    assert 0.3 < g.pow(x, 0.01).hi[0, 0] < 0.45 and g.pow(x, 0.4).hi[0, 0] > 4.2e-18
    assert g.normalize(g.vec3(x)).vacuous[0].all()


def test_smoothstep_beyond_its_edges_is_exact() -> None:
    """Products and sums of exactly 0 or 1 are exact in any order: no terms stay behind them."""
    far = Band.between([[-3.0], [7.0]], [[-2.9], [7.1]])
    risen = g.smoothstep(0.25, 0.75, far)
    assert risen.lo.ravel().tolist() == risen.hi.ravel().tolist() == [0.0, 1.0]
    assert (1.0 - risen).abs_sum.ravel().tolist() == [1.0, 2.0]
    between = g.smoothstep(0.25, 0.75, Band.exact([[0.5]]))
    assert between.lo.item() < 0.5 < between.hi.item()


def test_anything_goes_where_the_squares_of_a_vector_overflow() -> None:
    """Their sum may be infinity, or the largest number."""
    band = g.normalize(Band.exact([[3e19, 1.0, 0.0], [3e18, 1.0, 0.0]]))
    assert band.vacuous[0].all() and not band.vacuous[1].any()
