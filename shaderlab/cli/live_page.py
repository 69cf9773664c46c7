"""The report that `shaderlab watch --open` shows, and that reloads itself."""

from __future__ import annotations

import contextlib
import datetime
import time
from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path

import click

from shaderlab.cli.files import new_run_folder
from shaderlab.errors import ShaderlabError
from shaderlab.model import store
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record, Run
from shaderlab.report import html
from shaderlab.report.live import LiveReport, live_report

from .watching.session import Session


class LivePage:
    """The report of all that is watched, in a browser."""

    def __init__(self, report: LiveReport, folder: Path, options: RunOptions) -> None:
        self._report, self._folder = report, folder
        self._options = replace(options, folder=folder, pictures=True)
        self._records: dict[tuple[str, str], Record] = {}
        self._started = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
        self._opened = False

    def write(self, session: Session, case_files: Collection[Path]) -> None:
        """Run what was judged once more, with pictures, and write the page anew."""
        began = time.perf_counter()
        jobs = [job for job in session.jobs if Path(job.file) in case_files]
        for _, record in session.executor.run(jobs, self._options):
            self._records[record.id, record.variant] = record
        about = session.executor.about()
        run = Run(
            driver=about.driver,
            versions=about.versions,
            started=self._started,
            seconds=time.perf_counter() - began,
            records=tuple(self._records.get((r.id, r.variant), r) for r in session.records),
        )
        try:
            store.save(run, self._folder)
            html.write(run, self._folder)
        except ShaderlabError as error:
            click.echo(f"shaderlab: {error}", err=True)
            return
        self._report.changed()
        if not self._opened:
            self._opened = True
            click.echo(f"report: {self._report.address}")
            click.launch(self._report.address)


@contextlib.contextmanager
def live_page(options: RunOptions) -> Iterator[LivePage]:
    """A page in a new folder of runs, served until the end."""
    folder = new_run_folder()
    with live_report(folder) as report:
        yield LivePage(report, folder, options)
