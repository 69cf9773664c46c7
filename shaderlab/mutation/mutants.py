"""A mutant: what it changes in a scene, what has to be drawn to judge it, and what came of it."""

import random
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeVar

from shaderlab.engine.pictures import find_read_passes, with_read_passes
from shaderlab.files import display_path
from shaderlab.model.calls import CallEdit
from shaderlab.model.case import Case, Scene

T = TypeVar("T")
STATE = "state"
"""The operator of mutants of fixed-function state."""


@dataclass(frozen=True)
class Effect:
    """What a mutant changes in one scene.

    Attributes:
        scene: the scene with the mistake, if that is one of its data.
        passes: the passes that run what was changed.
        vertex_passes: those of them in which it is a vertex or geometry shader.
        program: the shaders of the program whose text is changed.
        texts: the texts to take in place of some of its shaders', by name.
        edit: what becomes of one call of its drawing.
    """

    scene: Scene
    passes: frozenset[str]
    vertex_passes: frozenset[str] = frozenset()
    program: tuple[str, ...] = ()
    texts: Mapping[str, str] = field(default_factory=dict)
    edit: CallEdit | None = None


@dataclass(frozen=True, kw_only=True)
class Mutant(ABC):
    """One small, realistic mistake.

    Attributes:
        file, line: the place in the author's file, the line counted from 1; 0 for none.
        operator: the kind of mistake, such as "constant + 1 %".
        before, after: the expression or statement that shows it.
        program: the shaders of the program that has it; none for a mistake in state or calls.
        text_edit: the shader, the line (from 1) and the column (from 0) in its text with includes
            expanded, what stands there, and what the mistake puts in its place; or nothing.
    """

    file: str
    line: int
    operator: str
    before: str
    after: str
    program: tuple[str, ...] = ()
    text_edit: tuple[str, int, int, str, str] | None = None

    @abstractmethod
    def effect(self, scene: Scene) -> Effect | None:
        """Return what it changes in a scene; None for nothing."""

    def __str__(self) -> str:
        place = display_path(self.file, self.line or None)
        alone = len(self.program) == 1 and self.file.endswith(self.program)
        where = f"  in {' + '.join(self.program)}" if self.program and not alone else ""
        return f"{place}  {self.operator}: {self.before} → {self.after}{where}"


def select_scenes(case: Case, variants: Collection[str] = ()) -> list[Scene]:
    """Return the case's scenes: those of the named `variants`, or all."""
    return [s for s in case.scenes() if not variants or s.variant in variants]


def sample_alike(alike: Mapping[Any, list[T]], most: int, seed: int) -> Iterator[list[T]]:
    """Yield so many of each list at most, the same ones for a seed."""
    for key, same in alike.items():
        yield random.Random(f"{seed}{key}").sample(same, min(most, len(same)))


def with_readers(scene: Scene, passes: Collection[str]) -> set[str]:
    """Return the names of these passes and of all that read what they draw."""
    touched = set(passes)
    for description in scene.passes:
        if find_read_passes(description) & touched:
            touched.add(description.name)
    return touched


def part_of(scene: Scene, passes: Collection[str], expect: Iterable[int] = ()) -> Scene:
    """Return the scene with some of its passes and expectations."""
    return replace(
        scene,
        passes=tuple(p for p in scene.passes if p.name in passes),
        expect=tuple(scene.expect[i] for i in expect),
    )


@dataclass(frozen=True)
class Trial:
    """One scene to try a mutant on; the `touched` passes may draw something else, the expectations
    with the indices `expect` may fail."""

    scene: Scene
    effect: Effect
    touched: set[str]
    expect: list[int]

    def part(self, everything: bool = False) -> Scene:
        """Return as much of the changed scene as the expectations need, or all that is touched."""
        names = {name for i in self.expect for name in self.scene.expect[i].passes(self.scene)}
        names |= self.touched if everything else set()
        return part_of(self.effect.scene, with_read_passes(self.scene, names), self.expect)


