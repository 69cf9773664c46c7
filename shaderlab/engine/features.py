"""What packages above the engine add to the run of each scene; they register it here."""

from __future__ import annotations

from collections.abc import Callable, Set
from dataclasses import dataclass
from typing import Protocol

from shaderlab.model.expectation import Judgement, Need
from shaderlab.model.records import Explanation, ModulesRecord, Outcome

from .evaluation import Evaluation
from .expectations.formula import Formula


class SceneCheck(Protocol):
    """A check of a whole scene, besides its expectations.

    Attributes:
        outside: the outputs, (pass, output), that failed it; complete after `judgement`.
    """

    outside: set[tuple[str, str]]

    def judge_captured(self, needed: Set[Need]) -> None:
        """Judge what was captured and is not `needed` any more: it is about to be released."""

    def judgement(self) -> tuple[ModulesRecord, Judgement]:
        """Judge the rest, while the scene is on the device, and return what was found."""


@dataclass
class Features:
    """What is registered.

    Attributes:
        self_check: makes a check of a scene: of all its pixels if the flag is set, else of
            a sample.
        explain: says where a formula that fails goes wrong; None where it has no answer.
            Raises ShaderlabError.
    """

    self_check: Callable[[Evaluation, bool], SceneCheck] | None = None
    explain: Callable[[Evaluation, Formula, Outcome], Explanation | None] | None = None


FEATURES = Features()
