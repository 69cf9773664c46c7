"""The records of a sweep's points, in its journal: written as they come, read again where one is
looked at, so that memory does not grow with their number.

Points of a sweep have almost everything in common. A line of the journal is `[point, record]`, or
`[point, base, patch]`: what is not as in the record of the point `base`. In a patch an object has
what differs in an object, a list of one value is that value.
"""

from __future__ import annotations

import json
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from shaderlab.errors import ShaderlabError
from shaderlab.files import open_regular
from shaderlab.model import store
from shaderlab.model.records import Record

from .journal import FILE_NAME, Journal, as_line, lines

Plain = Mapping[str, Any]


class PointRecords:
    """Writes and reads the records of `count` points in the journal of a sweep.

    Args:
        folder: the run's folder.
        journal: the journal that is open there.
        count: how many points there are.
    """

    def __init__(self, folder: Path, journal: Journal, count: int) -> None:
        self._folder = folder
        self._journal = journal
        self._starts = array("q", [-1]) * count  # where the line of each point begins
        self._base: tuple[int, Plain, int] | None = None  # its point, record and length

    def add(self, point: int, record: Record) -> Plain:
        """Write a point's record; returns it as plain data."""
        plain: Plain = store.to_plain(record)
        line, whole = b"", self._base is None
        if self._base is not None:
            number, base, length = self._base
            line = as_line([point, number, changes(base, plain)])
            whole = len(line) > length // 2  # the base is an odd one out, such as a crash
        if whole:
            line = as_line([point, plain])
            self._base = point, plain, len(line)
        start = self._journal.write(line)
        self._starts[point] = -1 if start is None else start
        return plain

    def resume(self, use: Callable[[int, Plain], None]) -> Iterator[int]:
        """Call `use` with each point and record that an earlier command wrote.

        Returns:
            The numbers of lines that are damaged, or whose base is, or that `use` raises of.
        """
        bases: dict[int, Plain] = {}
        for number, start, line in lines(self._folder):
            try:
                point, plain = _read(line, bases)
                if not 0 <= point < len(self._starts):
                    raise ValueError(f"there is no point {point}")
                if point in bases:
                    store.parse(plain, Record)
                use(point, plain)
            except (ValueError, LookupError, TypeError, AttributeError, ShaderlabError):
                yield number
            else:
                self._starts[point] = start

    def read(self, points: Iterable[int]) -> list[Record]:
        """The records of some points, without those that could not be written."""
        bases: dict[int, Plain] = {}
        found = []
        with open(open_regular(self._folder / FILE_NAME), "rb") as file:

            def line(point: int) -> bytes:
                file.seek(self._starts[point])
                return file.readline()

            for point in points:
                if self._starts[point] >= 0:
                    text = line(point)
                    base = json.loads(text)[1]
                    if isinstance(base, int) and base not in bases:
                        _read(line(base), bases)  # the last base only is kept
                    found.append(store.parse(_read(text, bases)[1], Record))
        return found


def changes(base: Any, value: Any) -> Any:
    """What makes `base` into another value: `changed` is the inverse."""
    if isinstance(base, dict) and isinstance(value, dict) and base.keys() == value.keys():
        return {key: changes(base[key], v) for key, v in value.items() if not _same(base[key], v)}
    if isinstance(base, list) and isinstance(value, list) and len(base) == len(value):
        pairs = enumerate(zip(base, value, strict=True))
        if all(isinstance(each, dict) for each in base):
            return {str(n): changes(b, v) for n, (b, v) in pairs if not _same(b, v)}
    return [value]


def changed(base: Any, patch: Any) -> Any:
    """`base` with the changes of a patch; `base` stays as it is."""
    if isinstance(patch, list):
        return patch[0]
    if isinstance(base, list):
        return [changed(each, patch.get(str(n), {})) for n, each in enumerate(base)]
    if not patch:
        return base
    return {**base, **{key: changed(base[key], change) for key, change in patch.items()}}


def _same(one: Any, other: Any) -> bool:
    return one == other and repr(one) == repr(other)  # 0.0 equals -0.0, and 1 equals 1.0


def _read(line: bytes, bases: dict[int, Plain]) -> tuple[int, Plain]:
    """The point and the record of a line; one that is whole takes the place of all in `bases`:
    lines refer to the last one before them."""
    point, *what = json.loads(line)
    if type(point) is not int or not isinstance(what[-1], dict):
        raise ValueError("this is no point")
    if len(what) == 1:
        bases.clear()
        bases[point] = what[0]
        return point, what[0]
    base, patch = what
    found: Plain = changed(bases[base], patch)
    return point, found
