"""What `shaderlab watch` judges: case files and files of tests, the files that these depend on, and
their latest records. What runs in workers is at the end."""

import contextlib
import importlib.util
import os
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from shaderlab.engine.catalogue import find_imported_files, is_project_file
from shaderlab.engine.jobs import (
    CaseInfo,
    Executor,
    Job,
    LoadCase,
    RunJob,
    format_error,
    make_case_info,
    make_failed_record,
)
from shaderlab.engine.worker import Worker
from shaderlab.functions.library import record_of_test
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record
from shaderlab.mutation.function_tests import RunTestFile
from shaderlab.workers.pool import ItemResult


@dataclass
class Watched:
    """One case file: its variants' jobs and records, and the files that these depend on; or a file
    with tests of GLSL functions, which has no jobs, but a record for each test."""

    file: Path
    tests: bool = False
    facts: CaseInfo | None = None
    jobs: Sequence[Job] = ()
    files: set[Path] = field(default_factory=set)
    records: dict[str, Record] = field(default_factory=dict)

    @property
    def undecided(self) -> bool:
        """Whether it came to no verdict: a file that was missing may be there now."""
        return any(record.status in ("error", "crash") for record in self.records.values())


class Session:
    """Judges case files, and again those that depend on a file; `select` gives the files' jobs."""

    def __init__(
        self,
        start: Callable[[], Executor],
        select: Callable[[Sequence[CaseInfo]], Sequence[Job]],
        options: RunOptions,
    ) -> None:
        self._start = start
        self._select = select
        self._options = options
        self._executor = start()
        self._stale = False
        self._unfinished: set[Path] = set()
        self._watched: dict[Path, Watched] = {}

    def close(self) -> None:
        self._executor.close()

    @property
    def files(self) -> set[Path]:
        """All files that a verdict depends on."""
        return set().union(*(watched.files for watched in self._watched.values()))

    def follow(self, case_files: Iterable[Path], test_files: Iterable[Path] = ()) -> set[Path]:
        """Watch these files and no others; return those that are new."""
        wanted = {**dict.fromkeys(case_files, False), **dict.fromkeys(test_files, True)}
        new = {file for file in wanted if file not in self._watched}
        self._watched = {
            file: self._watched.get(file) or Watched(file, tests, files={file})
            for file, tests in wanted.items()
        }
        return new

    def affected(self, changed: Collection[Path]) -> set[Path]:
        """The case files that depend on one of these, have no verdict, or that `judge` left out."""
        found = self._unfinished & set(self._watched)
        for file, watched in self._watched.items():
            touched = watched.files & set(changed)
            if any(path.suffix == ".py" for path in touched):
                watched.facts = None
                self._stale = True
            if touched or watched.undecided:
                found.add(file)
        return found

    def judge(
        self, case_files: Collection[Path], interrupted: Callable[[], bool] = lambda: False
    ) -> Iterator[Record]:
        """Judge these files, what failed first: the records of variants and of tests. No more jobs
        begin once `interrupted` says so."""
        if self._stale:  # a worker that has read a Python module keeps it
            self._executor.close()
            self._executor = self._start()
            self._stale = False
        chosen = [watched for file, watched in self._watched.items() if file in case_files]
        self._load([w for w in chosen if w.facts is None and not w.tests])
        jobs = [job for watched in chosen for job in watched.jobs]
        jobs.sort(key=self._has_passed)
        self._unfinished = {watched.file for watched in chosen}
        for job in (job for job in jobs if job.broken):
            yield self._keep(job, make_failed_record(job, job.broken, job.trouble), set())
        requests: list[RunJob | RunTestFile] = [
            *(RunJob(job, self._options) for job in jobs if not job.broken),
            *(RunTestFile(watched.file) for watched in chosen if watched.tests),
        ]
        waiting = len(requests)
        with contextlib.closing(self._executor.perform(map(WatchedRequest, requests))) as results:
            for result in results:
                yield from self._collect(result)
                waiting -= 1
                if waiting and interrupted():
                    return
        self._unfinished = set()

    def _load(self, wanted: Sequence[Watched]) -> None:
        requests = [WatchedRequest(LoadCase(watched.file)) for watched in wanted]
        for result in self._executor.perform(requests):
            watched, (result, files) = wanted[result.number], _split(result)
            watched.facts = make_case_info(watched.file, result)
            own = {path for path in find_imported_files(watched.file) if is_project_file(path)}
            watched.files |= {watched.file, *files, *own}
        if not wanted:
            return
        by_file: dict[str, list[Job]] = {}
        for job in self._select([w.facts for w in self._watched.values() if w.facts is not None]):
            by_file.setdefault(job.file, []).append(job)
        for watched in (w for w in self._watched.values() if not w.tests):
            watched.jobs = by_file.get(str(watched.file), [])
            names = {job.variant for job in watched.jobs}
            watched.records = {v: r for v, r in watched.records.items() if v in names}

    def _collect(self, result: ItemResult) -> Iterator[Record]:
        """Keep and yield the records of a variant, or of a file's tests."""
        result, files = _split(result)
        if isinstance(result.item, RunJob):
            yield self._keep(result.item.job, self._executor.record_of(result), files)
            return
        watched = self._watched[result.item.file]
        watched.files |= files
        if result.status == "done":
            records: Sequence[Record] = result.value.records
        else:
            name, why = result.step.rpartition("::")[2] or "all tests", format_error(result)
            file, status = str(watched.file), result.status
            records = [record_of_test(file, name, 1, status=status, message=why)]
        watched.records = {record.variant: record for record in records}
        yield from records

    def _has_passed(self, job: Job) -> bool:
        record = self._watched[Path(job.file)].records.get(job.variant)
        return record is None or record.status in ("pass", "unsupported")

    def _keep(self, job: Job, record: Record, files: set[Path]) -> Record:
        watched = self._watched[Path(job.file)]
        watched.records[job.variant] = record
        watched.files |= files
        return record


