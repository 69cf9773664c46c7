"""Running a file of tests in a worker: pytest is called in the process, which keeps its device."""

from __future__ import annotations

import importlib
import importlib.util
import io
import linecache
import os
import sys
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager, redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shaderlab.engine.discovery import is_own
from shaderlab.errors import ShaderError, extra
from shaderlab.functions.evaluation import use_worker
from shaderlab.functions.library import Loads, record_loads

if TYPE_CHECKING:
    import pytest

    from shaderlab.model.records import Record
    from shaderlab.workers.lab_worker import LabWorker

_PROFILE = "shaderlab-in-worker"


@dataclass(frozen=True)
class TestFileResult:
    """What running a file of tests gave.

    Attributes:
        records: one for each test, in their order; one, in error, where none could be collected.
        loads: the GLSL that was loaded, and the functions of it that were asked for.
        refused: whether some GLSL did not compile.
    """

    __test__ = False  # pytest takes it for no test

    records: tuple[Record, ...]
    loads: Loads
    refused: bool


@dataclass(frozen=True)
class RunTestFile:
    """Asks for the result of a file's tests.

    Attributes:
        file: with the tests.
        texts: what to take in place of GLSL that is loaded, by its text with includes expanded.
        only: the names of the only tests to run; all of them if empty.
        alike: whether properties try the same samples each time, and leave no trace in Hypothesis'
            database.
    """

    __test__ = False

    file: Path
    texts: Mapping[str, str] = field(default_factory=dict)
    only: frozenset[str] = frozenset()
    alike: bool = False

    def perform(self, worker: LabWorker) -> TestFileResult:
        """See `shaderlab.workers.jobs.Request`. Raises UsageError: pytest is not installed."""
        with extra("pytest", "running tests of functions"):
            import pytest

        linecache.checkcache()
        importlib.invalidate_caches()
        with ExitStack() as stack:
            stack.enter_context(_forgotten())
            stack.enter_context(use_worker(worker))
            loads = stack.enter_context(record_loads(self.texts))
            session = _Session(worker, self.file, self.only)
            stack.enter_context(redirect_stdout(io.StringIO()))
            pytest.main(self._arguments(), plugins=session.plugins())
        return TestFileResult(tuple(session.records), loads, session.refused)

    def _arguments(self) -> list[str]:
        words = [str(self.file), "-q", "--color=no", "-p", "no:cacheprovider"]
        words += ["--shaderlab-report=", "-p", "no:unraisableexception"]  # which collects garbage
        if importlib.util.find_spec("xdist") is not None:
            words += ["-n", "0"]
        if self.alike and importlib.util.find_spec("hypothesis") is not None:
            import hypothesis

            hypothesis.settings.register_profile(_PROFILE, database=None, derandomize=True)
            words.append(f"--hypothesis-profile={_PROFILE}")
        return words


class _Session:
    """One session of pytest: what it collects, what it finds, and how far it is."""

    def __init__(self, worker: LabWorker, file: Path, only: Collection[str]) -> None:
        self._worker = worker
        self._file = file
        self._only = only
        self.records: list[Record] = []
        self.refused = False

    def plugins(self) -> list[object]:
        """What pytest is called with."""
        from shaderlab.pytest_plugin.report import Recorder

        return [self, Recorder(lambda _, record: self.records.append(record), every=True)]

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Keep Python's tests: variants of cases have records of their own."""
        items[:] = [
            item
            for item in items
            if hasattr(item, "function") and (not self._only or item.name in self._only)
        ]

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """Each test has the time of a variant."""
        self._worker.note(nodeid)
        self._worker.restart_limit()

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """A file that can't be imported is a record in error."""
        if report.failed:
            from shaderlab.functions.records import record_of_test

            self.records.append(
                record_of_test(
                    str(self._file), "collection", 1, status="error", message=report.longreprtext
                )
            )

    def pytest_exception_interact(self, call: pytest.CallInfo[Any]) -> None:
        """Note whether a compiler is to blame."""
        if call.excinfo is not None and isinstance(call.excinfo.value, ShaderError):
            self.refused = True


@contextmanager
def _forgotten() -> Iterator[None]:
    """Modules of a project that the block imports are imported anew by the next one: they may have
    loaded GLSL that has changed."""
    before = set(sys.modules)
    try:
        yield
    finally:
        for name in set(sys.modules) - before:
            file = getattr(sys.modules[name], "__file__", None)
            if file and is_own(Path(os.path.abspath(file))):
                del sys.modules[name]
