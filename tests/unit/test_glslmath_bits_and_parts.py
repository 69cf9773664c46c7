"""Functions of bits, parts and packed codes against Python's integers, `struct` and NumPy, and
the hyperbolic ones against mpmath; bands of intervals hold those of their points."""

from __future__ import annotations

import struct
from typing import Any

import mpmath
import numpy as np
import pytest

from shaderlab import glslmath as g
from shaderlab.bands import Band, Integer, Rules

RULES = Rules()
NUMBERS = (0, 1, 2, 40, 255, 2**15, 2**24 + 1, 2**31 - 1, -1, -2, -41, -(2**31))
X = np.linspace(-4.0, 4.0, 81).astype(np.float32).astype(np.float64)


@pytest.mark.parametrize(
    ("name", "truth", "least", "most", "width"),
    [
        ("sinh", mpmath.sinh, -4.0, 4.0, 1e-4),
        ("cosh", mpmath.cosh, -4.0, 4.0, 1e-4),
        ("tanh", mpmath.tanh, -4.0, 4.0, 1e-4),
        ("asinh", mpmath.asinh, -4.0, 4.0, 1e-4),
        ("acosh", mpmath.acosh, 1.125, 4.0, 1e-4),
        ("atanh", mpmath.atanh, -0.9, 0.9, 1e-4),
    ],
)
def test_hyperbolic_bands_hold_the_truth_and_little_else(
    name: str, truth: Any, least: float, most: float, width: float
) -> None:
    x = np.linspace(least, most, 60).astype(np.float32).astype(np.float64)[:, None]
    exact = np.array([[float(truth(mpmath.mpf(float(v))))] for v in x.ravel()])
    function = getattr(g, name)
    np.testing.assert_allclose(function(x), exact, rtol=1e-12, atol=1e-15)
    band = function(Band.exact(x))
    assert ((band.lo <= exact) & (exact <= band.hi)).all() and not band.vacuous.any()
    assert ((band.hi - band.lo) <= width * np.maximum(np.abs(exact), 1.0)).all()


def test_where_hyperbolic_functions_are_not_defined_anything_goes() -> None:
    assert g.acosh(Band.exact([0.5])).vacuous and not g.acosh(Band.exact([1.5])).vacuous
    assert g.atanh(Band.exact([1.0])).vacuous and not g.atanh(Band.exact([0.5])).vacuous


@pytest.mark.parametrize("unsigned", [False, True])
def test_functions_of_bits_are_those_of_the_digits(unsigned: bool) -> None:
    for number in NUMBERS:
        whole = Integer([number], unsigned=unsigned).derive(np.array([number]))
        bits = number % 2**32
        digits = f"{bits:032b}"
        seen = bits ^ 0xFFFFFFFF if number < 0 and not unsigned else bits
        values = {
            "bitCount": digits.count("1"),
            "findLSB": 31 - digits.rindex("1") if bits else -1,
            "findMSB": seen.bit_length() - 1,
        }
        for name, expected in values.items():
            found = getattr(g, name)(whole)
            assert found.lo.tolist() == [expected] and not found.unsigned, (name, number)
        assert g.bitfieldReverse(whole).lo[0] % 2**32 == int(digits[::-1], 2)
        for offset, count in ((0, 0), (0, 32), (5, 9), (31, 1)):
            field = bits >> offset & (2**count - 1)
            if not unsigned and count and field >> (count - 1):
                field -= 2**count
            assert g.bitfieldExtract(whole, offset, count).lo.tolist() == [field]
            mask = (2**count - 1) << offset
            merged = (bits & ~mask) | (0xABCD1234 << offset & mask)
            inserted = g.bitfieldInsert(whole, 0xABCD1234, offset, count)
            assert inserted.lo[0] % 2**32 == merged
    assert g.bitfieldExtract(Integer([1]), 30, 3).anything.all()


def test_long_sums_and_products_are_those_of_large_integers() -> None:
    for a in NUMBERS:
        for b in NUMBERS:
            x, y = a % 2**32, b % 2**32
            total, carry = g.uaddCarry(x, y)
            assert carry.lo[0] * 2**32 + total.lo[0] == x + y
            rest, borrow = g.usubBorrow(x, y)
            assert rest.lo[0] - borrow.lo[0] * 2**32 == x - y
            upper, lower = g.umulExtended(x, y)
            assert int(upper.lo[0]) * 2**32 + int(lower.lo[0]) == x * y
            upper, lower = g.imulExtended(a, b)
            assert int(upper.lo[0]) * 2**32 + int(lower.lo[0]) % 2**32 == a * b


def test_parts_are_those_of_numpy_and_exact() -> None:
    band = Band.exact(X[:, None])
    fraction, whole = g.modf(band)
    expected = np.modf(X)
    for found, exact in zip((fraction, whole), expected, strict=True):
        assert np.array_equal(found.lo.ravel(), exact) and np.array_equal(found.hi, found.lo)
    significand, exponent = g.frexp(band)
    mantissa, power = np.frexp(X)
    assert np.array_equal(significand.lo.ravel(), mantissa)
    assert np.array_equal(exponent.lo.ravel(), power) and exponent.known
    assert np.array_equal(g.ldexp(significand, exponent).lo.ravel(), X)
    assert g.ldexp(Band.exact([1.0]), 200).vacuous


