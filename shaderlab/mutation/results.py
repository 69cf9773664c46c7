"""The fates of mutants, and the score that follows from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from shaderlab.mutation.mutants import Mutant
from shaderlab.mutation.states import STATE

Status = Literal["killed", "survived", "equivalent", "unjudged", "invalid"]


@dataclass(frozen=True, kw_only=True)
class Fate:
    """The fate of one mutant.

    Attributes:
        status: "killed" by an expectation, a crash or a time limit; "survived" where a judged
            output changed and every expectation passed; "equivalent" where no output changes;
            "unjudged" where only outputs change that no expectation reads, as in pictures for
            people; "invalid" where a compiler refuses it.
        by: the variant and expectation that killed it, or what else there is to say.
    """

    status: Status
    by: str = ""


@dataclass(frozen=True)
class Tried:
    """A mutant with its fate."""

    mutant: Mutant
    fate: Fate

    @property
    def of_state(self) -> bool:
        """Whether it is a mistake in the case's fixed-function state and not in a shader."""
        return self.mutant.operator == STATE


@dataclass(frozen=True, kw_only=True)
class CaseResult:
    """All mutants of one case; `message` says why there are none where the case itself fails."""

    id: str
    tried: tuple[Tried, ...]
    seconds: float
    message: str = ""

    def count(self, status: Status) -> int:
        """How many mutants ended like this."""
        return sum(t.fate.status == status for t in self.tried)

    @property
    def survivors(self) -> list[Tried]:
        """Mutants that changed a judged output and passed all the same."""
        return [t for t in self.tried if t.fate.status == "survived"]

    @property
    def score(self) -> float | None:
        """Shader mutants killed, of killed and survived; None of nothing."""
        return score([self])


def score(
    results: Iterable[CaseResult], *, state: bool = False, unjudged: bool = False
) -> float | None:
    """Share of mutants killed, of those killed and survived; None of nothing.

    Args:
        results: of one case or several.
        state: the score of the mutants of fixed-function state, not of the shaders' ones.
        unjudged: count those that only a picture shows as missed.
    """
    missing = ("survived", "unjudged") if unjudged else ("survived",)
    mine = [t.fate.status for r in results for t in r.tried if t.of_state == state]
    killed, missed = mine.count("killed"), sum(status in missing for status in mine)
    return killed / (killed + missed) if killed + missed else None


def as_json(results: Sequence[CaseResult]) -> dict[str, Any]:
    """Everything worth keeping, for other programs."""
    return {
        "cases": [
            {
                "id": result.id,
                "killed": result.count("killed"),
                "survived": [_entry(t) for t in result.survivors],
                "invalid": result.count("invalid"),
                "equivalent": result.count("equivalent"),
                "unjudged": result.count("unjudged"),
                "score": result.score,
                "score_with_unjudged": score([result], unjudged=True),
                "state_score": score([result], state=True),
                "killed_in_state": sum(
                    t.of_state and t.fate.status == "killed" for t in result.tried
                ),
                "seconds": round(result.seconds, 3),
                **({"message": result.message} if result.message else {}),
            }
            for result in results
        ],
        "score": score(results),
        "score_with_unjudged": score(results, unjudged=True),
        "state_score": score(results, state=True),
    }


def summary_rows(results: Sequence[CaseResult]) -> list[Mapping[str, Any]]:
    """One row a case for a table, survivors as lines of text."""
    return [
        {
            "id": result.id,
            "killed": result.count("killed"),
            "judged": result.count("killed") + result.count("survived"),
            "score": result.score,
            "survivors": [str(t.mutant) for t in result.survivors],
        }
        for result in results
    ]


def _entry(tried: Tried) -> dict[str, Any]:
    return {
        "file": tried.mutant.file,
        "line": tried.mutant.line,
        "operator": tried.mutant.operator,
        "before": tried.mutant.before,
        "after": tried.mutant.after,
        **({"note": tried.fate.by} if tried.fate.by else {}),
    }
