"""Worker processes side by side: items in, results out as they complete.

A crash, a hang or runaway memory costs one item, no more. A worker is a fresh Python: it inherits
no threads, no OpenGL context and no `__main__`.
"""

import contextlib
import errno
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
from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from shaderlab.errors import ShaderlabError
from shaderlab.files import open_memory_file, sort_search_path, suggest_limit
from shaderlab.model.options import Limits

STEP_BYTES = 256
"""The size of the file in which a worker notes its steps."""
START_SECONDS = 50.0
"""A worker is ready by then, or within the limit of an item if that is longer."""
END_SECONDS = 5.0
GROWTH = 512 << 20
"""A worker that holds this many bytes more than after its first item is replaced by a fresh one
before its next one: drivers keep a little of every scene."""
AHEAD = 32
"""How many items are taken ahead of the results that were read."""
ENVIRONMENT = {
    # Libraries start a thread per core, all of which wait busily; workers share the cores already.
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    # glibc reuses 192 MB of what arrays have freed: faulting them in anew takes a tenth of a run.
    "MALLOC_TRIM_THRESHOLD_": str(192 << 20),
    "MALLOC_MMAP_MAX_": "0",
}
"""Of workers, where the user's own says nothing else."""
_MARK = "SHADERLAB_WORKER"
_PROGRAM = "from shaderlab.workers.worker import main; main()"


