"""Worker processes side by side: items in, results out as they complete.

A crash, a hang or runaway memory costs one item, no more. A worker is a fresh Python: it inherits
no threads, no OpenGL context and no `__main__`.
"""

import contextlib
import errno
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
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from shaderlab.errors import ShaderlabError
from shaderlab.files import open_memory_file, sort_search_path, suggest_limit
from shaderlab.model.options import Limits

STEP_BYTES = 256
"""The size of the file in which a worker notes its steps."""
START_SECONDS = 30.0
"""A worker is ready by then, or within the limit of an item if that is longer."""
END_SECONDS = 5.0
GROWTH = 448 << 20
"""A worker that holds this many bytes more than after its first item is replaced by a fresh one
before its next one: drivers keep a little of every scene."""
AHEAD = 32
"""How many items are taken ahead of the results that were read."""
# Libraries for matrices and pictures start a thread per core and let all of them wait busily;
# workers share the cores already, and multiply matrices of four rows.
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
_PROGRAM = "from shaderlab.workers.worker import main; main()"


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


class _Run(queue.SimpleQueue["ItemResult | BaseException | None"]):
    """The results of one `run`, one for each item: None where none is needed any more, an exception
    where it ends the run. `closed` once nobody reads them."""

    closed = False


@dataclass(eq=False)
class WorkerDiedError(Exception):
    """A worker is gone: how it ended, with the step that it noted last."""

    status: Literal["crash", "timeout"]
    message: str
    step: str = ""


class _Process(subprocess.Popen[bytes]):
    """A process whose id is known before it runs its program, so that it can be ended even if it is
    stopped on its way there."""

    pid = 0

    def __init__(self) -> None:
        """Start nothing yet."""

    def start(self, command: Sequence[str], **options: Any) -> None:
        # With a group to change to, Python calls fork: vfork would hold the whole of Python up
        # until the program runs.
        super().__init__(command, group=os.getgid(), **options)


