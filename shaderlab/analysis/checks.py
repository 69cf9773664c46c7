"""Watching a program run: how far each instruction is from going wrong, by invocation."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from shaderlab.bands import Integer
from shaderlab.compiler.spirv import Glsl450, Op
from shaderlab.model.frame import Array

from .interpreter.program import Instruction
from .interpreter.running import Run
from .interpreter.textures import fetch_place
from .interpreter.values import Flags, PathState, Pointer

_ACCESS = (Op.AccessChain, Op.InBoundsAccessChain)
# Which operand the index is.
_DYNAMIC = {Op.VectorExtractDynamic: 1, Op.VectorInsertDynamic: 2}
INDEXING = frozenset({*_ACCESS, *_DYNAMIC})
"""The opcodes that choose a part by its number."""
_SIZED = ("vector", "matrix", "array")


@dataclass(frozen=True)
class Place:
    """An instruction by its id, the lines of the calls that led to it, and what is looked for."""

    id: int
    calls: tuple[int, ...]
    kind: str


@dataclass(eq=False)
class WatchedInstruction:
    """An instruction that may go wrong: how far each invocation is from that (the margin, infinite
    of those that don't come here), which of them do (the bad ones), (count,), and by row the
    operands of such a one, one component's."""

    at: Instruction
    check: Check
    margin: Array
    bad: Flags
    operands: dict[int, tuple[float, ...]] = field(default_factory=dict)


_Here = tuple[Run, Instruction, PathState]


class Watcher:
    """A `Watch` that looks at each instruction: `found` has what may go wrong, by place. Nothing is
    known of the size of textures that are `made_up`: texels lie outside of the largest ones; if
    `enlarged`, programs are told that theirs are those."""

    def __init__(self, count: int, *, made_up: bool = False, enlarged: bool = False) -> None:
        self.count, self._made_up, self._enlarged = count, made_up, enlarged
        self.found: dict[Place, WatchedInstruction] = {}

    def __call__(self, run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        here, checks = (run, at, state), CHECKS.get(number_of(at.op, at.operands), ())
        overflows = at.op in FLOATS and _is_large(result, state.mask)
        if checks or overflows:
            values = [numbers(v) for v in run.values(arguments_of(at.op, at.operands))]
            if all(v is not None for v in values):
                known = np.zeros(1, np.bool_)
                for check in checks:
                    known = known | self._note(here, check, values)
                if overflows:
                    self._overflow(here, values, result, known)
        elif at.op in INDEXING:
            for index, size in indices_of(run, at):
                self._note(here, INDEX, [index.lo, np.full((1, 1), size)])
        elif at.op == Op.ImageFetch:
            self._note_fetch(here)
        elif self._enlarged and at.op in SIZES:
            return _largest(run, at, result)
        elif self._made_up and at.op in SIZES:  # it may have the level that a made-up one lacks
            return Integer(np.maximum(result.lo, 1), unsigned=result.unsigned)
        return result

    def _note_fetch(self, here: _Here) -> None:
        """Note a texelFetch's coordinates and level, or sample, as indices."""
        texels, place, _, number, sizes = fetch_place(*here[:2])
        if self._made_up:
            sides = _SIDES if texels.kind != "2DMS" else np.full_like(_SIDES, _SIDES[0])
            sizes = np.repeat(sides, sizes.shape[1], axis=1)
        self._note(here, LEVEL, [number.lo, np.full((1, 1), len(sizes))])
        self._note(here, TEXEL, [place, sizes[np.clip(number.lo[:, 0], 0, len(sizes) - 1)]])

    def _overflow(self, here: _Here, given: list[Any], result: Any, bad: Flags) -> None:
        """Note results that are no numbers although all operands are, and good ones."""
        with np.errstate(all="ignore"):
            peak = _rows(np.abs(result.astype(np.float64))).max(axis=1, keepdims=True)
            known = ~bad[:, None]
            for operand in given:
                known = known & np.isfinite(_rows(operand)).all(axis=1, keepdims=True)
            worst = np.where(known, np.where(np.isfinite(peak), peak, np.nan), 0.0)
            margin = np.where(np.isnan(worst), -2.0, np.asarray(OVERFLOW.margin(worst)))
        self._note(here, OVERFLOW, [peak], margin)

    def _note(self, here: _Here, check: Check, values: list[Any], margin: Any = None) -> Flags:
        """Note the margin where it is less than before; the invocations that go wrong."""
        run, at, state = here
        place, mask = Place(at.id, tuple(run.calls), check.kind), state.mask[:, None]
        with np.errstate(all="ignore"):
            margin = np.asarray(check.margin(*values) if margin is None else margin, np.float64)
            bad = np.asarray(check.bad(margin)) & ~np.isnan(margin)
        own = np.where(np.isnan(margin), np.inf, margin)
        least = np.where(mask, own.min(axis=-1, keepdims=True), np.inf)[:, 0]
        fails: Flags = np.asarray((mask & bad).any(axis=-1))
        known = self.found.get(place)
        if known is None:
            far, no = np.full(self.count, np.inf), np.zeros(self.count, np.bool_)
            known = self.found[place] = WatchedInstruction(at, check, far, no)
        known.margin = np.minimum(least, known.margin)
        for row in map(int, np.flatnonzero(fails & ~known.bad)[:_KEPT]):
            known.operands[row] = _component(values, margin, bad, row)
        known.bad = known.bad | fails
        return fails


def _is_large(result: Any, here: Flags) -> bool:
    """Whether it is floats, of which one that concerns those who are here is large or no number."""
    if not isinstance(result, np.ndarray) or (result.max() <= 1e15 and result.min() >= -1e15):
        return False
    return len(result) == 1 or not (np.abs(result[here]) <= 1e15).all()


_KEPT = 4  # rows whose operands are kept


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
    value = value.lo if isinstance(value, Integer) else value
    return value.astype(np.float64) if isinstance(value, np.ndarray) else None


def indices_of(run: Run, at: Instruction) -> Iterator[tuple[Integer, int]]:
    """The indices in an instruction, each with how many elements there are to choose from."""
    if at.op in _DYNAMIC:
        size = run.value(at.operands[0]).shape[-1]
        yield run.value(at.operands[_DYNAMIC[Op(at.op)]]), size
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
            yield index, type_.count
        type_ = type_.part(int(index.lo.flat[0]) if type_.kind == "struct" else 0)


FLOATS = frozenset({Op.ExtInst, *range(Op.FNegate, Op.Dot + 1)})
"""The opcodes of arithmetic on floats, and of GLSL.std.450."""
_INT, _UINT = (-(2.0**31), 2.0**31), (-1.0, 2.0**32)


@dataclass(frozen=True, eq=False)
class Check:
    """One way in which an instruction may go wrong: `margin` is how far operands, (count or 1,
    components), are from it, `bad` says of that where it does, `words` of one component's operands
    what happens."""

    kind: str
    margin: Callable[..., Any]
    words: Callable[..., str]
    bad: Callable[[Any], Any] = lambda margin: margin < 0.0


def _at_most_0(margin: Any) -> Any:
    return margin <= 0.0


def _is_0(margin: Any) -> Any:
    return margin == 0.0


def _not_above_0(function: str) -> Check:
    return Check(
        f"{function} of 0 or less", lambda x: x, lambda x: f"{function}({x:.6g})", _at_most_0
    )


def _beyond(function: str) -> Check:
    return Check(
        f"{function} outside -1..1",
        lambda x: 1.0 - np.abs(x),
        lambda x: f"{function}({x:.9g}), which is defined for -1..1",
    )


def _conversion(to: str, low: float, high: float) -> Check:
    return Check(
        f"{to} of a number that has none",
        lambda x: np.minimum(x - low, high - x),
        lambda x: f"{to}({x:.6g}), which lies outside of the type's range",
        _at_most_0 if to == "uint" else lambda margin: margin < 0.0,
    )


def _of_two(name: str) -> Callable[[float, float], str]:
    return lambda a, b: f"{name}({a:.6g}, {b:.6g})"


_DIVISION = Check(
    "division by 0", lambda a, b: np.abs(b + 0.0 * a), lambda a, b: f"{a:.6g} is divided by 0",
    _is_0,
)  # fmt: skip
_MOD = replace(_DIVISION, words=_of_two("mod"))
_INTEGER_DIVISION = replace(_DIVISION, kind="integer division by 0")
_POW = Check(
    "pow of a negative number", lambda x, y: x + 0.0 * y,
    lambda x, y: f"pow({x:.6g}, {y:.6g}), whose base is negative",
)  # fmt: skip
_POW_0 = Check(
    "pow of 0 to 0 or less",
    lambda x, y: np.maximum(np.abs(x), np.maximum(y, 0.0)),
    _of_two("pow"),
    _is_0,
)
_SQRT = Check("sqrt of a negative number", lambda x: x, lambda x: f"sqrt({x:.6g})")
_ACOSH = Check("acosh below 1", lambda x: x - 1.0, lambda x: f"acosh({x:.9g})")
_ATAN = Check(
    "atan of (0, 0)", lambda y, x: np.maximum(np.abs(y), np.abs(x)), _of_two("atan"), _is_0
)
_CLAMP = Check(
    "clamp with reversed bounds", lambda x, low, high: high - low + 0.0 * x,
    lambda x, low, high: f"clamp to {low:.6g}..{high:.6g}, whose bounds are reversed",
)  # fmt: skip
_SMOOTHSTEP = Check(
    "smoothstep with reversed edges", lambda low, high, x: high - low + 0.0 * x,
    lambda low, high, x: f"smoothstep from {low:.6g} to {high:.6g}, which is not above it",
    _at_most_0,
)  # fmt: skip
_NORMALIZE = Check(
    "normalize of a zero vector", lambda v: np.sqrt((v * v).sum(axis=-1, keepdims=True)),
    lambda v: "normalize of a vector of length 0", _is_0,
)  # fmt: skip
_REMAINDER = Check(
    "remainder of a negative number", lambda a, b: np.minimum(a, b),
    lambda a, b: f"{a:g} % {b:g}, which is undefined of negative numbers",
)  # fmt: skip
_SHIFT = Check(
    "shift beyond 31 bits", lambda a, b: np.minimum(b, 31 - b) + 0 * a,
    lambda a, b: f"a shift by {b:g} bits",
)  # fmt: skip
_FIELD = Check(
    "bit field outside of 32 bits",
    lambda *parts: np.minimum(np.minimum(parts[-2], parts[-1]), 32 - parts[-2] - parts[-1]),
    lambda *parts: f"a field of {parts[-1]:g} bits from bit {parts[-2]:g} on",
)

CHECKS: Mapping[tuple[int, int], tuple[Check, ...]] = {
    (Op.FDiv, 0): (_DIVISION,),
    (Op.FRem, 0): (_DIVISION,),
    (Op.FMod, 0): (_MOD,),
    (Op.ConvertFToU, 0): (_conversion("uint", *_UINT),),
    (Op.ConvertFToS, 0): (_conversion("int", *_INT),),
    **{(op, 0): (_INTEGER_DIVISION,) for op in (Op.UDiv, Op.SDiv, Op.UMod)},
    **{(op, 0): (_INTEGER_DIVISION, _REMAINDER) for op in (Op.SRem, Op.SMod)},
    **{(op, 0): (_SHIFT,) for op in range(Op.ShiftRightLogical, Op.ShiftLeftLogical + 1)},
    **{(op, 0): (_FIELD,) for op in range(Op.BitFieldInsert, Op.BitFieldUExtract + 1)},
    (Op.ExtInst, Glsl450.Asin): (_beyond("asin"),),
    (Op.ExtInst, Glsl450.Acos): (_beyond("acos"),),
    (Op.ExtInst, Glsl450.Acosh): (_ACOSH,),
    (Op.ExtInst, Glsl450.Atanh): (replace(_beyond("atanh"), bad=_at_most_0),),
    (Op.ExtInst, Glsl450.Atan2): (_ATAN,),
    (Op.ExtInst, Glsl450.Pow): (_POW, _POW_0),
    (Op.ExtInst, Glsl450.Log): (_not_above_0("log"),),
    (Op.ExtInst, Glsl450.Log2): (_not_above_0("log2"),),
    (Op.ExtInst, Glsl450.Sqrt): (_SQRT,),
    (Op.ExtInst, Glsl450.InverseSqrt): (_not_above_0("inversesqrt"),),
    **{(Op.ExtInst, n): (_CLAMP,) for n in (Glsl450.FClamp, Glsl450.UClamp, Glsl450.SClamp)},
    (Op.ExtInst, Glsl450.SmoothStep): (_SMOOTHSTEP,),
    (Op.ExtInst, Glsl450.Normalize): (_NORMALIZE,),
}
"""By opcode and the number of GLSL.std.450's instruction, 0 for all others."""

OVERFLOW = Check(
    "overflow", lambda result: np.log2(np.finfo(np.float32).max) - np.log2(np.abs(result)),
    lambda result: "no number" if np.isnan(result) else "beyond the largest float",
    lambda margin: ~(margin > -1.0),
)  # fmt: skip
"""Of a result that is no number although all operands are; of the result."""

INDEX = Check(
    "index out of range", lambda index, size: np.minimum(index, size - 1 - index),
    lambda index, size: f"index {index:.0f} into {size:.0f} elements",
)  # fmt: skip
"""Of an index and the number of elements."""
TEXEL = replace(INDEX, kind="texel out of range")
LEVEL = replace(INDEX, kind="level out of range")
"""Of what `texelFetch` is given."""

SIZES = {Op.ImageQuerySizeLod, Op.ImageQuerySize}
_LEVELS = 15
_SIDES = 1 << np.arange(_LEVELS)[::-1, None]
"""A texture's size at each level, if it is as large as drivers must support (OpenGL 4.6, table
23.53)."""


def _largest(run: Run, at: Instruction, result: Integer) -> Integer:
    """The size of the largest texture, in place of another one's."""
    level = run.value(at.operands[1]).lo if len(at.operands) > 1 else np.zeros((1, 1), np.int64)
    sides = _SIDES[np.clip(level[:, 0], 0, _LEVELS - 1)]
    return Integer(np.repeat(sides, result.shape[1], axis=1), unsigned=result.unsigned)


def number_of(op: int, operands: tuple[int, ...]) -> tuple[int, int]:
    """What `CHECKS` has an instruction by."""
    return (op, operands[1]) if op == Op.ExtInst else (op, 0)


def arguments_of(op: int, operands: tuple[int, ...]) -> tuple[int, ...]:
    """The ids of an instruction's operands that are values."""
    return operands[2:] if op == Op.ExtInst else operands
