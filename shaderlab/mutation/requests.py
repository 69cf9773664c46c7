"""What a campaign asks of workers: a case's mutants, and the fate of each.

Mutants may loop for ever or take the driver down, so they are judged where that costs one process.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.model.options import RunOptions
from shaderlab.mutation.results import Fate

if TYPE_CHECKING:
    from shaderlab.model.case import Case
    from shaderlab.mutation.judging import Judge
    from shaderlab.mutation.mutants import Mutant
    from shaderlab.workers.lab_worker import LabWorker

OPENING = "running the case as it is"
"""The step that a worker notes while it opens a case."""
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
        locate: ask which statement each killed mutant is traced to.
    """

    variants: tuple[str, ...] = ()
    state: bool = True
    api: bool = False
    limit: int = 0
    seed: int = 0
    locate: bool = False


@dataclass(frozen=True)
class MakeMutants:
    """Asks for a case's mutants. Raises ShaderError if a shader can't be read; for mutants of calls
    the case is drawn, and whatever is wrong with that is raised."""

    file: Path
    plan: MutationPlan

    def perform(self, worker: LabWorker) -> Sequence[Mutant]:
        case = worker.case(str(self.file))
        if not self.plan.api:
            return mutants_of_case(case, self.plan)
        from shaderlab.mutation.api_mutants import api_mutants

        lab = worker.lab(RunOptions())
        return chosen(api_mutants(lab, case, self.plan.seed, self.plan.variants), self.plan)


@dataclass(frozen=True)
class JudgeMutant:
    """Asks for a mutant's `Fate`.

    The worker keeps one case open, with what it draws unmutated; it opens another one, with a time
    limit of its own, where this mutant is of another.
    """

    file: Path
    variants: tuple[str, ...]
    mutant: Mutant
    locate: bool = False

    def perform(self, worker: LabWorker) -> Fate:
        judge: Judge = worker.keep(
            "judge", (self.file, self.variants, self.locate), lambda: self._open(worker)
        )
        return judge.fate(self.mutant)

    def _open(self, worker: LabWorker) -> Judge:
        from shaderlab.mutation.judging import Judge

        worker.note(OPENING)
        worker.restart_limit(OPENING_SECONDS)
        lab, case = worker.lab(RunOptions()), worker.case(str(self.file))
        judge = Judge(lab, case, self.variants, locate=self.locate)
        worker.note("")
        worker.restart_limit()
        return judge


def mutants_of_case(case: Case, plan: MutationPlan) -> list[Mutant]:
    """The mutants of a case in the order of its programs, after `limit`."""
    from shaderlab.mutation.states import state_mutants
    from shaderlab.mutation.subjects import glsl_mutants

    found: list[Mutant] = [*glsl_mutants(case, plan.variants)]
    if plan.state:
        found += state_mutants(case, plan.seed, plan.variants)
    return chosen(found, plan)


def chosen(found: Sequence[Mutant], plan: MutationPlan) -> list[Mutant]:
    """As many of these, in their order, as a plan's limit allows."""
    if not plan.limit or plan.limit >= len(found):
        return list(found)
    numbers = random.Random(plan.seed).sample(range(len(found)), plan.limit)
    return [found[i] for i in sorted(numbers)]
