"""Several workers side by side: items in, one outcome for each out, in the items' order."""

from __future__ import annotations

import functools
import itertools
import queue
from collections import deque
from collections.abc import Callable, Generator, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from shaderlab.workers.process import DiedError, Limits, Process, environment

BATCH = 32
"""Items sent at once: enough that sending costs little, few enough that progress is seen."""


@dataclass(frozen=True)
class Outcome:
    """What became of one item.

    Attributes:
        item: the item itself.
        status: "done"; "crash" or "timeout" where the worker died on it; "error" where the work
            raised an exception.
        result: what the work gave, the exception where it raised one, else None.
        message: how the worker died.
    """

    item: Any
    status: Literal["done", "crash", "timeout", "error"]
    result: Any = None
    message: str = ""


class Pool:
    """Workers that share the items of `each`. Use it in a `with` statement.

    All of them, those too that take the place of others later on, start in the environment and the
    working directory that this process has now: what changes there meanwhile sets none apart.

    Args:
        work: the function to call, as "module:function", since workers import it by its name.
            It takes a sequence of items and gives one result for each, in order.
        limits: of each item.
        jobs: how many workers, to begin with; `widen` adds others.
        batch: how many items a worker is sent at once.
        folder: the workers' working directory, by default this process's.
        warm: a function, named like `work`, that each worker calls before it imports `work`: it
            sets something going meanwhile, and what it gives back is called when `work` is there.
    """

    def __init__(
        self,
        work: str,
        *,
        limits: Limits | None = None,
        jobs: int = 1,
        batch: int = BATCH,
        folder: Path | None = None,
        warm: str = "",
    ) -> None:
        limits = limits or Limits()
        folder = folder or Path.cwd()
        self._make = functools.partial(Process, work, limits, folder, environment(), warm)
        self._processes: list[Process] = []
        # Whoever worked last works next: one that was never needed is never started.
        self._idle: queue.LifoQueue[Process] = queue.LifoQueue()
        self._threads: list[ThreadPoolExecutor] = []
        self.widen(max(jobs, 1))
        self._batch = max(batch, 1)
        self._closed = False

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all workers, whatever they are doing."""
        self._closed = True
        for process in self._processes:
            process.close()
        for threads in self._threads:
            threads.shutdown(wait=True, cancel_futures=True)
        for process in self._processes:
            process.close()  # one that a thread started in the meantime

    def start(self) -> None:
        """Start the first worker now, and not with the first items; it is not waited for.

        Call it before `each`.
        """
        self._processes[0].launch()

    def widen(self, jobs: int) -> None:
        """Let there be this many workers if there are fewer."""
        added = [self._make() for _ in range(jobs - len(self._processes))]
        if not added:
            return
        self._processes += added
        for process in reversed(added):
            self._idle.put(process)
        # As many threads as workers: with more, those that wait for a worker would not be served
        # in the order of their items.
        self._threads.append(ThreadPoolExecutor(len(self._processes)))

    def each(
        self,
        items: Iterable[Any],
        heard: Callable[[Outcome], None] | None = None,
        batch: int | None = None,
    ) -> Generator[Outcome]:
        """Each item's outcome, in order. Only a few batches are taken from `items` ahead of what
        was asked for, so memory does not grow with their number. Close it before its end, and what
        no worker has begun is not begun.

        Args:
            items: what to work on.
            heard: called with each outcome as soon as it is there, in whatever order, from the
                thread that got it.
            batch: how many of these items a worker is sent at once, by default as of all others.

        Raises:
            ShaderlabError: no worker can be started at all.
        """
        size = max(batch or self._batch, 1)
        waiting: deque[Future[list[Outcome]]] = deque()
        rest = iter(items)
        ahead = max(len(self._processes) + 1, BATCH // size)
        try:
            for some in iter(lambda: list(itertools.islice(rest, size)), []):
                waiting.append(self._threads[-1].submit(self._run, some, heard))
                if len(waiting) > ahead:
                    yield from waiting.popleft().result()
            while waiting:
                yield from waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()

    def _run(
        self, batch: Sequence[Any], heard: Callable[[Outcome], None] | None = None
    ) -> list[Outcome]:
        process = self._idle.get()
        try:
            outcomes: list[Outcome] = []
            if not self._closed:
                process.start()
            while len(outcomes) < len(batch) and not self._closed:
                some = self._some(process, batch[len(outcomes) :])
                outcomes += some
                if heard is not None and not self._closed:
                    for outcome in some:
                        heard(outcome)
            return outcomes
        finally:
            self._idle.put(process)

    def _some(self, process: Process, items: Sequence[Any]) -> list[Outcome]:
        """The outcomes of the items up to the first that went wrong, that one included."""
        outcomes: list[Outcome] = []
        try:
            for kind, value in process.answers(items):
                status: Literal["done", "error"] = "done" if kind == "done" else "error"
                outcomes.append(Outcome(items[len(outcomes)], status, value))
        except DiedError as error:
            item = items[len(outcomes)]
            if error.status == "crash" and not process.fresh and not self._closed:
                # Perhaps an earlier item left the memory in disorder: ask once more, alone.
                outcomes.append(_alone(process, item))
            else:
                outcomes.append(Outcome(item, error.status, None, error.message))
        return outcomes


def _alone(process: Process, item: Any) -> Outcome:
    try:
        kind, value = next(iter(process.answers([item])))
        return Outcome(item, "done" if kind == "done" else "error", value)
    except DiedError as error:
        return Outcome(item, error.status, None, error.message)
