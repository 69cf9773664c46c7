"""float64 with a little noise: how far two ways to compute the same may lie apart."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from shaderlab.model.frame import Array

from .batches import InputBatch, flatten_outputs
from .interpreter import Numbers, Program, interpret
from .interpreter.arithmetic import EXACT
from .interpreter.values import Flags

_OPERATION = 2.0**-52
_INPUT = 2.0**-24  # a float32 is within half of an ULP of what it stands for, at most
_GIVEN = 1.001 * _INPUT  # what a number that nothing was done to errs by
_POOL = 1 << 17
_BEYOND = (1 << 29) - 1  # the bits of a float64 that a float32 has not
_DOUBLE = struct.Struct("<d")
_SUMS = {  # where a sum is not exact, though it may look so: 1 - 1e-20 is 1
    "add": lambda s, a, b: (s - a != b) | (s - b != a),
    "subtract": lambda s, a, b: (s + b != a) | (a - s != b),
}


@dataclass(frozen=True)
class PerturbedFloat(Numbers):
    """float64 in which every rounding errs by its full size, this way or that.

    All runs are one: the invocations come 1 + `copies` times, a block of `count` after the other,
    the first without noise. Operations err by 2^-52; numbers that the shader got or whose author
    wrote more digits than a float32 has, by half of a float32 ULP; what needs no rounding by
    nothing. What GLSL leaves undefined is NaN in all blocks."""

    dtype: Any = np.float64
    count: int = 1
    copies: int = 0

    def exact(self, values: Any) -> Array:
        found: Array = np.asarray(values, np.float32).astype(np.float64)
        rounded = (found.astype(np.float16) != found).any(axis=-1, keepdims=True)
        return self._perturb(found, np.broadcast_to(rounded, found.shape), _INPUT, "input")

    def literal(self, value: float) -> Array:
        found: Array = super().literal(float(np.float32(value)))
        return self._perturb(found, found != value, _INPUT, f"literal {value!r}")

    def undefined(self) -> Array:
        return np.full((1, 1), np.nan)

    def take_given(self, values: Sequence[Any]) -> Sequence[Any]:
        """The values, without noise where a device errs neither: as they were given or written."""
        return [self._take_given(value) for value in values] if self.copies else values

    def _take_given(self, value: Any) -> Any:
        if type(value) is not np.ndarray or len(value) == 1:
            return value
        blocks = value.reshape(1 + self.copies, self.count, *value.shape[1:])
        first = blocks[0]
        with np.errstate(all="ignore"):
            near = (np.abs(blocks - first) <= _GIVEN * np.abs(first)).all(axis=0)
        given = near & ((first.view(np.int64) & _BEYOND) == 0)
        return np.where(given, first, blocks).reshape(value.shape)

    def call(self, function: str, *values: Any) -> Any:
        taken = self.take_given(values) if function == "step" else values
        found = Numbers.call(self, function, *taken)
        if function == "pow":
            x, y = values
            found = np.where((x < 0.0) | ((x == 0.0) & (y <= 0.0)), np.nan, found)
        lost = _SUMS[function](found, *values) if function in _SUMS and self.copies else False
        return found if function in EXACT else self._perturb_rounded(found, function, lost)

    def rounded(self, value: Any) -> Any:
        return self._perturb_rounded(super().rounded(value), "rounded")

    def _perturb_rounded(self, value: Any, salt: str, lost: Any = False) -> Any:
        if not self.copies or type(value) is not np.ndarray:
            return value
        rounded = (value.view(np.int64) & _BEYOND != 0) | lost
        return self._perturb(value, rounded, _OPERATION, salt)

    def _perturb(self, value: Array, rounded: Array, size: float, salt: str) -> Array:
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


def _place(salt: str, number: float) -> int:
    """Where in the pool an operation's errors begin."""
    return zlib.crc32(_DOUBLE.pack(number), zlib.crc32(salt.encode())) % _POOL


def _factors(shape: tuple[int, ...], size: float, start: int) -> Array:
    pool, count = _pool(size), math.prod(shape)
    if count > _POOL:
        return np.resize(pool[start:], count).reshape(shape)
    return pool[start : start + count].reshape(shape)


@cache
def _pool(size: float) -> Array:
    generator = np.random.default_rng(20)
    errors = generator.uniform(0.5, 1.0, 2 * _POOL)
    return np.asarray(1.0 + size * np.where(generator.random(2 * _POOL) < 0.5, -errors, errors))


