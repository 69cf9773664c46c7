"""All mutants of some cases: made and judged by an executor, and their fates put together."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from shaderlab.errors import ShaderlabError
from shaderlab.mutation.mutants import Mutant
from shaderlab.mutation.requests import OPENING, JudgeMutant, MakeMutants, MutationPlan
from shaderlab.mutation.results import CaseResult, Fate, Tried
from shaderlab.workers.executor import LocalExecutor, error_text
from shaderlab.workers.jobs import Request
from shaderlab.workers.pool import ItemResult


class Subject(Protocol):
    """What mistakes are made in, and what judges them: a case, say."""

    @property
    def file(self) -> Path:
        """Its file; a worker keeps to the requests of one."""

    @property
    def id(self) -> str:
        """What results call it."""

    def make(self) -> Request:
        """The request for its mutants."""

    def judge(self, mutant: Mutant) -> Request:
        """The request for a mutant's `Fate`."""


@dataclass(frozen=True)
class CaseSubject:
    """A case as a subject."""

    file: Path
    id: str
    plan: MutationPlan

    def make(self) -> MakeMutants:
        return MakeMutants(self.file, self.plan)

    def judge(self, mutant: Mutant) -> JudgeMutant:
        return JudgeMutant(self.file, self.plan.variants, mutant, self.plan.locate)


@dataclass
class _CaseCampaign:
    """The mutants of one subject, and the fates of those that were judged."""

    subject: Subject
    mutants: Sequence[Mutant] = ()
    fates: dict[int, Fate] = field(default_factory=dict)
    seconds: float = 0.0
    message: str = ""

    def result(self) -> CaseResult:
        tried = tuple(Tried(self.mutants[i], fate) for i, fate in sorted(self.fates.items()))
        return CaseResult(
            id=self.subject.id, tried=tried, seconds=self.seconds, message=self.message
        )


class Campaign:
    """Makes the mutants of some cases, or other subjects, then judges them.

    Args:
        subjects: the cases.
        executor: performs everything; its time limit is that of one mutant.

    Raises:
        ShaderlabError: the mutants of a case can't be made, as a shader can't be read.
    """

    def __init__(self, subjects: Sequence[Subject], executor: LocalExecutor) -> None:
        self._executor = executor
        self._cases = [_CaseCampaign(subject) for subject in subjects]
        for result in executor.perform([subject.make() for subject in subjects]):
            if result.status != "done":
                if isinstance(result.value, ShaderlabError):
                    raise result.value
                raise ShaderlabError(
                    f"making the mutants: {error_text(result)}", file=subjects[result.number].file
                )
            self._cases[result.number].mutants = result.value
        self.total = sum(len(case.mutants) for case in self._cases)

    def judge(self) -> Iterator[tuple[str, Fate | None]]:
        """The id of a case and the fate of one of its mutants, for each as it is judged; None for
        those that are left out because the case does not pass unmutated."""
        waiting = {
            (case.subject.file, index): (case, index)
            for case in self._cases
            for index in range(len(case.mutants))
        }
        while waiting:
            batch = list(waiting.values())
            requests = [case.subject.judge(case.mutants[index]) for case, index in batch]
            results = self._executor.perform(requests, key=lambda request: request.file)
            with contextlib.closing(results):
                for result in results:
                    case, index = batch[result.number]
                    case.seconds += result.seconds
                    fate = _fate(result)
                    if fate is None:
                        case.message = _broken(result)
                        for key in [key for key in waiting if key[0] == case.subject.file]:
                            del waiting[key]
                            yield case.subject.id, None
                        break  # no other worker shall open it
                    case.fates[index] = fate
                    del waiting[case.subject.file, index]
                    yield case.subject.id, fate

    @property
    def judged(self) -> int:
        """How many mutants were judged so far."""
        return sum(len(case.fates) for case in self._cases)

    def results(self) -> list[CaseResult]:
        """What was found so far, a result for each case."""
        return [case.result() for case in self._cases]

    def whole_results(self) -> list[CaseResult]:
        """The results of those cases that are done with."""
        return [
            case.result()
            for case in self._cases
            if case.message or len(case.fates) == len(case.mutants)
        ]


def _fate(result: ItemResult) -> Fate | None:
    """A mutant's fate: one that hangs or crashes is killed. None if the case is at fault."""
    if result.status == "done":
        fate: Fate = result.value
        return fate
    if result.status == "error" or result.step == OPENING:
        return None
    how = "timeout" if result.status == "timeout" else f"crash ({result.message})"
    return Fate(status="killed", by=how)


def _broken(result: ItemResult) -> str:
    """Why a case can't be measured."""
    if result.status != "error":
        return f"the case itself does not run to its end: {result.message}"
    if isinstance(result.value, ShaderlabError):
        return error_text(result)
    return f"unforeseen {type(result.value).__name__}: {error_text(result)}"