class _Worker:
    """A process that answers items, as `WorkerPool` says.

    It is started with the first item, and again with the first one after it died. One thread uses
    it; any thread may call `close`. `memory` is what the process held when it had answered its
    first item, 0 before.
    """

    def __init__(
        self, work: str, limits: Limits, folder: Path, environment: Mapping[str, str]
    ) -> None:
        self.memory = 0
        self._limits = limits
        self._folder = folder
        self._environment = environment
        memory = int(limits.gigabytes * (1 << 30))
        self._arguments = [str(os.getpid()), work, str(limits.seconds), str(memory)]
        self._lock = threading.Lock()  # for the two below
        self._closed = False
        self._process: _Process | None = None
        self._streams: Sequence[Any] = ()
        self._pid = 0

    def answer(self, item: Any) -> tuple[Any, Any]:
        """Return the answer to an item: "done" or "error", and what that gives. Raises
        WorkerDiedError: it crashed or took too long."""
        self._send(item)
        kind, value = self._receive(self._limits.seconds)
        while kind == "limit":
            kind, value = self._receive(value)
        self.memory = self.memory or measure_memory(self._pid) or 1
        return kind, value

    def wait_until_ready(self) -> None:
        """Start the process, if there is none, and wait for it. Raises ShaderlabError: it can't."""
        if self.memory and measure_memory(self._pid) - self.memory > GROWTH:
            self.end()
        with self._lock:
            if self._process is not None:
                return
            if self._closed:
                raise ShaderlabError("the pool of workers is closed")
            self._process = _Process()
        try:
            self._start(self._process)
        except OSError as error:
            self._process = None
            said = f"can't start a worker process: {error.strerror or error}"
            raise ShaderlabError(said, remedy=suggest_limit(error)) from error
        try:
            self._receive(max(START_SECONDS, self._limits.seconds))
        except WorkerDiedError as error:
            remedy = "see that this Python can import shaderlab: run `shaderlab doctor`"
            if error.status == "timeout":
                remedy = "wait until this machine is less busy, or allow more time: --timeout S"
            said = f"can't start a worker process: {error.message}"
            raise ShaderlabError(said, remedy=remedy) from error

    def close(self) -> None:
        """End the process, and start no other one."""
        with self._lock:
            self._closed = True
            if self._process is not None:
                _kill_group(self._process)

    def end(self) -> int:
        """End the process and close its streams; return its exit status."""
        with self._lock:
            process, self._process = self._process, None
            if process is not None:
                _kill_group(process)
                process.wait()
        for stream in self._streams:
            stream.close()
        self.memory = 0
        return 0 if process is None else process.returncode

    def _start(self, process: _Process) -> None:
        self._socket, theirs = socket.socketpair()
        self._answers = self._socket.makefile("rb")
        # Both live as long as the process, and take no space on a disk that may be full.
        self._errors, self._steps = open_memory_file(), open_memory_file()
        self._steps.truncate(STEP_BYTES)
        self._streams = (self._answers, self._socket, self._errors, self._steps)
        inherited = [theirs.fileno(), self._steps.fileno()]
        with theirs:
            process.start(
                [sys.executable, "-P", "-c", _PROGRAM, *map(str, inherited), *self._arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._errors,
                cwd=self._folder,
                env=self._environment,
                pass_fds=inherited,
                process_group=0,  # so that what it starts can be ended with it
            )
        self._pid = process.pid

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
        stopped, ended = None, False
        if late:
            stopped = os.waitid(os.P_PID, self._pid, os.WSTOPPED | os.WNOWAIT | os.WNOHANG)
        else:
            with contextlib.suppress(subprocess.TimeoutExpired):
                ended = self._process.wait(END_SECONDS) is not None
        _kill_group(self._process)  # before its last line is read
        self._steps.seek(0)
        step = self._steps.read(STEP_BYTES).rstrip(b"\0").decode("utf-8", "ignore")
        self._errors.seek(max(self._errors.seek(0, os.SEEK_END) - 2000, 0))
        lines = self._errors.read().decode("utf-8", "replace").split("\n")
        code = self.end()
        if late or -code == signal.SIGALRM:
            how = ", and the process was stopped (SIGSTOP)" if stopped else ""
            return WorkerDiedError("timeout", f"took longer than {seconds:g} s{how}", step)
        how = f"exit status {code}"
        if not ended:
            how = "it closed its connection, but did not end"
        elif code < 0:
            how = f"signal {-code}"
            with contextlib.suppress(ValueError):
                how += f" ({signal.Signals(-code).name})"
        last_lines = filter(None, (line.strip() for line in reversed(lines)))
        message = ", ".join([how, *itertools.islice(last_lines, 1)])
        return WorkerDiedError("crash", f"the process died: {message}", step)


def _kill_group(process: _Process) -> None:
    """Kill a process, its group, and what it started in other groups."""
    if not process.pid:
        return
    single = list(_descendants(process.pid))
    if process.returncode is None:
        single.append(process.pid)  # which may have no group yet
    for kill, number in [(os.killpg, process.pid), *((os.kill, one) for one in single)]:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            kill(number, signal.SIGKILL)


def _descendants(process: int) -> Iterator[int]:
    """Yield the ids of a process's children and of theirs, where Linux lists them."""
    for children in Path(f"/proc/{process}/task").glob("*/children"):
        with contextlib.suppress(OSError):  # the thread has ended
            for child in map(int, children.read_text().split()):
                yield child
                yield from _descendants(child)


def measure_memory(process: int) -> int:
    """Return the bytes of memory that a process shares with no file; 0 once it has ended."""
    try:
        _, resident, shared, *_ = map(int, Path(f"/proc/{process}/statm").read_text().split())
    except (OSError, ValueError):
        return 0
    return (resident - shared) * os.sysconf("SC_PAGE_SIZE")


class WorkerPool(contextlib.AbstractContextManager["WorkerPool"]):
    """Worker processes that share the items of `run`. A context manager.

    All workers, later replacements included, start in the environment and the working directory
    that this process has now, and each only when all others are busy.

    Args:
        work: what workers call, as "module:name", since they import it by its name: a function
            that takes an item and returns its result; or a class that makes such a function from a
            `shaderlab.workers.worker.Channel`, optionally with a `preload()` that imports what it
            will need.
        limits: of each item.
        jobs: how many workers at most; may be set to more at any time.
    """

    def __init__(self, work: str, *, limits: Limits | None = None, jobs: int = 1) -> None:
        self.jobs = max(jobs, 1)
        path = os.pathsep.join(sort_search_path(sys.path))
        environment = {**_ONE_THREAD, **os.environ, "PYTHONPATH": path}
        self._make = functools.partial(_Worker, work, limits or Limits(), Path.cwd(), environment)
        self._queue: queue.SimpleQueue[tuple[_Run, int, Any] | None] = queue.SimpleQueue()
        self._lock = threading.Lock()  # for all below
        self._closed = False
        self._unfinished = 0  # items, but for those of `start`
        self._workers: dict[threading.Thread, _Worker] = {}

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all workers, whatever they are doing."""
        with self._lock:
            self._closed = True
        for worker in self._workers.values():
            worker.close()
            self._queue.put(None)
        for thread, worker in self._workers.items():
            while thread.is_alive():
                worker.close()  # again: its process may have got its id after the first time
                thread.join(0.5)

    def start(self, item: Any) -> None:
        """Start the first worker with an item whose result nobody needs, and wait for neither."""
        self._submit(_Run(), -1, item)

    def run(self, items: Iterable[Any]) -> Generator[ItemResult]:
        """Yield the items' results as they complete.

        Only a few are taken from `items` ahead of the results that were read, so memory does not
        grow with their number. Closing the generator drops what no worker was sent.

        Raises:
            ShaderlabError: no worker can be started at all.
        """
        run = _Run()
        numbered = enumerate(items)
        ahead = itertools.islice(numbered, min(max(self.jobs + 1, AHEAD), sys.maxsize))
        try:
            left = sum(self._submit(run, *each) for each in ahead)
            while left:
                result = run.get()
                if isinstance(result, BaseException):
                    raise result
                left += sum(self._submit(run, *n) for n in itertools.islice(numbered, 1)) - 1
                if result is not None:
                    yield result
        finally:
            run.closed = True

    def _submit(self, run: _Run, number: int, item: Any) -> bool:
        """Queue an item, for a new worker if all are busy; return False if the pool is closed."""
        with self._lock:
            if self._closed:
                return False
            self._queue.put((run, number, item))
            self._unfinished += number >= 0
            if len(self._workers) < min(self.jobs, max(self._unfinished, 1)):
                worker = self._make()
                thread = threading.Thread(target=self._serve, args=[worker], daemon=True)
                self._workers[thread] = worker  # first: Ctrl-C may come while it starts
                try:
                    thread.start()
                except RuntimeError as error:  # the system allows no more of them
                    del self._workers[thread]
                    if not self._workers:
                        remedy = suggest_limit(OSError(errno.EAGAIN, ""))
                        raise ShaderlabError(str(error), remedy=remedy) from error
        return True

    def _serve(self, worker: _Worker) -> None:
        """Give a worker one item after the other, until the pool is closed."""
        while (taken := self._queue.get()) is not None:
            run, number, item = taken
            result: ItemResult | BaseException | None = None
            try:
                if not (self._closed or run.closed):
                    result = self._answer(worker, number, item)
            except BaseException as error:
                result = None if self._closed else error
            with self._lock:
                self._unfinished -= number >= 0
            run.put(result)
        worker.end()

    def _answer(self, worker: _Worker, number: int, item: Any) -> ItemResult:
        """The result of an item; where the worker dies, its replacement is asked again if an
        earlier item may have left the memory in disorder."""
        while True:
            worker.wait_until_ready()
            fresh, began = not worker.memory, time.monotonic()
            try:
                kind, value = worker.answer(item)
            except WorkerDiedError as error:
                if error.status == "timeout" or fresh or self._closed:
                    seconds = time.monotonic() - began
                    how = error.status, None, error.message, error.step, seconds
                    return ItemResult(number, item, *how)
            else:
                return ItemResult(number, item, kind, value, seconds=time.monotonic() - began)
