"""What the lab is doing right now, and how long each kind of work took.

Drawing, compiling and judging say what they are about with `doing`; nobody has to hand a watch
through every call. A caller that measures opens an `Activity` around them: it adds up the time of
each phase, and passes every step on as it begins. If a driver takes the process down with it, the
last step that was passed on is what it died of.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
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
        self.notice = notice
        self.inner = 0.0  # seconds that phases inside the current one have taken so far

    @contextmanager
    def watch(self) -> Iterator[Activity]:
        """Take notice of everything done inside."""
        token = _CURRENT.set(self)
        try:
            yield self
        finally:
            _CURRENT.reset(token)

    def ordered(self) -> dict[str, float]:
        """Seconds by phase, in the order of PHASES; those that did not happen are left out."""
        known = {phase: self.spent[phase] for phase in PHASES if phase in self.spent}
        return {**known, **{p: s for p, s in self.spent.items() if p not in known}}


_CURRENT: ContextVar[Activity | None] = ContextVar("activity", default=None)


def doing(phase: str, step: str = "") -> AbstractContextManager[None]:
    """Count what is done inside as `phase`; `step` says in words what it is."""
    return _Doing(phase, step)


class _Doing(AbstractContextManager[None]):
    """One phase under way. No generator: a scene has some forty, which cost three times as much."""

    __slots__ = ("_activity", "_outer", "_phase", "_started", "_step")

    def __init__(self, phase: str, step: str) -> None:
        self._phase = phase
        self._step = step

    def __enter__(self) -> None:
        activity = self._activity = _CURRENT.get()
        if activity is None:
            return
        if self._step and activity.notice is not None:
            activity.notice(self._step)
        self._outer, activity.inner = activity.inner, 0.0
        self._started = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        activity = self._activity
        if activity is None:
            return
        whole = time.perf_counter() - self._started
        activity.spent[self._phase] = activity.spent.get(self._phase, 0.0) + whole - activity.inner
        activity.inner = self._outer + whole
