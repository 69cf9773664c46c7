"""Where the command line puts what it makes: run folders, the pointer to the latest, JSON."""

from __future__ import annotations

import contextlib
import datetime
import itertools
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from shaderlab.errors import UsageError
from shaderlab.files import replacing, write_bytes

REPORTS = Path("reports")
LATEST = "latest"


def new_run_folder(parent: Path = REPORTS) -> Path:
    """Make a folder of its own for this run, named by the time, whoever else starts now."""
    stamp = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    for number in itertools.count(1):
        folder = parent / (stamp if number == 1 else f"{stamp}-{number}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            if not parent.is_dir():
                raise UsageError("this is not a folder", file=parent) from None
        except OSError as error:
            raise _unwritable(parent, error) from error
        else:
            return folder
    raise AssertionError("unreachable")


def report_folder(folder: Path) -> Path:
    """Make the folder that was asked for; it may be there already."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _unwritable(folder, error) from error
    return folder


def latest(folder: Path) -> None:
    """Let `latest`, beside `folder`, point to it; where there are no symbolic links, leave it."""
    with contextlib.suppress(OSError), replacing(folder.parent / LATEST) as link:
        link.symlink_to(folder.name, target_is_directory=True)


def find_latest(parent: Path = REPORTS) -> Path:
    """The latest run's folder: what `latest` points to, else the last one by name.

    Raises:
        UsageError: there is no run.
    """
    pointer = parent / LATEST
    if (pointer / "run.json").is_file():
        return pointer.resolve()
    runs = sorted(path.parent for path in parent.glob("*/run.json"))
    if not runs:
        raise UsageError(
            f"there is no run in {parent}/", remedy="make one with: shaderlab run --all"
        )
    return runs[-1]


def write_json(data: Mapping[str, Any] | Sequence[Any], file: str) -> None:
    """Write `data` to a file whole or not at all, or to standard output for "-"."""
    write_output(json.dumps(data, indent=2, ensure_ascii=False) + "\n", file)


def write_output(text: str, file: str) -> None:
    """Write text to a file whole or not at all, or to standard output for "-"."""
    if file == "-":
        click.echo(text, nl=False)
        return
    path = Path(file)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, text.encode("utf-8"))
    except OSError as error:
        raise _unwritable(path, error) from error


def _unwritable(path: Path, error: OSError) -> UsageError:
    return UsageError(f"can't write here: {error.strerror or error}", file=path)
