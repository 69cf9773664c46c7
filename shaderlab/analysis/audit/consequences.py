"""What depends on a value that went wrong: the program is run again with other values for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Integer
from shaderlab.model.frame import Array

from ..equivalence.comparing import flattened
from ..inputs import Given
from ..interpreter import Program
from ..interpreter.program import Instruction
from ..interpreter.running import Run, Watch
from ..interpreter.values import PathState
from .watching import FLOATS, Place, arguments_of, run_watched

_VALUES = (None, 0.37, 41.0, -2.6, 7.5e3)
_STAND_IN = 0.5
_DISCARDED = "discard"


@dataclass(frozen=True)
class _Replacing:
    """A `Watch` that gives an instruction another result, or leaves it as it is with None. Other
    results that are no number although all operands are become one: they would hide what depends
    on this one."""

    place: Place
    value: float | None

    def __call__(self, run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        if at.id == self.place.id and tuple(run.calls) == self.place.calls:
            return result if self.value is None else _other(result, self.value)
        if isinstance(result, np.ndarray) and at.op in FLOATS and not np.isfinite(result).all():
            values = run.values(arguments_of(at.op, at.operands))
            if all(np.isfinite(v).all() for v in values if isinstance(v, np.ndarray)):
                return np.where(np.isfinite(result), result, np.float32(_STAND_IN))
        return result


@dataclass
class _Zeroing:
    """A `Watch` that makes every result 0 that is a certain number.

    Attributes:
        reached: whether an instruction is run with such an operand even so.
    """

    place: Place
    number: float
    reached: bool = False

    def __call__(self, run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        if at.id == self.place.id and tuple(run.calls) == self.place.calls:
            self.reached = True
        if isinstance(result, np.ndarray):
            return np.where(result == np.float32(self.number), np.float32(0.0), result)
        return result


def _other(result: Any, value: float) -> Any:
    if isinstance(result, tuple):
        return tuple(_other(part, value) for part in result)
    if isinstance(result, Integer):
        return Integer(np.full_like(result.lo, int(abs(value))), unsigned=result.unsigned)
    if isinstance(result, np.ndarray):
        return np.full_like(result, value)
    return result


def written(
    program: Program, given: Given, row: int, watch: Watch | None = None
) -> Mapping[str, Array]:
    """What an invocation writes, by output; `"discard"` is 1 where it is discarded."""
    result = run_watched(program, given, watch)
    found = _as_they_are(result.outputs, row)
    gone = bool(np.broadcast_to(result.discarded.all_true, (given.count,))[row])
    found[_DISCARDED] = np.array([float(gone)])
    return found


def _as_they_are(outputs: Mapping[str, Any], row: int) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for name, value in outputs.items():
        if isinstance(value, tuple):
            found |= _as_they_are({f"{name}[{i}]": part for i, part in enumerate(value)}, row)
        elif isinstance(value, np.ndarray):
            found[name] = value[row].astype(np.float64).ravel()
        else:
            found |= {n: v[row] for n, v in flattened({name: value})}
    return found


def alone(program: Program, given: Given, row: int) -> tuple[Given, int]:
    """An invocation with those of its quad that it depends on, and its row among them."""
    rows = given.rows_with(np.array([row]), program)
    return given.part(rows), int(np.flatnonzero(rows == row)[0])


def depending(program: Program, given: Given, row: int, place: Place) -> dict[str, Array]:
    """The outputs that depend on an instruction's result at an invocation, as they are."""
    some, own = alone(program, given, row)
    plain = written(program, some, own)
    others = [written(program, some, own, _Replacing(place, value)) for value in _VALUES]
    return {name: value for name, value in plain.items() if _differs(name, others)}


def _differs(name: str, runs: Sequence[Mapping[str, Array]]) -> bool:
    values = [run[name] for run in runs if name in run]
    return len(values) < len(runs) or any(
        not np.array_equal(value, values[0], equal_nan=True) for value in values
    )


def reached_by_0(program: Program, given: Given, row: int, place: Place, number: float) -> bool:
    """Whether an instruction is run where a number is 0 that is nearly so at an invocation; not so
    if a condition is before it, such as `x != 0.0`."""
    some, own = alone(program, given, row)
    watch = _Zeroing(place, number)
    written(program, some, own, watch)
    return watch.reached
