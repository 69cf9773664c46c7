"""What each statement of a program stores at one invocation, as its SPIR-V is interpreted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, TriBool
from shaderlab.bands.rounding import ulp
from shaderlab.engine.jobs import BareWorker
from shaderlab.errors import in_file
from shaderlab.model.frame import Array
from shaderlab.model.records import Explanation, Step

from .batches import InputBatch
from .inputs import domains_of, inputs_of, sample_inputs
from .interpreter import FLOAT32, FLOAT64, Arithmetic, Bands, Program, Stored, interpret
from .interpreter.running import is_vector, precision_loss, row_of, width
from .requests import ShaderOfFile

SAMPLES = 1024
"""Invocations of a draw, or of a file, that are looked at."""
_MOST_BLOCKS = 10_000  # a few seconds, for so few invocations
_Key = tuple[int, tuple[int, ...], str, int]


@dataclass(frozen=True, eq=False)
class Trace:
    """What the invocations of a draw stored in one arithmetic, in the order of execution; what they
    wrote; and which took both sides of a branch."""

    stored: list[Stored]
    outputs: Mapping[str, Any]
    undecided: Any

    def at(self, row: int) -> dict[_Key, Stored]:
        """What one of them stored, by line, calls, name, and how often it was there before."""
        found: dict[_Key, Stored] = {}
        for event in self.stored:
            if event.mask[row]:
                again = 0
                while (key := (event.line, event.calls, event.name, again)) in found:
                    again += 1
                found[key] = event
        return found


def trace_invocations(program: Program, given: InputBatch, arithmetic: Arithmetic) -> Trace:
    """Interpret invocations and keep what they store. Raises as `interpret` does."""
    events: list[Stored] = []
    result = interpret(
        program, given.each, given.bindings, arithmetic, count=given.count,
        max_blocks=_MOST_BLOCKS, trace=events.append,
    )  # fmt: skip
    undecided = np.zeros(given.count, np.bool_)
    for flags in result.undecided.values():
        undecided = undecided | flags
    return Trace(events, result.outputs, undecided)


def steps_at(
    program: Program, given: InputBatch, bands: Trace, driver: Mapping[Stored, Array], row: int
) -> tuple[Step, ...]:
    """What one invocation stores, step by step, with the driver's values where they are known. An
    integer or an argument has a step where the driver has another one."""
    single, exact = (
        trace_invocations(program, given, arithmetic).at(row) for arithmetic in (FLOAT32, FLOAT64)
    )
    steps = []
    for key, event in bands.at(row).items():
        if getattr(event.value, "ndim", 0) != 2 or key not in single or key not in exact:
            continue
        value, known = _bounds(single[key].value, row)[0], event in driver
        if known:
            value = driver[event].astype(np.float64)
        step = _step(program, event, value, known, _bounds(exact[key].value, row)[0], row)
        if (is_vector(event.value) and not event.is_argument) or (known and not step.inside):
            steps.append(step)
    return tuple(steps)


def _bounds(value: Any, row: int) -> tuple[Any, Any]:
    """The least and the greatest value of one invocation, (components,) each."""
    if isinstance(value, TriBool):
        return row_of(value.all_true, row), row_of(~value.all_false, row)
    if isinstance(value, Integer | Band):
        return row_of(value.lo, row), row_of(value.hi, row)
    return row_of(value, row), row_of(value, row)


def _step(
    program: Program, event: Stored, value: Any, measured: bool, exact: Any, row: int
) -> Step:
    file, line = program.place(event.line)
    low, high = _bounds(event.value, row)
    with np.errstate(all="ignore"):
        off = np.nanmax(np.abs(value - exact) / ulp(exact), initial=0.0)
    value, exact, low, high = (tuple(map(float, own)) for own in (value, exact, low, high))
    return Step(
        file=file, line=line, name=event.name,
        calls=tuple(program.place(call)[1] for call in event.calls),
        value=value, by_driver=measured, exact=exact, low=low, high=high, off=float(off),
        width=width(event.value, row) if is_vector(event.value) else 0.0,
        lost=precision_loss(event, row) if is_vector(event.value) else 0.0,
    )  # fmt: skip


def explain_file(
    shader: ShaderOfFile, ranges: Mapping[str, str], worker: BareWorker
) -> tuple[Explanation, dict[str, tuple[float, ...]]]:
    """What a shader file stores at one invocation, and what that gets: of inputs that are made up,
    where the band of what it writes is widest. Raises NotInterpretedError: it can't be interpreted;
    UsageError: a range is wrong."""
    program = shader.program(worker, None)
    with in_file(shader.file.path):
        inputs = inputs_of(program)
        made_up = sample_inputs(inputs, domains_of(inputs, [program], ranges), SAMPLES, 0)
        row = widest_row(program, made_up)
        some, own = made_up.alone(row, program)
        steps = steps_at(program, some, trace_invocations(program, some, Bands()), {}, own)
        return Explanation(pixel=(0, 0), steps=steps), made_up.example(row, inputs)


def widest_row(program: Program, given: InputBatch) -> int:
    """The invocation whose outputs' bands are widest in ULP, of those that are bounded."""
    widths = np.zeros(given.count)
    for band in trace_invocations(program, given, Bands()).outputs.values():
        if is_vector(band):
            with np.errstate(all="ignore"):
                unit = ulp(np.maximum(np.abs(band.lo), np.abs(band.hi)))
                found = np.nan_to_num((band.hi - band.lo) / unit, nan=0.0, posinf=0.0)
            widths = np.maximum(widths, found.max(axis=-1))
    return int(np.argmax(widths))