@dataclass(frozen=True)
class ItemResult:
    """The result of one item.

    Attributes:
        number: the item's position among those passed to `run`.
        status: "done"; "crash" or "timeout" where the worker died on it; "error" where work raised.
        value: the work's result, the exception where it raised one, else None.
        message, step: how the worker died, and the last step that the work noted before.
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


class _Process(subprocess.Popen[bytes]):
    """A process that answers one item after the other until it dies.

    Its id is known before it runs its program, so that it can be ended even if it is stopped on
    its way there. `memory` is what it held when it had answered its first item, 0 before.
    """

    pid = 0
    memory = 0

    def __init__(self, seconds: float) -> None:
        """Make the way to it; start nothing yet."""
        self._seconds = seconds
        self._socket, self._theirs = socket.socketpair()
        self._answers = self._socket.makefile("rb")
        # Both live as long as the process, and take no space on a disk that may be full.
        self._errors, self._steps = open_memory_file(), open_memory_file()
        self._steps.truncate(STEP_BYTES)

    def start(self, arguments: Sequence[str], **place: Any) -> None:
        """Start it, with arguments for its `main`. Raises OSError."""
        inherited = [self._theirs.fileno(), self._steps.fileno()]
        self._mark = os.urandom(8).hex()  # all that it starts inherits this
        with self._theirs:
            super().__init__(
                [sys.executable, "-P", "-c", _PROGRAM, *map(str, inherited), *arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._errors,
                pass_fds=inherited,
                process_group=0,  # so that what it starts can be ended with it
                # With a group to change to, Python calls fork: vfork would hold the whole of
                # Python up until the program runs.
                group=os.getgid(),
                **{**place, "env": {**place["env"], _MARK: self._mark}},
            )

    def wait_until_ready(self) -> None:
        """Raises ShaderlabError: it has died, or takes too long."""
        status, _, message, _ = self._receive(max(START_SECONDS, self._seconds))
        remedy = "see that this Python can import shaderlab: run `shaderlab doctor`"
        if status == "timeout":
            remedy = "wait until this machine is less busy, or allow more time: --timeout S"
        if status != "ready":
            raise ShaderlabError(f"can't start a worker process: {message}", remedy=remedy)

    def answer(self, number: int, item: Any) -> ItemResult:
        """Return the result of an item."""
        began = time.monotonic()
        self._socket.settimeout(self._seconds)
        with contextlib.suppress(OSError):  # gone or stopped; reading its answer says how
            self._socket.sendall(pickle.dumps(item, pickle.HIGHEST_PROTOCOL))
        answer = self._receive(self._seconds)
        while answer[0] == "limit":
            answer = self._receive(answer[1])
        self.memory = self.memory or measure_memory(self.pid) or 1
        return ItemResult(number, item, *answer, time.monotonic() - began)

    def end(self) -> None:
        """Kill it and all that it started, and close the way to it."""
        self.kill()
        self.wait()
        for stream in (self._answers, self._socket, self._errors, self._steps):
            stream.close()

    def kill(self) -> None:
        """Kill it, its group, and what it started in other groups. Any thread may call this."""
        if not self.pid:
            return
        # Once it has ended, those that it started are children of no process that we know.
        ended = self.returncode is not None
        single = [*_marked(self._mark)] if ended else [*_descendants(self.pid), self.pid]
        for kill, number in [(os.killpg, self.pid), *((os.kill, one) for one in single)]:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                kill(number, signal.SIGKILL)

    def _receive(self, seconds: float) -> tuple[Any, Any, str, str]:
        """Return a status and a value; where it died, also how, and its last step."""
        self._socket.settimeout(seconds)
        try:
            return (*pickle.load(self._answers), "", "")
        except TimeoutError:
            stopped = os.waitid(os.P_PID, self.pid, os.WSTOPPED | os.WNOWAIT | os.WNOHANG)
            how = ", and the process was stopped (SIGSTOP)" if stopped else ""
            status, message = "timeout", f"took longer than {seconds:g} s{how}"
        except (EOFError, OSError, pickle.UnpicklingError):
            status, message = "crash", f"the process died: {self._find_cause()}"
            if self.returncode == -signal.SIGALRM:
                status, message = "timeout", f"took longer than {seconds:g} s"
        except Exception as error:  # an exception's own class may raise when it is unpickled
            return "error", TypeError(f"can't be received: {error}"), "", ""
        self._steps.seek(0)
        step = self._steps.read(STEP_BYTES).rstrip(b"\0").decode("utf-8", "ignore")
        self.end()
        return status, None, message, step

    def _find_cause(self) -> str:
        """How it ended by itself, and the last line that it wrote."""
        try:
            code = self.wait(END_SECONDS)
            how = f"signal {-code}" if code < 0 else f"exit status {code}"
            with contextlib.suppress(ValueError):  # a signal without a name, or none
                how += f" ({signal.Signals(-code).name})"
        except subprocess.TimeoutExpired:
            how = "it closed its connection, but did not end"
        self.kill()  # what it started may still write
        self._errors.seek(max(self._errors.seek(0, os.SEEK_END) - 2000, 0))
        last_line = self._errors.read().decode("utf-8", "replace").rstrip().rpartition("\n")[2]
        return ", ".join(filter(None, [how, last_line.strip()]))


def _descendants(process: int) -> Iterator[int]:
    """Yield the ids of a process's children and of theirs, where Linux lists them."""
    with contextlib.suppress(OSError):  # it ends meanwhile, as may a thread of it
        for thread in os.listdir(f"/proc/{process}/task"):
            with contextlib.suppress(OSError):
                children = Path(f"/proc/{process}/task/{thread}/children").read_text().split()
                for child in map(int, children):
                    yield child
                    yield from _descendants(child)


def _marked(mark: str) -> Iterator[int]:
    """Yield the ids of processes that have a worker's mark in their environment."""
    for process in filter(str.isdecimal, os.listdir("/proc")):
        with contextlib.suppress(OSError):  # it ends meanwhile, or is someone else's
            if f"{_MARK}={mark}".encode() in Path(f"/proc/{process}/environ").read_bytes():
                yield int(process)


def measure_memory(process: int) -> int:
    """Return the bytes of memory that a process shares with no file; 0 once it has ended."""
    with contextlib.suppress(OSError, ValueError):
        _, resident, shared, *_ = map(int, Path(f"/proc/{process}/statm").read_text().split())
        return (resident - shared) * os.sysconf("SC_PAGE_SIZE")
    return 0


