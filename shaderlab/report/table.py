"""Rows of figures as files that other programs read: CSV, or Parquet if pyarrow is installed."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path

from shaderlab.errors import ShaderlabError, UsageError, extra
from shaderlab.files import write_named

FORMATS = (".csv", ".parquet")
Row = Mapping[str, str | float | int | None]


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
        with extra("sweep", "a .parquet file"):
            import pyarrow.parquet  # noqa: F401


def write_table(rows: Sequence[Row], path: Path) -> None:
    """Write rows of the same columns; None is an empty cell, or null.

    Raises:
        UsageError: as `check`.
        ShaderlabError: the file can't be written.
    """
    check(path)
    data = _csv(rows) if path.suffix == ".csv" else _parquet(rows)
    try:
        write_named(path, data)
    except OSError as error:
        raise ShaderlabError(
            f"can't write the table ({error.strerror or error})", file=path
        ) from error


def _csv(rows: Sequence[Row]) -> bytes:
    text = io.StringIO()
    columns = list(rows[0]) if rows else []
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode("utf-8", errors="replace")


def _parquet(rows: Sequence[Row]) -> bytes:
    import pyarrow as arrow
    from pyarrow import parquet

    data = io.BytesIO()
    parquet.write_table(arrow.Table.from_pylist([dict(row) for row in rows]), data)
    return data.getvalue()
