"""GLSL's functions: right on plain numbers; their bands hold the truth and the errors allowed."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

from shaderlab import glslmath as g
from shaderlab.bands import Band, Integer, Rules
from shaderlab.bands.rounding import ulp
from shaderlab.errors import FormulaError

SCALED = Rules(trig_outside="scaled")


def log_uniform(lo: float, hi: float) -> np.ndarray:
    return np.exp2(np.random.default_rng(0).uniform(lo, hi, 80))


def uniform(lo: float, hi: float) -> np.ndarray:
    return np.random.default_rng(0).uniform(lo, hi, 80)


def near_one() -> np.ndarray:
    return np.concatenate([uniform(0.4, 2.4), [0.5, 1.0, 2.0, 1 + 2**-23, 1 - 2**-24]])


# Name: inputs, the truth, and the error that the specification allows at (x, f(x)).
ALLOWED: dict[str, tuple[np.ndarray, Callable[[Any], Any], Callable[[Any, Any], Any]]] = {
    "sin": (uniform(-math.pi, math.pi), mpmath.sin, lambda x, f: 2.0**-11),
    "cos": (uniform(-math.pi, math.pi), mpmath.cos, lambda x, f: 2.0**-11),
    "exp": (uniform(-60, 60), mpmath.exp, lambda x, f: (3 + 2 * abs(x)) * ulp(f)),
    "exp2": (
        uniform(-90, 90),
        lambda x: mpmath.power(2, x),
        lambda x, f: (3 + 2 * abs(x)) * ulp(f),
    ),
    "log": (
        np.concatenate([near_one(), log_uniform(-100, 100)]),
        mpmath.log,
        lambda x, f: np.where((x >= 0.5) & (x <= 2), 2.0**-21, 3 * ulp(f)),
    ),
    "log2": (
        np.concatenate([near_one(), log_uniform(-100, 100)]),
        lambda x: mpmath.log(x, 2),
        lambda x, f: np.where((x >= 0.5) & (x <= 2), 2.0**-21, 3 * ulp(f)),
    ),
    "inversesqrt": (log_uniform(-120, 120), lambda x: 1 / mpmath.sqrt(x), lambda x, f: 2 * ulp(f)),
    "atan": (uniform(-50, 50), mpmath.atan, lambda x, f: 4096 * ulp(f)),
}


@pytest.mark.parametrize("name", ALLOWED)
def test_a_band_holds_the_truth_and_all_of_the_allowed_error_but_not_more(name: str) -> None:
    inputs, truth, error = ALLOWED[name]
    x = inputs.astype(np.float32).astype(np.float64)
    exact = np.array([float(truth(mpmath.mpf(float(value)))) for value in x])
    allowed = error(x, exact)
    band = getattr(g, name)(Band.exact(x))
    assert (band.lo <= exact - allowed).all() and (exact + allowed <= band.hi).all()
    # Outward rounding may add an ULP; it is twice the size on the far side of a power of two.
    assert (band.lo >= exact - allowed - 2 * ulp(band.lo)).all()
    assert (band.hi <= exact + allowed + 2 * ulp(band.hi)).all()


@pytest.mark.parametrize(
    ("name", "inputs", "truth", "relative"),
    [
        ("sqrt", log_uniform(-100, 100), mpmath.sqrt, 1.2e-6),
        ("tan", uniform(-1.2, 1.2), mpmath.tan, 0.1),
        ("asin", uniform(-1, 1), mpmath.asin, 0.1),
        ("acos", uniform(-1, 0.99), mpmath.acos, 0.1),
        ("radians", uniform(-360, 360), mpmath.radians, 1e-6),
        ("degrees", uniform(-6, 6), mpmath.degrees, 1e-6),
    ],
)
def test_derived_functions_hold_the_truth(
    name: str, inputs: np.ndarray, truth: Callable[[Any], Any], relative: float
) -> None:
    x = inputs.astype(np.float32).astype(np.float64)
    exact = np.array([float(truth(mpmath.mpf(float(value)))) for value in x])
    band = getattr(g, name)(Band.exact(x))
    assert ((band.lo < exact) & (exact < band.hi)).all()
    assert ((band.hi - band.lo) <= relative * np.maximum(np.abs(exact), 0.05)).all()


def test_pow_holds_the_truth_and_zero_to_the_positive_is_zero() -> None:
    rng = np.random.default_rng(2)
    x = rng.uniform(0.0, 3.0, 200).astype(np.float32).astype(np.float64)
    y = rng.uniform(-4.0, 40.0, 200).astype(np.float32).astype(np.float64)
    exact = np.array([float(mpmath.power(a, b)) for a, b in zip(x, y, strict=True)])
    band = g.pow(Band.exact(x), Band.exact(y))
    assert ((band.lo <= exact) & (exact <= band.hi)).all()
    zero = g.pow(Band.exact([0.0]), 1.0 / 2.2)
    assert zero.contains([0.0]) and zero.hi < 1e-16 and not zero.vacuous
    assert g.pow(Band.exact([0.0]), 0.0).vacuous


@pytest.mark.parametrize("function", [g.sin, g.cos, g.exp, g.log, g.sqrt, g.inversesqrt, g.atan])
def test_an_interval_holds_the_bands_of_its_points(function: Callable[[Any], Any]) -> None:
    rng = np.random.default_rng(3)
    lo = rng.uniform(0.01, 2.0, (60, 1))
    hi = np.minimum(lo + rng.uniform(0.0, 2.0, (60, 1)), 3.1)
    wide = function(Band.between(lo, hi))
    inside = np.linspace(wide_lo := np.asarray(lo, np.float64), hi, 17)[1:-1]
    assert wide_lo.shape == (60, 1)
    for x in inside:
        point = function(Band.exact(x))
        assert (wide.lo <= point.lo).all() and (point.hi <= wide.hi).all()


def test_an_interval_across_a_change_of_the_error_takes_the_larger() -> None:
    """An ULP doubles at a power of two; a logarithm's error changes at one half."""
    across = g.exp2(Band.between([-1e-8], [1e-8]))
    assert across.lo <= g.exp2(Band.exact([1e-8])).lo
    logs = g.log(Band.between([0.49999997], [2.1]))
    assert logs.lo <= g.log(Band.exact([0.5])).lo


