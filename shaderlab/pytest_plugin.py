"""`pytest my_cases/`: each variant of each case file is an item; a failure shows what `run` does.

A worker process imports and runs case files: a case that crashes or hangs is a failed test,
or a file that can't be collected, and the session goes on. Each variant runs when its turn comes;
with pytest-xdist (`-n auto`) each of its processes has a worker.

`shaderlab_timeout`, `shaderlab_memory` and `shaderlab_jobs` in pytest's configuration go before
`[tool.shaderlab]`; SHADERLAB_JOBS goes before all, and 0 runs everything in pytest's own process,
for debuggers. `--shaderlab-report DIR` writes the page of `shaderlab run`.
"""

from __future__ import annotations

import datetime
import fnmatch
import inspect
import os
import re
import time
from collections.abc import Callable, Generator, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import pytest

from shaderlab.engine.catalogue import inspect_file
from shaderlab.errors import ShaderlabError
from shaderlab.files import claim_folder, display_path
from shaderlab.model.options import CALL_LIMITS, Limits, RunOptions
from shaderlab.report.text import format_failure, format_label, has_failed

if TYPE_CHECKING:
    from shaderlab.engine.jobs import Executor, Job
    from shaderlab.engine.settings import Settings
    from shaderlab.functions.library import Notes
    from shaderlab.model.records import Record, Status

RECORD_ATTRIBUTE = "shaderlab_record"
"""A report's attribute with the record as plain data: pytest-xdist sends it on."""
_TESTS = re.compile(rb"^\s*(?:async\s+)?def test|^\s*class \w*Test|^Test", re.MULTILINE)
_EXECUTOR: pytest.StashKey[Executor] = pytest.StashKey()
_NOTES: pytest.StashKey[Notes] = pytest.StashKey()


class CaseFailure(Exception):
    """A scene did not pass; carries its record."""

    def __init__(self, record: Record) -> None:
        super().__init__(f"{format_label(record.id, record.variant)}: {record.status}")
        self.record = record


class CaseFile(pytest.File):
    """A case file; collecting it has the worker import it, which touches no device."""

    def collect(self) -> Iterator[CaseItem]:
        from shaderlab.engine.jobs import make_jobs

        (facts,) = get_executor(self.config).load([self.path])
        if facts.error is not None:
            raise facts.error
        for job in make_jobs(facts):
            item: CaseItem = CaseItem.from_parent(
                self, name=format_label(job.id, job.variant), job=job
            )
            yield item

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """A wrong case file is shown as one message, not as a traceback."""
        if isinstance(excinfo.value, ShaderlabError):
            return str(excinfo.value)
        return super().repr_failure(excinfo)


class NoTests(pytest.File):
    def collect(self) -> Iterator[pytest.Item]:
        return iter(())


