"""The rows of a measure: what each one reads and is given, and where its figure must lie."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from shaderlab.errors import CaseError
from shaderlab.model.checked import checked_arguments
from shaderlab.model.records import Row
from shaderlab.model.scene import UniformValue

from .bound import Bound


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

    def row(self, figure: float) -> Row:
        """The line of a table that shows a measured figure."""
        digits = None if self.bound is None else self.bound.digits
        more = 6 if digits is None else digits + 3
        return Row(
            label=f"{self.series}, {self.label}" if self.series else self.label,
            expected="–" if self.bound is None else str(self.bound),
            measured=f"{figure:.{more}g}" if digits is None else f"{figure:.{min(more, 9)}f}",
            ok=math.isfinite(figure) if self.bound is None else figure in self.bound,
            note=self.note,
        )


@checked_arguments
def reading(
    label: str | float,
    *,
    reads: Mapping[str, str] | None = None,
    given: Mapping[str, UniformValue] | None = None,
    series: str = "",
    note: str = "",
    equals: float | None = None,
    digits: int | None = None,
    at_most: float | None = None,
    at_least: float | None = None,
    between: tuple[float, float] | None = None,
) -> Reading:
    """One row of a `measure`: what it reads and is given, and where the figure must lie.

    Args:
        label: a word, or a number: then the row is a point of a curve at this x.
        reads: outputs by parameter: {"lit": "near.FragColor"}.
        given: constants by parameter.
        series: the curve that the point belongs to, where there are several.
        note: a remark in the table.
        equals, digits: the figure rounds to `equals` at that many decimals.
        at_most, at_least, between: the figure lies in these bounds. Without any bound the row is
            only shown.

    Raises:
        CaseError: bounds that say two things, or hold no number.
    """
    numeric = isinstance(label, int | float)
    return Reading(
        label=f"{label:g}" if numeric else str(label),
        x=float(label) if numeric else None,
        bound=Bound.of(
            str(label),
            equals=equals,
            digits=digits,
            at_most=at_most,
            at_least=at_least,
            between=between,
        ),
        reads=reads or {},
        given=given or {},
        series=series,
        note=note,
    )


def check_readings(label: str, rows: Sequence[Reading]) -> None:
    """Raise CaseError for rows of the measure `label` that could not fail, or can't be told
    apart."""
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
        if len({*row.reads.values()}) < len(row.reads):
            raise CaseError(
                f"measure {label!r}: two parameters read one output, which is then compared with "
                "itself"
            )
