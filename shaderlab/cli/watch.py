"""`shaderlab watch`: judge again what depends on a file that was saved.

Files are looked at several times a second, which works on every file system.
"""

from __future__ import annotations

import contextlib
import datetime
import math
import os
import time
from collections.abc import Collection, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from shaderlab.cli import OK
from shaderlab.cli.options import DRIVER, INCLUDE, TARGET, jobs_option, limits_option, make_executor
from shaderlab.engine.catalogue import files_below
from shaderlab.errors import UsageError
from shaderlab.files import display_path
from shaderlab.model.options import Limits, RunOptions

if TYPE_CHECKING:
    from shaderlab.cli.showing import Show
    from shaderlab.cli.watching import Session
    from shaderlab.engine.jobs import CaseInfo, Job


_SHOWN = 4
_PAUSE = 0.05
"""Seconds between two looks. An editor's save is several steps, and a file may be missing in
between: it is saved when nothing has changed for so long."""
_REST = 10
"""A look at a large folder is followed by a pause of so many times its length."""
_CLOCK_TICK = 0.02
"""Seconds by which a file's time may lag behind the clock."""


@click.command("watch")
@click.argument("targets", nargs=-1, metavar="[ID | FILE.py | FOLDER]…")
@INCLUDE
@TARGET
@DRIVER
@jobs_option()
@limits_option("Stop a variant that takes longer than S seconds.")
def command(
    targets: tuple[str, ...],
    includes: tuple[Path, ...],
    compile_targets: tuple[str, ...],
    driver: str | None,
    workers: int | None,
    limits: Limits,
) -> int:
    """Run cases and tests of GLSL functions, then rerun those that depend on a file whenever it is
    saved: a shader or an included file, a case or test file or a module that it imports, an
    image. Without arguments, watch everything below this folder.

    Workers stay warm, with their device open. Press Ctrl-C to stop.

    \b
    Examples:
      shaderlab watch                     watch all cases and tests below this folder
      shaderlab watch tests/test_light.py
      shaderlab watch 'attenuation[50]'   watch one variant

    Exit code: 0 ended by Ctrl-C, 2 wrong usage.
    """
    if workers == 0:
        raise UsageError("watch needs workers; leave out -j 0")
    options = RunOptions(
        pictures=False, include=includes, targets=compile_targets, driver=driver, limits=limits
    )

    from shaderlab.cli.showing import Show
    from shaderlab.cli.watching import Session

    wanted = _Wanted(targets or (".",))
    case_files, test_files = wanted.files()
    # Python takes its compiled modules for new as long as a file's second and size stay the same.
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    with (
        contextlib.suppress(KeyboardInterrupt),
        contextlib.closing(
            Session(lambda: make_executor(driver, limits, workers), wanted.jobs, options)
        ) as session,
    ):
        session.follow(case_files, test_files)
        _Watch(session, wanted, Show()).run({*case_files, *test_files})
    return OK


class _Wanted:
    """What was named: its case files as they are now, and the jobs of these."""

    def __init__(self, targets: Sequence[str]) -> None:
        self._targets = targets
        self._variants: dict[Path, set[str | None]] = {}
        self._tests: list[Path] = []

    def files(self) -> tuple[list[Path], list[Path]]:
        """The case files, and those with tests of functions; absolute. Raises UsageError."""
        from shaderlab.cli.selecting import resolve_target, split_targets

        self._tests, targets = split_targets(self._targets)
        self._variants = {}
        for target in targets:
            for file, variant in resolve_target(target):
                self._variants.setdefault(Path(os.path.abspath(file)), set()).add(variant)
        return list(self._variants), self._tests

    def files_below(self) -> Iterator[Path]:
        """All files in the folders that were named, where new cases may appear."""
        for folder in filter(os.path.isdir, self._targets):
            with contextlib.suppress(UsageError):  # it has just been removed
                yield from files_below(Path(os.path.abspath(folder)))

    def jobs(self, facts: Sequence[CaseInfo]) -> list[Job]:
        from shaderlab.cli.selecting import make_ids_distinct, select_variants

        return [
            job
            for case in make_ids_distinct(facts)
            for job in select_variants(case, None)
            if job.broken or {None, job.variant} & self._variants.get(Path(case.file), {None})
        ]


