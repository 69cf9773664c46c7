"""float64 with a little noise: how far two ways to compute the same may lie apart."""

from __future__ import annotations

import itertools
import math
import struct
import warnings
import zlib
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Truth
from shaderlab.compiler.spirv import Op
from shaderlab.errors import FormulaError, NotInterpretedError
from shaderlab.model.frame import Array

from ..inputs import Given, Role
from ..interpreter import Bands, Numbers, Program, Stored, interpret
from ..interpreter.arithmetic import Arithmetic
from ..interpreter.values import Flags

_OPERATION = 2.0**-52
_INPUT = 2.0**-24  # a float32 is within half of an ULP of what it stands for, at most
_POOL = 1 << 17
_BEYOND = (1 << 29) - 1  # the bits of a float64 that a float32 has not
_DOUBLE = struct.Struct("<d")

# Functions that round nothing.
_EXACT = frozenset(
    {"negate", "abs", "sign", "floor", "ceil", "trunc", "round", "roundEven", "min", "max",
     "clamp", "step", "transpose"}
)  # fmt: skip


@dataclass(frozen=True)
class Noisy(Numbers):
    """float64 in which every rounding errs by its full size, this way or that.

    All runs are one: the invocations come 1 + `copies` times, one block of `count` after the other.
    The first block is float64 without noise, and each of the others errs in its own way.

    Operations err by 2^-52; numbers that the shader got or whose author wrote more digits than a
    float32 has, by half of a float32 ULP. What needs no rounding has no error: results of as
    many bits as a float32 has, inputs all of whose numbers have few bits.

    GLSL's undefined results are NaN in all blocks: pow of a negative base, what is read before it
    is written.
    """

    dtype: Any = np.float64
    count: int = 1
    copies: int = 0

    def exact(self, values: Any) -> Array:
        found: Array = np.asarray(values, np.float32).astype(np.float64)
        rounded = (found.astype(np.float16) != found).any(axis=-1, keepdims=True)
        return self._shaken(found, np.broadcast_to(rounded, found.shape), _INPUT, "input")

    def literal(self, value: float) -> Array:
        found: Array = super().literal(value)
        return self._shaken(found, found != np.float32(value), _INPUT, f"literal {value!r}")

    def undefined(self) -> Array:
        return np.full((1, 1), np.nan)

    def call(self, function: str, *values: Any) -> Any:
        found = Numbers.call(self, function, *values)
        if function == "pow":
            x, y = values
            found = np.where((x < 0.0) | ((x == 0.0) & (y <= 0.0)), np.nan, found)
        return found if function in _EXACT else self._computed(found, function)

    def rounded(self, value: Any) -> Any:
        return self._computed(super().rounded(value), "rounded")

    def _computed(self, value: Any, salt: str) -> Any:
        if not self.copies or type(value) is not np.ndarray:
            return value
        if len(value) == 1:
            return self._shaken(value, _needs_rounding(value), _OPERATION, salt)
        found, noisy = value.copy(), value[self.count :]
        factors = _factors(noisy.shape, _OPERATION, _place(salt, value.item(0)))
        np.multiply(noisy, factors, out=found[self.count :], where=_needs_rounding(noisy))
        return found

    def _shaken(self, value: Array, rounded: Array, size: float, salt: str) -> Array:
        """The value with an error in each block but the first where it was rounded, from -1 to -.5
        or from .5 to 1 times `size`: none is lucky enough to be right. Errors follow from the
        numbers, so that the same expression of two shaders errs alike. A value with one row gets
        one for each invocation."""
        if not self.copies or not np.logical_or.reduce(rounded, axis=None):
            return value
        block = self.count
        if len(value) == 1:
            block = 1
            value, rounded = (np.repeat(x, 1 + self.copies, axis=0) for x in (value, rounded))
        exact = value[block:]
        factors = _factors(exact.shape, size, _place(salt, value.item(0)))
        found = value.copy()
        np.multiply(exact, factors, out=found[block:], where=rounded[block:])
        return found if block == self.count else np.repeat(found, self.count, axis=0)


def _needs_rounding(values: Array) -> Flags:
    """Where numbers have more bits than a float32."""
    found: Flags = (values.view(np.int64) & _BEYOND) != 0
    return found


def _place(salt: str, number: float) -> int:
    """Where in the pool an operation's errors begin."""
    return zlib.crc32(_DOUBLE.pack(number), _seed(salt)) % _POOL


@cache
def _seed(salt: str) -> int:
    return zlib.crc32(salt.encode())


def _factors(shape: tuple[int, ...], size: float, start: int) -> Array:
    pool, count = _pool(size), math.prod(shape)
    if count > _POOL:
        return np.resize(pool[start:], count).reshape(shape)
    return pool[start : start + count].reshape(shape)


