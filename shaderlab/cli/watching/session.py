"""A session of watching: what is judged, what it depends on, and what a saved file asks for."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from shaderlab.engine.discovery import imported_files, is_own
from shaderlab.errors import CaseError
from shaderlab.functions.records import record_of_test
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record, Status
from shaderlab.workers.executor import LocalExecutor, error_text
from shaderlab.workers.jobs import CaseFacts, Job, failed_record
from shaderlab.workers.pool import ItemResult

from .requests import LoadWatched, RunWatched, RunWatchedTests

Select = Callable[[Sequence[CaseFacts]], Sequence[Job]]


@dataclass
class Watched:
    """One case file: its variants' jobs and records, and the files that these depend on; or a file
    with tests of GLSL functions, which has no jobs, but a record for each test."""

    file: Path
    tests: bool = False
    facts: CaseFacts | None = None
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
        start: Callable[[], LocalExecutor],
        select: Select,
        options: RunOptions,
        warm: Callable[[LocalExecutor], None] = lambda executor: None,
    ) -> None:
        self._start = start
        self._warm = warm
        self._select = select
        self._options = options
        self._executor = start()
        self._spare: LocalExecutor | None = None
        self._retired: list[LocalExecutor] = []
        self._stale = False
        self._unfinished: set[Path] = set()
        self._watched: dict[Path, Watched] = {}

    def close(self) -> None:
        """End the workers."""
        for executor in (self._executor, self._spare, *self._retired):
            if executor is not None:
                executor.close()

    @property
    def executor(self) -> LocalExecutor:
        """What runs the jobs now."""
        return self._executor

    @property
    def records(self) -> list[Record]:
        """The latest record of each variant and of each test, in order."""
        found = []
        for watched in self._watched.values():
            names = [job.variant for job in watched.jobs] or list(watched.records)
            found += [watched.records[name] for name in names if name in watched.records]
        return found

    @property
    def jobs(self) -> list[Job]:
        """All jobs, in order."""
        return [job for _, job in self._in_order()]

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
        jobs.sort(key=self._passed)
        self._unfinished = {watched.file for watched in chosen}
        for job in (job for job in jobs if job.broken):
            yield self._keep(job, failed_record(job, job.broken, job.trouble), set())
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
                    message=error_text(result),
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
            found: CaseFacts | CaseError = CaseError(result.message)
            files: set[Path] = set()
            if result.status == "done":
                found, files = result.value
            elif result.status == "error":
                found = CaseError(str(result.value))
            if isinstance(found, CaseError):
                status = "error" if result.status == "done" else result.status
                case_id = watched.file.stem.replace("_", "-")
                found = CaseFacts(file=str(watched.file), id=case_id, error=found, status=status)
            watched.facts = found
            own = {path for path in imported_files(watched.file) if is_own(path)}
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

    def _passed(self, job: Job) -> bool:
        record = self._watched[Path(job.file)].records.get(job.variant)
        return record is None or record.status in ("pass", "unsupported")

    def _keep(self, job: Job, record: Record, files: set[Path]) -> Record:
        watched = self._watched[Path(job.file)]
        watched.records[job.variant] = record
        watched.files |= files
        return record
