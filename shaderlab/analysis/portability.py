"""How far conforming devices may differ at an output, at highp and at mediump."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Band
from shaderlab.bands.rounding import ulp
from shaderlab.compiler.spirv import Decoration, Op
from shaderlab.errors import FormulaError, NotInterpretedError
from shaderlab.model.frame import Array

from .answer import Cost
from .batches import InputBatch, flatten_outputs, run_batch
from .checks import arguments_of
from .hazards import Spread
from .inputs import Inputs
from .interpreter import FLOAT16, FLOAT32, FLOAT64, Arithmetic, Bands, Numbers, Program, Stored
from .interpreter.flow import HANDLERS
from .interpreter.operations import FUNCTIONS
from .interpreter.program import Instruction
from .interpreter.running import Run, Watch, is_vector, precision_loss
from .interpreter.values import PathState

MOST = 512
"""Invocations that are looked at."""
CODES = 255.0
_SMALL = 2.0**-8  # of an output's largest value: below it, what counts is the ULP of this


def portability(program: Program, batch: InputBatch, inputs: Inputs) -> list[Spread]:
    """How far the precision rules let each float output's values lie apart; nothing where bands
    can't be had."""
    found = []
    for name, band in (bands_of(program, batch) or {}).items():
        if not is_vector(band) or (name.startswith("gl_") and band.vacuous.all()):
            continue
        with np.errstate(all="ignore"):
            wide = band.hi - band.lo
            known = np.isfinite(wide) & ~band.vacuous
            size = np.where(known, np.maximum(np.abs(band.lo), np.abs(band.hi)), 0.0)
            steps = wide / ulp(np.maximum(size, _SMALL * size.max(axis=0)))
            steps = np.where(known & (wide > 0.0), steps, 0.0).max(axis=-1)
            codes = (np.clip(band.hi, 0.0, 1.0) - np.clip(band.lo, 0.0, 1.0)) * CODES
            codes = np.where(known, codes, 0.0).max(axis=-1) * (program.stage == "fragment")
        open_ones = float((~known).any(axis=-1).mean())
        row = int((codes if codes.max() > 0.0 else steps).argmax())
        file, line = _costliest_line(program, batch, row)
        found.append(
            Spread(
                output=name,
                precision="highp",
                codes=float(codes.max()),
                ulp=float(steps.max()),
                near=batch.example(row, inputs) if steps.max() else {},
                file=file,
                line=line,
                unbounded=open_ones,
            )
        )
    return found


def _costliest_line(program: Program, batch: InputBatch, row: int) -> tuple[str, int]:
    """The line that loses most precision at an invocation; "" and 0 for none."""
    most = max(find_costs(program, batch, row), default=None)
    return (most.file, most.line) if most else ("", 0)


_SIGNS = {
    Op.FAdd: "+", Op.FSub: "-", Op.FMul: "*", Op.FDiv: "/", Op.Dot: "dot",
    **dict.fromkeys(range(Op.VectorTimesScalar, Op.OuterProduct), "*"),
}  # fmt: skip


