"""Watching: files that are saved, what depends on them, and judging that again by warm workers."""

from __future__ import annotations

import contextlib
import importlib.util
import math
import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shaderlab.engine.catalogue import imported_files, is_project_file
from shaderlab.engine.jobs import (
    CaseInfo,
    Executor,
    Job,
    RunJob,
    format_error,
    make_failed_record,
)
from shaderlab.errors import CaseError, ShaderlabError, require_extra
from shaderlab.files import read_regular
from shaderlab.functions.evaluation import use_worker
from shaderlab.functions.library import load, record_of_test
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record, Status
from shaderlab.mutation.function_tests import RunTestFile
from shaderlab.workers.pool import ItemResult

if TYPE_CHECKING:
    from shaderlab.engine.jobs import Executor
    from shaderlab.engine.worker import Worker
    from shaderlab.model.records import Record


_STEP = 15
"""Milliseconds without another event that end a moment: an editor's save is several events."""
_LONGEST = 200
_MISSING = 0.15
"""Seconds that a file may be missing: some editors remove it and write it anew."""
_CLOCK_TICK = 0.02
"""Seconds by which a file's time may lag behind the clock."""


class Changes:
    """Watches folders, in a thread; a context manager.

    Args:
        folders: with everything below them, but for what tools write (.git, __pycache__, …).

    Raises:
        UsageError: the extra "watch" is not installed.
    """

    def __init__(self, folders: Iterable[Path]) -> None:
        with require_extra("watch", "shaderlab watch"):
            import watchfiles
        self._watch = watchfiles.watch
        self._filter = watchfiles.DefaultFilter()
        self._batches: queue.SimpleQueue[set[Path]] = queue.SimpleQueue()
        self._stop = threading.Event()
        self._threads: list[threading.Thread] = []
        self._folders: set[Path] = set()
        self.add(folders)

    def __enter__(self) -> Changes:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        for thread in self._threads:
            thread.join(2.0)

    def add(self, folders: Iterable[Path], *, below: bool = True) -> None:
        """Watch further folders, unless they lie in those that are watched; with `below` also
        everything below them."""
        for folder in sorted(set(folders)):
            known = any(folder.is_relative_to(one) for one in self._folders)
            if known or not folder.is_dir():
                continue
            if below:
                self._folders.add(folder)
            ready = threading.Event()
            thread = threading.Thread(target=self._serve, args=[folder, ready, below], daemon=True)
            self._threads.append(thread)
            thread.start()
            ready.wait(5.0)

    def next(self, timeout: float | None = None) -> set[Path]:
        """The files of the next moment, and of all that have passed; none after the time."""
        try:
            found = self._batches.get(timeout=timeout)
        except queue.Empty:
            return set()
        while not self._batches.empty():
            found |= self._batches.get()
        return found

    def pending(self) -> bool:
        """Whether something has changed that `next` has not given yet."""
        return not self._batches.empty()

    def settled(self, found: set[Path], known: Collection[Path]) -> set[Path]:
        """The files, and those that change while one that is known is missing for a moment."""
        until = time.monotonic() + _MISSING
        while any(path in known and not path.exists() for path in found):
            rest = until - time.monotonic()
            if rest <= 0:
                break
            found = found | self.next(rest)
        return found

    def _serve(self, folder: Path, ready: threading.Event, below: bool) -> None:
        moments = self._watch(
            folder,
            watch_filter=self._filter,
            debounce=_LONGEST,
            step=_STEP,
            rust_timeout=200,
            yield_on_timeout=True,
            stop_event=self._stop,
            recursive=below,
            raise_interrupt=False,
        )
        ready.set()
        for moment in moments:
            if moment:
                self._batches.put({Path(name) for _, name in moment})


class Contents:
    """What is in files, so that one that was only touched is no change."""

    def __init__(self) -> None:
        self._known: dict[Path, bytes] = {}

    def learn(self, files: Iterable[Path], since: float = math.inf) -> None:
        """Take files that are not known yet as they are now, but for those that were written after
        `since` (seconds as of `time.time`): who read them may have read something else."""
        for path in files:
            if path not in self._known and _modification_time(path) < since - _CLOCK_TICK:
                self._known[path] = _digest(path)

    def changed(self, files: Iterable[Path]) -> set[Path]:
        """Of these files, those that are not known, or have other contents; known as they are
        now from then on."""
        found = set()
        for path in files:
            digest = _digest(path)
            if self._known.get(path) != digest:
                self._known[path] = digest
                found.add(path)
        return found