Status = Literal["killed", "survived", "equivalent", "no difference", "invalid"]


@dataclass(frozen=True)
class MutantResult:
    """What came of one mutant.

    Attributes:
        status: "killed" by an expectation, a crash or a time limit; "survived" where an output
            changes, be it on other inputs than the case's, and every expectation passes;
            "equivalent" where the compiler makes the same program of it; "no difference" where no
            input was found that tells it from the original; "invalid" where a compiler refuses it.
        by: the variant and expectation that killed it, or what else there is to say.
        unread: whether it survived because no expectation reads what changes.
        noticed: for a file of tests, whether each test notices it.
    """

    status: Status
    by: str = ""
    unread: bool = False
    noticed: Mapping[str, bool] = field(default_factory=dict)


@dataclass(frozen=True)
class MutantRun:
    mutant: Mutant
    result: MutantResult

    @property
    def is_state(self) -> bool:
        """Whether it is a mistake in the case's fixed-function state and not in a shader."""
        return self.mutant.operator == STATE


@dataclass(frozen=True, kw_only=True)
class CaseResult:
    """All mutants of one case; `message` says why there are none where the case itself fails."""

    id: str
    runs: tuple[MutantRun, ...]
    seconds: float
    message: str = ""

    def count(self, status: Status) -> int:
        return len(self.with_status(status))

    def with_status(self, status: Status) -> list[MutantRun]:
        return [run for run in self.runs if run.result.status == status]

    @property
    def survivors(self) -> list[MutantRun]:
        """The mutants that changed an output while everything passed."""
        return self.with_status("survived")

    @property
    def noticed(self) -> dict[str, int]:
        """For a file of tests, how many mutants each test notices."""
        found: Counter[str] = Counter()
        for run in self.runs:
            found.update(run.result.noticed)
        return found

    @property
    def score(self) -> float | None:
        return score([self])


def score(results: Iterable[CaseResult], *, state: bool = False) -> float | None:
    """Return the share of mutants killed, of those killed and survived; None of nothing.

    With `state` they are those of fixed-function state, else those of shaders.
    """
    statuses = [run.result.status for r in results for run in r.runs if run.is_state == state]
    killed, survived = statuses.count("killed"), statuses.count("survived")
    return killed / (killed + survived) if killed + survived else None


def results_to_json(results: Sequence[CaseResult]) -> dict[str, Any]:
    """Return the results as plain data; docs/guide/mutation.md describes the fields."""
    return {
        "cases": [_case_to_json(result) for result in results],
        "score": score(results),
        "state_score": score(results, state=True),
    }


def _case_to_json(result: CaseResult) -> dict[str, Any]:
    killed = result.with_status("killed")
    texts = (run for run in killed if run.mutant.text_edit)
    examples = {(run.mutant.program, run.mutant.operator): run for run in texts}
    return {
        "id": result.id,
        "killed": len(killed),
        "survived": [_run_to_json(run) for run in result.survivors],
        "invalid": result.count("invalid"),
        "equivalent": result.count("equivalent"),
        "no_difference": [_run_to_json(run) for run in result.with_status("no difference")],
        "examples": [_run_to_json(run) for run in examples.values()],
        "score": result.score,
        "state_score": score([result], state=True),
        "killed_in_state": sum(run.is_state for run in killed),
        **({"noticed": result.noticed} if result.noticed else {}),
        "seconds": round(result.seconds, 3),
        **({"message": result.message} if result.message else {}),
    }


def _run_to_json(run: MutantRun) -> dict[str, Any]:
    placed = ("file", "line", "operator", "before", "after")
    return {
        **{name: getattr(run.mutant, name) for name in placed},
        "program": list(run.mutant.program),
        **({"edit": list(run.mutant.text_edit)} if run.mutant.text_edit else {}),
        **({"note": run.result.by} if run.result.by else {}),
        **({"unread": True} if run.result.unread else {}),
    }
