"""A whole run as JSON: `run.json` in its folder, from which the page can be made again."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import read_regular, write_text
from shaderlab.model.records import Run

if TYPE_CHECKING:
    from cattrs import Converter

FILE_NAME = "run.json"
Kind = TypeVar("Kind")


def save(run: Run, folder: str | Path) -> Path:
    """Write the whole run to `folder`/run.json and return that path.

    The JSON is strict: NaN and infinities are the strings "nan", "inf" and "-inf". Raises
    ShaderlabError: the file can't be written."""
    path = Path(folder) / FILE_NAME
    write_text(path, _pieces(run))
    return path


def _pieces(run: Run) -> Iterator[str]:
    """A run's JSON, one record at a time: the whole of it takes several times its size."""
    before, _, after = encode(replace(run, records=())).partition('"records":[]')
    yield f'{before}"records":['
    for number, record in enumerate(run.records):
        yield f"{',' if number else ''}{encode(record)}"
    yield f"]{after}\n"


def load(folder: str | Path) -> Run:
    """The run that `save` wrote to `folder`. Raises UsageError: there is none; ShaderlabError: the
    file is damaged or was written by another version."""
    path = Path(folder) / FILE_NAME
    try:
        text = read_regular(path).decode("utf-8")
    except (FileNotFoundError, NotADirectoryError) as error:
        raise UsageError(
            "no run was saved here", file=path, remedy="shaderlab run writes one"
        ) from error
    except (OSError, UnicodeDecodeError) as error:
        raise _damaged(path, error) from error
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise _damaged(path, error) from error
    return parse(data, Run, path)


def encode(value: Any) -> str:
    """A record, another dataclass of plain data, or a list of such, as strict JSON."""
    try:
        return _ENCODER.encode(value)
    except ValueError:  # few have numbers that are none
        return _ENCODER.encode(to_plain(value))


def to_plain(value: Any) -> Any:
    """A record, or another dataclass of plain data, as what strict JSON can hold."""
    kind = type(value)
    if kind in _AS_IT_IS:
        return value
    if kind is float:
        return value if math.isfinite(value) else str(value)
    if kind is tuple or kind is list:
        return [each if type(each) in _AS_IT_IS else to_plain(each) for each in value]
    if kind is dict:
        return {name: to_plain(each) for name, each in value.items()}
    return to_plain(_parts(value))


def _parts(value: Any) -> Any:
    """What is written for a value that JSON does not know, or whose class is one's own."""
    if isinstance(value, str):
        return str.__str__(value)
    for kind in (int, float):
        if isinstance(value, kind):
            return kind(value)
    if is_dataclass(value):
        return {name: getattr(value, name) for name in _names(value.__class__)}
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return dict(value)
    if hasattr(value, "item"):
        return value.item()  # a number of NumPy's
    raise TypeError(f"{type(value).__name__} is not plain data")


@cache
def _names(kind: Any) -> tuple[str, ...]:
    return tuple(field.name for field in fields(kind))


_AS_IT_IS = frozenset({str, int, bool, type(None)})
_ENCODER = json.JSONEncoder(allow_nan=False, separators=(",", ":"), default=_parts)


def parse(data: Any, kind: type[Kind], path: Path | None = None) -> Kind:
    """The inverse of `to_plain`. Raises ShaderlabError: another version wrote the file `path`."""
    try:
        return _converter().structure(data, kind)
    except Exception as error:  # cattrs raises groups of its hooks' errors
        raise _damaged(path or Path(kind.__name__), error) from error


@cache
def _converter() -> Converter:
    from cattrs import Converter

    converter = Converter(forbid_extra_keys=True)
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
        raise ValueError(f"{value!r} is not a number")
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
        f"this is not a run of this version ({type(first).__name__}: {first})",
        file=path,
        remedy="run the cases again",
    )
