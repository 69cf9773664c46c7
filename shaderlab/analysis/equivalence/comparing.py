"""Two programs on the same inputs: at which invocations do their outputs differ?"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Integer, Truth
from shaderlab.model.frame import Array

from ..interpreter import Program, interpret
from ..interpreter.memory import Flags
from .given import Given
from .noise import Noisy

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
