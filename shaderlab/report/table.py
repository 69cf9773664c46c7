"""Rows of figures as files that other programs read: CSV, or Parquet if pyarrow is installed."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import BinaryIO

from shaderlab.errors import ShaderlabError, UsageError, require_extra
from shaderlab.files import write_named

FORMATS = (".csv", ".parquet")
Row = Mapping[str, str | float | int | None]
_ROWS_AT_ONCE = 4096


def check(path: Path) -> None:
    """Check that a table can be written in the format of the file's suffix.

    Raises:
        UsageError: it is none of FORMATS, or its library is not installed.
    """
    if path.suffix not in FORMATS:
        raise UsageError(
            f"a table is {' or '.join(FORMATS)}, not {path.suffix or 'without a suffix'}", file=path
        )
    if path.suffix == ".parquet":
        with require_extra("sweep", "a .parquet file"):
            import pyarrow.parquet  # noqa: F401


def write_table(rows: Callable[[], Iterator[Row]], path: Path) -> None:
    """Write rows of the same columns, a few thousand at a time; None is an empty cell, or null.

    Raises:
        UsageError: as `check`.
        ShaderlabError: the file can't be written.
    """
    check(path)
    write = _csv if path.suffix == ".csv" else _parquet
    try:
        write_named(path, lambda file: write(rows(), file))
    except OSError as error:
        raise ShaderlabError(
            f"can't write the table ({error.strerror or error})", file=path
        ) from error


def _csv(rows: Iterable[Row], file: BinaryIO) -> None:
    text = io.TextIOWrapper(file, "utf-8", errors="replace", newline="", write_through=False)
    writer = None
    for row in rows:
        if writer is None:
            writer = csv.DictWriter(text, list(row), lineterminator="\n")
            writer.writeheader()
        writer.writerow(row)
    text.detach()


def _parquet(rows: Iterator[Row], file: BinaryIO) -> None:
    import pyarrow as arrow
    from pyarrow import parquet

    parts = []
    while some := [dict(row) for row in islice(rows, _ROWS_AT_ONCE)]:
        parts.append(arrow.Table.from_pylist(some))
    # A column without any value in one part has a type in the others.
    whole = arrow.concat_tables(parts, promote_options="permissive") if parts else arrow.table({})
    parquet.write_table(whole, file)