class _Watch:
    """The loop: what changed, what that asks for, what came of it."""

    def __init__(self, session: Session, wanted: _Wanted, show: Show) -> None:
        self._session = session
        self._wanted = wanted
        self._show = show
        self._stamps: dict[Path, tuple[float, int, int] | None] = {}

    def run(self, waiting: Collection[Path]) -> None:
        """Judge these files, then what changes ask for."""
        self._learn()
        began = time.perf_counter()
        while True:
            self._judge(waiting, began)
            self._show.console.print("watching; press Ctrl-C to end", style="dim")
            waiting = set()
            while not waiting:
                changed, began = self._wait()
                waiting = self._find_affected(changed)

    def _list_files(self) -> set[Path]:
        """All files that may matter: those that verdicts depend on with those beside them, and
        those in the folders that were named."""
        known = self._session.files
        found = {*known, *self._wanted.files_below()}
        for folder in {path.parent for path in known}:
            with contextlib.suppress(OSError), os.scandir(folder) as entries:
                found |= {Path(entry) for entry in entries if entry.is_file()}
        return found

    def _learn(self, since: float = math.inf) -> None:
        """Take files that are not known yet as they are now, but for those that were written after
        `since` (seconds as of `time.time`): who read them may have read something else."""
        for path in self._list_files():
            stamp = _stamp(path)
            if path not in self._stamps and (stamp is None or stamp[0] < since - _CLOCK_TICK):
                self._stamps[path] = stamp

    def _find_changed(self, files: Iterable[Path]) -> set[Path]:
        """Of these files, those that were written, made or removed since the last call."""
        stamps = {path: _stamp(path) for path in files}
        found = {path for path in stamps if self._stamps.get(path, ()) != stamps[path]}
        self._stamps.update(stamps)
        return found

    def _wait(self) -> tuple[set[Path], float]:
        """Wait for files to be saved; return them, and when that was."""
        found: set[Path] = set()
        while not found:
            looked = time.perf_counter()
            found = self._find_changed(self._list_files())
            if not found:
                time.sleep(max(_PAUSE, _REST * (time.perf_counter() - looked)))
        while True:
            began = time.perf_counter()
            time.sleep(_PAUSE)
            more = self._find_changed(self._list_files())
            if not more:
                return found, began
            found |= more

    def _find_affected(self, changed: Collection[Path]) -> set[Path]:
        """The case files to judge after these files changed."""
        new: set[Path] = set()
        if any(path.suffix == ".py" for path in changed):
            with contextlib.suppress(UsageError):  # there is no case at the moment
                new = self._session.follow(*self._wanted.files())
        affected = new | self._session.affected(changed)
        if affected:
            known = {path for path in changed if path in new or path in self._session.files}
            names = sorted(display_path(path) for path in known or changed)
            more = ", …" if len(names) > _SHOWN else ""
            now = datetime.datetime.now().strftime("%H:%M:%S")
            self._show.console.print(f"\n{now} {', '.join(names[:_SHOWN])}{more}", style="bold")
        return affected

    def _judge(self, case_files: Collection[Path], began: float) -> None:
        records, since = [], time.time()
        known = {path: self._stamps.get(path) for path in self._session.files}

        def interrupted() -> bool:
            return any(_stamp(path) != stamp for path, stamp in known.items())

        for record in self._session.judge(case_files, interrupted):
            self._show.verdict(record)
            records.append(record)
        self._show.total(records, time.perf_counter() - began)
        self._learn(since)


def _stamp(path: Path) -> tuple[float, int, int] | None:
    """What tells a file that was written from what it was before; None if it is missing."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime, found.st_size, found.st_ino
