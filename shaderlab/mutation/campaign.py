"""All mutants of some cases: made, dealt out to processes, and their fates put together."""

from __future__ import annotations

import os
import random
import selectors
import time
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from shaderlab.model import Case
from shaderlab.mutation.children import Child, Gone
from shaderlab.mutation.mutants import Mutant
from shaderlab.mutation.results import STATE, CaseResult, Fate, Tried
from shaderlab.mutation.states import StateMutant, state_mutants
from shaderlab.mutation.subjects import glsl_mutants
from shaderlab.mutation.worker import Opening, Question

MOST_JOBS = 8
OPENING = 120.0  # seconds for a child to start, load a case and run it as it is


@dataclass(frozen=True, kw_only=True)
class Options:
    """How mutants are made and judged.

    Args:
        variants: names of the only variants to judge by; all of them if empty.
        state: mutate the cases' fixed-function state as well.
        limit: at most so many mutants a case, drawn at random by `seed`; 0 for all.
        seed: which ones.
        timeout: seconds after which a mutant counts as killed, because its draw does not end.
        jobs: how many processes; 0 for one a core.
    """

    variants: tuple[str, ...] = ()
    state: bool = True
    limit: int = 0
    seed: int = 0
    timeout: float = 20.0
    jobs: int = 0


class Watch(Protocol):
    """What is told while mutants are judged."""

    def total(self, mutants: int) -> None:
        """How many there are in all."""

    def judged(self, case_id: str, fate: Fate | None) -> None:
        """One more is done; None for one that is left out because its case is broken."""


def mutants_of_case(case: Case, options: Options) -> list[Mutant | StateMutant]:
    """The mutants of a case in the order of its files, after `limit`."""
    found: list[Mutant | StateMutant] = [*glsl_mutants(case)]
    if options.state:
        found += state_mutants(case, options.seed)
    if options.limit and options.limit < len(found):
        chosen = random.Random(options.seed).sample(range(len(found)), options.limit)
        found = [found[i] for i in sorted(chosen)]
    return found


def run(cases: Iterable[Case], options: Options, watch: Watch | None = None) -> list[CaseResult]:
    """Judge all mutants of all cases.

    Raises:
        ShaderError: a case's shader can't be read.
    """
    works = [_Work(case, mutants_of_case(case, options), options) for case in cases]
    if watch is not None:
        watch.total(sum(len(work.mutants) for work in works))
    _Crew(works, options, watch).run()
    return [work.result() for work in works]


@dataclass
class _Work:
    """One case on its way: what is to be done and what is."""

    case: Case
    mutants: Sequence[Mutant | StateMutant]
    options: Options
    fates: dict[int, Fate] = field(default_factory=dict)
    seconds: float = 0.0
    message: str = ""

    @property
    def opening(self) -> Opening:
        return Opening(case_file=self.case.file, variants=self.options.variants)

    def result(self) -> CaseResult:
        tried = tuple(_tried(self.mutants[i], fate) for i, fate in sorted(self.fates.items()))
        return CaseResult(id=self.case.id, tried=tried, seconds=self.seconds, message=self.message)


class _Crew:
    """The children and what each of them is at."""

    def __init__(self, works: list[_Work], options: Options, watch: Watch | None) -> None:
        self._todo = deque((work, index) for work in works for index in range(len(work.mutants)))
        self._options = options
        self._watch = watch
        self._busy: dict[Child, tuple[_Work, int]] = {}
        self._idle: list[Child] = []
        self._selector = selectors.DefaultSelector()

    def run(self) -> None:
        wanted = self._options.jobs or min(os.cpu_count() or 1, MOST_JOBS)
        try:
            for _ in range(min(wanted, len(self._todo))):
                self._idle.append(Child())
            while self._todo or self._busy:
                while self._todo and self._idle:
                    self._start(self._idle.pop(), *self._todo.popleft())
                self._wait()
        finally:
            for child in (*self._idle, *self._busy):
                child.close()
            self._selector.close()

    def _start(self, child: Child, work: _Work, index: int) -> None:
        if work.message:
            self._idle.append(child)
            self._note(work, None)
            return
        question: Question = work.mutants[index]
        limit = self._options.timeout
        if child.opened != work.opening:
            question, limit = work.opening, OPENING
        self._busy[child] = (work, index)
        self._selector.register(child, selectors.EVENT_READ, child)
        try:
            child.ask(question, limit)
        except Gone as gone:
            self._lost(child, str(gone))

    def _wait(self) -> None:
        if not self._busy:
            return
        patience = min(child.deadline for child in self._busy) - time.monotonic()
        for key, _ in self._selector.select(max(patience, 0.0)):
            self._hear(key.data)
        for child in [c for c in self._busy if c.deadline <= time.monotonic()]:
            self._lost(child, "timeout")

    def _hear(self, child: Child) -> None:
        try:
            answer = child.answer()
        except Gone as gone:
            self._lost(child, f"crash ({gone})")
            return
        work, index = self._release(child)
        self._idle.append(child)
        if isinstance(answer, Fate):
            self._settle(work, index, answer)
        elif answer:
            work.message = answer
            self._note(work, None)
        else:
            child.opened = work.opening
            self._todo.appendleft((work, index))

    def _lost(self, child: Child, how: str) -> None:
        """A child that hangs or is gone: a mutant that did this is killed, a case that does it
        unmutated can't be measured."""
        work, index = self._release(child)
        if child.opened == work.opening:
            self._settle(work, index, Fate(status="killed", by=how))
        else:
            work.message = f"the case itself does not run to its end: {how}"
            self._note(work, None)
        child.close()
        self._idle.append(Child())

    def _release(self, child: Child) -> tuple[_Work, int]:
        self._selector.unregister(child)
        work, index = self._busy.pop(child)
        work.seconds += time.monotonic() - child.asked
        return work, index

    def _settle(self, work: _Work, index: int, fate: Fate) -> None:
        work.fates[index] = fate
        self._note(work, fate)

    def _note(self, work: _Work, fate: Fate | None) -> None:
        if self._watch is not None:
            self._watch.judged(work.case.id, fate)


def _tried(mutant: Mutant | StateMutant, fate: Fate) -> Tried:
    if isinstance(mutant, Mutant):
        return Tried(
            file=mutant.file,
            line=mutant.line,
            operator=mutant.operator,
            before=mutant.before,
            after=mutant.after,
            fate=fate,
        )
    before, after = mutant.shown
    return Tried(file=mutant.file, line=0, operator=STATE, before=before, after=after, fate=fate)
