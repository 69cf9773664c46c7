"""`pytest --shaderlab-report DIR`: the usual page, of cases and of tests of GLSL functions."""

from __future__ import annotations

import datetime
import inspect
import time
from collections.abc import Callable, Generator
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import pytest

from shaderlab.files import display_path
from shaderlab.functions.records import Notes, take_notes

if TYPE_CHECKING:
    from shaderlab.engine.jobs import DriverInfo
    from shaderlab.model.records import Record, Status

ATTRIBUTE = "shaderlab_record"
"""A report's attribute with the record as plain data: pytest-xdist sends it on."""
_NOTES: pytest.StashKey[Notes] = pytest.StashKey()


class Recorder:
    """Makes a record of each test that calls GLSL functions.

    Args:
        take: gets the report of a test's call, and its record.
        every: whether other tests have records, too.
    """

    def __init__(
        self, take: Callable[[pytest.TestReport, Record], None], every: bool = False
    ) -> None:
        self._take = take
        self._every = every

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, Any, Any]:
        """Note what the test's checks find."""
        with take_notes() as notes:
            item.stash[_NOTES] = notes
            return (yield)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Make the record, from the report of the call or of a setup that ended the test."""
        report = yield
        if report.when == "call" or (report.when == "setup" and not report.passed):
            record = self._record(item, report)
            if record is not None:
                self._take(report, record)
        return report

    def _record(self, item: pytest.Item, report: pytest.TestReport) -> Record | None:
        own: Record | None = getattr(item, "record", None)  # a variant of a case
        notes = item.stash.get(_NOTES, None)
        if own is not None or not (notes or self._every):
            return own
        from shaderlab.functions.records import record_of_test

        status = "pass" if report.passed else "unsupported" if report.skipped else "fail"
        if report.when == "setup" and report.failed:
            status = "error"
        module = getattr(item, "module", None)
        line = (item.location[1] or 0) + 1
        return record_of_test(
            str(item.path),
            item.name,
            line,
            status=cast("Status", status),
            message=_why(report),
            seconds=report.duration,
            lesson=inspect.getdoc(module) or "",
            notes=notes,
        )


class ReportWriter:
    """Gathers records, in the process that ends the session, and writes the page.

    Args:
        folder: of the report.
        about: tells the driver.
    """

    def __init__(self, folder: Path, about: Callable[[], DriverInfo]) -> None:
        self._folder = folder
        self._about = about
        self._records: list[Record] = []
        self._started = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
        self._clock = time.perf_counter()
        self._said = ""

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Keep a report's record."""
        data = getattr(report, ATTRIBUTE, None)
        if data is not None:
            from shaderlab.model.records import Record
            from shaderlab.model.store import parse

            self._records.append(parse(data, Record))

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self) -> None:
        """Write the page."""
        from shaderlab.errors import ShaderlabError
        from shaderlab.model import store
        from shaderlab.model.records import Run
        from shaderlab.report import html

        if not self._records:
            self._said = "no test of cases or of GLSL functions: no report is written"
            return
        about = self._about()
        run = Run(
            driver=about.driver,
            versions=about.versions,
            started=self._started,
            seconds=time.perf_counter() - self._clock,
            records=tuple(self._records),
        )
        try:
            store.save(run, self._folder)
            self._said = f"report: {display_path(html.write(run, self._folder))}"
        except ShaderlabError as error:
            self._said = f"shaderlab: {error}"

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Say where it is."""
        terminalreporter.write_line(self._said)


def attach(report: pytest.TestReport, record: Record) -> None:
    """Give a report its record."""
    from shaderlab.model.store import to_plain

    setattr(report, ATTRIBUTE, to_plain(record))


def _why(report: pytest.TestReport) -> str:
    if report.passed:
        return ""
    if report.skipped and isinstance(report.longrepr, tuple):
        return str(report.longrepr[2]).removeprefix("Skipped: ")
    return report.longreprtext
