"""Worker processes side by side: items in, results out as they complete.

A crash, a hang or runaway memory costs one item, no more. A worker is a fresh Python: it inherits
no threads, no OpenGL context and no `__main__`.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import os
import pickle
import queue
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Literal

from shaderlab.errors import ShaderlabError
from shaderlab.files import open_memory_file, sort_search_path
from shaderlab.model.options import Limits

STEP_BYTES = 256
"""The size of the file in which a worker notes its steps."""
START_SECONDS = 120.0
END_SECONDS = 5.0
GROWTH = 256 << 20
"""A worker that holds this many bytes more than after its first batch is replaced by a fresh one
before its next batch: drivers keep a little of every scene."""
# Libraries for matrices and pictures start a thread per core and let all of them wait busily;
# workers share the cores already, and multiply matrices of four rows.
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
_PROGRAM = "from shaderlab.workers.worker import main; main()"


def worker_environment() -> dict[str, str]:
    """Return the environment of a worker: this process's as it is now, with its module path."""
    path = os.pathsep.join(sort_search_path(sys.path))
    return {**_ONE_THREAD, **os.environ, "PYTHONPATH": path}


@dataclass(eq=False)
class WorkerDiedError(Exception):
    """A worker is gone.

    Attributes:
        status: "crash" or "timeout".
        message: how it ended.
        step: the last step that it noted, "" if there was none.
        fresh: whether it had answered nothing yet.
    """

    status: Literal["crash", "timeout"]
    message: str
    step: str
    fresh: bool


class WorkerProcess:
    """A worker that answers batches, as `shaderlab.workers.pool.WorkerPool` says.

    It is started with the first batch, and again with the first one after it died. One thread uses
    it; any thread may call `close`.
    """

    def __init__(
        self, work: str, limits: Limits, folder: Path, environment: Mapping[str, str]
    ) -> None:
        self._work = work
        self._limits = limits
        self._folder = folder
        self._environment = environment
        self._lock = threading.Lock()  # for the three below
        self._closed = False
        self._process: subprocess.Popen[bytes] | None = None
        self._streams: Sequence[Any] = ()
        self._ready = False
        self._fresh = True
        self._memory = 0  # after the first batch

    def answers(self, batch: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
        """Yield an answer for each item, in order, each as soon as it is there.

        Raises:
            WorkerDiedError: it crashed or took too long over the item after the last one answered.
            ShaderlabError: no worker can be started at all.
        """
        if self._has_grown():
            self._end()
        self.start()
        self._send(batch)
        for _ in batch:
            kind, value = self._receive(self._limits.seconds)
            while kind == "limit":
                kind, value = self._receive(value)
            self._fresh = False
            yield kind, value
            if kind == "error":
                break
        if self._process is not None and not self._memory:
            self._memory = _own_memory(self._process.pid)

    def _has_grown(self) -> bool:
        if self._process is None or not self._memory:
            return False
        return _own_memory(self._process.pid) - self._memory > GROWTH

    def launch(self) -> None:
        """Start the process, if there is none, without waiting until it is ready."""
        with self._lock:
            if self._process is not None:
                return
            if self._closed:
                raise ShaderlabError("the pool of workers is closed")
            self._ready, self._fresh, self._memory = False, True, 0
            try:
                self._start_process()
            except OSError as error:
                raise ShaderlabError(
                    f"can't start a worker process: {error.strerror or error}",
                    remedy="see what limits this system has: ulimit -a",
                ) from error
        memory = int(self._limits.gigabytes * (1 << 30))
        self._send((self._work, self._limits.seconds, memory))

    def start(self) -> None:
        """Start the process, if there is none, and wait until it is ready.

        Raises:
            ShaderlabError: none can be started.
        """
        self.launch()
        if self._ready:
            return
        try:
            self._receive(START_SECONDS)
        except WorkerDiedError as error:
            raise ShaderlabError(
                f"can't start a worker process: {error.message}",
                remedy="see that this Python can import shaderlab: run `shaderlab doctor`",
            ) from error
        self._ready = True

    def close(self) -> None:
        """End the process, whatever it is doing, and start no other one."""
        with self._lock:
            self._closed = True
            if self._process is not None:
                _kill_group(self._process)

    def release(self) -> None:
        """Give everything back, once no thread waits for the process."""
        self._end()

    def _start_process(self) -> None:
        self._socket, theirs = socket.socketpair()
        self._answers = self._socket.makefile("rb")
        # Both live as long as the process, and take no space on a disk that may be full.
        self._errors, self._steps = open_memory_file(), open_memory_file()
        self._steps.truncate(STEP_BYTES)
        self._streams = (self._answers, self._socket, self._errors, self._steps)
        inherited = [theirs.fileno(), self._steps.fileno()]
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", _PROGRAM, *map(str, [*inherited, os.getpid()])],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._errors,
                cwd=self._folder,
                env=dict(self._environment),
                pass_fds=inherited,
                process_group=0,  # so that what it starts can be ended with it
            )

    def _end(self) -> int:
        """End the process and close its streams; return its exit status."""
        with self._lock:
            process, self._process = self._process, None
            streams, self._streams = self._streams, ()
            if process is not None:
                _kill_group(process)
                process.wait()
        for stream in streams:
            stream.close()
        return 0 if process is None else process.returncode

    def _send(self, value: Any) -> None:
        self._socket.settimeout(None)
        with contextlib.suppress(OSError):  # it is gone then; reading its answer says how
            self._socket.sendall(pickle.dumps(value, pickle.HIGHEST_PROTOCOL))

    def _receive(self, seconds: float) -> tuple[Any, Any]:
        self._socket.settimeout(seconds)
        try:
            answer: tuple[Any, Any] = pickle.load(self._answers)
        except TimeoutError:
            raise self._died(seconds, late=True) from None
        except (EOFError, OSError, pickle.UnpicklingError):
            raise self._died(seconds) from None
        except Exception as error:  # an exception's own class may raise when it is unpickled
            return "error", TypeError(f"can't be received: {error}")
        return answer

    def _died(self, seconds: float, late: bool = False) -> WorkerDiedError:
        """Return how the process ended, once it is gone with everything that it started."""
        assert self._process is not None
        ended = not late and _wait_for_end(self._process.pid)
        _kill_group(self._process)  # before its last line is read
        step, last_line = self._noted_step(), last_stderr_line(self._errors)
        code = self._end()
        if late or -code == signal.SIGALRM:
            return WorkerDiedError("timeout", f"took longer than {seconds:g} s", step, self._fresh)
        how = f"exit status {code}"
        if not ended:
            how = "it closed its connection, but did not end"
        elif code < 0:
            how = f"signal {-code}"
            with contextlib.suppress(ValueError):
                how += f" ({signal.Signals(-code).name})"
        message = f"the process died: {how}" + (f", {last_line}" if last_line else "")
        return WorkerDiedError("crash", message, step, self._fresh)

    def _noted_step(self) -> str:
        self._steps.seek(0)
        return self._steps.read(STEP_BYTES).rstrip(b"\0").decode("utf-8", "ignore")


