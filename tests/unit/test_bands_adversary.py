"""A device that errs as much as the rules allow, in every operation, never leaves the band.

It evaluates random expression trees in float32 (benchmarks/adversary_device.py), with as-written
rules and with the default ones. Then the compiler's part: the tree is rearranged first, and the
device rounds to nearest or towards zero, as real ones do. `benchmarks/adversary.py` is the same
over as many samples as one likes.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from benchmarks.adversary_device import (
    BINARY,
    UNARY,
    Device,
    Tree,
    on_bands,
    on_device,
    rearranged,
)
from shaderlab.bands import Band, Rules

SAMPLES = 24


def trees(names: tuple[str, ...], unary: tuple[str, ...]) -> st.SearchStrategy[Tree]:
    leaf = st.one_of(
        st.integers(0, 2).map(lambda i: ("input", i)),
        st.sampled_from([0.5, 2.0, 0.25, 1.0, 3.0, 0.75]).map(lambda c: ("constant", c)),
    )
    return st.recursive(
        leaf,
        lambda inner: st.one_of(
            st.tuples(st.sampled_from(names), inner, inner),
            *([st.tuples(st.sampled_from(unary), inner)] if unary else []),
            *([st.tuples(st.sampled_from(("dot", "mix")), inner, inner)] if unary else []),
        ),
        max_leaves=8,
    )


def input_values(seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    scales = np.exp2(rng.integers(-3, 4, (2, SAMPLES, 1)))
    values = [rng.uniform(-1.0, 1.0, (SAMPLES, 1)) * scale for scale in scales]
    values.append(rng.uniform(-2.0, 2.0, (SAMPLES, 3)))
    for value in values:
        value[:4] = [[0.0], [1.0], [-1.0], [2.0**-130]]
    return [value.astype(np.float32).astype(np.float64) for value in values]


def assert_inside(tree: Tree, run: Tree, seed: int, mode: str, rules: Rules) -> None:
    values = input_values(seed)
    band = on_bands(tree, [Band.exact(value, rules) for value in values])
    with np.errstate(all="ignore"):
        measured = on_device(run, values, Device(seed, mode))
    outside = ~band.contains(measured)
    assert not outside.any(), (tree, run, band.lo[outside], measured[outside], band.hi[outside])


@settings(max_examples=250, derandomize=True)
@given(tree=trees(BINARY, UNARY), seed=st.integers(0, 2**32 - 1))
def test_no_error_that_the_rules_allow_leaves_the_band(tree: Tree, seed: int) -> None:
    assert_inside(tree, tree, seed, "either", Rules(rearrange=False))
    assert_inside(tree, tree, seed, "either", Rules())


@settings(max_examples=400, derandomize=True)
@given(
    tree=trees(("add", "sub", "mul", "add"), ()),
    seed=st.integers(0, 2**32 - 1),
    mode=st.sampled_from(["nearest", "zero"]),
)
def test_no_rearrangement_leaves_the_default_band(tree: Tree, seed: int, mode: str) -> None:
    rng = np.random.default_rng(seed)
    run = rearranged(rearranged(tree, rng), rng)
    assert_inside(tree, run, seed, mode, Rules())


@pytest.mark.parametrize("factor", [1.01, 0.99])
def test_the_adversary_does_leave_the_band_of_another_formula(factor: float) -> None:
    """The tests above can fail: a constant one per cent off is outside nearly everywhere."""
    tree = ("add", ("mul", ("input", 0), ("constant", 3.0)), ("constant", 0.75))
    wrong = ("add", ("mul", ("input", 0), ("constant", 3.0 * factor)), ("constant", 0.75))
    values = input_values(5)
    band = on_bands(tree, [Band.exact(value) for value in values])
    measured = on_device(wrong, values, Device(1, "nearest"))
    assert (~band.contains(measured)).mean() > 0.9
