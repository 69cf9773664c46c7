"""Comparisons and choice: GLSL's relational functions (GLSL 4.60, 8.7) and its ternary operator.

On bands a condition is a `TriBool`: true, false, or undecided, value by value.
"""

from __future__ import annotations

import numpy as np

from shaderlab.bands import Band, Integer, TriBool, exact, integer
from shaderlab.bands.bounds import as_vector
from shaderlab.bands.exact import as_tri_bool
from shaderlab.glslmath.dispatch import Condition, Value, apply, as_bands, as_integers, as_number

__all__ = [
    "all", "any", "either", "equal", "greaterThan", "greaterThanEqual", "isinf", "isnan",
    "lessThan", "lessThanEqual", "notEqual", "not_", "where",
]  # fmt: skip


def where(condition: Condition, a: Value, b: Value) -> Value:
    """GLSL's `condition ? a : b`, value by value; the condition broadcasts over components.

    A band's undecided condition gives the hull of both sides, and marks it undecided.

    >>> float(where(0.5 < 1.0, 2.0, 3.0))
    2.0
    """
    whole = as_integers(a, b)
    if isinstance(condition, Integer):
        condition = notEqual(condition, 0)
    if whole is not None:
        return integer.select(condition, *whole)
    lifted = as_bands(a, b)
    if lifted is None and isinstance(condition, TriBool) and condition.rules is not None:
        lifted = [Band.literal(a, condition.rules), Band.literal(b, condition.rules)]
    if lifted is None:
        if isinstance(condition, TriBool):
            condition = condition.all_true
        chosen: Value = np.where(condition, as_number(a), as_number(b))
        return as_vector(chosen, condition, a, b)[()]
    return exact.select(as_tri_bool(condition), *lifted)


def either(a: Value, b: Value) -> Value:
    """`a`, or `b`, another way to compute the same number: bands allow both.

    Not a function of GLSL, but for references of formulas that are usually written in two ways.

    >>> float(either(0.75, 1.0 - 0.25))
    0.75
    """
    return apply(lambda a, b: a, exact.union, a, b)


def isnan(x: Value) -> Condition:
    """Whether x is NaN; undecided for a band that may be."""
    lifted = as_bands(x)
    if lifted is None:
        return np.isnan(x)
    nan = lifted[0].nan
    return TriBool(np.zeros_like(nan), ~nan, lifted[0].rules)


def isinf(x: Value) -> Condition:
    """Whether x is infinite; undecided for a band that may be."""
    lifted = as_bands(x)
    if lifted is None:
        return np.isinf(x)
    a = lifted[0]
    always = (a.lo == a.hi) & np.isinf(a.lo) & ~a.nan
    never = np.isfinite(a.lo) & np.isfinite(a.hi)
    return TriBool(always, never, a.rules)


def lessThan(x: Value, y: Value) -> Condition:
    """x < y, component by component."""
    return as_number(x) < as_number(y)


def lessThanEqual(x: Value, y: Value) -> Condition:
    """x ≤ y, component by component."""
    return as_number(x) <= as_number(y)


def greaterThan(x: Value, y: Value) -> Condition:
    """x > y, component by component."""
    return as_number(x) > as_number(y)


def greaterThanEqual(x: Value, y: Value) -> Condition:
    """x ≥ y, component by component."""
    return as_number(x) >= as_number(y)


def equal(x: Value, y: Value) -> Condition:
    """x == y, component by component."""
    if isinstance(x, TriBool) or isinstance(y, TriBool):
        x, y = as_tri_bool(x), as_tri_bool(y)
        return (x & y) | (~x & ~y)
    return as_number(x) == as_number(y)


def notEqual(x: Value, y: Value) -> Condition:
    """x != y, component by component."""
    return not_(equal(x, y))


def any(x: Condition) -> Condition:
    """Whether a component holds; the last axis stays with size 1."""
    return x.any() if isinstance(x, TriBool) else np.any(np.atleast_1d(x), axis=-1, keepdims=True)


def all(x: Condition) -> Condition:
    """Whether all components hold; the last axis stays with size 1."""
    return x.all() if isinstance(x, TriBool) else np.all(np.atleast_1d(x), axis=-1, keepdims=True)


def not_(x: Condition) -> Condition:
    """Where x does not hold (GLSL's `not` and `!`)."""
    return ~x if isinstance(x, TriBool) else np.logical_not(x)
