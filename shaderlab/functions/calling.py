"""Calls in a worker: arrays into shared memory, the kernel run there, results out of it."""

from __future__ import annotations

import atexit
import functools
import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shaderlab.compiler.sources import Source
from shaderlab.drivers import Evaluation
from shaderlab.errors import CallError
from shaderlab.functions.memory import SharedMemory
from shaderlab.functions.requests import Evaluate, Preprocess
from shaderlab.model.frame import Array
from shaderlab.model.options import CALL_LIMITS
from shaderlab.settings import settings_of
from shaderlab.workers import InProcessExecutor, ProcessExecutor
from shaderlab.workers.executor import LocalExecutor

if TYPE_CHECKING:
    from shaderlab.workers.lab_worker import LabWorker


class Caller:
    """A worker that stays warm, and the memory shared with it. One call at a time.

    Args:
        executor: performs the requests.
        driver: as in `shaderlab.drivers.open_backend`.
    """

    def __init__(self, executor: LocalExecutor, driver: str | None = None) -> None:
        self._driver = driver
        self._executor = executor
        self._lock = threading.Lock()
        self._memory = SharedMemory()

    def preprocess(self, source: Source) -> str:
        """A source's text after the preprocessor. Raises ShaderError, CallError."""
        with self._lock:
            text: str = self._perform(Preprocess(source), f"preprocessing {source.path}")
        return text

    def evaluate(
        self,
        evaluation: Evaluation,
        versions: tuple[int, ...],
        layers: int,
        words: int,
        what: str,
        fill: Callable[[Array], None],
        take: Callable[[Array], Any],
    ) -> Any:
        """What `take` makes of the outputs, (words, height, width, lanes); `fill` sets the inputs,
        (layers, height, width, lanes). `versions` are those of GLSL to try, `what` says what runs.

        Raises:
            ShaderError, CaseError, CallError: as `shaderlab.drivers.Backend.evaluate`; it hangs,
                or takes its process down.
        """
        width, height = evaluation.size
        shape = (height, width, evaluation.lanes)
        size = width * height * evaluation.lanes
        with self._lock:
            whole = self._memory.words((layers + words) * size).reshape(-1, *shape)
            fill(whole[:layers])
            request = Evaluate(
                evaluation, versions, layers, words, self._memory.region, what, self._driver
            )
            self._perform(request, what)
            return take(whole[layers:])

    def close(self) -> None:
        """End the worker."""
        self._executor.close()

    def _perform(self, request: Any, what: str) -> Any:
        (result,) = self._executor.perform([request])
        if result.status == "done":
            return result.value
        if result.status == "error":
            raise result.value
        raise CallError(f"{what}: {result.message}")


_CALLER: ContextVar[Caller | None] = ContextVar("_CALLER", default=None)


@contextmanager
def called_in(worker: LabWorker) -> Iterator[None]:
    """Inside a worker: calls are made in this process, on its own device."""
    driver = settings_of(Path.cwd()).driver
    made = worker.keep("caller", driver, lambda: Caller(InProcessExecutor(driver, worker), driver))
    token = _CALLER.set(made)
    try:
        yield
    finally:
        _CALLER.reset(token)


def caller() -> Caller:
    """What makes calls: inside `called_in` its worker, else this process's own."""
    return _CALLER.get() or _own()


@functools.cache
def _own() -> Caller:
    """This process's own, started at the first call; SHADERLAB_JOBS=0 calls in this process."""
    executor: LocalExecutor
    settings = settings_of(Path.cwd())
    if os.environ.get("SHADERLAB_JOBS") == "0":
        executor = InProcessExecutor(settings.driver)
    else:
        limits = CALL_LIMITS.get(settings.limits)
        executor = ProcessExecutor(settings.driver, limits, early=False)
    made = Caller(executor, settings.driver)
    atexit.register(made.close)
    return made
