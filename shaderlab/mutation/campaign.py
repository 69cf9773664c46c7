"""A mutation run: the mutants of some cases, made and judged by worker processes.

Mutants may loop for ever or take the driver down, so they are judged where that costs one process.
"""

import contextlib
import random
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from shaderlab.engine.jobs import Executor, Request, format_error
from shaderlab.engine.worker import Worker
from shaderlab.errors import ShaderlabError
from shaderlab.model.case import Case
from shaderlab.model.options import RunOptions
from shaderlab.mutation.call_mutants import mutate_calls
from shaderlab.mutation.judging import Judge
from shaderlab.mutation.mutants import CaseResult, Mutant, MutantResult, MutantRun, select_scenes
from shaderlab.mutation.shader_mutants import mutate_case
from shaderlab.mutation.state_mutants import mutate_state
from shaderlab.workers.pool import ItemResult

_COMPILING, _OPENING = "compiling the case's shaders", "running the case as it is"
"""The steps that a worker notes while it opens a case; the first has a mutant's time limit."""
OPENING_SECONDS = 120.0


@dataclass(frozen=True, kw_only=True)
class MutationPlan:
    """Which mutants are made, and what they are judged by.

    Attributes:
        variants: names of the only variants to judge by; all of them if empty.
        state: mutate the cases' fixed-function state as well.
        api: mutate the calls of OpenGL that drawing takes, and nothing else.
        limit: the most mutants of a case, drawn at random by `seed`; 0 for all.
        seed: selects the mutants that `limit` draws.
    """

    variants: tuple[str, ...] = ()
    state: bool = True
    api: bool = False
    limit: int = 0
    seed: int = 0

    def sample(self, mutants: Sequence[Mutant]) -> list[Mutant]:
        """Return as many of these, in their order, as the limit allows."""
        if not self.limit or self.limit >= len(mutants):
            return list(mutants)
        numbers = random.Random(self.seed).sample(range(len(mutants)), self.limit)
        return [mutants[i] for i in sorted(numbers)]


@dataclass(frozen=True)
class MutationTarget(ABC):
    """What mistakes are made in, and what judges them: a case, or a file of tests. As a request it
    makes them. Results have its `id`."""

    file: Path
    id: str
    plan: MutationPlan

    @abstractmethod
    def perform(self, worker: Worker) -> list[Mutant]:
        """Return its mutants."""

    @abstractmethod
    def judge(self, mutant: Any) -> Request:
        """Return the request for a mutant's `MutantResult`."""


class CaseTarget(MutationTarget):
    """A case. Raises ShaderError if a shader can't be read; for mutants of calls the case is drawn,
    and whatever is wrong with that is raised."""

    def perform(self, worker: Worker) -> list[Mutant]:
        case, plan = worker.case(str(self.file)), self.plan
        if not plan.api:
            return make_mutants(case, plan)
        calls = mutate_calls(worker.lab(RunOptions()), case, plan.seed, plan.variants)
        return plan.sample(calls)

    def judge(self, mutant: Mutant) -> "JudgeMutant":
        return JudgeMutant(self.file, self.plan.variants, mutant)


@dataclass(frozen=True)
class JudgeMutant:
    """Requests a mutant's `MutantResult`.

    The worker keeps one case open, with what it draws unmutated. Where this mutant is of another
    case, it opens that one, with its own time limit.
    """

    file: Path
    variants: tuple[str, ...]
    mutant: Mutant

    def perform(self, worker: Worker) -> MutantResult:
        judge: Judge = worker.keep("judge", (self.file, self.variants), lambda: self._open(worker))
        return judge.judge(self.mutant)

    def _open(self, worker: Worker) -> Judge:
        worker.note(_COMPILING)
        lab, case = worker.lab(RunOptions()), worker.case(str(self.file))
        for scene in select_scenes(case, self.variants):
            worker.restart_limit()
            lab.prepare_for_opengl(scene)
        worker.note(_OPENING)
        worker.restart_limit(OPENING_SECONDS)
        judge = Judge(lab, case, self.variants)
        worker.note("")
        worker.restart_limit()
        return judge


def make_mutants(case: Case, plan: MutationPlan) -> list[Mutant]:
    """Return the mutants of a case's shaders and state, as many as the plan's limit allows."""
    mutants: list[Mutant] = [*mutate_case(case, plan.variants)]
    if plan.state:
        mutants += mutate_state(case, plan.seed, plan.variants)
    return plan.sample(mutants)


@dataclass
class _TargetRun:
    target: MutationTarget
    mutants: Sequence[Mutant] = ()
    results: dict[int, MutantResult] = field(default_factory=dict)
    seconds: float = 0.0
    message: str = ""


class MutationRun:
    """Makes the mutants of some cases, or other targets, then judges them. A case that has none,
    as a shader can't be read, has a message that says so."""

    def __init__(self, targets: Sequence[MutationTarget], executor: Executor) -> None:
        self._executor = executor
        self._runs = [_TargetRun(target) for target in targets]
        for result in executor.perform(targets):
            run = self._runs[result.number]
            if result.status == "done":
                run.mutants = result.value
            else:
                run.message = _describe_failure(result, "making its mutants")
        self.total = sum(len(run.mutants) for run in self._runs)

    def judge(self) -> Iterator[tuple[str, MutantResult | None]]:
        """Yield a case's id and the result of one of its mutants, for each as it is judged; None
        for those that are left out because the case does not pass unmutated."""
        every = [(run, index) for run in self._runs for index in range(len(run.mutants))]
        waiting = {(run.target.file, index): (run, index) for run, index in every}
        while waiting:
            batch = list(waiting.values())
            requests = [run.target.judge(run.mutants[index]) for run, index in batch]
            results = self._executor.perform(requests)
            with contextlib.closing(results):
                for item in results:
                    run, index = batch[item.number]
                    run.seconds += item.seconds
                    result = _mutant_result(item)
                    if result is None:
                        run.message = _describe_failure(item)
                        for key in [key for key in waiting if key[0] == run.target.file]:
                            del waiting[key]
                            yield run.target.id, None
                        break  # no other worker shall open it
                    run.results[index] = result
                    del waiting[run.target.file, index]
                    yield run.target.id, result

    @property
    def judged(self) -> int:
        return sum(len(run.results) for run in self._runs)

    def results(self, complete: bool = False) -> list[CaseResult]:
        """Return a result for each case, or for those that are `complete`."""
        return [
            CaseResult(
                id=run.target.id,
                runs=tuple(MutantRun(run.mutants[i], run.results[i]) for i in sorted(run.results)),
                seconds=run.seconds,
                message=run.message,
            )
            for run in self._runs
            if not complete or run.message or len(run.results) == len(run.mutants)
        ]


def _mutant_result(item: ItemResult) -> MutantResult | None:
    """What came of a mutant: one that hangs or crashes is killed. None if the case is at fault."""
    if item.status == "done":
        return cast(MutantResult, item.value)
    if item.status == "error" or item.step in (_COMPILING, _OPENING):
        return None
    how = "timeout" if item.status == "timeout" else f"crash ({item.message})"
    return MutantResult("killed", how)


def _describe_failure(
    item: ItemResult, what: str = "the case itself does not run to its end"
) -> str:
    if item.status != "error":
        late = "\n→ allow more time: --timeout S" * (
            item.status == "timeout" and item.step != _OPENING
        )
        return f"{what}: {item.message}{late}"
    unforeseen = not isinstance(item.value, ShaderlabError | MemoryError)
    said = format_error(item) or "out of memory"
    return f"unforeseen {type(item.value).__name__}: " * unforeseen + said
