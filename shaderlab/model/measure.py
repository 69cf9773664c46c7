"""Measures: statistics of what was drawn, held against bounds; one figure, a table, or a curve.

A measure is for what no single pixel shows: the share of pixels in the wrong shadow, a picture's
distance from another one, the energy that a model of reflection loses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from shaderlab.errors import CaseError
from shaderlab.model.scene import UniformValue

Statistic = Callable[..., Any]


@dataclass(frozen=True, kw_only=True)
class Bound:
    """Where a figure must lie: low ≤ figure ≤ high. `digits` is for a printed figure, which is in
    the middle; None for other bounds."""

    low: float = -math.inf
    high: float = math.inf
    digits: int | None = None


@dataclass(frozen=True, kw_only=True)
class Reading:
    """One row of a measure. `x` is its place along the curve, None where its label is a word."""

    label: str
    x: float | None = None
    bound: Bound | None = None
    reads: Mapping[str, str] = field(default_factory=dict)
    given: Mapping[str, UniformValue] = field(default_factory=dict)
    series: str = ""
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class Measure:
    """A statistic computed from the frame, each of its readings within its bound."""

    name: str
    statistic: Statistic
    readings: tuple[Reading, ...]
    pass_name: str | None = None
    draw: int = -1
    x_label: str = ""
    y_label: str = ""
    log_x: bool = False
    log_y: bool = False


def reading(
    label: str | float,
    *,
    reads: Mapping[str, str] | None = None,
    given: Mapping[str, UniformValue] | None = None,
    equals: float | None = None,
    digits: int | None = None,
    at_most: float | None = None,
    at_least: float | None = None,
    between: tuple[float, float] | None = None,
    series: str = "",
    note: str = "",
) -> Reading:
    """One row of a `measure`: what it reads and is given, and where the figure must lie.

    Args:
        label: a word, or a number: then the row is a point of a curve at this x.
        reads: outputs by parameter: {"lit": "near.FragColor"}.
        given: constants by parameter.
        equals, digits: the figure rounds to `equals` at `digits` decimals.
        at_most, at_least, between: other bounds; without any the row is only shown.
        series: the curve that the point belongs to, where there are several.
        note: a remark in the table.

    Raises:
        CaseError: bounds that say two things, or hold no number.
    """
    numeric = isinstance(label, int | float)
    return Reading(
        label=f"{label:g}" if numeric else str(label),
        x=float(label) if numeric else None,
        bound=_bound(str(label), equals, digits, at_most, at_least, between),
        reads=reads or {},
        given=given or {},
        series=series,
        note=note,
    )


def measure(
    label: str,
    statistic: Statistic,
    *,
    readings: Sequence[Reading] = (),
    reads: Mapping[str, str] | None = None,
    given: Mapping[str, UniformValue] | None = None,
    equals: float | None = None,
    digits: int | None = None,
    at_most: float | None = None,
    at_least: float | None = None,
    between: tuple[float, float] | None = None,
    pass_name: str | None = None,
    draw: int = -1,
    x_label: str = "",
    y_label: str = "",
    log_x: bool = False,
    log_y: bool = False,
    note: str = "",
) -> Measure:
    """A figure that `statistic` computes from the frame lies within its bound.

    The parameters of `statistic` are found by name: outputs of any pass as float64 arrays
    (height, width, components), `FragColor` of the last pass or `shadow_depth` for
    "shadow.depth"; uniforms and textures of a draw; and what `reads` and `given` say.

    Args:
        label: how tables and outcomes call it.
        statistic: a Python function that returns one number; NumPy may be used.
        readings: rows, from `reading`; without them there is one, with `label` for its name.
        reads: outputs by parameter, in every row that does not say otherwise.
        given: constants by parameter, likewise.
        equals, digits, at_most, at_least, between: the bound of the rows that have none.
        pass_name, draw: whose uniforms and textures are meant; the last draw of the last pass.
        x_label, y_label: what the axes of the curve say, where labels of rows are numbers.
        log_x, log_y: logarithmic axes.
        note: a remark in the table, where there is one row.

    Raises:
        CaseError: there is no bound at all, or two rows are alike.
    """
    if not callable(statistic):
        raise CaseError(f"measure {label!r}: needs a function, not {type(statistic).__name__}")
    common = _bound(label, equals, digits, at_most, at_least, between)
    rows = tuple(
        Reading(
            label=row.label,
            x=row.x,
            bound=row.bound or common,
            reads={**(reads or {}), **row.reads},
            given={**(given or {}), **row.given},
            series=row.series,
            note=row.note,
        )
        for row in readings or (reading(label, note=note),)
    )
    _check(label, rows)
    return Measure(
        name=label,
        statistic=statistic,
        readings=rows,
        pass_name=pass_name,
        draw=draw,
        x_label=x_label,
        y_label=y_label or label,
        log_x=log_x,
        log_y=log_y,
    )


def _check(label: str, rows: Sequence[Reading]) -> None:
    if all(row.bound is None for row in rows):
        raise CaseError(
            f"measure {label!r} has no bound, so it could not fail",
            remedy="give equals with digits, at_most, at_least or between",
        )
    names = [(row.series, row.label) for row in rows]
    for series, name in names:
        if names.count((series, name)) > 1:
            where = f" of series {series!r}" if series else ""
            raise CaseError(f"measure {label!r}: two readings{where} are called {name!r}")
    for row in rows:
        for parameter in row.reads.keys() & row.given.keys():
            raise CaseError(f"measure {label!r}: {parameter!r} is both read and given")


def _bound(
    label: str,
    equals: float | None,
    digits: int | None,
    at_most: float | None,
    at_least: float | None,
    between: tuple[float, float] | None,
) -> Bound | None:
    kinds = [equals is not None, at_most is not None or at_least is not None, between is not None]
    if sum(kinds) > 1:
        raise CaseError(f"measure {label!r}: give equals, or between, or at_most and at_least")
    if (equals is None) != (digits is None):
        raise CaseError(f"measure {label!r}: equals and digits go together")
    if equals is not None and digits is not None:
        half = 0.5 * 10.0**-digits * (1.0 + 1e-6)
        return Bound(low=equals - half, high=equals + half, digits=digits)
    if not any(kinds):
        return None
    low, high = between or (
        -math.inf if at_least is None else at_least,
        math.inf if at_most is None else at_most,
    )
    if not low <= high or (math.isinf(low) and math.isinf(high)):
        raise CaseError(f"measure {label!r}: {low} … {high} bounds no figure")
    return Bound(low=float(low), high=float(high))
