"""Printed figures beside computed and measured ones."""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.model.frame import Array
from shaderlab.model.records import Row, significant


def figure_row(
    label: str, equals: Any, digits: int, computed: Any, measured: Any, ok: bool, note: str
) -> Row:
    """One line of a table of figures: as printed, and as measured with a few digits more, or none
    of integers."""
    found = computed if measured is None else measured
    whole = isinstance(found, np.ndarray) and found.dtype.kind in "iu"
    text = shown(found, 0 if whole else min(digits + 3, 9))
    digits = 0 if whole else digits
    return Row(label=label, expected=shown(equals, digits), measured=text, ok=ok, note=note)


def rounds_to(computed: Any, equals: Any, digits: int) -> bool:
    """Whether every component, rounded to `digits` decimals, is the printed figure.

    A tie may be printed rounded either way.
    """
    difference = np.abs(np.asarray(computed, np.float64) - np.asarray(equals, np.float64))
    return bool(np.all(difference <= 0.5 * 10.0**-digits * (1.0 + 1e-6)))


def ulp_distance(measured: float, reference: float, unit: float | None = None) -> float:
    """How many float32 units in the last place of `reference` (or `unit`s) lie between the two.

    >>> ulp_distance(1.0 + 2.0**-23, 1.0)
    1.0
    """
    unit = unit or float(np.spacing(np.float32(abs(reference))))
    return abs(float(measured) - float(reference)) / unit if np.isfinite(reference) else np.nan


def plain(values: Array) -> tuple[float, ...]:
    """A vector as a tuple of Python numbers."""
    return tuple(float(v) for v in np.ravel(values))


def shown(values: object, digits: int | None = None) -> str:
    """A number or vector for people: `digits` decimals, or nine significant digits.

    >>> shown((0.5, 1.0)), shown(0.25, 4)
    ('(0.5, 1)', '0.2500')
    """
    numbers = [float(v) for v in np.ravel(np.asarray(values, np.float64))]
    texts = [f"{n:.{digits}f}" if digits is not None else significant(n) for n in numbers]
    return texts[0] if len(texts) == 1 else f"({', '.join(texts)})"