@cache
def _pool(size: float) -> Array:
    generator = np.random.default_rng(20)
    errors = generator.uniform(0.5, 1.0, 2 * _POOL)
    found: Array = 1.0 + size * np.where(generator.random(2 * _POOL) < 0.5, -errors, errors)
    return found


COPIES = 3
"""Runs with noise, besides the one without."""
_FEW, _SURE = 200, 12  # so few invocations are asked again, with so many runs
_FAR = 2.0**20  # pixels between two runs
TIMES = 16.0
"""How many times the spread two outputs may lie apart."""
_TINY = float(np.finfo(np.float32).tiny)  # smaller ones are zero on many devices
_HUGE = float(np.finfo(np.float32).max)


@dataclass(frozen=True, eq=False)
class Ran:
    """What a program gave, without noise (first) and with: outputs (runs, count, components) by
    name, NaN where there is no float32; and whether an invocation was discarded, (runs, count)."""

    outputs: Mapping[str, Array]
    discarded: Flags


@dataclass(frozen=True, eq=False)
class Compared:
    """How an output of two programs compares, by invocation, (count,).

    Attributes:
        different: where it is another one.
        judged: where that can be told: what noise decides, and what neither program draws or
            defines, is left out.
        apart: how far the two are apart, infinite where only one is there.
        why: "value", "coverage" or "definedness" of the first that differs; "" if none does.
    """

    different: Flags
    judged: Flags
    apart: Array
    why: str


def run(program: Program, given: Given, copies: int = COPIES) -> Ran:
    """A program on some inputs, without noise and so many times with it.

    Raises:
        NotInterpretedError: it does what the interpreter does not know, or does not end.
        FormulaError: it reads what is not given.
    """
    times, count = 1 + copies, given.count
    each = {
        name: values if len(values) == 1 else np.concatenate([values] * times)
        for name, values in given.each.items()
    }
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        found = interpret(
            program, each, given.bindings, Noisy(count=count, copies=copies),
            count=count * times, places=_apart(each.get("gl_FragCoord"), count), unwritten=True,
        )  # fmt: skip
    gone = np.broadcast_to(found.discarded.all_true, (count * times,))
    outputs = {
        name: values.reshape(times, count, values.shape[-1])
        for name, values in flattened(found.outputs)
    }
    return Ran(outputs, gone.reshape(times, count))


def _apart(places: Array | None, count: int) -> Array | None:
    """The pixels of each run elsewhere, so that no run's are the neighbours of another's."""
    if places is None:
        return None
    found = places[:, :2].astype(np.float64)
    found[:, 1] += np.arange(len(found)) // count * _FAR
    return found


def confirmed(
    programs: tuple[Program, Program], given: Given, compared: Compared, names: tuple[str, str]
) -> Compared:
    """The comparison once more, with more noise, where few invocations differ: by chance the first
    noise may have cancelled there."""
    rows = np.flatnonzero(compared.different)
    if not 0 < len(rows) <= _FEW:
        return compared
    taken = np.union1d(*(given.rows_with(rows, program) for program in programs))
    some = given.part(taken)
    old, new = (run(program, some, _SURE) for program in programs)
    again = compare(old, new, *names)
    different, judged, apart = (
        compared.different.copy(),
        compared.judged.copy(),
        compared.apart.copy(),
    )
    different[rows] = again.different[np.isin(taken, rows)]
    judged[rows] &= again.judged[np.isin(taken, rows)]
    apart[rows] = again.apart[np.isin(taken, rows)]
    return Compared(different, judged, apart, again.why)


def flattened(outputs: Mapping[str, Any]) -> list[tuple[str, Array]]:
    """Outputs as float64 (count, components), an array's elements each by its own name."""
    found = []
    for name, value in outputs.items():
        if isinstance(value, tuple):
            found += flattened({f"{name}[{i}]": part for i, part in enumerate(value)})
            continue
        if isinstance(value, Integer):
            value = value.lo
        elif isinstance(value, Truth):
            value = value.all_true
        numbers = np.asarray(value, np.float64)
        numbers = numbers.reshape(len(numbers), -1)
        found.append((name, np.where(np.abs(numbers) <= _HUGE, numbers, np.nan)))
    return found


