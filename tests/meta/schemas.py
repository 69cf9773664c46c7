"""The JSON Schemas of `run --json` and `list --json`, made of the records that these write.

`python -m tests.meta.schemas` writes them; a test holds both equal to what it would write, and the
commands' outputs against them.
"""

from __future__ import annotations

import json
import types
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from shaderlab.cli import list_cases
from shaderlab.engine.jobs import CaseInfo
from shaderlab.model import records
from shaderlab.report.formats import json as run_json

FOLDER = "docs/schemas"
_NUMBER = {"type": ["number", "string"], "pattern": "^(nan|inf|-inf)$"}
_PLAIN: Mapping[Any, Mapping[str, Any]] = {
    str: {"type": "string"}, bool: {"type": "boolean"}, int: {"type": "integer"}, float: _NUMBER,
    type(None): {"type": "null"}, Any: {},
}  # fmt: skip
# What is written of these; of other dataclasses all fields.
_WRITTEN: Mapping[type, Iterable[str]] = {
    records.Record: run_json._RECORD,
    records.Outcome: run_json._OUTCOME,
    records.Row: run_json._ROW,
    CaseInfo: list_cases.FIELDS,
}


def schemas() -> dict[str, str]:
    """The schemas' texts, by their paths in the repository."""
    run = get_type_hints(records.Run)
    known = {
        "driver": run["driver"], "seconds": float, "cases": run["records"],
        "drivers": run["drivers"], "disagreements": run["disagreements"],
        "replaced": run["replaced"], "missing": int,
    }  # fmt: skip
    listed = {"cases": tuple[CaseInfo, ...]}
    return {
        f"{FOLDER}/run.schema.json": _schema("shaderlab run --json", run_json.VERSION, known),
        f"{FOLDER}/list.schema.json": _schema("shaderlab list --json", list_cases.VERSION, listed),
    }


def _schema(title: str, version: int, properties: Mapping[str, Any]) -> str:
    whole = {name: _of(kind) for name, kind in properties.items()}
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        **_object({"version": {"const": version}, **whole}),
    }
    return json.dumps(schema, indent=1) + "\n"


def _object(properties: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "object", "required": [*properties], "properties": dict(properties)}


def _of(kind: Any) -> Mapping[str, Any]:
    """The schema of a type's values, as `store.to_plain` writes them."""
    if kind in _PLAIN:
        return _PLAIN[kind]
    if is_dataclass(kind):
        hints = get_type_hints(kind)
        names = _WRITTEN.get(kind, [field.name for field in fields(kind)])  # type: ignore[arg-type]
        found = {name: _of(hints[name]) for name in names}
        if kind is records.Outcome:
            found["values"] = _of(hints["rows"])
        return _object(found)
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Literal:
        return {"enum": list(arguments)}
    if origin in (Union, types.UnionType):
        return {"anyOf": [_of(each) for each in arguments]}
    if origin is tuple and arguments[-1] is not Ellipsis:
        count = len(arguments)
        return {"type": "array", "items": _of(arguments[0]), "minItems": count, "maxItems": count}
    if origin is not None and issubclass(origin, Mapping):
        return {"type": "object", "additionalProperties": _of(arguments[1])}
    assert origin is not None, kind
    return {"type": "array", "items": _of(arguments[0])}


def main() -> None:
    """Write the schemas."""
    for path, text in schemas().items():
        file = Path(__file__).resolve().parents[2] / path
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
