"""Checks of every number: all floats and integers of some ranges, none left out."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands import Integer
from shaderlab.engine.judging.banded import judge_band
from shaderlab.engine.judging.laws import Law
from shaderlab.engine.judging.references import Inputs, Reference, evaluate, match_parameters
from shaderlab.errors import CallError
from shaderlab.functions.call import Call, find_ranges
from shaderlab.functions.checks import (
    CallLaw,
    find_kept,
    judge_function,
    judge_reference,
    match_inputs,
    split_result,
)
from shaderlab.functions.signatures import DTYPES
from shaderlab.model.frame import Array
from shaderlab.model.records import Outcome

if TYPE_CHECKING:
    from shaderlab.functions.library import Function

_BLOCK = 1 << 20  # values of a draw
_PART = 1 << 14  # of them for which a formula is evaluated at a time
_FIRST = 1 << 14  # values from all over, whose bands are evaluated whatever they are
_MOST = 1 << 33
_SECONDS = 0.2  # between two looks at how far it is


@dataclass(frozen=True)
class Numbers:
    """All numbers of one type from `low` to `high`, both included, in order: -0 before 0."""

    low: Any
    high: Any
    dtype: np.dtype[Any]

    def __len__(self) -> int:
        return max(self._number(self.high) - self._number(self.low) + 1, 0)

    def __getitem__(self, indices: Array) -> Array:
        ordinals = indices + self._number(self.low)
        if self.dtype.kind != "f":
            return ordinals.astype(self.dtype)
        words = ordinals.astype(f"i{self.dtype.itemsize}")
        words ^= (words >> self._sign) & np.iinfo(words.dtype).max
        return words.view(self.dtype)

    @property
    def _sign(self) -> int:
        return 8 * self.dtype.itemsize - 1

    @np.errstate(over="ignore")
    def _number(self, value: Any) -> int:
        """How many numbers lie between 0 and this one, less than 0 for negative ones."""
        exact = np.array(value, self.dtype)
        if self.dtype.kind != "f":
            return int(exact)
        word = int(exact.view(f"i{self.dtype.itemsize}"))
        return word if word >= 0 else word ^ ((1 << self._sign) - 1)


class Grid:
    """All combinations of the numbers of several arguments, or each `step`-th. Raises CallError:
    there is no range, or one that is none; or there are too many values."""

    def __init__(
        self, function: Function, arguments: Sequence[Any], named: Mapping[str, Any], step: int
    ) -> None:
        if len(function.signatures) > 1:
            raise CallError(f"{function.__name__} is overloaded", remedy="choose one by its types")
        signature = function.signatures[0]
        self._function, self._step = function, step
        given = {p.name: v for p, v in zip(signature.given, arguments, strict=False)}
        self._fixed = {**given, **named}
        self._ranges: dict[str, Numbers] = {}
        for one, (low, high) in find_ranges(signature, arguments, named):
            dtype = np.dtype(DTYPES[one.type.kind])
            if type(low) is type(high) is np.float16 and dtype.kind == "f":
                dtype = np.dtype(np.float16)
            self._ranges[one.name] = Numbers(low, high, dtype)
        whole = math.prod(map(len, self._ranges.values())) if self._ranges else 0
        self.count = -(-whole // step)
        if not 1 <= step <= _MOST or not 0 < self.count <= _MOST:
            raise CallError(
                f"{function.__name__}: every= takes ranges of 1 to {_MOST:,} values, "
                f"not {self.count:,}",
                remedy="give both ends for a float or an integer, such as distance=(0, 50), and "
                "every=16 for each 16th value",
            )

    def __str__(self) -> str:
        return ", ".join(f"{n} from {r.low} to {r.high}" for n, r in self._ranges.items())

    def bind(self, indices: Array) -> Call:
        """The calls of these numbers."""
        rest, values = indices * self._step, dict(self._fixed)
        for name, numbers in self._ranges.items():
            rest, own = np.divmod(rest, len(numbers)) if len(self._ranges) > 1 else (rest, rest)
            values[name] = numbers[own]
        return self._function.bind(**values)

    def blocks(self) -> Iterator[Array]:
        """All of them; the first one of a block is the last one of the block before, as well."""
        for start in range(0, self.count, _BLOCK):
            yield np.arange(max(start - 1, 0), min(start + _BLOCK, self.count))


def judge_every(
    function: Function,
    law: Law | CallLaw | Callable[..., Any],
    step: int,
    arguments: Sequence[Any],
    named: Mapping[str, Any],
) -> tuple[Call, list[Outcome]]:
    """Check a function at each combination of numbers, up to the first block that fails. Values all
    over the ranges are judged as `check` does. Of the others those are within their bands that are
    one of the two floats about what the formula gives in float64: a band holds that, and ends at
    floats. So bands are evaluated for the rest alone. Returns the calls that show a failure, else
    some of them all over the range; and the outcomes."""
    grid = Grid(function, arguments, named, step)
    some = np.unique(np.linspace(0, grid.count - 1, _FIRST).astype(np.int64))
    first = grid.bind(some)
    outcomes = judge_function(function, law, first, [])
    if any(one.status != "pass" for one in outcomes):
        return first, outcomes
    started = shown = time.monotonic()
    with ThreadPoolExecutor(1) as threads:
        waiting: Future[list[Outcome]] | None = None
        call = first
        for indices in grid.blocks():
            before, call = call, grid.bind(indices)
            if isinstance(law, Law | CallLaw):
                before, found = call, judge_function(function, law, call, [])
            else:
                got = function.evaluate(call)
                found = waiting.result() if waiting else []
                waiting = threads.submit(_judge_block, function, law, call, got)
            if any(one.outside for one in found):
                return before, found
            if time.monotonic() - shown > _SECONDS and sys.stderr.isatty():
                shown, share = time.monotonic(), (indices[-1] + 1) / grid.count
                print(f"\r{share:6.1%} of {grid.count:,} values", end="\r", file=sys.stderr)
        if waiting and waiting.result():
            return call, waiting.result()
    seconds = time.monotonic() - started
    each = "each" if step == 1 else f"one in {step}"
    print(f"{function.__name__}: {grid.count:,} values, {each} of {grid}, in {seconds:.0f} s")
    return first, [replace(one, judged=one.judged // len(some) * grid.count) for one in outcomes]


def _judge_block(function: Function, law: Reference, call: Call, got: Any) -> list[Outcome]:
    """The outcomes of a block in which a value lies outside its band; of others none."""
    parts = split_result(call.signature.outputs, got)
    kept = find_kept(call, parts[0])
    inputs = match_inputs(law, call, kept, function.folder)
    near = [find_next_to(part.rows(kept), part.of(law), inputs) for part in parts]
    rows = np.flatnonzero(~np.logical_and.reduce(near))
    some = inputs.part(rows)
    for part in parts:
        if rows.size and judge_band(part.rows(kept)[rows], part.of(law), some, rules=None).outside:
            judged = ((one, one.judge(law, inputs, kept)) for one in parts)
            return [judge_reference(function, call, *each) for each in judged]
    return []


@np.errstate(all="ignore")
def find_next_to(got: Array, reference: Reference, inputs: Inputs) -> Array:
    """Which values are one of the two floats about what a formula gives in float64, (count,), or
    the same integers; False for what is no number of full precision."""
    found = np.zeros(len(got), np.bool_)
    parameters = match_parameters(reference, inputs)
    for start in range(0, len(got), _PART):
        rows = slice(start, start + _PART)
        exact = evaluate(
            reference, inputs.part(rows), rules=None, decimal=False, parameters=parameters
        )
        values = got[rows]
        if isinstance(exact, Integer):
            same = (values == exact.lo) & ~exact.anything & (values.dtype.kind in "iu")
        elif values.dtype != np.float32:
            continue
        else:
            exact = np.asarray(exact, np.float64)
            near = exact.astype(np.float32)
            same = (near == values) & np.isfinite(values)
            if not same.all():
                other = np.nextafter(near, np.where(exact > near, np.inf, -np.inf), dtype="f4")
                same |= (other == values) & (near != exact) & np.isfinite(values)
        found[rows] = same.all(axis=-1)
    return found