def compare(old: Ran, new: Ran, name: str, other: str) -> Compared:
    """How the old program's output `name` and the new one's `other` compare."""
    a, b = old.outputs.get(name), new.outputs.get(other)
    nothing = np.full((*old.discarded.shape, 1), np.nan)  # where all were discarded
    a, b = nothing if a is None else a, nothing if b is None else b
    size = min(a.shape[-1], b.shape[-1])
    a, b = a[..., :size], b[..., :size]
    there = [_in_all(~ran.discarded) for ran in (old, new)]
    gone = [_in_all(ran.discarded) for ran in (old, new)]
    coverage = (there[0] & gone[1]) | (gone[0] & there[1])
    both = there[0] & there[1]

    known = [np.isfinite(x) for x in (a, b)]
    always, never = [_in_all(k) for k in known], [_in_all(~k) for k in known]
    only_one = (always[0] & never[1]) | (never[0] & always[1])
    defined = only_one.any(axis=-1) & both

    with np.errstate(all="ignore"):
        spread = np.maximum(np.abs(a[1:] - a[0]).max(axis=0), np.abs(b[1:] - b[0]).max(axis=0))
        apart = np.abs(a[0] - b[0])
        here = always[0] & always[1] & both[:, None]
        value = (here & (apart > TIMES * spread + _TINY)).any(axis=-1)
        scale = np.maximum(np.abs(a[0]), np.abs(b[0]))
        vague = (here & (spread > 1e-2 * scale + _TINY)).all(axis=-1)
        far = np.where(here, apart, 0.0).max(axis=-1, initial=0.0)
    different = coverage | defined | value
    judged = different | gone[0] & gone[1] | (both & here.any(axis=-1) & ~vague)
    kinds = {"coverage": coverage, "definedness": defined, "value": value}
    first = next((kind for kind, flags in kinds.items() if flags.any()), "")
    return Compared(different, judged, np.where(coverage | defined, np.inf, far), first)


def _in_all(flags: Flags) -> Flags:
    """What holds in every run."""
    found: Flags = np.logical_and.reduce(flags, axis=0)
    return found


PAIRS = 192
_PARTS, _ROUNDS = 8, 6  # each round looks for the steepest of so many parts
_SMOOTH = 2  # after so many rounds a change that goes on shrinking is no jump
_SHRINKS = 0.5  # what is left of a smooth change from one round to the next, at most
_JUMP = 1e9  # how far apart something and nothing are


@dataclass(frozen=True, eq=False)
class _Ways:
    """Straight ways from invocations to others, each along all inputs that vary, or along one."""

    start: Given
    end: Mapping[str, Array]
    roles: Mapping[str, Role]

    def at(self, t: Array) -> Given:
        """The inputs at a share of each way, (count,)."""
        each = dict(self.start.each)
        for name, end in self.end.items():
            start = each[name]
            value = start + t[:, None] * (end - start)
            if name in self.roles and self.roles[name].kind == "unit":
                with np.errstate(invalid="ignore"):
                    value = value / np.linalg.norm(value, axis=1, keepdims=True)
            each[name] = value.astype(np.float32)
        return Given(each, self.start.bindings, self.start.count)

    def repeated(self, times: int) -> _Ways:
        """Each way several times, all of them one after the other."""
        rows = np.tile(np.arange(self.start.count), times)
        end = {name: values[rows] for name, values in self.end.items()}
        return _Ways(self.start.part(rows), end, self.roles)


def jumps(
    programs: tuple[Program, Program],
    given: Given,
    roles: Mapping[str, Role],
) -> Given | None:
    """Inputs on both sides of places where one of the programs jumps; None where nothing can be
    varied steadily."""
    ways = _ways(given, roles, np.random.default_rng(23))
    if ways is None:
        return None
    ends = []
    for program in programs:
        ends += [ways.at(t) for t in _steepest(program, ways)]
    if not ends:
        return None
    each = {n: np.concatenate([end.each[n] for end in ends]) for n in ends[0].each}
    return Given(each, given.bindings, len(ends) * PAIRS)


def _steepest(program: Program, ways: _Ways) -> tuple[Array, ...]:
    """Both ends of the steepest little part of each way, (count,); nothing where a program changes
    smoothly along all of them."""
    all_ = np.arange(PAIRS)
    low, high, before = np.zeros(PAIRS), np.ones(PAIRS), np.full(PAIRS, np.inf)
    for number in range(_ROUNDS):
        t = low + np.linspace(0.0, 1.0, _PARTS + 1)[:, None] * (high - low)
        changes = _changes(_values(program, ways.repeated(_PARTS + 1).at(t.ravel())), _PARTS + 1)
        steepest = changes.argmax(axis=0)
        low, high = (t[steepest + k, all_] for k in (0, 1))
        change = changes[steepest, all_]
        if number >= _SMOOTH and (change <= _SHRINKS * before).all():
            return ()
        before = change
    return low, high


