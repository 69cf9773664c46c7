"""The state of a process that performs requests.

A worker imports this module before it reports ready: its first request has no time for imports.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shaderlab import drivers as backends
from shaderlab.drivers import known_driver, prepare_process
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.jobs import BareWorker, Request
from shaderlab.engine.run import SceneRunner
from shaderlab.model.case import Case, Scene
from shaderlab.model.options import RunOptions

if TYPE_CHECKING:
    from shaderlab.workers.process_state import ProcessState
    from shaderlab.workers.worker import Channel


class Worker(BareWorker):
    """The state of a process that performs requests: an open lab, and case files loaded once."""

    def __init__(self, channel: Channel | None = None) -> None:
        super().__init__(channel)
        self._lab: SceneRunner | None = None
        self._driver = ""
        self._scenes: dict[str, Mapping[str, Scene]] = {}
        self._kept: dict[str, tuple[Hashable, Any]] = {}
        self._file = ""  # that was used last
        self._state: ProcessState | None = None

    @staticmethod
    def preload() -> None:
        """Import what the driver needs, without opening it, and what each scene needs."""
        import numpy.random

        from shaderlab.model.pictures import pack, save_png

        _ = numpy.random, pack, save_png
        backends.preload()

    def __call__(self, request: Request) -> Any:
        if self._lab is not None and self._lab.exhausted:
            # What ran out of memory may have left the driver half way. A new process costs less
            # than a doubt about every later record; the parent starts it and asks again.
            os._exit(1)
        return super().__call__(request)

    def lab(self, options: RunOptions) -> SceneRunner:
        """The process's lab, with these options for the scenes to come."""
        if self._lab is not None and options.driver not in (None, self._driver):
            # Mesa reads once in a process which driver it is to be.
            if self._channel is not None:
                os._exit(0)  # the parent starts another process and asks that one
            self._lab.close()
            self._lab = None
        if self._lab is None:
            self._driver = known_driver(options.driver)
            self._require_unchanged()
            if self._channel is not None:
                prepare_process(options.driver)  # a worker is the lab's alone
            self._lab = SceneRunner(options, self.note)
            self._state, _ = None, self._lab.driver  # opening it changes this process
            self._require_unchanged()
        elif options != self._lab.options:
            self._lab.configure(options)
        return self._lab

    def scenes(self, file: str) -> Mapping[str, Scene]:
        """The scenes of a case file by variant. Raises CaseError."""
        if file != self._file:
            self._require_unchanged()
            self._file = file
        if file not in self._scenes:
            self._scenes[file] = {s.variant: s for s in load_case(Path(file)).scenes()}
        return self._scenes[file]

    def has_changed(self) -> bool:
        """Whether a case has changed what others in this worker process depend on."""
        if self._channel is None:
            return False
        from shaderlab.workers.process_state import ProcessState

        if self._state is None:
            self._state = ProcessState()
            return False
        return self._state.has_changed()

    def _require_unchanged(self) -> None:
        if self.has_changed():
            os._exit(1)  # the parent starts a fresh process and asks that

    def case(self, file: str) -> Case:
        """The case of a case file. Raises CaseError."""
        return next(iter(self.scenes(file).values())).case

    def keep(self, slot: str, key: Hashable, make: Callable[[], Any]) -> Any:
        """The value in `slot`, made now unless it was made for the same key."""
        if slot not in self._kept or self._kept[slot][0] != key:
            self._kept.pop(slot, None)
            self._kept[slot] = key, make()
        return self._kept[slot][1]

    def restart_limit(self, seconds: float | None = None) -> None:
        """Give the current request so many seconds from now on, by default the usual limit."""
        if self._channel is not None:
            self._channel.restart_limit(seconds)

    def close(self) -> None:
        if self._lab is not None:
            self._lab.close()
