"""Broken files, which a loader must refuse in exactly these words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from shaderlab import refused


def broken_files(
    load: Callable[[Path], Any],
    folder: Path,
    rows: Mapping[str, str | tuple[str, Mapping[str, Any]]],
    remedy: str,
) -> list[Any]:
    """A `refused` for each file of the folder "broken" in `folder`.

    Args:
        load: what reads such a file.
        folder: of the case's files.
        rows: file name → the message, or the message and what else `refused` takes: `line`, or
            another `remedy`.
        remedy: what most of them are to say.

    >>> one, two = broken_files(open, Path("a"), {"b": "c", "d": ("e", {"line": 8})}, "f")
    >>> one.name, one.remedy, two.line
    ('b', 'f', 8)
    """
    return [
        refused(
            partial(load, folder / "broken" / name),
            message=message,
            file=f"{folder.name}/broken/{name}",
            name=name,
            **{"remedy": remedy, **more},
        )
        for name, row in rows.items()
        for message, more in [(row, {}) if isinstance(row, str) else row]
    ]
