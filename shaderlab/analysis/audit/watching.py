"""Watching a program run: how far each instruction is from going wrong, by invocation."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from shaderlab.bands import Integer, Truth
from shaderlab.model.frame import Array

from ..equivalence.comparing import flattened
from ..equivalence.given import Given
from ..interpreter import FLOAT32, Arithmetic, Interpreted, Program, interpret
from ..interpreter.memory import Flags, Pointer, World
from ..interpreter.program import Instruction
from ..interpreter.running import Run, Watch
from ..interpreter.workgroups import numbered, places_in
from .checks import CHECKS, FLOATS, INDEX, OVERFLOW, Check, arguments_of, number_of

_ACCESS = (65, 66)  # OpAccessChain, OpInBoundsAccessChain
_DYNAMIC = {77: 1, 78: 2}  # OpVectorExtractDynamic, OpVectorInsertDynamic: where the index is
_WRAPPING = (128, 130, 132)  # OpIAdd, OpISub, OpIMul
_SIZED = ("vector", "matrix", "array")


@dataclass(frozen=True)
class Place:
    """An instruction by its id, the lines of the calls that led to it, and what is looked for."""

    id: int
    calls: tuple[int, ...]
    kind: str


@dataclass(eq=False)
class Watched:
    """An instruction that may go wrong.

    Attributes:
        at, check: what is looked at.
        margin: how far each invocation is from going wrong, infinite of those that don't come
            here, (count,).
        bad: which of them go wrong.
        operands: those of a bad invocation, by its row: one component's.
    """

    at: Instruction
    check: Check
    margin: Array
    bad: Flags
    operands: dict[int, tuple[float, ...]] = field(default_factory=dict)


class Watcher:
    """A `Watch` that looks at each instruction.

    Attributes:
        found: what may go wrong, by place.
    """

    def __init__(self, count: int, lanes: int = 1) -> None:
        self.count = count
        self.lanes = lanes
        self.found: dict[Place, Watched] = {}

    def __call__(self, run: Run, at: Instruction, world: World, result: Any) -> Any:
        checks = CHECKS.get(number_of(at.op, at.operands), ())
        if at.op in _WRAPPING and isinstance(result, Integer) and result.unsigned:
            checks = ()  # hashes wrap around on purpose
        if checks or at.op in FLOATS:
            values = [numbers(v) for v in run.values(arguments_of(at.op, at.operands))]
            if all(v is not None for v in values):
                known = np.zeros(1, np.bool_)
                for check in checks:
                    known = known | self._look(run, at, world, check, values)
                self._overflow(run, at, world, values, result, known)
        elif at.op in _ACCESS or at.op in _DYNAMIC:
            for index, size in indices_of(run, at):
                self._look(run, at, world, INDEX, [index, np.full((1, 1), float(size))])
        return result

    def _look(
        self, run: Run, at: Instruction, world: World, check: Check, values: list[Any]
    ) -> Flags:
        with np.errstate(all="ignore"):
            margin = np.asarray(check.margin(*values), np.float64)
        return self._note(run, at, world, check, values, margin)

    def _overflow(
        self,
        run: Run,
        at: Instruction,
        world: World,
        values: list[Any],
        result: Any,
        known_bad: Flags,
    ) -> None:
        """Note results that are no numbers although all operands are, and good ones."""
        value = numbers(result) if isinstance(result, np.ndarray) else None
        if value is None:
            return
        with np.errstate(all="ignore"):
            peak = _rows(np.abs(value)).max(axis=1, keepdims=True)
            if not (peak > 1e15).any() and not np.isnan(peak).any():
                return
            known = ~known_bad[:, None]
            for operand in values:
                known = known & np.isfinite(_rows(operand)).all(axis=1, keepdims=True)
            worst = np.where(known, np.where(np.isfinite(peak), peak, np.nan), 0.0)
            margin = np.where(np.isnan(worst), -2.0, np.asarray(OVERFLOW.margin(worst)))
        self._note(run, at, world, OVERFLOW, [peak], margin)

    def _note(
        self,
        run: Run,
        at: Instruction,
        world: World,
        check: Check,
        values: list[Any],
        margin: Array,
    ) -> Flags:
        """Note the margin where it is less than before; the invocations that go wrong."""
        place = Place(at.id, tuple(run.calls), check.kind)
        here = world.mask[:, None]
        with np.errstate(all="ignore"):
            bad = np.asarray(check.bad(margin)) & ~np.isnan(margin)
        size = np.where(np.isnan(margin), np.inf, np.abs(margin))
        nearest = size.argmin(axis=-1)[:, None]
        own = np.where(np.isnan(margin), np.inf, margin)
        least = (
            np.take_along_axis(own, nearest, -1) if check.crosses else own.min(-1, keepdims=True)
        )
        least = np.where(here, least, np.inf)[:, 0].reshape(-1, self.lanes)
        closest = np.abs(least).argmin(axis=1) if check.crosses else least.argmin(axis=1)
        least = least[np.arange(self.count), closest]
        flags: Flags = np.asarray((here & bad).any(axis=-1))
        groups = flags.reshape(-1, self.lanes)
        fails = groups.any(axis=1)
        lane = np.where(fails, groups.argmax(axis=1), closest)
        known = self.found.get(place)
        if known is None:
            known = Watched(at, check, np.full(self.count, np.inf), np.zeros(self.count, np.bool_))
            self.found[place] = known
        closer = np.abs(least) < np.abs(known.margin) if check.crosses else least < known.margin
        known.margin = np.where(closer, least, known.margin)
        rows = [int(row) for row in np.flatnonzero(fails & ~known.bad)[:_KEPT]]
        if check.crosses and not fails.any():
            rows = [row for row in (int(np.abs(least).argmin()),) if row not in known.operands]
        for row in rows:
            one = row * self.lanes + int(lane[row])
            known.operands[row] = _component(values, margin, bad, one)
        known.bad = known.bad | fails
        return flags


_KEPT = 4  # rows whose operands are kept


def run_watched(
    program: Program, given: Given, watch: Watch | None = None, arithmetic: Arithmetic = FLOAT32
) -> Interpreted:
    """Run a program on some invocations; on whole workgroups where those share variables or wait:
    an output then holds what all of one gave, and is as wide. Raises as `interpret` does."""
    lanes, count = program.lanes, given.count
    each = given.each if lanes == 1 else _with_lanes(program, given, lanes)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        found = interpret(
            program, each, given.bindings, arithmetic,
            count=count * lanes, lanes=lanes, watch=watch, unwritten=True,
        )  # fmt: skip
    if lanes == 1:
        return found
    outputs = {name: v.reshape(count, -1) for name, v in flattened(found.outputs)}
    return replace(found, outputs=outputs, discarded=Truth.known(np.zeros(count, np.bool_)))


def _with_lanes(program: Program, given: Given, lanes: int) -> dict[str, Array]:
    """What each invocation of workgroups gets."""
    each = {n: v if len(v) == 1 else np.repeat(v, lanes, axis=0) for n, v in given.each.items()}
    groups = given.each.get("gl_WorkGroupID", np.zeros((given.count, 3), np.int64))
    size = program.workgroup
    local = np.tile(places_in(size), (given.count, 1))
    return each | numbered(size, np.repeat(groups, lanes, axis=0), local)


def _component(values: list[Any], margin: Array, bad: Flags, row: int) -> tuple[float, ...]:
    """The operands of a row's component that is bad, or the first one."""
    flags = bad[row if len(bad) > 1 else 0]
    k = int(flags.argmax())
    found = []
    for value in values:
        one = value[row if len(value) > 1 else 0]
        found.append(float(one.ravel()[min(k, one.size - 1)]))
    return tuple(found)


def _rows(value: Array) -> Array:
    return value.reshape(len(value), -1)


def numbers(value: Any) -> Array | None:
    """A float or an integer as float64, (count or 1, components); None of anything else."""
    if isinstance(value, Integer):
        return value.lo.astype(np.float64)
    if isinstance(value, np.ndarray):
        return value.astype(np.float64)
    return None


def indices_of(run: Run, at: Instruction) -> Iterator[tuple[Array, int]]:
    """The indices in an instruction, each with how many elements there are to choose from."""
    if at.op in _DYNAMIC:
        size = run.value(at.operands[0]).shape[-1]
        yield run.value(at.operands[_DYNAMIC[at.op]]).lo.astype(np.float64), size
        return
    base, *steps = at.operands
    pointer = run.value(base)
    if not isinstance(pointer, Pointer):
        return
    type_, _ = run.program.variables[pointer.variable]
    for index in pointer.path:
        type_ = type_.part(index if isinstance(index, int) else 0)
    for step in steps:
        index = run.value(step)
        if type_.kind in _SIZED and type_.count:
            yield index.lo.astype(np.float64), type_.count
        type_ = type_.part(int(index.lo.flat[0]) if type_.kind == "struct" else 0)
