"""The first line at which two programs go apart, at one invocation."""

from __future__ import annotations

import itertools
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.equivalence.given import Given
from shaderlab.interpreter import Program, Stored, interpret
from shaderlab.interpreter.arithmetic import Arithmetic

_KILL = 252  # OpKill
Differ = Callable[[Any, Any], bool]


@dataclass(frozen=True, eq=False)
class Step:
    """A value that was stored: the variable, how often it had been before, its line, the value."""

    name: str
    turn: int
    line: int
    value: Any


def steps(program: Program, given: Given, row: int, arithmetic: Arithmetic) -> list[Step]:
    """What an invocation stores, in order. Its quad runs with it where that matters."""
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

    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        interpret(program, quad.each, quad.bindings, arithmetic, count=quad.count, trace=note)
    return found


def first(old: list[Step], new: list[Step], differ: Differ) -> Step | None:
    """The first of the new program's steps that another value is stored in than in the old one's
    step of the same variable; None where none is.

    What functions return has no name: it counts up to where the programs store to other variables,
    or in another order.
    """
    pairs = list(
        itertools.takewhile(lambda pair: pair[0].name == pair[1].name, zip(old, new, strict=False))
    )
    known = {(step.name, step.turn): step for step in old if step.name != "return"}
    later = [step for step in new[len(pairs) :] if (step.name, step.turn) in known]
    pairs += [(known[step.name, step.turn], step) for step in later]
    return next((b for a, b in pairs if differ(a.value, b.value)), None)


def discards(program: Program) -> list[int]:
    """The lines at which a program discards."""
    return sorted(
        instruction.line
        for function in program.functions.values()
        for block in function.blocks.values()
        for instruction in block
        if instruction.op == _KILL
    )
