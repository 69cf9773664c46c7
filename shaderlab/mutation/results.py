"""The fates of mutants, and the score that follows from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from shaderlab.mutation.mutants import Mutant
from shaderlab.mutation.states import STATE

Status = Literal["killed", "survived", "equivalent", "no difference", "invalid"]


@dataclass(frozen=True, kw_only=True)
class Fate:
    """The fate of one mutant.

    Attributes:
        status: "killed" by an expectation, a crash or a time limit; "survived" where an output
            changes, be it on other inputs than the case's, and every expectation passes;
            "equivalent" where the compiler makes the same program of it; "no difference" where no
            input was found that tells it from the original; "invalid" where a compiler refuses it.
        by: the variant and expectation that killed it, or what else there is to say.
        unread: whether it survived because no expectation reads what changes.
        noticed: of a file of tests, whether each test notices it.
        traced: where a killed one was traced to, "lamp.frag:12: diffuse"; "" if it was not asked
            for, or not found.
    """

    status: Status
    by: str = ""
    unread: bool = False
    noticed: Mapping[str, bool] = field(default_factory=dict)
    traced: str = ""


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
        return len(self.with_status(status))

    @property
    def survivors(self) -> list[Tried]:
        """Mutants that changed an output and passed all the same."""
        return self.with_status("survived")

    def with_status(self, status: Status) -> list[Tried]:
        """The mutants that ended like this."""
        return [t for t in self.tried if t.fate.status == status]

    @property
    def noticed(self) -> dict[str, int]:
        """Of a file of tests, how many mutants each test notices."""
        found: dict[str, int] = {}
        for tried in self.tried:
            for name, failed in tried.fate.noticed.items():
                found[name] = found.get(name, 0) + failed
        return found

    @property
    def score(self) -> float | None:
        """Shader mutants killed, of killed and survived; None of nothing."""
        return score([self])


def score(results: Iterable[CaseResult], *, state: bool = False) -> float | None:
    """Share of mutants killed, of those killed and survived; None of nothing.

    Args:
        results: of one case or several.
        state: the score of the mutants of fixed-function state, not of the shaders' ones.
    """
    mine = [t.fate.status for r in results for t in r.tried if t.of_state == state]
    killed, survived = mine.count("killed"), mine.count("survived")
    return killed / (killed + survived) if killed + survived else None


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
                "no_difference": [_entry(t) for t in result.with_status("no difference")],
                "score": result.score,
                "state_score": score([result], state=True),
                "killed_in_state": sum(
                    t.of_state and t.fate.status == "killed" for t in result.tried
                ),
                **({"traced": traced} if (traced := _traced(result)) else {}),
                **({"noticed": result.noticed} if result.noticed else {}),
                "seconds": round(result.seconds, 3),
                **({"message": result.message} if result.message else {}),
            }
            for result in results
        ],
        "score": score(results),
        "state_score": score(results, state=True),
    }


def _traced(result: CaseResult) -> list[dict[str, Any]]:
    """The killed mutants that were traced to a statement."""
    return [
        {**_entry(t), "traced": t.fate.traced}
        for t in result.with_status("killed")
        if t.fate.traced
    ]


_PLACED = ("file", "line", "operator", "before", "after")


def _entry(tried: Tried) -> dict[str, Any]:
    return {
        **{name: getattr(tried.mutant, name) for name in _PLACED},
        "program": list(tried.mutant.program),
        **({"note": tried.fate.by} if tried.fate.by else {}),
        **({"unread": True} if tried.fate.unread else {}),
    }
