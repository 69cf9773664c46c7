"""The stable JSON that other programs read; docs/guide/json.md describes each field.

It is strict: NaN and infinities are the strings "nan", "inf" and "-inf". Fields may be added in
later versions, none is renamed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from shaderlab.model.records import Run
from shaderlab.model.store import to_plain

VERSION = 1
"""Of this form: another one where a field goes or changes its meaning."""
_RECORD = (
    "id", "variant", "status", "message", "seconds", "timings", "driver", "size", "compile",
    "expectations", "images", "unread", "gl_calls", "modules", "not_asked",
)  # fmt: skip
_OUTCOME = (
    "name", "kind", "status", "message", "worst", "vacuous", "undecided", "informative",
    "judged", "outside",
)  # fmt: skip
_ROW = ("label", "expected", "measured", "ok", "note")


def render(run: Run) -> str:
    """The public view of a run, as indented JSON."""
    whole = to_plain(run)
    public = {
        "version": VERSION,
        "driver": whole["driver"],
        "seconds": whole["seconds"],
        "cases": [_record(record) for record in whole["records"]],
        "drivers": whole["drivers"],
        "disagreements": whole["disagreements"],
        "replaced": whole["replaced"],
        "missing": whole["missing"],
    }
    return json.dumps(public, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _record(record: Mapping[str, Any]) -> dict[str, Any]:
    outcomes = [_outcome(outcome) for outcome in record["expectations"]]
    return _only(record, _RECORD) | {"expectations": outcomes}


def _outcome(outcome: Mapping[str, Any]) -> dict[str, Any]:
    return _only(outcome, _OUTCOME) | {"values": [_only(row, _ROW) for row in outcome["rows"]]}


def _only(data: Mapping[str, Any], names: tuple[str, ...]) -> dict[str, Any]:
    return {name: data[name] for name in names}