def _split(result: ItemResult) -> tuple[ItemResult, set[Path]]:
    """The result of the request that was watched, and the files that this read."""
    value, files = result.value if result.status == "done" else (result.value, set())
    return replace(result, item=result.item.request, value=value), files


@dataclass(frozen=True)
class WatchedRequest:
    """Asks for the result of a request, and the files that it reads."""

    request: LoadCase | RunJob | RunTestFile

    def perform(self, worker: Worker) -> tuple[Any, set[Path]]:
        """See `shaderlab.engine.jobs.Request`. Raises what the request does."""
        if isinstance(self.request, RunJob):
            worker.lab(self.request.options).forget_shaders()
        opened: OpenedFiles = worker.keep("opened files", None, OpenedFiles)
        with opened.noted() as files:
            value = self.request.perform(worker)
        return value, files


class OpenedFiles:
    """Notes the files that this process opens for reading, those that are not there too.

    Python can't take an audit hook back: a process has one of these, and keeps it.
    """

    def __init__(self) -> None:
        self._names: set[str] | None = None
        sys.addaudithook(self._note_open)

    @contextmanager
    def noted(self) -> Iterator[set[Path]]:
        """The files of the project that the block reads; filled when it ends."""
        found: set[Path] = set()
        self._names = set()
        try:
            yield found
        finally:
            names, self._names = self._names, None
            found |= {path for path in map(_source, names) if is_project_file(path)}

    def _note_open(self, event: str, arguments: tuple[Any, ...]) -> None:
        if event != "open" or self._names is None:
            return
        name, _, flags = arguments
        if isinstance(name, str | bytes) and flags & os.O_ACCMODE == os.O_RDONLY:
            self._names.add(os.fsdecode(name))


def _source(name: str) -> Path:
    """A file's path; that of the source where Python reads what it has compiled."""
    if name.endswith(".pyc"):
        with contextlib.suppress(ValueError, NotImplementedError):
            name = importlib.util.source_from_cache(name)
    return Path(os.path.abspath(name))
