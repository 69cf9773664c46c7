"""`shaderlab watch`: judge again what depends on a file that was saved."""

from __future__ import annotations

import contextlib
import datetime
import os
import sys
import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from shaderlab.cli import OK
from shaderlab.cli.options import (
    DRIVER,
    INCLUDE,
    TARGET,
    jobs_option,
    limits_option,
    make_executor,
)
from shaderlab.engine.settings import FILE, have_settings_changed, load_settings
from shaderlab.errors import UsageError
from shaderlab.files import display_path
from shaderlab.model.options import Limits, RunOptions

if TYPE_CHECKING:
    from shaderlab.cli.showing import Show
    from shaderlab.cli.watching import Changes, Contents, Session
    from shaderlab.engine.jobs import CaseInfo, Executor, Job


_SHOWN = 4


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

    Workers stay warm, with their device open. A change to [tool.shaderlab] restarts the command.
    Press Ctrl-C to end it.

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

    def start() -> Executor:
        return make_executor(driver, limits, workers)

    from shaderlab.cli.showing import Show
    from shaderlab.cli.watching import Changes, Contents, Session, warm_up

    wanted = _Wanted(targets or (".",))
    case_files, test_files = wanted.files()
    show = Show()
    # Python takes its compiled modules for new as long as a file's second and size stay the same.
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    restart = False
    with (
        contextlib.suppress(KeyboardInterrupt),
        contextlib.ExitStack() as stack,
    ):
        changes = stack.enter_context(Changes(wanted.folders()))
        session = stack.enter_context(
            contextlib.closing(Session(start, wanted.jobs, options, warm_up))
        )
        changes.add({file.parent for file in wanted.settings()}, below=False)
        _Watch(session, changes, Contents(), wanted, show).run(case_files, test_files)
        restart = True
    if restart:  # options, workers and what they keep come of the settings
        os.execv(sys.executable, [sys.executable, "-m", "shaderlab", *sys.argv[1:]])
    return OK


class _Wanted:
    """What was named: its case files as they are now, and the jobs of these."""

    def __init__(self, targets: Sequence[str]) -> None:
        self._targets = targets
        self._variants: dict[Path, set[str | None]] = {}
        self._tests: list[Path] = []

    def files(self) -> tuple[list[Path], list[Path]]:
        """The case files, and those with tests of functions; absolute. Raises UsageError."""
        from shaderlab.cli.selecting import exclude_test_files, find_test_files, resolve_target

        self._variants = {}
        self._tests = find_test_files(self._targets)
        for target in exclude_test_files(self._targets, self._tests):
            for file, variant in resolve_target(target):
                self._variants.setdefault(Path(os.path.abspath(file)), set()).add(variant)
        return list(self._variants), self._tests

    def folders(self) -> set[Path]:
        """The folders that the case files are in, and those that were named."""
        named = {Path(os.path.abspath(t)) for t in self._targets if os.path.isdir(t)}
        return named | {file.parent for file in (*self._variants, *self._tests)}

    def settings(self) -> set[Path]:
        """The files that the settings of this folder and of the case files come from, or would."""
        roots = (load_settings(folder).root for folder in self._projects())
        return {(root or Path.cwd()) / FILE for root in roots}

    def have_settings_changed(self) -> bool:
        """Whether settings are others by now. Raises UsageError where they can't be read."""
        return any([have_settings_changed(folder) for folder in self._projects()])

    def _projects(self) -> set[Path]:
        return {Path(), *(file.parent for file in (*self._variants, *self._tests))}

    def jobs(self, facts: Sequence[CaseInfo]) -> list[Job]:
        """The jobs of case files, in order."""
        from shaderlab.cli.selecting import make_ids_distinct, select_variants

        return [
            job
            for case in make_ids_distinct(facts)
            for job in select_variants(case, None)
            if job.broken or {None, job.variant} & self._variants.get(Path(case.file), {None})
        ]


@dataclass(frozen=True)
class _Watch:
    """The loop: what changed, what that asks for, what came of it."""

    _session: Session
    _changes: Changes
    _contents: Contents
    _wanted: _Wanted
    _show: Show

    def run(self, case_files: Collection[Path], test_files: Collection[Path]) -> None:
        """Judge all files, then wait for changes, until the settings are other ones."""
        self._contents.learn(self._wanted.settings())
        self._judge(self._session.follow(case_files, test_files), time.perf_counter())
        while True:
            self._show.console.print("watching; press Ctrl-C to end", style="dim")
            waiting: set[Path] = set()
            began = 0.0
            while not waiting:
                found = self._changes.next()
                began = time.perf_counter()
                changed = self._find_changed(self._changes.settled(found, self._session.files))
                if changed & self._wanted.settings() and self._have_settings_changed():
                    return
                waiting = self._find_affected(changed)
            self._judge(waiting, began)

    def _find_changed(self, found: Collection[Path]) -> set[Path]:
        """Of these files, those with other contents. One that nothing depends on and that is gone
        again was an editor's own."""
        known = self._session.files
        return self._contents.changed(path for path in found if path in known or path.exists())

    def _have_settings_changed(self) -> bool:
        """Whether the settings are others; ones that can't be read are none."""
        try:
            changed = self._wanted.have_settings_changed()
        except UsageError as error:
            click.echo(f"shaderlab: {error}", err=True)
            return False
        if changed:
            self._show.console.print("\nthe settings changed: restarting", style="bold")
        return changed

    def _find_affected(self, changed: Collection[Path]) -> set[Path]:
        """The case files to judge after these files changed."""
        if not changed:
            return set()
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
        self._contents.learn(self._session.files)
        for record in self._session.judge(case_files, self._changes.pending):
            self._show.verdict(record)
            records.append(record)
        self._show.total(records, time.perf_counter() - began)
        files = self._session.files
        self._contents.learn(files, since)
        self._changes.add({path.parent for path in files})
