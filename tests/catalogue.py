"""The lab's own cases, loaded once for all tests of a process."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

from benchmarks.shipped import load_cases

if TYPE_CHECKING:
    from shaderlab.model.case import Case

FOR_PEOPLE = {"scene", "picture"}


@cache
def shipped() -> Mapping[str, Case]:
    """The cases by id. Cases can't be changed, so tests may share them."""
    return load_cases()


@cache
def judged_only(case_id: str) -> Case:
    """A case without its large pictures, and without what is expected of them in all variants."""
    case = shipped()[case_id]
    scene = next(case.scenes())
    kept = tuple(p for p in case.passes if p.name not in FOR_PEOPLE)
    expect = [
        e for e in case.expect if not FOR_PEOPLE & {read.pass_name for read in e.find_reads(scene)}
    ]
    return replace(case, passes=kept, expect=expect, picture="")
