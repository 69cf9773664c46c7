"""The first line at which two programs go apart, at one invocation."""

from __future__ import annotations

import itertools
import warnings
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..interpreter import Program, Stored, interpret
from ..interpreter.arithmetic import Arithmetic
from .given import Given

_KILL = 252  # OpKill
_SOON, _MORE = 128, 16  # stored values that are compared first; how many times as many then
Differ = Callable[[Any, Any], bool]


@dataclass(frozen=True, eq=False)
class Step:
    """A value that was stored: the variable, how often it had been before, its line, the value."""

    name: str
    turn: int
    line: int
    value: Any


class _EnoughError(Exception):
    """As many values were stored as are looked at."""


def steps(
    program: Program, given: Given, row: int, arithmetic: Arithmetic, most: int | None = None
) -> list[Step]:
    """What an invocation stores, in order, all of it or so many values at most. Its quad runs with
    it where that matters."""
    rows = given.rows_with(np.array([row]), program)
    quad, own = given.part(rows), int(np.flatnonzero(rows == row)[0])
    found: list[Step] = []
    turns: Counter[str] = Counter()

    def note(stored: Stored) -> None:
        if stored.mask[own] and not isinstance(stored.value, tuple):
            value = stored.value
            lane = value[own : own + 1] if value.shape[0] > 1 else value
            found.append(Step(stored.name, turns[stored.name], stored.line, lane))
            turns[stored.name] += 1
            if len(found) == most:
                raise _EnoughError

    with warnings.catch_warnings(), np.errstate(all="ignore"), suppress(_EnoughError):
        warnings.simplefilter("ignore")
        interpret(program, quad.each, quad.bindings, arithmetic, count=quad.count, trace=note)
    return found


def first(
    programs: tuple[Program, Program],
    given: Given,
    row: int,
    arithmetic: Arithmetic,
    differ: Differ,
) -> tuple[Step | None, list[Step], list[Step]]:
    """The first step of an invocation in which the new program stores another value than the old
    one, None where none is; and what either stored up to there, or beyond."""
    most = _SOON
    while True:
        old, new = (steps(program, given, row, arithmetic, most) for program in programs)
        pairs = _in_order(old, new)
        found = next((b for a, b in pairs if differ(a.value, b.value)), None)
        if found is not None:
            return found, old, new
        if max(len(old), len(new)) < most:
            return _later(old, new, len(pairs), differ), old, new
        most *= _MORE


def _in_order(old: list[Step], new: list[Step]) -> list[tuple[Step, Step]]:
    """The steps of both up to where they store to other variables, or in another order."""
    pairs = zip(old, new, strict=False)
    return list(itertools.takewhile(lambda pair: pair[0].name == pair[1].name, pairs))


def _later(old: list[Step], new: list[Step], start: int, differ: Differ) -> Step | None:
    """The first of the new program's later steps that another value is stored in than in the old
    one's step of the same variable. What functions return has no name, and is left out."""
    known = {(step.name, step.turn): step for step in old if step.name != "return"}
    later = (step for step in new[start:] if (step.name, step.turn) in known)
    return next((b for b in later if differ(known[b.name, b.turn].value, b.value)), None)


def discards(program: Program) -> list[int]:
    """The lines at which a program discards."""
    return sorted(
        instruction.line
        for function in program.functions.values()
        for block in function.blocks.values()
        for instruction in block
        if instruction.op == _KILL
    )
