"""Worker processes side by side: items in, results out as they complete.

A crash, a hang or runaway memory costs one item, no more. A worker is forked from a fork server and
not from this process: it inherits no threads, no OpenGL context and no `__main__`.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Hashable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from shaderlab.model.options import Limits

from .worker_process import DiedError, WorkerProcess, environment

BATCH = 32
"""Items sent at once: enough that sending costs little, few enough that progress is seen."""
QUICK, IN_A_ROW, TOGETHER = 0.02, 8, 4
"""A worker that took at most `QUICK` seconds for each of `IN_A_ROW` items gets `TOGETHER` at once
while it stays so: between two batches it waits for this process, which may be busy."""


@dataclass(frozen=True)
class ItemResult:
    """The result of one item.

    Attributes:
        number: the item's place among those that were given.
        item: the item itself.
        status: "done"; "crash" or "timeout" where the worker died on it; "error" where the work
            raised an exception.
        value: what the work gave, the exception where it raised one, else None.
        message: how the worker died.
        step: the last step that the work noted before the worker died.
        seconds: the time from the result before it, or from when the item was sent.
    """

    number: int
    item: Any
    status: Literal["done", "crash", "timeout", "error"]
    value: Any = None
    message: str = ""
    step: str = ""
    seconds: float = 0.0


@dataclass(frozen=True, eq=False)
class _Batch:
    """Items that one worker gets at once, and the queue for their results; None ends a batch, and
    several of them one that is made of so many, `count`."""

    items: list[tuple[int, Any]]
    key: Hashable
    results: queue.SimpleQueue[ItemResult | BaseException | None]
    count: int = 1


class _Worker:
    """A process, the thread that feeds it, the key of its last batch, and how many items in a row
    were quick.

    The thread lives as long as the pool.
    """

    def __init__(self, process: WorkerProcess) -> None:
        self.process = process
        self.key: Hashable = None
        self.quick = 0
        self.inbox: queue.SimpleQueue[_Batch | None] = queue.SimpleQueue()
        self.thread: threading.Thread | None = None


class WorkerPool(contextlib.AbstractContextManager["WorkerPool"]):
    """Worker processes that share the items of `run`. A context manager.

    All workers, later replacements included, start in the environment and the working directory
    that this process has now.

    Args:
        work: what workers call, as "module:name", since they import it by its name: a function
            that takes a sequence of items and yields one result for each, in order; or a class
            that makes such a function from a `shaderlab.workers.worker_main.Channel`, with a
            `preload()` perhaps that imports what it will need.
        limits: of each item.
        jobs: how many workers, to begin with; `widen` adds others.
        batch: how many items a worker is sent at once.
        folder: the workers' working directory, by default this process's.
    """

    def __init__(
        self,
        work: str,
        *,
        limits: Limits | None = None,
        jobs: int = 1,
        batch: int = BATCH,
        folder: Path | None = None,
    ) -> None:
        self._make = functools.partial(
            WorkerProcess, work, limits or Limits(), folder or Path.cwd(), environment()
        )
        self._batch = max(batch, 1)
        self._lock = threading.Lock()  # for all below
        self._closed = False
        self._workers: list[_Worker] = []
        self._idle: list[_Worker] = []  # a stack: what is never needed is never started
        self._pending: deque[_Batch] = deque()
        self.widen(max(jobs, 1))

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all workers, whatever they are doing."""
        with self._lock:
            self._closed = True
            while self._pending:
                self._pending.popleft().results.put(None)
        for worker in self._workers:
            worker.process.kill()
            worker.inbox.put(None)
        for worker in self._workers:
            while worker.thread is not None and worker.thread.is_alive():
                worker.process.kill()  # one that the thread has started in the meantime
                worker.thread.join(0.05)
            worker.process.close()

    def start(self) -> None:
        """Start the first worker without waiting for it or for the first items."""
        self._idle[-1].process.launch()

    def widen(self, jobs: int) -> None:
        """Grow the pool to at least `jobs` workers."""
        with self._lock:
            added = [_Worker(self._make()) for _ in range(jobs - len(self._workers))]
            self._workers += added
            self._idle[:0] = reversed(added)

    def run(
        self,
        items: Iterable[Any],
        batch: int | None = None,
        key: Callable[[Any], Hashable] | None = None,
    ) -> Generator[ItemResult]:
        """The items' results as they complete.

        Only a few batches are taken from `items` ahead of the results that were read, so memory
        does not grow with their number. Closing the generator drops what no worker was sent.

        Args:
            items: what to work on.
            batch: how many of these items a worker is sent at once, by default as of all others.
            key: a worker prefers items of the key that it had last, then those of a key that no
                other worker has; items of one key should share one batch only.

        Raises:
            ShaderlabError: no worker can be started at all.
        """
        size = max(batch or self._batch, 1)
        results: queue.SimpleQueue[ItemResult | BaseException | None] = queue.SimpleQueue()
        numbered = enumerate(items)
        batches = (
            _Batch(some, key(some[0][1]) if key is not None else None, results)
            for some in iter(lambda: list(itertools.islice(numbered, size)), [])
        )
        try:
            ahead = max(len(self._workers) + 1, BATCH // size)
            unfinished = sum(map(self._submit, itertools.islice(batches, ahead)))
            while unfinished:
                result = results.get()
                if result is None:
                    unfinished += sum(map(self._submit, itertools.islice(batches, 1))) - 1
                elif isinstance(result, BaseException):
                    raise result
                else:
                    yield result
        finally:
            with self._lock:
                self._pending = deque(b for b in self._pending if b.results is not results)

    def _submit(self, batch: _Batch) -> bool:
        """Give the batch to an idle worker or let it wait. False if the pool is closed."""
        with self._lock:
            if self._closed:
                return False
            if not self._idle:
                self._pending.append(batch)
                return True
            same = [w for w in self._idle if w.key == batch.key]
            worker = same[-1] if same and batch.key is not None else self._idle[-1]
            self._idle.remove(worker)
            worker.key = batch.key
            worker.inbox.put(batch)
            if worker.thread is None:
                worker.thread = threading.Thread(target=self._serve, args=[worker], daemon=True)
                worker.thread.start()
        return True

    def _serve(self, worker: _Worker) -> None:
        """A worker's thread: one batch after the other, until the pool is closed."""
        batch = worker.inbox.get()
        while batch is not None:
            began = time.monotonic()
            try:
                for result in self._results(worker.process, batch):
                    batch.results.put(result)
            except BaseException as error:
                if not self._closed:
                    batch.results.put(error)
            quick = time.monotonic() - began <= QUICK * len(batch.items)
            worker.quick = worker.quick + len(batch.items) if quick else 0
            with self._lock:
                following = self._next(worker)
                if following is None:
                    self._idle.append(worker)
            for _ in range(batch.count):
                batch.results.put(None)
            batch = following or worker.inbox.get()

    def _next(self, worker: _Worker) -> _Batch | None:
        """The waiting batch that suits a worker best, taken off the queue; for a quick one with
        others like it, if several wait for each worker."""
        if self._closed or not self._pending:
            return None
        best = self._pending[0]
        if best.key is not None and best.key != worker.key:
            taken = {other.key for other in self._workers if other is not worker}
            mine = (b for b in self._pending if b.key == worker.key and b.key is not None)
            free = (b for b in self._pending if b.key not in taken)
            best = next(mine, None) or next(free, best)
        worker.key = best.key
        like = (b for b in self._pending if b.key == best.key and b.results is best.results)
        most = TOGETHER // len(best.items) if worker.quick >= IN_A_ROW else 1
        share = min(len(self._pending) // len(self._workers), most)
        some = list(itertools.islice(like, max(share, 1)))
        for batch in some:
            self._pending.remove(batch)
        items = [item for batch in some for item in batch.items]
        return _Batch(items, best.key, best.results, len(some))

    def _results(self, worker: WorkerProcess, batch: _Batch) -> Iterator[ItemResult]:
        rest = deque(batch.items)
        alone = False
        while rest and not self._closed:
            worker.start()
            began = time.monotonic()
            try:
                sent = itertools.islice(rest, 1 if alone else None)
                for kind, value in worker.answers([item for _, item in sent]):
                    now = time.monotonic()
                    yield ItemResult(*rest.popleft(), kind, value, seconds=now - began)
                    began = now
                alone = False
            except DiedError as error:
                # Perhaps an earlier item left the memory in disorder: ask once more, alone.
                alone = error.status == "crash" and not error.fresh and not self._closed
                if not alone:
                    seconds = time.monotonic() - began
                    number, item = rest.popleft()
                    yield ItemResult(
                        number, item, error.status, None, error.message, error.step, seconds
                    )
