"""A run's plan and records as lines of a file, each written as soon as it is there.

`records.jsonl` begins with one line about the run (what was asked for), then has a line for each
record, in the order in which they came. A line that was cut short counts as not written. Lines are
read one at a time: a sweep has a hundred thousand.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from shaderlab.cli.sweep_table import Grid
from shaderlab.engine.jobs import Job
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import NO_ROOM, open_regular
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

FILE_NAME = "records.jsonl"
_BLOCK = 1 << 16


@dataclass(frozen=True, kw_only=True)
class RunPlan:
    """What was asked for, so that it can be resumed: jobs, or the points of a sweep."""

    started: str
    options: RunOptions
    jobs: tuple[Job, ...] = ()
    grid: Grid | None = None


class Journal(contextlib.AbstractContextManager["Journal"]):
    """The file of a run that is going on. A context manager.

    Only one run at a time may write to a folder; the lock goes with the process. On a full disk
    nothing is written, and `problem` says so.

    Args:
        folder: the run's folder.
        plan: what is run; None resumes the run that is there.

    Raises:
        UsageError: another run is writing to this folder, or it can't be written to.
    """

    def __init__(self, folder: Path, plan: RunPlan | None) -> None:
        self._path = folder / FILE_NAME
        self.problem = ""
        self._file: IO[bytes]
        try:
            descriptor = open_regular(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
            self._file = open(descriptor, "ab", buffering=0)  # noqa: SIM115
        except OSError as error:
            if plan is None or (error.errno not in NO_ROOM and folder.is_dir()):
                raise UsageError(f"can't write here: {error.strerror}", file=self._path) from error
            self._file = open(os.devnull, "wb", buffering=0)  # noqa: SIM115
            self.problem = f"can't write {self._path}: {os.strerror(errno.ENOSPC)}"
            return
        try:
            _lock(self._file, folder)
            if plan is None:
                self._file.truncate(_find_last_line_end(self._path))  # a line that was cut short
            else:
                self._file.truncate(0)
                self.add(plan)
        except BaseException:
            self._file.close()
            raise

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def add(self, value: RunPlan | Record) -> None:
        """Append one line. If the disk is full the run goes on, and `problem` says so."""
        if not self.problem:
            self.write(encode_line(value))

    def write(self, line: bytes) -> int | None:
        """Append a line that `as_line` made, as `add` does; returns where in the file it begins,
        None if it is not there."""
        if self.problem:
            return None
        start = os.fstat(self._file.fileno()).st_size
        try:
            while line:
                line = line[self._file.write(line) or 0 :]
        except OSError as error:
            self.problem = f"can't write {self._path}: {error.strerror}"
            with contextlib.suppress(OSError):
                os.ftruncate(self._file.fileno(), start)
            return None
        return start


def encode_line(data: Any) -> bytes:
    """Plain data, or a dataclass of such, as a line of a journal."""
    from shaderlab.model import store  # not before workers get ready: it takes its time

    return (store.encode(data) + "\n").encode("utf-8", "replace")


def read_journal(folder: Path) -> tuple[RunPlan, list[Record], list[int]]:
    """What the journal of a run holds: what was asked for, the records that there are, and the
    numbers of lines that are damaged.

    Raises:
        UsageError: there is none, or not even its first line is whole.
        ShaderlabError: it was written by another version.
    """
    from shaderlab.model import store

    plan = read_plan(folder)
    records: list[Record] = []
    damaged: list[int] = []
    if plan.grid is None:
        for number, _, line in read_lines(folder):
            try:
                records.append(store.parse(json.loads(line), Record))
            except (ValueError, ShaderlabError):
                damaged.append(number)
    return plan, records, damaged


def read_plan(folder: Path) -> RunPlan:
    """What was asked for. Raises as `read`."""
    path = folder / FILE_NAME
    try:
        with open(open_regular(path), "rb") as file:
            line = file.readline()
    except (FileNotFoundError, NotADirectoryError) as error:
        raise UsageError(
            "there is no run to resume", file=path, remedy="name the folder of a run"
        ) from error
    except OSError as error:
        raise UsageError(f"can't resume this run: {error.strerror}", file=path) from error
    if not line.endswith(b"\n"):
        raise UsageError("this run never began", file=path, remedy="start it again")
    from shaderlab.model import store

    try:
        first = json.loads(line)
    except ValueError as error:
        raise UsageError(
            "the first line, which holds the plan of the run, is damaged",
            file=path,
            line=1,
            remedy="start it again",
        ) from error
    return store.parse(first, RunPlan, path)


def read_lines(folder: Path) -> Iterator[tuple[int, int, bytes]]:
    """Whole lines after the first: their numbers, where they begin, their bytes."""
    with open(open_regular(folder / FILE_NAME), "rb") as file:
        start = len(file.readline())
        for number, line in enumerate(file, 2):
            if line.endswith(b"\n"):
                yield number, start, line
            start += len(line)


def _find_last_line_end(path: Path) -> int:
    """The length of a file up to the end of its last whole line."""
    with open(open_regular(path), "rb") as file:
        end = file.seek(0, os.SEEK_END)
        while end > 0:
            start = file.seek(max(0, end - _BLOCK))
            last = file.read(end - start).rfind(b"\n")
            if last >= 0:
                return start + last + 1
            end = start
    return 0


def _lock(file: IO[bytes], folder: Path) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise UsageError(
            "another run is writing to this folder",
            file=folder,
            remedy="give each run a folder with --report, or wait",
        ) from error
