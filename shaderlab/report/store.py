"""A run as JSON: kept whole in its folder, and the smaller public form of `run --json`."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import write_text
from shaderlab.records import Disagreement, DriverResult, Outcome, Record, Run, Worst

if TYPE_CHECKING:
    from cattrs import Converter

FILE_NAME = "run.json"
Kind = TypeVar("Kind")


def save(run: Run, folder: str | Path) -> Path:
    """Write the whole run to `folder`/run.json and return that path.

    The JSON is strict: NaN and infinities are the strings "nan", "inf" and "-inf".

    Raises:
        ShaderlabError: the file can't be written.
    """
    path = Path(folder) / FILE_NAME
    data = _converter().unstructure(run)
    write_text(path, json.dumps(data, allow_nan=False, separators=(",", ":")) + "\n")
    return path


def load(folder: str | Path) -> Run:
    """The run that `save` wrote to `folder`.

    Raises:
        UsageError: there is none.
        ShaderlabError: the file is damaged or was written by another version.
    """
    path = Path(folder) / FILE_NAME
    try:
        text = path.read_text(encoding="utf-8")
    except (FileNotFoundError, NotADirectoryError) as error:
        raise UsageError(
            "no run was saved here", file=path, remedy="shaderlab run writes one"
        ) from error
    except (OSError, UnicodeDecodeError) as error:
        raise _damaged(path, error) from error
    try:
        run: Run = _converter().structure(json.loads(text), Run)
    except Exception as error:  # cattrs raises groups of whatever its hooks raise
        raise _damaged(path, error) from error
    return run


def plain(value: Any) -> Any:
    """A record, or another dataclass of plain data, as what strict JSON can hold."""
    return _converter().unstructure(value)


def parse(data: Any, kind: type[Kind]) -> Kind:
    """What `plain` was given, from what it gave.

    Raises:
        ShaderlabError: it was written by another version.
    """
    try:
        return _converter().structure(data, kind)
    except Exception as error:  # cattrs raises groups of whatever its hooks raise
        raise _damaged(Path(kind.__name__), error) from error


def public_json(run: Run) -> dict[str, Any]:
    """The stable view of a run that `shaderlab run --json` prints (docs/json.md).

    Strict JSON as in `save`; fields may be added to it in later versions, none is renamed.
    """
    return {
        "driver": dict(run.driver),
        "seconds": _number(run.seconds),
        "cases": [_case(record) for record in run.records],
        "drivers": [_on_driver(result) for result in run.drivers],
        "disagreements": [_disagreement(found) for found in run.disagreements],
    }


def _on_driver(result: DriverResult) -> dict[str, Any]:
    return {
        "driver": result.driver,
        "renderer": result.renderer,
        "id": result.id,
        "variant": result.variant,
        "status": result.status,
        "ulp": _number(result.ulp),
        "widths": _number(result.widths),
    }


def _disagreement(found: Disagreement) -> dict[str, Any]:
    return {
        "id": found.id,
        "variant": found.variant,
        "output": found.output,
        "drivers": list(found.drivers),
        "pixels": found.pixels,
        "differing": found.differing,
        "ulp": _number(found.ulp),
    }


def _case(record: Record) -> dict[str, Any]:
    return {
        "id": record.id,
        "variant": record.variant,
        "status": record.status,
        "message": record.message,
        "seconds": _number(record.seconds),
        "timings": {phase: _number(spent) for phase, spent in record.timings.items()},
        "driver": record.driver,
        "size": record.size,
        "compile": dict(record.compile),
        "expectations": [_expectation(outcome) for outcome in record.expectations],
        "images": dict(record.images),
    }


def _expectation(outcome: Outcome) -> dict[str, Any]:
    return {
        "name": outcome.name,
        "kind": outcome.kind,
        "status": outcome.status,
        "message": outcome.message,
        "worst": None if outcome.worst is None else _worst(outcome.worst),
        "vacuous": _number(outcome.vacuous),
        "undecided": _number(outcome.undecided),
        "judged": outcome.judged,
        "outside": outcome.outside,
        "values": [
            {
                "label": row.label,
                "expected": row.expected,
                "measured": row.measured,
                "ok": row.ok,
                "note": row.note,
            }
            for row in outcome.rows
        ],
    }


def _worst(worst: Worst) -> dict[str, Any]:
    return {
        "pixel": None if worst.pixel is None else list(worst.pixel),
        "component": worst.component,
        "measured": _numbers(worst.measured),
        "reference": _numbers(worst.reference),
        "low": _numbers(worst.low),
        "high": _numbers(worst.high),
        "ulp": _number(worst.ulp),
        "widths": _number(worst.widths),
        "inputs": {name: _numbers(values) for name, values in worst.inputs.items()},
    }


def _number(value: float) -> float | str:
    """A float for strict JSON: itself, or "nan", "inf", "-inf"."""
    number = float(value)
    return number if math.isfinite(number) else str(number)


def _numbers(values: tuple[float, ...]) -> list[float | str]:
    return [_number(value) for value in values]


@cache
def _converter() -> Converter:
    from cattrs import Converter

    converter = Converter(forbid_extra_keys=True)
    converter.register_unstructure_hook(float, _number)
    # float() reads "nan" and "inf" too, but would also take true, and "1".
    converter.register_structure_hook(float, lambda value, _: _float(value))
    converter.register_structure_hook(int, lambda value, _: _exactly(value, int))
    converter.register_structure_hook(bool, lambda value, _: _exactly(value, bool))
    converter.register_structure_hook(str, lambda value, _: _exactly(value, str))
    return converter


def _float(value: object) -> float:
    if value in ("nan", "inf", "-inf"):
        return float(str(value))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{value!r} is no number")
    return float(value)


def _exactly(value: object, kind: type) -> Any:
    if type(value) is not kind:
        raise ValueError(f"{value!r} is no {kind.__name__}")
    return value


def _damaged(path: Path, error: Exception) -> ShaderlabError:
    first = error
    while isinstance(getattr(first, "exceptions", None), tuple):
        first = first.exceptions[0]  # type: ignore[attr-defined]
    return ShaderlabError(
        f"this is no run of this version ({type(first).__name__}: {first})",
        file=path,
        remedy="run the cases again",
    )
