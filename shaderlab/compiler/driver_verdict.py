"""A driver's verdict on a program, next to glslang's."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from shaderlab.compiler.sources import Source
from shaderlab.model.records import Diagnostic, Severity, Verdict

DRIVER = "driver"
"""The target that a driver's verdict is for."""

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
    # A message without a line; the empty group keeps the names the same.
    re.compile(r"^(?P<severity>error|warning)\s*:\s*(?P<line>)(?P<message>.*)$", re.IGNORECASE),
)


def parse_driver_log(log: str, source: Source, *, ok: bool) -> tuple[Diagnostic, ...]:
    """A driver's log as diagnostics at the author's lines; includes an error unless `ok`."""
    found: dict[Diagnostic, None] = {}
    for row in filter(None, map(str.strip, log.split("\n"))):
        match = next(filter(None, (form.match(row) for form in _FORMS)), None)
        severity: Severity = "info"
        at, message = None, row
        if match:
            severity = "error" if match["severity"].lower() == "error" else "warning"
            at, message = int(match["line"] or 0) or None, match["message"]
        found[source.diagnostic(message, at, severity=severity)] = None
    if not ok and not any(d.severity == "error" for d in found):
        message = "the driver refuses it" + ("" if found else " and does not say why")
        return (source.diagnostic(message), *found)
    return tuple(found)


def mark_disagreement(verdicts: Iterable[Verdict]) -> tuple[Verdict, ...]:
    """The verdicts, with the driver's status "disagrees" if plain GLSL's verdict differs.

    The first diagnostic says so. It is a warning, since the side that refuses the program has
    reported its errors already.
    """
    by_target = {verdict.target: verdict for verdict in verdicts}
    plain, driver = by_target.get("glsl"), by_target.get(DRIVER)
    if plain and driver and not (plain.status or driver.status) and plain.ok != driver.ok:
        refusing = plain if driver.ok else driver
        first = next(d for d in refusing.diagnostics if d.severity == "error")
        accepts, refuses = ("the driver", "glslang") if driver.ok else ("glslang", "the driver")
        message = f"disagreement: {accepts} accepts what {refuses} refuses: {first.message}"
        note = replace(first, severity="warning", message=message)
        by_target[DRIVER] = replace(
            driver, status="disagrees", diagnostics=(note, *driver.diagnostics)
        )
    return tuple(by_target.values())
