"""What this package adds to the run of each scene."""

from __future__ import annotations

from shaderlab.engine.evaluation import FEATURES, Evaluation
from shaderlab.engine.expectations.formula import Formula
from shaderlab.model.records import Explanation, Outcome

from .self_check import SelfCheck


def register() -> None:
    """Have the engine hold draws against their shaders, and explain formulas that fail."""
    FEATURES.self_check = SelfCheck
    FEATURES.explain = _explain


def _explain(evaluation: Evaluation, formula: Formula, outcome: Outcome) -> Explanation | None:
    from .explain import locate_failure  # it parses GLSL, which few runs need

    return locate_failure(evaluation, formula, outcome)