class WorkerPool(contextlib.AbstractContextManager["WorkerPool"]):
    """Worker processes that share the items of `run`. A context manager.

    All workers, later replacements included, start in the environment and the working directory
    that this process has now, and each only when all others are busy.

    Args:
        work: what workers call, as "module:name", since they import it by its name: a function
            that takes an item and returns its result; or a class that makes such a function from a
            `shaderlab.workers.worker.Channel`, optionally with a `preload()` that imports what it
            will need.
        jobs: how many workers at most; may be set to more at any time.
    """

    def __init__(self, work: str, *, limits: Limits | None = None, jobs: int = 1) -> None:
        self.jobs = max(jobs, 1)
        self._limits = limits or Limits()
        memory = int(self._limits.gigabytes * (1 << 30))
        self._arguments = [str(os.getpid()), str(memory), str(self._limits.seconds), work]
        path = os.pathsep.join(sort_search_path(sys.path))
        environment = {**ENVIRONMENT, **os.environ, "PYTHONPATH": path}
        self._place = {"cwd": Path.cwd(), "env": environment}
        self._queue: queue.SimpleQueue[tuple[_Run, int, Any] | None] = queue.SimpleQueue()
        self._lock = threading.Lock()  # for all below
        self._closed = False
        self._unfinished = 0  # items, but for those of `start`
        self._processes: dict[threading.Thread, _Process | None] = {}

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all workers, whatever they are doing."""
        with self._lock:
            self._closed = True
        for _ in self._processes:
            self._queue.put(None)
        while alive := [thread for thread in self._processes if thread.is_alive()]:
            for thread in alive:  # again: its process may have got its id after the first time
                if process := self._processes[thread]:
                    process.kill()
            alive[0].join(0.5)

    def start(self, item: Any) -> None:
        """Start the first worker with an item whose result nobody needs, and wait for neither."""
        self._submit(_Run(), -1, item)

    def run(self, items: Iterable[Any]) -> Generator[ItemResult]:
        """Yield the items' results as they complete.

        Only a few are taken from `items` ahead of the results that were read, so memory does not
        grow with their number. Closing the generator drops what no worker was sent. Raises
        ShaderlabError: no worker can be started at all."""
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
            if len(self._processes) < min(self.jobs, max(self._unfinished, 1)):
                thread = threading.Thread(target=self._serve, daemon=True)
                self._processes[thread] = None  # first: Ctrl-C may come while it starts
                try:
                    thread.start()
                except RuntimeError as error:  # the system allows no more of them
                    del self._processes[thread]
                    if not self._processes:
                        remedy = suggest_limit(OSError(errno.EAGAIN, ""))
                        raise ShaderlabError(str(error), remedy=remedy) from error
        return True

    def _serve(self) -> None:
        """Give a process of this thread's own one item after the other, until the pool is closed.

        Where it dies, a fresh one is asked again if an earlier item may have left its memory in
        disorder.
        """
        process = None
        while (taken := self._queue.get()) is not None:
            run, number, item = taken
            result: ItemResult | BaseException | None = None
            try:
                while result is None and not (self._closed or run.closed):
                    process = self._make_ready(process)
                    used = process.memory
                    result = process.answer(number, item)
                    if result.status == "crash" and used:
                        result = None
            except BaseException as error:
                result = None if self._closed else error
            with self._lock:
                self._unfinished -= number >= 0
            run.put(result)
        if process is not None:
            process.end()

    def _make_ready(self, process: _Process | None) -> _Process:
        """Return the process, or a fresh one if it has died or holds too much memory."""
        if process is not None and process.returncode is None:
            if measure_memory(process.pid) - process.memory <= GROWTH:
                return process
            process.end()
        thread = threading.current_thread()
        try:
            self._processes[thread] = process = _Process(self._limits.seconds)
            process.start(self._arguments, **self._place)
        except OSError as error:
            self._processes[thread] = None
            said = f"can't start a worker process: {error.strerror or error}"
            raise ShaderlabError(said, remedy=suggest_limit(error)) from error
        process.wait_until_ready()
        return process
