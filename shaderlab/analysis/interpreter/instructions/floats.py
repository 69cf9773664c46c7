"""Arithmetic on floats, and what becomes floats."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from shaderlab.bands import Integer

from ..memory import World
from ..program import Instruction
from .handler import Handler, calling
from .multiples import exactly

if TYPE_CHECKING:
    from ..running import Run


def _matrix_times_scalar(run: Run, at: Instruction, world: World) -> Any:
    matrix, scalar = run.values(at.operands)
    return run.arithmetic.call("multiply", matrix, scalar[..., None])


def _vector_times_matrix(run: Run, at: Instruction, world: World) -> Any:
    vector, matrix = run.values(at.operands)
    call = run.arithmetic.call
    return call("mul", call("transpose", matrix), vector)


def _from_integer(run: Run, at: Instruction, world: World) -> Any:
    whole: Integer = run.value(at.operands[0])
    if run.arithmetic.rules is None:
        return run.arithmetic.rounded(whole.lo)
    band = whole.as_band(run.arithmetic.rules)
    run.note_unit(band, 1.0)
    return band


def _bitcast(run: Run, at: Instruction, world: World) -> Any:
    value, to = run.value(at.operands[0]), run.program.types[at.type].base
    if to.kind == "float":
        return run.arithmetic.call("uintBitsToFloat", value.converted(True))
    if isinstance(value, Integer):
        return value.converted(not to.signed)
    return run.arithmetic.call("floatBitsToInt" if to.signed else "floatBitsToUint", value)


FLOATS: Mapping[int, Handler] = {
    109: calling("uint"),
    110: calling("int"),
    111: _from_integer,
    112: _from_integer,
    124: _bitcast,
    127: exactly("negate"),
    129: exactly("add"),
    131: exactly("subtract"),
    133: exactly("multiply"),
    136: calling("divide"),
    140: calling("remainder"),
    141: exactly("mod"),
    142: exactly("multiply"),
    143: _matrix_times_scalar,
    144: _vector_times_matrix,
    145: calling("mul"),
    146: calling("matmul"),
    147: calling("outerProduct"),
    148: calling("dot"),
}
