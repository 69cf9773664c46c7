"""What the lab is doing right now, and how long each kind of work took.

Drawing, compiling and judging say what they are about with `doing`; nobody has to hand a watch
through every call. A caller that measures opens an `Activity` around them: it adds up the time of
each phase, and passes every step on as it begins. If a driver takes the process down with it, the
last step that was passed on is what it died of.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

PHASES = ("compile", "link", "draw", "read", "reference", "judge", "picture")
"""The phases that a record's timings may have, in the order in which they first happen."""


class Activity:
    """Time by phase, each moment counted once: a phase inside another one interrupts it.

    Args:
        notice: called with each step as it begins, in words.
    """

    def __init__(self, notice: Callable[[str], None] | None = None) -> None:
        self.spent: dict[str, float] = {}
        self._notice = notice
        self._inner = 0.0  # time that phases inside the current one have taken so far

    @contextmanager
    def watch(self) -> Iterator[Activity]:
        """Take notice of everything done inside."""
        token = _CURRENT.set(self)
        try:
            yield self
        finally:
            _CURRENT.reset(token)

    @contextmanager
    def _phase(self, phase: str, step: str) -> Iterator[None]:
        if step and self._notice is not None:
            self._notice(step)
        outer, self._inner = self._inner, 0.0
        started = time.perf_counter()
        try:
            yield
        finally:
            whole = time.perf_counter() - started
            self.spent[phase] = self.spent.get(phase, 0.0) + whole - self._inner
            self._inner = outer + whole

    def ordered(self) -> dict[str, float]:
        """Seconds by phase, in the order of PHASES; those that did not happen are left out."""
        known = {phase: self.spent[phase] for phase in PHASES if phase in self.spent}
        return {**known, **{p: s for p, s in self.spent.items() if p not in known}}


_CURRENT: ContextVar[Activity | None] = ContextVar("activity", default=None)


@contextmanager
def doing(phase: str, step: str = "") -> Iterator[None]:
    """Count what is done inside as `phase`; `step` says in words what it is."""
    activity = _CURRENT.get()
    if activity is None:
        yield
        return
    with activity._phase(phase, step):
        yield