def test_large_angles_have_4096_ulp() -> None:
    band, truth = g.acos(Band.exact([-0.99])), math.acos(float(np.float32(-0.99)))
    assert band.contains([truth + 2.0**-10.1]) and band.contains([truth - 2.0**-10.1])


def test_waves_reach_their_crests_inside_an_interval() -> None:
    assert g.sin(Band.between([1.0], [2.0])).hi >= 1.0
    assert g.sin(Band.between([-2.0], [-1.0])).lo <= -1.0
    assert g.cos(Band.between([-0.5], [0.5])).hi >= 1.0
    assert g.cos(Band.between([3.0], [3.14])).lo > -1.001


def test_waves_outside_pi_follow_the_rules() -> None:
    assert g.sin(Band.exact([4.0])).vacuous
    scaled = g.sin(Band.exact([100.0], SCALED))
    assert not scaled.vacuous and scaled.hi - scaled.lo == pytest.approx(2 * 100 / 4096, rel=1e-5)
    assert not g.sin(Band.exact([np.float32(np.pi)])).vacuous


@pytest.mark.parametrize(
    ("y", "x", "lowest", "highest"),
    [
        *((1.0, 1.0, 0.785, 0.786), (1.0, -1.0, 2.355, 2.358), (-1.0, -1.0, -2.358, -2.355)),
        *((0.0, 1.0, 0.0, 0.0), (0.0, -1.0, -3.15, 3.15)),
    ],
)
def test_atan_of_two(y: float, x: float, lowest: float, highest: float) -> None:
    band = g.atan(Band.exact([y]), Band.exact([x]))
    assert lowest <= band.lo <= band.hi <= highest
    assert g.atan(Band.exact([0.0]), Band.exact([0.0])).vacuous


