"""Where two programs differ: inputs on both sides of jumps, the first value stored otherwise, and
how accurate each is."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shaderlab.compiler.spirv import Op
from shaderlab.model.frame import Array

from .batches import InputBatch, join_batches, run_batch
from .inputs import Domains
from .interpreter import FLOAT64, Program, Stored
from .interpreter.program import Instruction
from .interpreter.running import Run
from .interpreter.values import Flags, PathState
from .noise import PerturbedFloat, run

PAIRS = 192
_PARTS, _ROUNDS = 8, 6  # each round looks for the steepest of so many parts
_SMOOTH = 2  # after so many rounds a change that goes on shrinking is no jump
_SHRINKS = 0.5  # what is left of a smooth change from one round to the next, at most
_ENDS = 1e-6  # what stored values may differ by where a step is called the same
_JUMP = 1e9  # how far apart something and nothing are


def jumps(
    pair: tuple[Program, Program], batch: InputBatch, domains: Domains, count: int
) -> InputBatch | None:
    """Inputs on both sides of places where one of the programs jumps, on the straight ways between
    so many pairs of invocations; None where both are smooth, or nothing can be varied steadily."""
    steady = [
        name
        for name, values in batch.each.items()
        if name != "gl_FragCoord" and len(values) == batch.count
        if values.dtype.kind == "f" and values.ndim == 2
    ]
    if not steady or batch.count < 2:
        return None
    rng = np.random.default_rng(23)
    start, end = (batch.part(rows) for rows in rng.integers(0, batch.count, (2, count)))
    alone = rng.integers(0, len(steady), count)  # ways along one input
    alone[: count // 2] = -1  # and along all of them
    moved = {
        name: np.where(((alone == -1) | (alone == i))[:, None], end.each[name], start.each[name])
        for i, name in enumerate(steady)
    }
    ends = []
    for program in pair:
        low, high = start, InputBatch({**start.each, **moved}, start.bindings, count)
        before = np.full(count, np.inf)
        for number in range(_ROUNDS):
            pairs = [(n, low.each[n].astype(np.float64), high.each[n]) for n in steady]
            ways = (
                {n: domains[n].clip(a + t * (b - a)) for n, a, b in pairs}
                for t in np.linspace(0.0, 1.0, _PARTS + 1)
            )
            along = join_batches([replace(low, each={**low.each, **way}) for way in ways])
            changes = _find_changes(program, along)
            steepest = changes.argmax(axis=0) * count + np.arange(count)
            low, high = along.part(steepest), along.part(steepest + count)
            if number >= _SMOOTH and (changes.max(axis=0) <= _SHRINKS * before).all():
                break
            before = changes.max(axis=0)
        else:
            ends += [low, high]
    return join_batches(ends) if ends else None


def _find_changes(program: Program, along: InputBatch) -> Array:
    """How much outputs change from one point of each way to the next, (points - 1, ways)."""
    ran = run(program, along, 0)
    gone = ran.discarded[0][:, None]
    found = [np.where(np.isfinite(v[0]), v[0], -_JUMP) for v in ran.outputs.values()]
    changes = []
    for values in found or [np.zeros((along.count, 1))]:
        points = np.where(gone, _JUMP, values).reshape(_PARTS + 1, -1, values.shape[-1])
        changes.append(np.abs(np.diff(points, axis=0)).max(axis=-1))
    return np.asarray(np.max(changes, axis=0))


_COMPARISONS = range(Op.FOrdEqual, Op.FUnordGreaterThanEqual + 1)


def meet_bounds(program: Program, batch: InputBatch, domains: Domains) -> InputBatch:
    """The invocations; half of the numbers that the program compares with something else are that.
    Raises as `run`."""
    rng = np.random.default_rng(37)
    each = {
        name: batch.each[name].copy() for name, domain in domains.items()
        if domain.kind == "number" and name in batch.each and name != "gl_FragCoord"
    }  # fmt: skip

    first: dict[float, list[str]] = {}  # the inputs that the first invocation has a number of
    for name in each:
        for number in {*batch.each[name].reshape(batch.count, -1)[0].tolist()}:
            first.setdefault(number, []).append(name)

    def meet(run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        if at.op not in _COMPARISONS:
            return result
        for own, other in itertools.permutations(run.values(at.operands), 2):
            for name in first.get(own.item(0), ()) if own.shape == (batch.count, 1) else ():
                equal = (batch.each[name].reshape(batch.count, -1) == own).all(axis=0)
                if equal.any():
                    rows = state.mask & (rng.random(batch.count) < 0.5)
                    bound = np.broadcast_to(domains[name].clip(other), own.shape)
                    each[name].reshape(batch.count, -1)[np.ix_(rows, equal)] = bound[rows]
        return result

    run_batch(program, batch, FLOAT64, watch=meet)
    return replace(batch, each={**batch.each, **each})


def keep_defined(programs: tuple[Program, Program], batch: InputBatch) -> InputBatch:
    """The invocations, in whole quads where it matters, in which not both programs store something
    infinite or undefined. Raises as `run`."""
    old, new = (_meets_undefined(program, batch) for program in programs)
    return batch.part(np.flatnonzero(~(old & new)))


def _meets_undefined(program: Program, batch: InputBatch) -> Flags:
    found = np.zeros(batch.count, np.bool_)

    def note(stored: Stored) -> None:
        if isinstance(stored.value, np.ndarray):
            known = np.isfinite(stored.value).reshape(len(stored.value), -1).all(axis=1)
            np.logical_or(found, stored.mask & ~known, out=found)

    run_batch(program, batch, FLOAT64, trace=note)
    found[batch.rows_with(np.flatnonzero(found), program)] = True
    return found


@dataclass(frozen=True, eq=False)
class Step:
    """A value that was stored: the variable, how often it had been before, its line, the value."""

    name: str
    turn: int
    line: int
    value: Any


def steps(program: Program, batch: InputBatch, row: int) -> list[Step]:
    """What an invocation stores, in order. Its quad runs with it where that matters."""
    quad, own = batch.alone(row, program)
    found: list[Step] = []
    turns: Counter[str] = Counter()

    def note(stored: Stored) -> None:
        if not stored.is_argument and stored.mask[own] and not isinstance(stored.value, tuple):
            value = stored.value
            lane = value[own : own + 1] if value.shape[0] > 1 else value
            found.append(Step(stored.name, turns[stored.name], stored.line, lane))
            turns[stored.name] += 1

    run_batch(program, quad, PerturbedFloat(), trace=note, unwritten=False)
    return found


def first_difference(
    programs: tuple[Program, Program], batch: InputBatch, row: int
) -> tuple[Step | None, list[Step], list[Step]]:
    """The first step of an invocation in which the new program stores another value than the old
    one, None where none is; and what either stores.

    Steps are compared one by one while both store to the same variables, then by variable. What
    functions return has no name, and is left out there."""
    old, new = (steps(program, batch, row) for program in programs)
    zipped = zip(old, new, strict=False)
    same = list(itertools.takewhile(lambda pair: pair[0].name == pair[1].name, zipped))
    found = next((b for a, b in same if _look_different(a.value, b.value)), None)
    if found is None:
        known = {(step.name, step.turn): step for step in old if step.name != "return"}
        later = (step for step in new[len(same) :] if (step.name, step.turn) in known)
        pairs = ((known[b.name, b.turn], b) for b in later)
        found = next((b for a, b in pairs if _look_different(a.value, b.value)), None)
    return found, old, new


def _look_different(a: object, b: object) -> bool:
    """Whether two stored values are other ones, as far as a reader would say so."""
    x, y = (np.asarray(getattr(v, "lo", getattr(v, "all_true", v)), np.float64) for v in (a, b))
    if x.shape[1:] != y.shape[1:]:
        return True
    with np.errstate(all="ignore"):
        near = np.abs(x - y) <= _ENDS * np.maximum(np.abs(x), np.abs(y)) + 1e-12
    return not bool((near | (np.isnan(x) & np.isnan(y)) | (x == y)).all())


def discards(program: Program) -> list[int]:
    """The lines at which a program discards."""
    return sorted(one.line for one in program.instructions if one.op == Op.Kill)
