"""Worker processes side by side: items in, results out as they complete.

A crash, a hang or runaway memory costs one item, no more. A worker is a fresh Python: it inherits
no threads, no OpenGL context and no `__main__`.
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

from .process import WorkerDiedError, WorkerProcess, worker_environment

BATCH = 32
"""Items sent at once: enough that sending costs little, few enough that progress is visible."""


@dataclass(frozen=True)
class ItemResult:
    """The result of one item.

    Attributes:
        number: the item's position among those passed to `run`.
        item: the item itself.
        status: "done"; "crash" or "timeout" where the worker died on it; "error" where the work
            raised an exception.
        value: the work's result, the exception where it raised one, else None.
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


_Results = queue.SimpleQueue[ItemResult | BaseException | None]


@dataclass(frozen=True, eq=False)
class _Batch:
    """Items that one worker gets at once, and the queue for their results, which None ends."""

    items: list[tuple[int, Any]]
    key: Hashable
    results: _Results


class _Worker:
    """A process, the thread that feeds it as long as the pool lives, and the key of its last
    batch."""

    def __init__(self, process: WorkerProcess) -> None:
        self.process = process
        self.key: Hashable = None
        self.inbox: queue.SimpleQueue[_Batch | None] = queue.SimpleQueue()
        self.thread: threading.Thread | None = None


class WorkerPool(contextlib.AbstractContextManager["WorkerPool"]):
    """Worker processes that share the items of `run`. A context manager.

    All workers, later replacements included, start in the environment and the working directory
    that this process has now.

    Args:
        work: what workers call, as "module:name", since they import it by its name: a function
            that takes a sequence of items and yields one result for each, in order; or a class
            that makes such a function from a `shaderlab.workers.worker.Channel`, optionally with a
            `preload()` that imports what it will need.
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
            WorkerProcess, work, limits or Limits(), folder or Path.cwd(), worker_environment()
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
            worker.process.close()
            worker.inbox.put(None)
        for worker in self._workers:
            if worker.thread is not None:
                worker.thread.join()
            worker.process.release()

    def start(self) -> None:
        """Start the first worker without waiting for it or for the first items."""
        self._submit(_Batch([], None, queue.SimpleQueue()))

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
        """Yield the items' results as they complete.

        Only a few batches are taken from `items` ahead of the results that were read, so memory
        does not grow with their number. Closing the generator drops what no worker was sent.

        Args:
            items: what to work on.
            batch: how many of these items a worker is sent at once, by default as set for the pool.
            key: a worker prefers items of the key that it had last, then those of a key that no
                other worker has; items of one key should share one batch only.

        Raises:
            ShaderlabError: no worker can be started at all.
        """
        size = max(batch or self._batch, 1)
        results: _Results = queue.SimpleQueue()
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
        """Give the batch to an idle worker or queue it; return False if the pool is closed."""
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
        """Run a worker's thread: one batch after the other, until the pool is closed."""
        batch = worker.inbox.get()
        while batch is not None:
            try:
                for result in self._results(worker.process, batch):
                    batch.results.put(result)
            except BaseException as error:
                if not self._closed:
                    batch.results.put(error)
            with self._lock:
                following = self._take_pending(worker)
                if following is None:
                    self._idle.append(worker)
            batch.results.put(None)
            batch = following or worker.inbox.get()

    def _take_pending(self, worker: _Worker) -> _Batch | None:
        """Take the batch that suits a worker best off the queue."""
        if self._closed or not self._pending:
            return None
        best = self._pending[0]
        if best.key is not None and best.key != worker.key:
            taken = {other.key for other in self._workers if other is not worker}
            mine = (b for b in self._pending if b.key == worker.key and b.key is not None)
            free = (b for b in self._pending if b.key not in taken)
            best = next(mine, None) or next(free, best)
        worker.key = best.key
        self._pending.remove(best)
        return best

    def _results(self, process: WorkerProcess, batch: _Batch) -> Iterator[ItemResult]:
        process.launch()
        rest = deque(batch.items)
        alone = False
        while rest and not self._closed:
            process.start()
            began = time.monotonic()
            try:
                sent = itertools.islice(rest, 1 if alone else None)
                for kind, value in process.answers([item for _, item in sent]):
                    now = time.monotonic()
                    yield ItemResult(*rest.popleft(), kind, value, seconds=now - began)
                    began = now
                alone = False
            except WorkerDiedError as error:
                # Perhaps an earlier item left the memory in disorder: try once more, alone.
                alone = error.status == "crash" and not error.fresh and not self._closed
                if not alone:
                    seconds = time.monotonic() - began
                    number, item = rest.popleft()
                    yield ItemResult(
                        number, item, error.status, None, error.message, error.step, seconds
                    )