def test_rounding_functions() -> None:
    x = Band.exact([-1.5, -0.5, 0.5, 1.5, 2.5])
    assert g.floor(x).lo.tolist() == [-2, -1, 0, 1, 2]
    assert g.ceil(x).lo.tolist() == [-1, 0, 1, 2, 3]
    assert g.trunc(x).lo.tolist() == [-1, 0, 0, 1, 2]
    assert g.roundEven(x).lo.tolist() == [-2, 0, 0, 2, 2]
    assert g.round(x).lo.tolist() == [-2, -1, 0, 1, 2]
    assert g.round(x).hi.tolist() == [-1, 0, 1, 2, 3]
    assert g.sign(Band.between([-1.0], [1.0])).lo == -1.0
    assert g.fract(Band.exact([1.25])).lo == g.fract(Band.exact([1.25])).hi == 0.25
    assert g.mod(Band.exact([5.5]), 2.0).contains([1.5])


def test_min_and_max_with_nan_give_either() -> None:
    undefined = Band.exact([np.nan])
    smaller = g.min(undefined, 1.0)
    assert smaller.contains([1.0]) and smaller.contains([np.nan]) and smaller.contains([-9.0])
    maybe = Band.between([0.0], [1.0]) * Band.between([1.0], [np.inf])
    assert maybe.nan.all() and not maybe.vacuous.any()
    assert g.max(maybe, -1.0).contains([-1.0]) and not g.max(maybe, -1.0).contains([-2.0])
    assert g.max(undefined, 0.0).contains([0.0]) and g.max(undefined, 0.0).vacuous


def test_unit_vectors_are_within_unit_length() -> None:
    rng = np.random.default_rng(5)
    v = rng.normal(size=(500, 3)).astype(np.float32)
    band = g.normalize(Band.exact(v))
    exact = v / np.linalg.norm(v.astype(np.float64), axis=-1, keepdims=True)
    assert ((band.lo <= exact) & (exact <= band.hi)).all()
    assert ((band.hi - band.lo) / 2 <= 16 * ulp(exact)).all()
    wide = g.normalize(Band.between([0.5, -0.1, 0.0], [1.0, 0.1, 0.0]))
    assert (np.abs([wide.lo, wide.hi]) <= 1.0 + 1e-5).all()


