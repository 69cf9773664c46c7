"""Formulas that a band does not take for each other, and `either`, which does: the rewrites that
docs/guide/bands.md names."""

from __future__ import annotations

import numpy as np

from shaderlab import glslmath as g
from shaderlab.bands import Band

RNG = np.random.default_rng(8)
F = np.float32
A, B = (RNG.uniform(0.01, 1.0, (4096, 1)).astype(F) for _ in range(2))


def test_a_mix_by_one_is_no_selection_until_either_says_so() -> None:
    """x + (y - x)·1 rounds twice on its way to y, at the size of x."""
    mixed = A * F(100.0) + (B - A * F(100.0)) * F(1.0)
    a, b = Band.exact(A) * 100.0, Band.exact(B)
    one = g.step(0.005, Band.exact(A))
    chosen, blended = g.where(one == 1.0, b, a), g.mix(a, b, one)
    assert not chosen.contains(mixed).all()
    assert g.either(chosen, blended).contains(mixed).all()
    assert not g.either(chosen, blended).contains(mixed + F(0.001)).any()


def test_a_power_is_no_product_until_either_says_so() -> None:
    x = Band.exact(A)
    product, power = x * x * x * x * x, g.pow(x, 5.0)
    computed = np.exp2(F(5.0) * np.log2(A))
    off = (computed * (1.0 + 10 * 2.0**-23)).astype(F)
    assert power.contains(A * A * A * A * A).all(), "the wider band holds the narrower formula"
    assert not product.contains(off).all() and g.either(product, power).contains(off).all()
    assert not g.either(product, power).contains(computed * F(1.001)).any()
