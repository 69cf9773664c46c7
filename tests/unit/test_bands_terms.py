"""What rearranging may change: how many terms a sum has, and what a flushed product is worth."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.adversary import Tally, check_one
from shaderlab import glslmath as g
from shaderlab.bands import Band, Rules
from shaderlab.glslmath.dispatch import mark_undefined


def chopped(x: np.ndarray) -> np.ndarray:
    """Rounded towards zero to float32, which is a legal rounding."""
    near = x.astype(np.float32)
    return np.where(np.abs(near) > np.abs(x), np.nextafter(near, np.float32(0)), near).astype(float)


def test_how_many_terms_there_may_be() -> None:
    a, b, c = (Band.exact([[x, 2.0, 3.0]]) for x in (0.3, 0.7, 1.1))
    assert (a + b).count == 2
    assert (a + b - c).count == 3
    assert (a * b).count == 1
    assert (a * (b + c)).count == 2
    assert ((a + b) * (b - c)).count == 4
    assert g.dot(a, b).count == 3
    assert g.max(a + b, c).count == 1, "what a function returns is one value"
    assert (-(a + b)).count == 2
    assert g.where(a < b, a + b, a).count == 2
    assert (Band.exact([1.0], Rules(rearrange=False)) + 2.0).count == 1


def test_small_terms_may_be_added_to_the_largest_one_by_one() -> None:
    """((a + b) + c) + 3 as a + (b + (c + 3)), truncated each time: three roundings at size 3."""
    rng = np.random.default_rng(7)
    a, b, c = rng.uniform(0.0, 0.1, (3, 20000, 1)).astype(np.float32).astype(float)
    band = ((Band.exact(a) + Band.exact(b)) + Band.exact(c)) + 3.0
    measured = chopped(a + chopped(b + chopped(c + 3.0)))
    assert band.contains(measured).all()
    as_written = Rules(rearrange=False)
    bands = [Band.exact(x, as_written) for x in (a, b, c)]
    precise = ((bands[0] + bands[1]) + bands[2]) + 3.0
    assert (~precise.contains(measured)).mean() > 0.1, "`precise` forbids that order"


def test_a_flushed_product_may_be_multiplied_afterwards() -> None:
    """(y·s)·t as (y·t)·s: y·t is denormal, flushed, and s would have brought it back."""
    y, s, t = 2.0**-120, 2.0**12, 2.0**-8 * 1.5
    band = (Band.exact([[y]]) * Band.exact([[s]]) - 2.0**-130) * Band.exact([[t]])
    assert band.contains(np.array([[0.0]])).all()
    lost = float(np.float32(y * s * t))
    assert band.contains(np.array([[lost]])).all()
    far = Band.exact([[1.5]]) * Band.exact([[s]]) * Band.exact([[t]])
    assert not far.contains(np.array([[0.0]])).any(), "values of ordinary size stay sharp"


@pytest.mark.parametrize("seed", [54, 1001148, 1001236, 1001380, 1001388, 1001448, 1001592])
def test_what_once_left_its_band(seed: int) -> None:
    tally = Tally()
    check_one(seed, 4096, tally)
    assert tally.samples > 4 * 4096
    assert tally.outside == 0


def test_powers_have_one_band_in_any_order() -> None:
    """1 − c may be multiplied out, but not while a product has it as a factor several times."""
    c = np.linspace(0.01, 0.999, 200).astype(np.float32).astype(float)[:, None]
    x = 1.0 - Band.exact(c)
    squared = x * x
    orders = (
        x * x * x * x * x,
        squared * squared * x,
        (x * x) * (x * x) * x,
        x * (x * (x * squared)),
    )
    library = g.pow(x, Band.exact([5.0]))
    narrowest = np.min([order.hi - order.lo for order in orders], axis=0)
    for order in orders:
        assert (order.hi - order.lo <= 1.25 * narrowest).all()
        assert (order.lo >= library.lo).all()
        assert (order.hi <= library.hi).all()
        assert order.contains((1.0 - c) ** 5).all()


@pytest.mark.parametrize("factor", ["0.96", "0.5", "1 - f0"])
def test_another_factor_does_not_change_what_a_power_costs(factor: str) -> None:
    """k·x·x·x·x·x and x·x·x·x·x·k are one product, and none is wider than by `pow`."""
    c = np.linspace(0.01, 0.999, 200).astype(np.float32).astype(float)[:, None]
    x = 1.0 - Band.exact(c)
    k = 1.0 - Band.exact([[0.0625]]) if "f0" in factor else Band.literal([[float(factor)]])
    orders = (
        k * x * x * x * x * x,
        x * x * x * x * x * k,
        x * k * x * x * x * x,
        (x * x) * (x * x) * x * k,
        (k * x) * ((x * x) * (x * x)),
    )
    library = k * g.pow(x, Band.exact([5.0]))
    narrowest = np.min([order.hi - order.lo for order in orders], axis=0)
    away = chopped(1.0 - c)
    for order in orders:
        assert (order.hi - order.lo <= 1.25 * narrowest).all()
        assert (order.lo >= library.lo).all()
        assert (order.hi <= library.hi).all()
        for round_ in (chopped, lambda v: v.astype(np.float32).astype(float)):
            scaled = round_(k.lo * away)
            for _ in range(4):
                scaled = round_(scaled * away)
            assert order.contains(scaled).all(), "as written with the factor first"


def test_no_product_loses_a_factor() -> None:
    """Products of the same few values in random order, each several times."""
    rng = np.random.default_rng(7)
    exact = [rng.uniform(0.5, 2.0, (16, 1)).astype(np.float32).astype(float) for _ in range(3)]
    x, y, z = map(Band.exact, exact)
    values = [(x, exact[0]), (y, exact[1]), (3.0 - z, 3.0 - exact[2]), (Band.literal([[3.0]]), 3.0)]
    for _ in range(300):
        left = [values[n] for n in rng.integers(0, 4, rng.integers(3, 9))]
        while len(left) > 1:
            (a, real_a), (b, real_b) = (left.pop(rng.integers(len(left))) for _ in range(2))
            left.append((a * b, real_a * real_b))
        band, real = left[0]
        assert band.contains(np.asarray(real, np.float32)).all()


def test_a_power_covers_every_order_at_the_edge_of_what_is_exact() -> None:
    """x²·x³ of exact x² and x³ is rounded once, x⁴·x twice; flushed squares stay flushed."""
    rng = np.random.default_rng(3)
    x = np.ldexp(rng.integers(1, 256, (20000, 1)), rng.integers(-40, 8, (20000, 1)))
    band = Band.exact(x)
    for round_ in (chopped, lambda v: v.astype(np.float32).astype(float)):
        square = round_(x * x)
        one_by_one = round_(round_(round_(square * x) * x) * x)
        assert ((band * band) * (band * band) * band).contains(one_by_one).all()
        assert ((band * band) * ((band * band) * band)).contains(one_by_one).all()
        by_squares = round_(round_(square * square) * x)
        assert (band * band * band * band * band).contains(by_squares).all()


def test_only_the_product_itself_is_taken_apart() -> None:
    """What was negated, or is undefined in places, is no longer the product of its factors."""
    c = np.linspace(0.1, 0.9, 9).astype(np.float32).astype(float)[:, None]
    x, k = 1.0 - Band.exact(c), Band.literal([[0.96]])
    assert (-(k * x) * x).contains(-0.96 * (1.0 - c) ** 2).all()
    risen = mark_undefined(k * x, c > 0.5)
    assert (risen * x).may_be_nan.ravel().tolist() == (c > 0.5).ravel().tolist()
    twice = (k * x).copy_independent() * x
    assert (twice.hi - twice.lo >= (k * x * x).hi - (k * x * x).lo).all()
