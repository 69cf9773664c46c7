"""What the lab is doing right now, and how long each kind of work took.

Drawing, compiling and judging say what they are doing with `phase`; no timer has to be passed
through every call. A caller that measures opens a `PhaseTimer` around them: it adds up the time of
each phase, and passes every step on as it begins. If a driver takes the process down with it, the
last step that was passed on is what it died of.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar, Token

PHASES = ("compile", "link", "draw", "read", "reference", "judge", "picture")
"""The phases that a record's timings may have, in the order in which they first happen."""


class PhaseTimer:
    """Time by phase, each moment counted once: a phase inside another one interrupts it. `notice`
    is called with each step as it begins, in words."""

    def __init__(self, notice: Callable[[str], None] | None = None) -> None:
        self.spent: dict[str, float] = {}
        self.notice = notice
        self.inner = 0.0  # seconds that phases inside the current one have taken so far
        self._token: Token[PhaseTimer | None] | None = None

    def __enter__(self) -> "PhaseTimer":
        self._token = _CURRENT.set(self)
        return self

    def __exit__(self, *_: object) -> None:
        assert self._token is not None
        _CURRENT.reset(self._token)

    def timings(self) -> dict[str, float]:
        """Return seconds by phase, in the order of PHASES, without those that did not happen."""
        known = {name: self.spent[name] for name in PHASES if name in self.spent}
        return {**known, **self.spent}


_CURRENT: "ContextVar[PhaseTimer | None]" = ContextVar("timer", default=None)


@contextmanager
def phase(name: str, step: str = "") -> Iterator[None]:
    """Count what is done inside as the phase `name`; `step` says in words what it is."""
    timer = _CURRENT.get()
    if timer is None:
        yield
        return
    if step and timer.notice is not None:
        timer.notice(step)
    outer, timer.inner = timer.inner, 0.0
    started = time.perf_counter()
    try:
        yield
    finally:
        whole = time.perf_counter() - started
        timer.spent[name] = timer.spent.get(name, 0.0) + whole - timer.inner
        timer.inner = outer + whole
