"""Judging what needs no band: exact arrays, counts, figures of a reference alone, errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from shaderlab.checks.figures import figure_row, rounds_to
from shaderlab.checks.inputs import source_of
from shaderlab.checks.judgement import Judgement, plain, shown
from shaderlab.errors import CaseError, FormulaError
from shaderlab.frame import Array, Image, Reply
from shaderlab.model import GL_ERRORS, Computed, Coverage, Exact, GlCall, GlError
from shaderlab.records import Outcome, Row, Worst


def judge_exact(expectation: Exact, image: Image, expected: Any) -> Judgement:
    """Compare every pixel bit for bit.

    Raises:
        CaseError: the expected array can't be laid over the image.
    """
    wanted = laid_over(expected, image.values, expectation.name)
    same = (_bits(image.values) == _bits(wanted)).all(axis=2)
    outside = int((~same).sum())
    worst = None
    if outside:
        y, x = (int(k) for k in np.argwhere(~same)[0])
        measured, reference = plain(image.values[y, x]), plain(wanted[y, x])
        differs = [m != r for m, r in zip(measured, reference, strict=True)]
        worst = Worst(
            pixel=(x, y),
            component=differs.index(True) if any(differs) else 0,
            measured=measured,
            reference=reference,
            low=reference,
            high=reference,
            ulp=float("nan"),
            widths=float("inf"),
        )
    outcome = Outcome(
        name=expectation.name,
        kind="exact",
        status="fail" if outside else "pass",
        message=f"{outside} of {same.size} pixels differ" if outside else "",
        judged=same.size,
        outside=outside,
        worst=worst,
    )
    if not outside and not expectation.pictured:
        return Judgement(outcome=outcome)
    distance = np.where(same, 0.0, np.inf)
    pictures = {"measured": image.values, "reference": wanted, "distance": distance}
    return Judgement(outcome=outcome, pictures=pictures)


def laid_over(expected: Any, values: Array, name: str) -> Array:
    """An expected colour or table, as an array of the image's own shape and type.

    A table of cells is laid over the image as `Cell` lays draws: cell k of n begins at pixel
    ⌊size·k/n⌋.
    """
    height, width, components = values.shape
    table = np.asarray(expected)
    table = table[..., None] if table.ndim in (0, 2) else table
    table = table[None, None] if table.ndim == 1 else table
    if table.ndim != 3 or table.shape[2] not in (1, components) or table.size == 0:
        raise CaseError(
            f"exact {name!r}: an image of shape {values.shape} can't be compared with an array "
            f"of shape {np.shape(expected)}"
        )
    with np.errstate(over="ignore", invalid="ignore"):
        typed = table.astype(values.dtype)
    if values.dtype.kind in "iu" and (typed != table).any():
        raise CaseError(f"exact {name!r}: the attachment holds {values.dtype}, not {expected!r}")
    rows, columns = _cell_of(height, table.shape[0]), _cell_of(width, table.shape[1])
    return np.broadcast_to(typed[rows][:, columns], values.shape)


def judge_coverage(expectation: Coverage, covered: Array) -> Judgement:
    """Compare the number of pixels that show the draw with the expected one."""
    count = int(np.count_nonzero(covered))
    ok = count == expectation.pixels
    row = Row(label="pixels", expected=str(expectation.pixels), measured=str(count), ok=ok)
    message = "" if ok else f"{count} pixels are covered, not {expectation.pixels}"
    return table(expectation.name, "coverage", [row], message, judged=covered.size)


def judge_computed(expectation: Computed) -> Judgement:
    """Compare a figure with what the reference gives in float64."""
    try:
        got = expectation.compute()
    except Exception as error:
        place = source_of(expectation.compute)
        raise FormulaError(
            f"{expectation.label}: {type(error).__name__}: {error}",
            file=place.file,
            line=place.line,
        ) from error
    ok = rounds_to(got, expectation.equals, expectation.digits)
    row = figure_row(
        expectation.label,
        expectation.equals,
        expectation.digits,
        got,
        None,
        ok,
        expectation.note or "float64, no shader",
    )
    message = "" if ok else f"the reference gives {shown(got, expectation.digits + 3)}"
    judgement = table(expectation.name, "computed", [row], message, judged=1)
    return replace(judgement, outcome=replace(judgement.outcome, rows_per_variant=False))


def judge_gl_error(expectation: GlError, errors: Sequence[int]) -> Judgement:
    """Compare the GL errors that a draw raised with the one expected."""
    want = GL_ERRORS[expectation.error]
    expected = [] if want == 0 else [want]
    ok = list(errors) == expected
    row = Row(
        label="glGetError",
        expected=error_name(want),
        measured=", ".join(error_name(e) for e in errors) or error_name(0),
        ok=ok,
    )
    message = "" if ok else f"the draw raises {row.measured}"
    return table(expectation.name, "GL error", [row], message, judged=1)


def judge_gl_call(expectation: GlCall, reply: Reply) -> Judgement:
    """Compare the errors that a call of the API raised, and what it returned, with the expected."""
    want = GL_ERRORS[expectation.raises]
    errors = ", ".join(error_name(code) for code in reply.errors) or error_name(0)
    first = reply.at == str(expectation.call)
    ok = first and list(reply.errors) == ([want] if want else [])
    rows = [
        Row(
            label=reply.at,
            expected=error_name(want if first else 0),
            measured=errors,
            ok=ok,
            note="" if first else f"comes before {expectation.call}",
        )
    ]
    if expectation.returns is not None and first and not want:
        expected, returned = (
            ", ".join(_named(v, reply.names) for v in values) or "nothing"
            for values in (reply.wanted, reply.returned)
        )
        same = reply.wanted == reply.returned
        rows.append(Row(label="its answer", expected=expected, measured=returned, ok=same))
    wrong = next((row for row in rows if not row.ok), None)
    verb = "raises" if wrong is rows[0] else "answers"
    message = f"{reply.at} {verb} {wrong.measured}" if wrong else ""
    return table(expectation.name, "GL call", rows, message, judged=len(rows))


def _named(value: Any, names: Mapping[int, str]) -> str:
    """A returned value as people read it: a constant by its name, with its number."""
    if isinstance(value, int) and names.get(value):
        return f"{names[value]} (0x{value:04X})"
    return str(value)


def error_name(code: int) -> str:
    """A GL error's name with its number.

    >>> error_name(0x0502)
    'GL_INVALID_OPERATION (0x0502)'
    """
    for name, number in GL_ERRORS.items():
        if number == code:
            return f"GL_{name.upper()} (0x{code:04X})"
    return f"GL error 0x{code:04X}"


def table(name: str, kind: str, rows: Sequence[Row], message: str, judged: int) -> Judgement:
    """A judgement of rows: it fails where there is a message."""
    return Judgement(
        outcome=Outcome(
            name=name,
            kind=kind,
            status="fail" if message else "pass",
            message=message,
            judged=judged,
            outside=sum(not row.ok for row in rows),
            rows=tuple(rows),
        )
    )


def _cell_of(pixels: int, cells: int) -> Any:
    """For each pixel along an axis, the cell it lies in."""
    starts = np.array([pixels * k // cells for k in range(cells)])
    return np.searchsorted(starts, np.arange(pixels), side="right") - 1


def _bits(values: Array) -> Array:
    if values.dtype.kind != "f":
        return values
    return np.ascontiguousarray(values).view({2: np.uint16, 4: np.uint32}[values.dtype.itemsize])