# Formulas over vectors a, b (N, 3), scalars x in [0, 1] (N, 1) and a matrix m (3, 3).
FORMULAS: dict[str, Callable[..., Any]] = {
    "dot": lambda a, b, x, m: g.dot(a, b),
    "cross": lambda a, b, x, m: g.cross(a, b),
    "distance": lambda a, b, x, m: g.distance(a, b),
    "reflect": lambda a, b, x, m: g.reflect(a, g.normalize(b)),
    "refract": lambda a, b, x, m: g.refract(g.normalize(a), g.normalize(b), 0.7),
    "faceforward": lambda a, b, x, m: g.faceforward(a, b, a + 0.1),
    "mix": lambda a, b, x, m: g.mix(a, b, x),
    "smoothstep": lambda a, b, x, m: g.smoothstep(0.1, 0.8, x),
    "step": lambda a, b, x, m: g.step(0.3, a),
    "mod": lambda a, b, x, m: g.mod(a, 0.7),
    "fma": lambda a, b, x, m: g.fma(a, b, x),
    "where": lambda a, b, x, m: g.where(a < b, a * x, b / 3.0),
    "mul": lambda a, b, x, m: g.mul(m, a),
    "matmul": lambda a, b, x, m: g.matmul(m, g.transpose(m)),
    "inverse": lambda a, b, x, m: g.inverse(m),
    "determinant": lambda a, b, x, m: g.determinant(m),
    "outerProduct": lambda a, b, x, m: g.outerProduct(a, b),
    "matrixCompMult": lambda a, b, x, m: g.matrixCompMult(m, m),
    "tbn": lambda a, b, x, m: g.mul(g.mat3(a, b, g.cross(a, b)), g.vec3(x, 0.5, 1.0)),
    "swizzled": lambda a, b, x, m: g.vec4(g.swizzle(a, "zx"), g.swizzle(b, "rr")),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_the_float64_value_of_a_formula_is_inside_its_own_band(name: str) -> None:
    rng = np.random.default_rng(6)
    shapes = ((64, 3), (64, 3), (64, 1), (3, 3))
    inputs = [rng.uniform(-1.0, 1.0, shape).astype(np.float32) for shape in shapes]
    inputs[2] = np.abs(inputs[2])
    plain = FORMULAS[name](*(x.astype(np.float64) for x in inputs))
    band = FORMULAS[name](*(Band.exact(x) for x in inputs))
    assert band.shape == plain.shape
    assert ((band.lo <= plain) & (plain <= band.hi)).all()
    assert (band.vacuous | band.undecided).mean() < 0.01


def test_plain_numbers_need_no_arrays_and_no_warnings() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert pytest.approx(0.011695906) == 1.0 / (1.0 + 0.09 * 50.0 + 0.032 * 50.0 * 50.0)
        assert g.mix(0.0, 10.0, 0.2) == 2.0 and g.clamp(3, 0, 1) == 1.0
        assert math.isnan(g.sqrt(-1.0)) and g.log(0.0) == -math.inf
        assert g.inversesqrt(0.0) == math.inf and math.isnan(g.mod(1.0, 0.0))
        assert np.isnan(g.normalize(np.zeros(3))).all()
        assert g.atan(1.0, 1.0) == pytest.approx(math.pi / 4)
        assert g.where(1.0 > 2.0, 1.0, 2.0) == 2.0
        assert g.step(0.5, 0.5) == 1.0 and g.smoothstep(0.0, 1.0, 0.5) == 0.5
        assert g.isnan(math.nan) and g.isinf(math.inf)
        assert g.length(-3.0).tolist() == [3.0]


def test_constructors() -> None:
    per_pixel = np.arange(6.0).reshape(2, 3)
    assert g.vec4(per_pixel, 1.0).shape == (2, 4)
    assert g.vec4(Band.exact(per_pixel), 1.0).hi[:, 3].tolist() == [1.0, 1.0]
    assert g.vec3(2.0).tolist() == [2.0, 2.0, 2.0]
    assert g.vec3(np.arange(4.0)).tolist() == [0.0, 1.0, 2.0]
    assert g.mat3(np.eye(4)).shape == (3, 3)
    columns = g.mat3(*(Band.exact(row) for row in per_pixel.T[:, [0, 0, 1]]))
    assert columns.lo[:, 0].tolist() == [0.0, 0.0, 3.0]
    for wrong in (lambda: g.vec3(1.0, 2.0), lambda: g.vec2(1.0, 2.0, 3.0), lambda: g.vec4()):
        with pytest.raises(FormulaError):
            wrong()


def test_an_array_gives_all_that_an_uncertain_index_may_choose() -> None:
    table = g.array(0.1, 0.7, 0.3)
    low, high, anything = np.array([(0, 1, 2, 0, 2), (0, 2, 2, 3, 2), (0, 0, 0, 0, 1)])[..., None]
    n = Integer(low, high, rules=Rules(), anything=anything > 0)
    got = table[n]
    assert got.lo[:3, 0] == pytest.approx([0.1, 0.3, 0.3]) and got.hi[1, 0] == pytest.approx(0.7)
    assert np.isneginf(got.lo[3:]).all() and np.isposinf(got.hi[3:]).all()
    whole = g.array([4, 9], [2, 7])[Integer([[0], [1]], rules=Rules())]
    assert [column.lo.tolist() for column in whole] == [[[4], [2]], [[9], [7]]]
    assert g.array(np.arange(3, dtype=np.uint32))[2].unsigned
    for wrong in (lambda: g.array(), lambda: table[1.0], lambda: table[Band.exact([1.0])]):
        with pytest.raises(FormulaError):
            wrong()


@pytest.mark.parametrize("names", ["xw", "xg", "", "q"])
def test_wrong_swizzles_are_refused(names: str) -> None:
    with pytest.raises(FormulaError):
        g.swizzle(np.arange(3.0), names)
    assert g.swizzle(Band.exact([1.0, 2.0]), "yxx").lo.tolist() == [2.0, 1.0, 1.0]
