"""The shipped cases, for benchmarks and tests."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from shaderlab.engine.catalogue import load_case, shipped_cases, sort_key
from shaderlab.model.case import Case


def load_cases(files: Iterable[Path] | None = None) -> dict[str, Case]:
    """Load the shipped cases, or those in `files`, by id, in the order of the notes."""
    cases = map(load_case, shipped_cases() if files is None else files)
    in_order = sorted(cases, key=lambda case: sort_key(case.section, case.id))
    return {case.id: case for case in in_order}