class CaseItem(pytest.Item):
    def __init__(self, *, job: Job, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.job = job
        self.record: Record | None = None

    def runtest(self) -> None:
        self.record = None
        ((_, record),) = get_executor(self.config).run([self.job], make_options(self.config))
        self.record = record
        if record.status == "unsupported":
            pytest.skip(record.message or "this driver lacks what the case needs")
        if has_failed(record):
            raise CaseFailure(record)
        if record.not_asked:
            count = len(record.not_asked)
            message = f"{count} checks of OpenGL's own calls were skipped"
            self.warn(pytest.PytestWarning(f"{message}: {', '.join(record.not_asked)}"))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        if isinstance(excinfo.value, CaseFailure):
            return "\n".join(format_failure(excinfo.value.record))
        if isinstance(excinfo.value, ShaderlabError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[os.PathLike[str], int | None, str]:
        return self.path, 0, self.name


def get_executor(config: pytest.Config) -> Executor:
    """Return what runs this process's cases, made when it is first needed."""
    executor = config.stash.get(_EXECUTOR, None)
    if executor is None:
        from shaderlab.analysis import CHECKING_WORK
        from shaderlab.engine.jobs import InProcessExecutor, ProcessExecutor

        driver = _settings(config).driver
        executor = (
            InProcessExecutor(driver, CHECKING_WORK)
            if _runs_in_process(config)
            else ProcessExecutor(driver, _limits(config), 1, early=False, work=CHECKING_WORK)
        )
        config.stash[_EXECUTOR] = executor
    return executor


def make_options(config: pytest.Config) -> RunOptions:
    """How the session's variants are run."""
    folder, driver = _report_folder(config), _settings(config).driver
    return RunOptions(
        pictures=folder is not None, folder=folder, driver=driver, limits=_limits(config)
    )


def pytest_configure(config: pytest.Config) -> None:
    """Calls of GLSL functions have the limits of variants; a report needs records."""
    if not config.option.fulltrace:
        config.pluginmanager.register(_ShortInterrupts())
    folder = _report_folder(config)
    if folder is not None:
        config.pluginmanager.register(Recorder(attach_record))
        if not hasattr(config, "workerinput"):  # of pytest-xdist, whose first process writes it
            try:
                claim_folder(folder)
            except (OSError, ShaderlabError) as error:
                raise pytest.UsageError(f"--shaderlab-report: {error}") from error
            writer = ReportWriter(folder, lambda: get_executor(config).about())
            config.pluginmanager.register(writer)
    if config.getini("shaderlab_timeout") or config.getini("shaderlab_memory"):
        CALL_LIMITS.set(_limits(config))


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--shaderlab-report`; and settings for pytest's configuration file, or for its -o."""
    parser.getgroup("shaderlab").addoption(
        "--shaderlab-report",
        metavar="DIR",
        help="write the report of cases, and of tests of GLSL functions, into DIR",
    )
    parser.addini("shaderlab_timeout", "seconds that one variant may take; else 30", default="")
    parser.addini("shaderlab_memory", "gigabytes of it; 0 for any amount; else 4", default="")
    parser.addini("shaderlab_jobs", "0 runs cases in pytest's own process", default="")


def _report_folder(config: pytest.Config) -> Path | None:
    folder: str | None = config.getoption("--shaderlab-report", None)
    return Path(config.invocation_params.dir, folder) if folder else None


def _runs_in_process(config: pytest.Config) -> bool:
    """Whether cases run in this process; else in a worker."""
    name, text = "SHADERLAB_JOBS", os.environ.get("SHADERLAB_JOBS", "")
    if not text:
        name, text = "shaderlab_jobs", config.getini("shaderlab_jobs")
    if text and not text.isdecimal():
        raise pytest.UsageError(f"{name} is {text!r}: give it a whole number, 0 for no workers")
    return bool(text) and int(text) == 0


def _settings(config: pytest.Config) -> Settings:
    from shaderlab.engine.settings import load_settings

    try:
        return load_settings(config.rootpath)
    except ShaderlabError as error:
        raise pytest.UsageError(str(error)) from None


def _limits(config: pytest.Config) -> Limits:
    seconds, gigabytes = (config.getini(f"shaderlab_{name}") for name in ("timeout", "memory"))
    try:
        usual = _settings(config).limits
        return Limits(
            seconds=float(seconds or usual.seconds), gigabytes=float(gigabytes or usual.gigabytes)
        )
    except (ValueError, ShaderlabError) as error:
        said = f"shaderlab_timeout is {seconds!r}, shaderlab_memory is {gigabytes!r}"
        raise pytest.UsageError(f"{said}: {error}") from None


class NoCaseWarning(pytest.PytestWarning):
    """A file takes `Case` from shaderlab, but nothing of it is run."""


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> CaseFile | None:
    """Collect case files, and nothing else."""
    reason = inspect_file(file_path)
    if reason != "":
        if reason and file_path.name != "conftest.py" and not _has_tests(file_path, parent):
            shown = display_path(file_path)
            parent.warn(NoCaseWarning(f"{shown} takes Case but is no case: {reason}"))
        return None
    found: CaseFile = CaseFile.from_parent(parent, path=file_path)
    return found


@pytest.hookimpl(tryfirst=True)
def pytest_pycollect_makemodule(module_path: Path, parent: pytest.Collector) -> NoTests | None:
    """Keep pytest from importing a case file as a module of tests, in its own process and outside
    the tree of cases. One that has tests as well stays one."""
    if inspect_file(module_path) != "" or _has_tests(module_path, parent):
        return None
    found: NoTests = NoTests.from_parent(parent, path=module_path)
    return found


def _has_tests(file: Path, parent: pytest.Collector) -> bool:
    """Whether pytest would find Python tests in the file."""
    named = any(fnmatch.fnmatch(file.name, p) for p in parent.config.getini("python_files"))
    return named and _TESTS.search(file.read_bytes()) is not None


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """What a variant took is its own time, without that of its worker's start."""
    report = yield
    if call.when == "call" and isinstance(item, CaseItem) and item.record is not None:
        report.duration = item.record.seconds or report.duration
    return report


class _ShortInterrupts:
    """Has pytest look at the last frame of an interrupt, the only one that it shows, and not parse
    the sources of all, which takes a second."""

    @pytest.hookimpl(tryfirst=True)
    def pytest_keyboard_interrupt(self, excinfo: pytest.ExceptionInfo[BaseException]) -> None:
        excinfo.traceback = excinfo.traceback[-1:]


def pytest_unconfigure(config: pytest.Config) -> None:
    """End the workers, whatever they are doing."""
    executor = config.stash.get(_EXECUTOR, None)
    if executor is not None:
        executor.close()
        del config.stash[_EXECUTOR]


class Recorder:
    """Makes a record of each test that calls GLSL functions, or of `every` test; `take` gets the
    report of a test's call, and its record."""

    def __init__(
        self, take: Callable[[pytest.TestReport, Record], None], every: bool = False
    ) -> None:
        self._take = take
        self._every = every

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, Any, Any]:
        from shaderlab.functions.evaluation import keeping
        from shaderlab.functions.library import NOTES, Notes

        with keeping(NOTES, Notes()) as notes:
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
        from shaderlab.functions.library import record_of_test

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
    """Gathers records, in the process that ends the session, and writes the page."""

    def __init__(self, folder: Path, about: Callable[[], Mapping[str, str]]) -> None:
        self._folder = folder
        self._about = about
        self._records: list[Record] = []
        self._started = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
        self._clock = time.perf_counter()
        self._message = ""

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        data = getattr(report, RECORD_ATTRIBUTE, None)
        if data is not None:
            from shaderlab.model.records import Record
            from shaderlab.model.store import parse

            self._records.append(parse(data, Record))

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self) -> None:
        from shaderlab.engine.jobs import package_versions
        from shaderlab.model import store
        from shaderlab.model.records import Run
        from shaderlab.report import html

        if not self._records:
            self._message = "no test of cases or of GLSL functions: no report is written"
            return
        run = Run(
            driver=self._about(),
            versions=package_versions(),
            started=self._started,
            seconds=time.perf_counter() - self._clock,
            records=tuple(self._records),
        )
        try:
            store.save(run, self._folder)
            self._message = f"report: {display_path(html.write(run, self._folder))}"
        except ShaderlabError as error:
            self._message = f"shaderlab: {error}"

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        terminalreporter.write_line(self._message)


def attach_record(report: pytest.TestReport, record: Record) -> None:
    from shaderlab.model.store import to_plain

    setattr(report, RECORD_ATTRIBUTE, to_plain(record))


def _why(report: pytest.TestReport) -> str:
    if report.passed:
        return ""
    if report.skipped and isinstance(report.longrepr, tuple):
        return str(report.longrepr[2]).removeprefix("Skipped: ")
    return report.longreprtext