def _ways(given: Given, roles: Mapping[str, Role], rng: np.random.Generator) -> _Ways | None:
    steady = [
        name
        for name, values in given.each.items()
        if name != "gl_FragCoord" and len(values) == given.count
        if values.dtype.kind == "f" and values.ndim == 2
    ]
    if not steady or given.count < 2:
        return None
    rows = rng.integers(0, given.count, (2, PAIRS))
    start, end = (given.part(each) for each in rows)
    alone = rng.integers(0, len(steady), PAIRS)
    alone[: PAIRS // 2] = -1  # along all of them
    ends = {}
    for i, name in enumerate(steady):
        moves = ((alone == -1) | (alone == i))[:, None]
        ends[name] = np.where(moves, end.each[name], start.each[name])
    return _Ways(start, ends, roles)


def _values(program: Program, given: Given) -> dict[str, Array]:
    """Outputs without noise, with a jump's height where nothing is drawn or defined."""
    ran = run(program, given, 0)
    gone = ran.discarded[0][:, None]
    return {
        name: np.where(gone, _JUMP, np.where(np.isfinite(v[0]), v[0], -_JUMP))
        for name, v in ran.outputs.items()
    } or {"": np.where(gone, _JUMP, 0.0)}


def _changes(values: Mapping[str, Array], points: int) -> Array:
    """How much outputs change from one point of each way to the next, (points - 1, ways)."""
    found = []
    for output in values.values():
        along = output.reshape(points, -1, output.shape[-1])
        found.append(np.abs(np.diff(along, axis=0)).max(axis=-1))
    most: Array = np.max(found, axis=0)
    return most


MOST = 512
"""Invocations whose bands are looked at."""
_SMALL = 2.0**-8  # of an output's largest value: below it, what counts is the ULP of this
_ULPS, _RATIO = 1.0, 1.25  # wider by more than both is less accurate


@dataclass(frozen=True, eq=False)
class Accuracy:
    """How much accuracy a program loses against another one.

    Attributes:
        worse, better: ULP of the output's value that a band is wider or narrower, at most.
        row: the invocation where that is, of whichever is more.
        step: the first stored value whose band is wider there, or narrower; None if none is.
    """

    worse: float
    better: float
    row: int
    step: Step | None


def bands_of(program: Program, given: Given) -> Mapping[str, Any] | None:
    """A program's outputs as bands; None where it can't be run in them."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            return interpret(
                program, given.each, given.bindings, Bands(), count=given.count
            ).outputs
        except (NotInterpretedError, FormulaError):
            return None


def accuracy(
    programs: tuple[Program, Program], given: Given, bands: tuple[Any, Any], values: Array
) -> Accuracy | None:
    """How the accuracy of an output changes from one program to the other.

    Args:
        programs: the old and the new one.
        given: what they get.
        bands: the output of both.
        values: the output in float64, (count, components).

    Returns:
        None where the output has no bands, such as an integer's, or all of them are open.
    """
    if not all(isinstance(band, Band) for band in bands):
        return None
    size = min(bands[0].shape[-1], bands[1].shape[-1], values.shape[-1])
    values = values[:, :size]
    with np.errstate(all="ignore"):
        floor = _SMALL * np.nanmax(np.abs(values), axis=0, initial=0.0)
        ulp = np.spacing(np.maximum(np.abs(values), floor).astype(np.float32)).astype(np.float64)
        old, new = (_off(band, values, size) / ulp for band in bands)
        known = np.isfinite(old) & np.isfinite(new)
        if not known.any():
            return None
        wider = np.where(known & (new > _RATIO * old), new - old, 0.0).max(axis=-1)
        narrower = np.where(known & (old > _RATIO * new), old - new, 0.0).max(axis=-1)
    worse, better = (float(v.max()) if v.max() > _ULPS else 0.0 for v in (wider, narrower))
    row = int((wider if worse >= better else narrower).argmax())
    step = None
    if worse or better:
        differ = _wider if worse >= better else _narrower
        step, _, _ = first(programs, given, row, Bands(), differ)
    return Accuracy(worse, better, row, step)


def _off(band: Band, values: Array, size: int) -> Array:
    """How far a device may be from the value, (count, size)."""
    off: Array = np.maximum(band.hi[..., :size] - values, values - band.lo[..., :size])
    return off


def _wider(old: Any, new: Any) -> bool:
    if not (isinstance(old, Band) and isinstance(new, Band)) or old.shape[1:] != new.shape[1:]:
        return False
    with np.errstate(all="ignore"):
        before, after = old.hi - old.lo, new.hi - new.lo
        size = np.maximum(np.abs(new.lo), np.abs(new.hi)).astype(np.float32)
        return bool((after > _RATIO * before + 0.5 * np.spacing(size)).any())


def _narrower(old: Any, new: Any) -> bool:
    return _wider(new, old)


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
        if instruction.op == Op.Kill
    )
