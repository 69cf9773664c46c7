"""Coordinates as pairs of bounds, of numbers and bands alike."""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array

Span = tuple[Array, Array]
"""The least and the greatest value; for a number both are the same array."""


def span_of(value: Any) -> Span:
    """The bounds of a coordinate, (count, components) or (components,), as float64."""
    if isinstance(value, Band):
        low, high = value.settled()
        return (low, low) if value.lo is value.hi and low is value.lo else (low, high)
    if isinstance(value, Integer):
        low = value.lo.astype(np.float64)
        return (low, low) if value.known else (low, value.hi.astype(np.float64))
    number = np.atleast_1d(np.asarray(value, np.float64))
    return number, number


def component(span: Span, index: int) -> Span:
    """One component of a coordinate, without the last axis."""
    low, high = span
    one = low[..., index]
    return (one, one) if low is high else (one, high[..., index])


def components(span: Span) -> int:
    """How many components a coordinate has."""
    return int(span[0].shape[-1])


def widened(span: Span, amount: Any) -> Span:
    """The span extended by `amount` on both sides."""
    return span[0] - amount, span[1] + amount


def hull(parts: list[Span]) -> Span:
    """The least span that holds all of them."""
    if len(parts) == 1:
        return parts[0]
    return (
        np.minimum.reduce([low for low, _ in parts]),
        np.maximum.reduce([high for _, high in parts]),
    )


def require_narrow(span: Span, what: str) -> None:
    """Raise FormulaError if a span, in texels or levels, is wider than 1."""
    low, high = span
    if low is not high and not (high - low <= 1.0).all():
        raise FormulaError(
            f"{what}: a coordinate's band spans more than two texels",
            remedy="judge the coordinate by itself, and the sample of captured coordinates",
        )