def test_bits_of_floats_are_those_of_struct() -> None:
    for x in (1.0, -2.5, 3e38, -1e-30):
        value = float(np.float32(x))
        (signed,) = struct.unpack("<i", struct.pack("<f", value))
        for given in (value, Band.exact([value])):
            assert g.floatBitsToInt(given).lo.tolist() == [signed]
            assert g.floatBitsToUint(given).hi.tolist() == [signed % 2**32]
        back = g.intBitsToFloat(Integer([signed], rules=RULES))
        assert back.lo.tolist() == back.hi.tolist() == [value]
        assert g.uintBitsToFloat(signed % 2**32).tolist() == [value]
    assert g.intBitsToFloat(Integer([0x7FC00000], rules=RULES)).vacuous
    zero = g.floatBitsToInt(Band.exact([0.0]))
    assert (zero.lo[0], zero.hi[0]) == (-(2**31), 0), "a zero may have either sign"


@pytest.mark.parametrize("name", ["modf", "frexp", "floatBitsToInt", "floatBitsToUint"])
def test_an_interval_holds_what_its_points_give(name: str) -> None:
    rng = np.random.default_rng(4)
    lo = rng.uniform(-3.0, 3.0, 200).astype(np.float32).astype(np.float64)
    hi = (lo + rng.choice([0.0, 0.01, 1.0, 4.0], 200)).astype(np.float32).astype(np.float64)
    results = [getattr(g, name)(Band.between(lo, hi))]
    for share in (0.0, 0.25, 0.6, 1.0):
        point = getattr(g, name)(Band.exact(lo + (hi - lo) * share))
        pairs = zip(results[0], point, strict=True) if name in ("modf", "frexp") else [
            (results[0], point)
        ]  # fmt: skip
        for wide, narrow in pairs:
            assert (wide.lo <= narrow.lo).all() and (narrow.hi <= wide.hi).all()


def test_packed_codes_are_those_of_struct() -> None:
    def as_uint(text: str, *codes: float) -> int:
        return int(struct.unpack("<I", struct.pack(text, *codes))[0])

    v = [0.25, -0.75, 1.0, -1.0]
    cases = {
        "packUnorm2x16": as_uint("<2H", round(0.25 * 65535), 0),
        "packSnorm2x16": as_uint("<2h", round(0.25 * 32767), round(-0.75 * 32767)),
        "packHalf2x16": as_uint("<2e", 0.25, -0.75),
        "packUnorm4x8": as_uint("<4B", round(0.25 * 255), 0, 255, 0),
        "packSnorm4x8": as_uint("<4b", round(0.25 * 127), round(-0.75 * 127), 127, -127),
    }
    for name, expected in cases.items():
        given = np.array(v[: 4 if "4x8" in name else 2])
        for value in (given, Band.exact(given)):
            found = getattr(g, name)(value)
            assert found.lo.tolist() == found.hi.tolist() == [expected], name
        back = getattr(g, f"un{name[0].lower()}{name[1:]}")(
            Integer([expected], unsigned=True, rules=RULES)
        )
        largest = 127.0 if "4x8" in name else 32767.0
        clamped = np.clip(given, 0.0 if "Unorm" in name else -1.0, 1.0)
        assert (np.abs(back.lo - clamped) <= 0.51 / largest).all(), name
        assert (back.hi - back.lo <= 1e-6).all()
    assert g.packHalf2x16(Band.exact([1e6, 0.0])).anything.all()


def test_derivatives_are_differences_over_quads() -> None:
    y, x = (axis.ravel() + 0.5 for axis in np.mgrid[0:6, 0:8])
    places = np.stack([x, y], axis=-1)
    values = (x * x + 3.0 * y)[:, None]
    own = (2.0 * (np.floor(x / 2.0) * 2.0 + 0.5) + 1.0)[:, None]
    assert np.array_equal(g.dFdx(values, places), own)
    assert np.array_equal(g.dFdy(values, places), np.full_like(values, 3.0))
    band = g.fwidth(Band.exact(values), places)
    assert band.contains(own + 3.0).all() and not band.vacuous.any()
    assert (band.hi - band.lo <= 32 * 2.0**-23 * values.max()).all()
    assert not g.dFdx(Band.exact(values), places).contains(own + 1.0).any()


def test_either_row_of_a_quad_is_allowed_and_fine_ones_are_not() -> None:
    places = np.array([[0.5, 0.5], [1.5, 0.5], [0.5, 1.5], [1.5, 1.5]])
    band = Band.exact([[0.0], [1.0], [0.0], [5.0]])
    either, own = g.dFdx(band, places), g.dFdxFine(band, places)
    ones, fives = np.full((4, 1), 1.0), np.full((4, 1), 5.0)
    assert either.contains(ones).all() and either.contains(fives).all()
    assert own.contains(ones).ravel().tolist() == [True, True, False, False]
    assert own.contains(fives).ravel().tolist() == [False, False, True, True]
    assert not either.contains(ones - 1e-4).any() and not either.contains(fives + 1e-4).any()


def test_beside_what_is_not_drawn_a_derivative_is_unknown() -> None:
    places = np.array([[0.5, 0.5], [1.5, 0.5], [0.5, 1.5]])
    band = g.dFdx(Band.exact([[0.0], [1.0], [0.0]]), places)
    assert band.vacuous.all()
    fine = g.dFdxFine(Band.exact([[0.0], [1.0], [0.0]]), places)
    assert fine.vacuous.ravel().tolist() == [False, False, True]
