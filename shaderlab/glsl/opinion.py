"""A second opinion: what a driver says of a program, beside what glslang says of it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from shaderlab.glsl.sources import Source
from shaderlab.records import Diagnostic, Severity, Verdict

__all__ = ["DRIVER", "Diagnostic", "Opinion", "Verdict", "compared", "of_driver"]

DRIVER = "driver"

Opinion = Callable[[Sequence[Source]], Verdict]
"""Asks a driver about a program's stages; its verdict's target is DRIVER."""

_FORMS = (
    # Mesa: "0:3(12): error: `x' undeclared"
    re.compile(
        r"^\d+:(?P<line>\d+)\(\d+\): (?:preprocessor )?"
        r"(?P<severity>error|warning): (?P<message>.*)$"
    ),
    # NVIDIA: "0(3) : error C1008: undefined variable"
    re.compile(r"^\d+\((?P<line>\d+)\) ?: (?P<severity>error|warning) (?P<message>.*)$"),
    # AMD, Intel, Apple: "ERROR: 0:3: 'x' : undeclared identifier"
    re.compile(r"^(?P<severity>ERROR|WARNING): \d+:(?P<line>\d+): (?P<message>.*)$"),
)
_UNPLACED = re.compile(r"^(?P<severity>error|warning)\s*:\s*(?P<message>.*)$", re.IGNORECASE)


def of_driver(log: str, source: Source, *, ok: bool) -> tuple[Diagnostic, ...]:
    """A driver's log as diagnostics at the author's lines; an error is in it unless `ok`."""
    found: dict[Diagnostic, None] = {}
    for row in filter(None, map(str.strip, log.split("\n"))):
        match = next(filter(None, (form.match(row) for form in _FORMS)), None)
        bare = None if match else _UNPLACED.match(row)
        severity: Severity = "info"
        file, line, message = source.path, None, row
        if match:
            file, line = source.place(int(match["line"]))
        if match or bare:
            told = match or bare
            assert told is not None
            severity = "error" if told["severity"].lower() == "error" else "warning"
            message = told["message"]
        found[Diagnostic(file=file, line=line, severity=severity, message=message)] = None
    if ok:
        return tuple(found)
    if not any(d.severity == "error" for d in found):
        message = "the driver refuses it" + ("" if found else " and does not say why")
        last = Diagnostic(file=source.path, line=None, severity="error", message=message)
        found = dict.fromkeys([last, *found])
    return tuple(found)


def compared(verdicts: Iterable[Verdict]) -> tuple[Verdict, ...]:
    """The verdicts, the driver's with status "disagrees" where it is not that of plain GLSL.

    The disagreement itself is its first diagnostic: a warning, since the side that refuses the
    program has said its errors already.
    """
    given = tuple(verdicts)
    plain = next((v for v in given if v.target == "glsl" and not v.status), None)
    return tuple(
        _disagreeing(v, plain) if plain and v.target == DRIVER and not v.status else v
        for v in given
    )


def _disagreeing(driver: Verdict, plain: Verdict) -> Verdict:
    if driver.ok == plain.ok:
        return driver
    refusing = plain if driver.ok else driver
    first = next(d for d in refusing.diagnostics if d.severity == "error")
    accepts, refuses = ("the driver", "glslang") if driver.ok else ("glslang", "the driver")
    note = Diagnostic(
        file=first.file,
        line=first.line,
        severity="warning",
        message=f"disagreement: {accepts} accepts what {refuses} refuses: {first.message}",
        token=first.token,
    )
    return replace(driver, status="disagrees", diagnostics=(note, *driver.diagnostics))