def find_costs(program: Program, batch: InputBatch, row: int) -> set[Cost]:
    """What the operations of an invocation cost, but for those that cost nothing."""
    quad, own = batch.alone(row, program)
    found = set()

    def note(run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        name = FUNCTIONS.get(at.operands[1]) if at.op == Op.ExtInst else _SIGNS.get(at.op)
        if name and is_vector(result) and state.mask[own]:
            read = tuple(run.values(arguments_of(at.op, at.operands)))
            ulp = precision_loss(Stored(at, name, result, state.mask, (), read), own)
            if 0.0 < ulp < np.inf:
                found.add(Cost(ulp, name, *program.place(at.line)))
        return result

    run_batch(program, quad, Bands(), watch=note, unwritten=False)
    return found


def bands_of(program: Program, batch: InputBatch, **options: Any) -> Mapping[str, Any] | None:
    """A program's outputs as bands; None where it can't be run in them."""
    try:
        return run_batch(program, batch, Bands(), **options).outputs
    except (NotInterpretedError, FormulaError):
        return None


_ULPS, _RATIO = 1.0, 1.25  # wider by more than both is less accurate


def compare_accuracy(bands: tuple[Any, Any], values: Array) -> tuple[float, float, int] | None:
    """By how many ULP of an output's values (count, components) the second of two bands is wider,
    and narrower, at most; and the invocation where that is, of whichever is more. None where
    all bands are open; what has none, such as an integer, is as accurate."""
    if not all(isinstance(band, Band) for band in bands):
        return 0.0, 0.0, 0
    size = min(bands[0].shape[-1], bands[1].shape[-1], values.shape[-1])
    values = values[:, :size]
    with np.errstate(all="ignore"):
        floor = _SMALL * np.nanmax(np.abs(values), axis=0, initial=0.0)
        ulp = np.spacing(np.maximum(np.abs(values), floor).astype(np.float32)).astype(np.float64)
        old, new = (  # how far a device may be from the value
            np.maximum(band.hi[..., :size] - values, values - band.lo[..., :size]) / ulp
            for band in bands
        )
        known = np.isfinite(old) & np.isfinite(new)
        if not known.any():
            return None
        wider = np.where(known & (new > _RATIO * old), new - old, 0.0).max(axis=-1)
        narrower = np.where(known & (old > _RATIO * new), old - new, 0.0).max(axis=-1)
    worse, better = (float(v.max()) if v.max() > _ULPS else 0.0 for v in (wider, narrower))
    return worse, better, int((wider if worse >= better else narrower).argmax())


_SMALLEST = 2.0**-14  # a float16 that is no subnormal number


@dataclass(frozen=True)
class _Flushing(Numbers):
    """float16 of a device that has no subnormal numbers."""

    dtype: Any = np.float16

    def call(self, function: str, *values: Any) -> Any:
        found = FLOAT16.call(function, *map(_half, values))
        if isinstance(found, np.ndarray) and found.dtype == np.float16:
            return np.where(np.abs(found) < _SMALLEST, np.float16(0.0), found)
        return found


def _half(value: Any) -> Any:
    with np.errstate(all="ignore"):
        return value.astype(np.float16) if isinstance(value, np.ndarray) else value


@dataclass
class _Relaxed:
    """A `Watch` of a run in float32 that computes what is mediump as a device of 16 bits does."""

    device: Arithmetic

    def __call__(self, run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        if not isinstance(result, np.ndarray) or not _is_relaxed(run.program, at.id):
            return result
        if at.op != Op.Load and at.op in HANDLERS:
            own, run.arithmetic = run.arithmetic, self.device
            try:
                result = HANDLERS[at.op](run, at, state)
            finally:
                run.arithmetic = own
        return _half(result).astype(np.float32)


def _is_relaxed(program: Program, id_: int) -> bool:
    return program.module.decorated(id_, Decoration.RelaxedPrecision) is not None


def mediump(program: Program, batch: InputBatch, inputs: Inputs) -> list[Spread]:
    """How far devices of 16 bits are off at each float output, in codes of 8 bits; nothing where
    the program can't be run so. What the shader declares as mediump or lowp is computed so; where
    it declares nothing, everything."""
    relaxed = any(_is_relaxed(program, id_) for id_ in program.definitions)
    try:
        exact = _outputs(program, batch, FLOAT64)
        devices = [
            _outputs(program, batch, *((FLOAT32, _Relaxed(device)) if relaxed else (device,)))
            for device in (FLOAT16, _Flushing())
        ]
    except (NotInterpretedError, FormulaError):
        return []
    found = []
    for name, values in exact.items():
        off = np.max([_codes(device[name], values) for device in devices], axis=0)
        row = int(off.argmax())
        file, line = _costliest_line(program, batch, row) if off[row] > 0.0 else ("", 0)
        found.append(
            Spread(
                output=name,
                precision="mediump",
                codes=float(off[row]),
                file=file,
                line=line,
                near=batch.example(row, inputs) if off[row] > 0.0 else {},
            )
        )
    return found


def _outputs(
    program: Program, batch: InputBatch, arithmetic: Arithmetic, watch: Watch | None = None
) -> dict[str, Array]:
    outputs = run_batch(program, batch, arithmetic, watch=watch).outputs
    floats = {n: v for n, v in outputs.items() if isinstance(v, np.ndarray | tuple)}
    return dict(flatten_outputs(floats))


def _codes(values: Array, exact: Array) -> Array:
    """How many codes of 8 bits apart, (count,); infinite where only the exact one is a number."""
    known = np.isfinite(exact)
    with np.errstate(all="ignore"):
        off = np.abs(np.clip(values, 0.0, 1.0) - np.clip(exact, 0.0, 1.0)) * CODES
    off = np.where(np.isfinite(values), off, np.inf)
    return np.asarray(np.where(known, off, 0.0).max(axis=-1))


def find_spreads(program: Program, batch: InputBatch, inputs: Inputs) -> list[Spread]:
    """How far devices may differ at each float output, on some of the invocations: whole quads
    from all over."""
    if program.stage not in ("vertex", "fragment"):
        return []
    some = batch
    if batch.count > MOST:
        start: Array = np.linspace(0, batch.count // 4 - 1, MOST // 4).astype(np.int64) * 4
        some = batch.part((start[:, None] + np.arange(4)).ravel())
    found = portability(program, some, inputs)
    return found + mediump(program, some, inputs) if program.stage == "fragment" else found


def widest_spreads(spreads: Sequence[Spread]) -> list[Spread]:
    """The widest of each output and precision."""
    found: dict[tuple[str, str], Spread] = {}
    for one in spreads:
        known = found.setdefault((one.output, one.precision), one)
        if (one.codes, one.ulp) > (known.codes, known.ulp):
            found[one.output, one.precision] = one
    return list(found.values())