def _modification_time(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def _digest(path: Path) -> bytes:
    try:
        return blake2b(read_regular(path), digest_size=16).digest()
    except OSError:
        return b""


@dataclass(frozen=True)
class WarmUp:
    """Asks for a call and its judgement, so that what the first of them takes is done before."""

    def perform(self, worker: Worker) -> None:
        with use_worker(worker):
            same = load("float same(float x) { return x; }").same
            same.check(lambda x: x, [1.0, 2.0])


def warm_up(executor: Executor) -> None:
    """Have an executor's worker get ready, in the background."""

    def perform() -> None:
        with contextlib.suppress(ShaderlabError):  # the next request reports it
            list(executor.perform([WarmUp()]))

    threading.Thread(target=perform, daemon=True).start()


@dataclass(frozen=True)
class LoadWatched:
    """Asks for a file's `CaseInfo`, or why there are none, and the files that it reads."""

    file: Path

    def perform(self, worker: Worker) -> tuple[CaseInfo | CaseError, set[Path]]:
        with _files(worker) as files:
            try:
                found: CaseInfo | CaseError = worker.facts(self.file)
            except CaseError as error:
                found = error
        return found, files


@dataclass(frozen=True)
class RunWatched:
    """Asks for a job's `Record`, of its shaders as they are now, and the files that it reads."""

    job: Job
    options: RunOptions

    def perform(self, worker: Worker) -> tuple[Record, set[Path]]:
        """See `shaderlab.engine.jobs.Request`. Raises CaseError."""
        worker.lab(self.options).forget_shaders()
        with _files(worker) as files:
            record = RunJob(self.job, self.options).perform(worker)
        return record, files


@dataclass(frozen=True)
class RunWatchedTests:
    """Asks for the records of a file's tests of GLSL functions, and the files that they read."""

    file: Path

    def perform(self, worker: Worker) -> tuple[Sequence[Record], set[Path]]:
        """See `shaderlab.engine.jobs.Request`. Raises UsageError: pytest is not installed."""
        with _files(worker) as files:
            result = RunTestFile(self.file).perform(worker)
        return result.records, files


@contextmanager
def _files(worker: Worker) -> Iterator[set[Path]]:
    opened: OpenedFiles = worker.keep("opened files", None, OpenedFiles)
    with opened.noted() as files:
        yield files


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


Select = Callable[[Sequence[CaseInfo]], Sequence[Job]]


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
    """Judges case files, and again those that depend on a file.

    A worker that has read a Python module keeps it. So where one changes, the next worker
    takes over, which waits with its device open and has read none.

    Args:
        start: starts an executor.
        select: the jobs of case files, in order.
        options: how scenes are run.
        warm: has an executor get ready that waits, without waiting for it.
    """

    def __init__(
        self,
        start: Callable[[], Executor],
        select: Select,
        options: RunOptions,
        warm: Callable[[Executor], None] = lambda executor: None,
    ) -> None:
        self._start = start
        self._warm = warm
        self._select = select
        self._options = options
        self._executor = start()
        self._spare: Executor | None = None
        self._retired: list[Executor] = []
        self._stale = False
        self._unfinished: set[Path] = set()
        self._watched: dict[Path, Watched] = {}

    def close(self) -> None:
        """End the workers."""
        for executor in (self._executor, self._spare, *self._retired):
            if executor is not None:
                executor.close()

    @property
    def records(self) -> list[Record]:
        """The latest record of each variant and of each test, in order."""
        found = []
        for watched in self._watched.values():
            names = [job.variant for job in watched.jobs] or list(watched.records)
            found += [watched.records[name] for name in names if name in watched.records]
        return found

    @property
    def files(self) -> set[Path]:
        """All files that a verdict depends on."""
        return set().union(*(watched.files for watched in self._watched.values()))

    def follow(self, case_files: Iterable[Path], test_files: Iterable[Path] = ()) -> set[Path]:
        """Watch these files and no others; returns those that are new."""
        wanted = {**dict.fromkeys(case_files, False), **dict.fromkeys(test_files, True)}
        new = {file for file in wanted if file not in self._watched}
        self._watched = {
            file: self._watched.get(file) or Watched(file, tests, files={file})
            for file, tests in wanted.items()
        }
        return new

    def affected(self, changed: Collection[Path]) -> set[Path]:
        """The case files that depend on one of these files, those without a verdict, and those that
        `judge` did not come to."""
        if any(path.suffix == ".py" for path in changed if path in self.files):
            self._stale = True
        found = self._unfinished & set(self._watched)
        for file, watched in self._watched.items():
            touched = watched.files & set(changed)
            if any(path.suffix == ".py" for path in touched):
                watched.facts = None
            if touched or watched.undecided:
                found.add(file)
        return found

    def judge(
        self, case_files: Collection[Path], interrupted: Callable[[], bool] = lambda: False
    ) -> Iterator[Record]:
        """Judge these files, what failed first: the records of variants and of tests.

        Args:
            case_files: some of those that are followed.
            interrupted: whether to begin no more jobs.
        """
        self._take_over()
        chosen = [watched for file, watched in self._watched.items() if file in case_files]
        self._load([w for w in chosen if w.facts is None and not w.tests])
        jobs = [job for watched, job in self._in_order() if watched.file in case_files]
        jobs.sort(key=self._has_passed)
        self._unfinished = {watched.file for watched in chosen}
        for job in (job for job in jobs if job.broken):
            yield self._keep(job, make_failed_record(job, job.broken, job.trouble), set())
        requests: list[RunWatched | RunWatchedTests] = [
            *(RunWatched(job, self._options) for job in jobs if not job.broken),
            *(RunWatchedTests(watched.file) for watched in chosen if watched.tests),
        ]
        waiting = len(requests)
        with contextlib.closing(self._executor.perform(requests)) as results:
            for result in results:
                if isinstance(result.item, RunWatchedTests):
                    yield from self._tested(result)
                else:
                    yield self._ran(result)
                waiting -= 1
                if waiting and interrupted():
                    break
            else:
                self._unfinished = set()
        self.prepare()

    def _ran(self, result: ItemResult) -> Record:
        if result.status != "done":
            return self._keep(result.item.job, self._executor.record_of(result), set())
        record, files = result.value
        return self._keep(result.item.job, record, files)

    def _tested(self, result: ItemResult) -> Iterator[Record]:
        watched = self._watched[result.item.file]
        if result.status == "done":
            records, files = result.value
            watched.files |= files
        else:
            status: Status = "timeout" if result.status == "timeout" else "crash"
            records = [
                record_of_test(
                    str(watched.file),
                    result.step.rpartition("::")[2] or "all tests",
                    1,
                    status="error" if result.status == "error" else status,
                    message=format_error(result),
                )
            ]
        watched.records = {record.variant: record for record in records}
        yield from records

    def prepare(self) -> None:
        """Have the next worker get ready, and end those that know too much."""
        while self._retired:
            self._retired.pop().close()
        if self._spare is None:
            self._spare = self._start()
            self._warm(self._spare)

    def _take_over(self) -> None:
        if not self._stale:
            return
        self._stale = False
        self._retired.append(self._executor)  # ending it takes time that a verdict is waited for
        self._executor = self._spare or self._start()
        self._spare = None

    def _load(self, wanted: Sequence[Watched]) -> None:
        requests = [LoadWatched(watched.file) for watched in wanted]
        for result in self._executor.perform(requests):
            watched = wanted[result.number]
            found: CaseInfo | CaseError = CaseError(result.message)
            files: set[Path] = set()
            if result.status == "done":
                found, files = result.value
            elif result.status == "error":
                found = CaseError(str(result.value))
            if isinstance(found, CaseError):
                status = "error" if result.status == "done" else result.status
                case_id = watched.file.stem.replace("_", "-")
                found = CaseInfo(file=str(watched.file), id=case_id, error=found, status=status)
            watched.facts = found
            own = {path for path in imported_files(watched.file) if is_project_file(path)}
            watched.files |= {watched.file, *files, *own}
        if wanted:
            facts = [w.facts for w in self._watched.values() if w.facts is not None]
            by_file: dict[str, list[Job]] = {}
            for job in self._select(facts):
                by_file.setdefault(job.file, []).append(job)
            for watched in (w for w in self._watched.values() if not w.tests):
                watched.jobs = by_file.get(str(watched.file), [])
                names = {job.variant for job in watched.jobs}
                watched.records = {v: r for v, r in watched.records.items() if v in names}

    def _in_order(self) -> Iterator[tuple[Watched, Job]]:
        for watched in self._watched.values():
            for job in watched.jobs:
                yield watched, job

    def _has_passed(self, job: Job) -> bool:
        record = self._watched[Path(job.file)].records.get(job.variant)
        return record is None or record.status in ("pass", "unsupported")

    def _keep(self, job: Job, record: Record, files: set[Path]) -> Record:
        watched = self._watched[Path(job.file)]
        watched.records[job.variant] = record
        watched.files |= files
        return record
