"""A thread that writes a scene's files while the scene is judged, where a core is idle: packing
them takes no lock of Python's."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Callable

from .failures import unless_unwritable
from .record_builder import RecordBuilder

Task = Callable[[], None]
_WAITING = 8
"""Tasks that may wait, as they hold what they write; `submit` waits for room."""


class FileThread(contextlib.AbstractContextManager["FileThread"]):
    """Runs tasks in order, in a thread that is started with the first one. All are done when it is
    left; the record gets a notice of files that can't be written.

    Args:
        builder: of the record.
        beside: False has each task run where it is submitted, with the same end: threads that take
            turns at Python's lock take a tenth more of the processor's time.
    """

    def __init__(self, builder: RecordBuilder, beside: bool = True) -> None:
        self._builder = builder
        self._beside = beside
        self._tasks: queue.Queue[Task | None] = queue.Queue(_WAITING)
        self._thread: threading.Thread | None = None
        self._errors: list[Exception] = []

    def submit(self, task: Task) -> None:
        """Have a task run."""
        if not self._beside:
            self._perform(task)
            return
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, daemon=True)
            self._thread.start()
        self._tasks.put(task)

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._thread is not None:
            self._tasks.put(None)
            self._thread.join()
        for error in self._errors if kind is None else ():
            with unless_unwritable(self._builder, "a file for the report"):
                raise error

    def _run(self) -> None:
        while (task := self._tasks.get()) is not None:
            self._perform(task)

    def _perform(self, task: Task) -> None:
        try:
            task()
        except Exception as error:
            self._errors.append(error)
