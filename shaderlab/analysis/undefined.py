"""Undefined behaviour beyond single instructions: uninitialised reads and outputs, for which the
program runs twice, each time with another value in all of them; and divergent derivatives. And what
depends on a value that went wrong."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.bands import Integer, TriBool
from shaderlab.compiler.spirv import Glsl450, Op, StorageClass
from shaderlab.model.frame import Array

from .batches import DERIVATIVES, InputBatch, flatten_outputs, quads_of, run_batch
from .checks import FLOATS, Place, arguments_of, number_of
from .hazards import Hazard
from .inputs import Domains, Inputs, smooth_quads
from .interpreter import Interpreted, Numbers, Program
from .interpreter.flow import HANDLERS
from .interpreter.operations import COMPOSITES
from .interpreter.program import Instruction
from .interpreter.running import EndlessError, Run, Watch
from .interpreter.values import Flags, PathState, null

READ, UNWRITTEN = "uninitialised read", "output not written"
_VALUES = (0.21, 3.4)
_TRIED = (0.37, 41.0, -2.6, 7.5e3)
_STAND_IN = 0.5
_MOST_ROWS = 256  # that go wrong, of which one may change an output
_ARGUMENT = "param"  # what glslang calls the copy of an argument
_INTERFACE = "gl_"  # built-in outputs need no value
NEEDED = ("gl_FragDepth", "gl_Position")  # but for these, where a shader writes to them at all


@dataclass(frozen=True)
class _Filled(Numbers):
    """float32 in which what nothing was stored to is a certain number."""

    dtype: Any = np.float32
    value: float = 0.0

    def undefined(self) -> Array:
        return np.full((1, 1), self.value, np.float32)


@dataclass
class _Filling:
    """A `Watch` that stores a number to variables, those outside of functions too, or to one of
    them alone; it keeps what is loaded at a row."""

    value: float
    only: int | None = None
    row: int | None = None
    loads: list[tuple[int, Array]] = field(default_factory=list)
    filled: dict[int, None] = field(default_factory=dict)
    began: bool = False

    def __call__(self, run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        if not self.began:
            self.began = True
            if self._fill_globals(run, state) and at.op == Op.Load:  # it may be of one of them
                result = HANDLERS[Op.Load](run, at, state)
        if at.op == Op.Variable and len(at.operands) == 1:
            self.filled[at.id] = None
            type_, _ = run.program.variables[at.id]
            state.memory[at.id] = fill_value(null(type_, run.arithmetic), self._value(at.id))
        elif at.op == Op.Undef:
            self.filled[at.id] = None
            result = fill_value(result, self._value(at.id))
        elif at.op == Op.Load and self.row is not None and state.mask[self.row]:
            pointer = run.value(at.operands[0])
            if run.program.name(pointer.variable) != _ARGUMENT and _has_numbers(result):
                parts = [v[self.row if len(v) > 1 else 0] for _, v in flatten_outputs({"": result})]
                self.loads.append((at.line, np.concatenate(parts)))
        return result

    def _fill_globals(self, run: Run, state: PathState) -> bool:
        before, unset = len(self.filled), run.shared.keys() - run.program.module.initialisers
        for id_, (type_, storage) in run.program.variables.items():
            if id_ in unset or (storage == StorageClass.Private and state.memory.get(id_) is None):
                self.filled[id_] = None
                state.memory[id_] = fill_value(null(type_, run.arithmetic), self._value(id_))
                if id_ in run.shared:
                    run.shared[id_] = state.memory[id_]
        return len(self.filled) > before

    def _value(self, id_: int) -> float:
        return self.value if self.only in (None, id_) else _VALUES[0]


def _has_numbers(value: Any) -> bool:
    if isinstance(value, tuple):
        return all(_has_numbers(part) for part in value)
    return isinstance(value, np.ndarray | Integer | TriBool)


def undefined_values(program: Program, batch: InputBatch, inputs: Inputs) -> Iterator[Hazard]:
    """What is read before it is written and changes an output, and outputs not written."""
    watch = _Filling(_VALUES[0])
    plain = _run(program, batch, watch)
    both = _run(program, batch, _Filling(_VALUES[1]), _VALUES[1])
    if not _find_differences(plain, both, batch.count):
        return
    whole = _run(program, batch, _Filling(_VALUES[1]))
    if _find_differences(plain, whole, batch.count):
        for id_ in watch.filled:
            other = _run(program, batch, _Filling(_VALUES[1], id_))
            for output, row in list(_find_differences(plain, other, batch.count).items())[:1]:
                yield _read(program, batch, row, id_, output, inputs)
    other = _run(program, batch, _Filling(_VALUES[0]), _VALUES[1])
    for output, row in _find_differences(plain, other, batch.count, unwritten=True).items():
        file, line = _declaration(program, output)
        yield Hazard(
            file=file,
            line=line,
            kind=UNWRITTEN,
            message=f"{UNWRITTEN}: {output} has no value here, or a part of it has none",
            inputs=batch.example(row, inputs),
        )


def _run(
    program: Program, batch: InputBatch, watch: _Filling, outputs: float = _VALUES[0]
) -> Interpreted:
    return run_batch(program, batch, _Filled(value=outputs), watch=watch)


def _find_differences(
    one: Interpreted, other: Interpreted, count: int, *, unwritten: bool = False
) -> dict[str, int]:
    """The first row at which each output differs, of those that do; with `unwritten`, of those that
    need a value."""
    gone, gone_too = (np.broadcast_to(r.discarded.all_true, (count,)) for r in (one, other))
    if (gone != gone_too).any():
        return {"discard": int((gone != gone_too).argmax())}
    found = {}
    others = dict(flatten_outputs(other.outputs))
    for name, a in flatten_outputs(one.outputs):
        b = others.get(name)
        built_in = unwritten and name.startswith(_INTERFACE)
        if b is None or (built_in and not name.startswith(NEEDED)):
            continue
        differs = _rows_apart(a, b) & ~gone
        if differs.any() and not (built_in and differs.all()):
            found[name] = int(differs.argmax())
    return found


def _read(
    program: Program, batch: InputBatch, row: int, id_: int, to: str, inputs: Inputs
) -> Hazard:
    """The hazard of an uninitialised variable: at the first line that loads it."""
    some, own = batch.alone(row, program)
    watches = [_Filling(value, id_, own) for value in _VALUES]
    for watch in watches:
        _run(program, some, watch)
    inside = program.definitions.get(id_)
    file, line = (
        _declaration(program, program.name(id_)) if inside is None else program.place(inside.line)
    )
    for (at, a), (_, b) in zip(*(watch.loads for watch in watches), strict=False):
        if not np.array_equal(a, b, equal_nan=True):
            file, line = program.place(at)
            break
    name = program.name(id_) or "a function's result"
    return Hazard(
        file=file,
        line=line,
        kind=READ,
        message=f"{READ}: {name} has no value here, and {to} depends on it",
        inputs=batch.example(row, inputs),
    )


def _declaration(program: Program, output: str) -> tuple[str, int]:
    """Where an output is declared, or where `main` is."""
    text = "" if program.source is None else program.source.code
    own = re.escape(output.partition("[")[0].partition(".")[0])
    for pattern in (rf"\bout\b[^;{{}}]*\b{own}\b", rf"\b{own}\b", r"\bmain\b"):
        found = re.search(pattern, text)
        if found:
            return program.place(text.count("\n", 0, found.end()) + 1)
    return program.place(1)


KIND = "derivative in divergent control flow"
_SHADOWS = (Op.ImageSampleDrefImplicitLod, Op.ImageSampleProjDrefImplicitLod)
_SAMPLES = (Op.ImageSampleImplicitLod, Op.ImageSampleProjImplicitLod, *_SHADOWS)


@dataclass
class _Divergent:
    """A `Watch` that keeps the pixels of each derivative that not all of their quads take."""

    quads: Array
    found: dict[Place, tuple[Flags, Instruction, bool]] = field(default_factory=dict)

    def __call__(self, run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        sampled = at.op in _SAMPLES
        if not sampled and at.op not in DERIVATIVES:
            return result
        here = state.mask
        if here.all():
            return result
        count = int(self.quads.max()) + 1
        present = np.bincount(self.quads, here, count)
        split = here & ((present < np.bincount(self.quads, minlength=count))[self.quads])
        if split.any():
            mipmapped = not sampled or len(set(run.value(at.operands[0]).filter)) > 1
            place = Place(at.id, tuple(run.calls), KIND)
            before = self.found.get(place, (split,))[0]
            self.found[place] = before | split, at, mipmapped
        return result


def divergent(
    program: Program, batch: InputBatch, inputs: Inputs, made_up: Domains | None
) -> Iterator[Hazard]:
    """Derivatives of a fragment stage in divergent control flow on which an output depends.

    The batch has whole quads; generated inputs become smooth, and uniforms uniform. `made_up` says
    of which values inputs are generated; then it is unknown which textures have mipmaps: those that
    compare depths seldom have."""
    ops = {one.op for one in program.definitions.values()}
    if program.stage != "fragment" or not ops & {*DERIVATIVES, *_SAMPLES}:
        return
    if made_up is not None:
        batch = smooth_quads(batch, inputs, made_up)
    quads = np.unique(quads_of(batch.each["gl_FragCoord"]), return_inverse=True)[1].ravel()
    watch = _Divergent(quads)
    run_batch(program, batch, watch=watch)
    for place, (split, at, mipmapped) in watch.found.items():
        if not mipmapped and made_up is None:
            continue
        row, outputs = find_dependents(program, batch, np.flatnonzero(split), place)
        if not outputs:
            continue
        what = "a derivative" if at.op in DERIVATIVES else "a texture's level of detail"
        words = f"{what} is undefined where other pixels of the quad take another branch, or end"
        words = words if mipmapped else f"{words}; only if the texture has mipmaps"
        evident, found = mipmapped or at.op not in _SHADOWS, (place, at, batch, row)
        yield hazard_at(program, inputs, found, outputs, words, evident=evident)


_CONFLICTS = {
    Op.ControlBarrier: "not all invocations of a workgroup come to it",
    Op.Load: "another invocation of the workgroup writes what this reads, with no barrier between",
    Op.Store: "two invocations of a workgroup write different values",
}


def conflicts(program: Program, batch: InputBatch, inputs: Inputs) -> Iterator[Hazard]:
    """What invocations of a workgroup do to each other: barriers that not all come to, and races,
    whether an output depends on them or not."""
    found = run_batch(program, batch).conflicts if program.group > 1 else {}
    for (at, calls, kind), here in found.items():
        if here.any():
            place, words = Place(at.id, calls, kind), f"{kind}: {_CONFLICTS[Op(at.op)]}"
            yield hazard_at(program, inputs, (place, at, batch, int(here.argmax())), {}, words)


HASH = "sine hash"
_SINES = {(Op.ExtInst, Glsl450.Sin), (Op.ExtInst, Glsl450.Cos)}
_FRACT, _FLOOR = (Op.ExtInst, Glsl450.Fract), (Op.ExtInst, Glsl450.Floor)
_PRODUCTS = (Op.FMul, Op.VectorTimesScalar)
_MAGNIFIED = 100.0  # times: of the 2^-11 that a sine may err, a twentieth of fract's range


@dataclass
class _Hashes:
    """A `Watch` that follows sines, and keeps where the fraction is taken of large multiples."""

    sines: dict[int, tuple[Any, bool]] = field(default_factory=dict)  # kept, and whether magnified
    floors: dict[int, tuple[Any, Any]] = field(default_factory=dict)  # and of what
    found: dict[Place, tuple[Flags, Instruction]] = field(default_factory=dict)

    def __call__(self, run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        number = number_of(at.op, at.operands)
        values = [] if at.op == Op.Variable else arguments_of(at.op, at.operands)
        known = [
            self.sines[id(run.results[v])] for v in values if id(run.results.get(v)) in self.sines
        ]
        if number in _SINES:
            self.sines[id(result)] = result, False
        elif known and at.op in _PRODUCTS:
            others = [v for v in run.values(at.operands) if id(v) not in self.sines]
            large = any(np.abs(v).min() >= _MAGNIFIED for v in others)
            self.sines[id(result)] = result, large or any(flag for _, flag in known)
        elif known and at.op in COMPOSITES:
            self.sines[id(result)] = result, any(flag for _, flag in known)
        elif number == _FLOOR and known:
            self.floors[id(result)] = result, known[0][0]
        elif any(flag for _, flag in known) and self._is_fraction(run, at, number):
            self.found[Place(at.id, tuple(run.calls), HASH)] = state.mask, at
        return result

    def _is_fraction(self, run: Run, at: Instruction, number: object) -> bool:
        """fract(x), mod(x, 1.0) or x - floor(x)."""
        if number == _FRACT:
            return True
        if at.op == Op.FMod:
            return bool((np.abs(run.value(at.operands[1])) <= 1.0).all())
        x, whole = run.values(at.operands) if at.op == Op.FSub else (None, None)
        return x is not None and self.floors.get(id(whole), (None, None))[1] is x


def sine_hashes(program: Program, batch: InputBatch, inputs: Inputs) -> Iterator[Hazard]:
    """Random numbers of the last bits of a sine, on which an output depends."""
    numbers = {number_of(one.op, one.operands) for one in program.definitions.values()}
    if not numbers & _SINES or not {_FRACT, _FLOOR, number_of(Op.FMod, ())} & numbers:
        return
    watch = _Hashes()
    run_batch(program, batch, watch=watch)
    for place, (here, at) in watch.found.items():
        row, outputs = find_dependents(program, batch, np.flatnonzero(here), place)
        if outputs:
            words = f"{HASH}: fract of a large multiple of a sine, another one on each GPU"
            yield hazard_at(program, inputs, (place, at, batch, row), outputs, words)


@dataclass(frozen=True)
class _Replacing:
    """A `Watch` that replaces an instruction's result, or leaves it as it is with None. Other
    results that are no number although all operands are become one: they would hide what depends
    on this one."""

    place: Place
    value: float | None

    def __call__(self, run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        if at.id == self.place.id and tuple(run.calls) == self.place.calls:
            return result if self.value is None else fill_value(result, self.value)
        if isinstance(result, np.ndarray) and at.op in FLOATS and not np.isfinite(result).all():
            values = run.values(arguments_of(at.op, at.operands))
            if all(np.isfinite(v).all() for v in values if isinstance(v, np.ndarray)):
                return np.where(np.isfinite(result), result, np.float32(_STAND_IN))
        return result


def fill_value(value: Any, number: float) -> Any:
    """The value with a number in place of each of its own, true where that is above 1."""
    if isinstance(value, tuple):
        return tuple(fill_value(part, number) for part in value)
    if isinstance(value, Integer):
        return Integer(np.full_like(value.lo, int(abs(number))), unsigned=value.unsigned)
    if isinstance(value, TriBool):
        return TriBool.of(np.full_like(value.all_true, number > 1.0))
    return np.full_like(value, number) if isinstance(value, np.ndarray) else value


def find_written_outputs(
    program: Program, batch: InputBatch, watch: Watch | None = None
) -> dict[str, Array]:
    """What each invocation writes, by output; "discard" is 1 where it is discarded."""
    result = run_batch(program, batch, watch=watch)
    found = dict(flatten_outputs(result.outputs, finite=False))
    found["discard"] = np.reshape(result.discarded.all_true, (-1, 1)).astype(np.float64)
    return {n: np.broadcast_to(v, (batch.count, *v.shape[1:])) for n, v in found.items()}


def outputs_at(program: Program, batch: InputBatch, row: int) -> dict[str, tuple[float, ...]]:
    """What one invocation writes, by output; "discard" as of `find_written_outputs`."""
    some, own = batch.alone(row, program)
    return {n: tuple(map(float, v[own])) for n, v in find_written_outputs(program, some).items()}


def find_dependence(program: Program, batch: InputBatch, place: Place) -> dict[str, Flags]:
    """At which invocations each output depends on an instruction's result; none of what is
    discarded in any case."""
    runs = [find_written_outputs(program, batch, _Replacing(place, None))]
    for value in _TRIED:
        with suppress(EndlessError):
            runs.append(find_written_outputs(program, batch, _Replacing(place, value)))
    gone = np.all([run["discard"] for run in runs], axis=(0, 2))
    found = {}
    for name, first in runs[0].items():  # an output that a run has not got may be anything
        found[name] = ~gone
        if all(name in run for run in runs):
            found[name] &= np.any([_rows_apart(first, run[name]) for run in runs], axis=0)
    return found


def find_dependents(
    program: Program, batch: InputBatch, rows: Array, place: Place
) -> tuple[int, dict[str, tuple[float, ...]]]:
    """The first of some rows at which outputs depend on an instruction's result, and these as they
    are; no outputs if there is none."""
    rows = rows[:_MOST_ROWS]
    kept = np.unique(batch.rows_with(rows, program))
    found = find_dependence(program, batch.part(kept), place)
    differs = {name: flags[np.searchsorted(kept, rows)] for name, flags in found.items()}
    first = int(np.logical_or.reduce(list(differs.values())).argmax())
    names = [name for name, flags in differs.items() if flags[first]]
    plain = outputs_at(program, batch, int(rows[first])) if names else {}
    return int(rows[first]), {name: plain[name] for name in names if name in plain}


Found = tuple[Place, Instruction, InputBatch, int]


def hazard_at(
    program: Program, inputs: Iterable[str], found: Found, outputs: Any, words: str, **more: Any
) -> Hazard:
    """The hazard of an instruction that was found at a place, for a row of a batch."""
    place, at, batch, row = found
    file, line = program.place(at.line)
    return Hazard(
        file=file, line=line, kind=place.kind, message=words, inputs=batch.example(row, inputs),
        outputs=outputs, calls=tuple(program.place(call)[1] for call in place.calls), **more,
    )  # fmt: skip


def _rows_apart(a: Array, b: Array) -> Flags:
    return np.asarray(~((a == b) | (np.isnan(a) & np.isnan(b))).all(axis=-1))