COPIES = 3
"""Runs with noise, besides the one without."""
_FEW, _SURE = 200, 12  # so few invocations are run again, so many times
_FAR = 2.0**20  # pixels between two runs
TIMES = 16.0
"""How many times the spread two outputs may lie apart."""
_TINY = float(np.finfo(np.float32).tiny)  # smaller ones are zero on many devices
_LEAST = 2.0**-26  # of a value: less than half of what float32 can tell
_HUGE = float(np.finfo(np.float32).max)


@dataclass(frozen=True, eq=False)
class Ran:
    """What a program gave, without noise (first) and with: outputs (runs, count, components) by
    name, NaN where there is no float32; whether an invocation was discarded, (runs, count); the
    labels of the blocks that were run; and how many those were, each time counted."""

    outputs: Mapping[str, Array]
    discarded: Flags
    labels: Set[int]
    blocks: int = 0


@dataclass(frozen=True, eq=False)
class Compared:
    """How an output of two programs compares, by invocation, (count,): where it can be judged (what
    noise dominates, and what neither program draws or defines, is left out), how far the two are
    apart, infinite where only one is there, and why the first that differs does: "value",
    "coverage", "definedness" or ""."""

    different: Flags
    judged: Flags
    apart: Array
    why: str


def run(program: Program, batch: InputBatch, copies: int = COPIES) -> Ran:
    """A program on some inputs, without noise and so many times with it. Raises
    NotInterpretedError: it does what the interpreter does not know, or does not end; FormulaError:
    it reads what is not given."""
    times, count = 1 + copies, batch.count
    each = {
        name: values if len(values) == 1 else np.concatenate([values] * times)
        for name, values in batch.each.items()
    }
    if (places := each.get("gl_FragCoord")) is not None:  # no run's are next to another's
        places = places[:, :2].astype(np.float64)
        places[:, 1] += np.arange(len(places)) // count * _FAR
    found = interpret(
        program,
        each,
        batch.bindings,
        PerturbedFloat(count=count, copies=copies),
        count=count * times,
        places=places,
        unwritten=True,
    )
    gone = np.broadcast_to(found.discarded.all_true, (count * times,))
    outputs = {
        name: values.reshape(times, count, values.shape[-1])
        for name, values in flatten_outputs(found.outputs)
    }
    labels = {label for _, label in found.taken}
    return Ran(outputs, gone.reshape(times, count), labels, found.blocks)


def confirm(
    programs: tuple[Program, Program], batch: InputBatch, compared: Compared, names: tuple[str, str]
) -> Compared:
    """The comparison once more, with more noise, where few invocations differ: by chance the first
    noise may have cancelled there."""
    rows = np.flatnonzero(compared.different)
    if not 0 < len(rows) <= _FEW:
        return compared
    taken = np.union1d(*(batch.rows_with(rows, program) for program in programs))
    some = batch.part(taken)
    old, new = (run(program, some, _SURE) for program in programs)
    again = compare(old, new, *names)
    kept = compared.different, compared.judged, compared.apart
    different, judged, apart = map(np.copy, kept)
    different[rows] = again.different[np.isin(taken, rows)]
    judged[rows] &= again.judged[np.isin(taken, rows)]
    apart[rows] = again.apart[np.isin(taken, rows)]
    return Compared(different, judged, apart, again.why)


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
        scale = np.maximum(np.abs(a[0]), np.abs(b[0]))
        value = (here & (apart > TIMES * spread + _TINY + _LEAST * scale)).any(axis=-1)
        vague = (here & (spread > 1e-2 * scale + _TINY)).all(axis=-1)
        far = np.where(here, apart, 0.0).max(axis=-1, initial=0.0)
    different = coverage | defined | value
    judged = different | gone[0] & gone[1] | (both & here.any(axis=-1) & ~vague)
    kinds = {"coverage": coverage, "definedness": defined, "value": value}
    first = next((kind for kind, flags in kinds.items() if flags.any()), "")
    return Compared(different, judged, np.where(coverage | defined, np.inf, far), first)


def _in_all(flags: Flags) -> Flags:
    """What holds in every run."""
    return np.asarray(np.logical_and.reduce(flags, axis=0))