def last_stderr_line(errors: BinaryIO) -> str:
    """Return the last line that a process wrote to its standard error."""
    size = errors.seek(0, os.SEEK_END)
    errors.seek(max(size - 2000, 0))
    lines = errors.read().decode("utf-8", "replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "")


def _kill_group(process: subprocess.Popen[bytes]) -> None:
    """Kill a process that was not waited for, its group, and what it started in other groups."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        started = list(_descendants(process.pid))
        os.killpg(process.pid, signal.SIGKILL)
        for descendant in started:
            with contextlib.suppress(ProcessLookupError):
                os.kill(descendant, signal.SIGKILL)


def _descendants(process: int) -> Iterator[int]:
    """Yield the ids of a process's children and of theirs, where Linux lists them."""
    for children in Path(f"/proc/{process}/task").glob("*/children"):
        with contextlib.suppress(OSError):  # the thread has ended
            for child in map(int, children.read_text().split()):
                yield child
                yield from _descendants(child)


def _wait_for_end(process: int) -> bool:
    """Wait a little until a process has ended; return whether it has.

    Its id stays taken, so that its group can still be killed.
    """
    until = time.monotonic() + END_SECONDS
    while os.waitid(os.P_PID, process, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None:
        if time.monotonic() > until:
            return False
        time.sleep(0.005)
    return True


def _own_memory(process: int) -> int:
    """Return the bytes of memory that a process shares with no file; 0 where the system has no
    /proc."""
    try:
        with open(f"/proc/{process}/statm", "rb", buffering=0) as file:
            _, resident, shared, *_ = map(int, file.read().split())
    except (OSError, ValueError):
        return 0
    return (resident - shared) * os.sysconf("SC_PAGE_SIZE")


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
