"""What a run tells of on the way: values that are stored, and those that its flow depends on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Band
from shaderlab.bands.rounding import ulp

from .program import Instruction, Type
from .values import Flags

_FLOW = (57, 250, 251)  # a call, a branch, a switch


@dataclass(frozen=True, eq=False)
class Stored:
    """One value stored by one path through a program, or one that its flow depends on.

    Attributes:
        at: the instruction. Of an argument that is the call, of a condition the branch.
        name: the variable, or the part of it, as GLSL writes it; "f()" is the result of f, "f(x)"
            what f is passed as x, "condition" what a branch goes by, "selector" a switch.
        type: the value's type.
        value: floats of the arithmetic, an `Integer`, a `Truth`, or a tuple of such, with one row
            or as many as there are invocations.
        mask: the invocations that were here; the value means nothing to others.
        calls: the lines of the calls that led here, the outermost first.
        reads: what was loaded, and what functions gave, since the value that was stored before.
    """

    at: Instruction
    name: str
    type: Type
    value: Any
    mask: Flags
    calls: tuple[int, ...]
    reads: tuple[Any, ...]

    @property
    def line(self) -> int:
        """The line of the program's text, counted from 1; see `Program.place`."""
        return self.at.line

    @property
    def is_flow(self) -> bool:
        """Whether it is an argument or a condition."""
        return self.at.op in _FLOW


Trace = Callable[[Stored], object]


def is_vector(value: Any) -> bool:
    """Whether a value is a band of scalars or of vectors."""
    return isinstance(value, Band) and value.ndim == 2


def row_of(values: Any, row: int) -> Any:
    """One row of what has a row for each invocation, or one for all."""
    array = np.asarray(values, np.float64)
    return array[row if len(array) > 1 else 0]


def width(band: Band, row: int, scale: float = 0.0) -> float:
    """A band's width in ULP of its larger bound, or of `scale` where it holds 0 and that is larger;
    in the component where that is most."""
    low, high = row_of(band.lo, row), row_of(band.hi, row)
    with np.errstate(all="ignore"):
        size = np.maximum(np.abs(low), np.abs(high))
        unit = ulp(np.where((low <= 0.0) & (high >= 0.0), np.maximum(size, scale), size))
        found = np.where(high == low, 0.0, (high - low) / unit)
    return float(np.nan_to_num(found, nan=np.inf).max())


def lost(event: Stored, row: int) -> float:
    """How many ULP wider the band is that one invocation stores than the widest that it read."""
    reads = [value for value in event.reads if is_vector(value)]
    # 1 - x that may be 0 has no size of its own: what it is made of has.
    scale = max((_size(value, row) for value in reads), default=0.0)
    own = width(event.value, row)
    if not np.isfinite(own):
        return own
    before = max((width(value, row) for value in reads), default=0.0)
    return max(width(event.value, row, scale) - before, 0.0)


def _size(band: Band, row: int) -> float:
    """The largest absolute value that a band allows."""
    return float(np.maximum(np.abs(row_of(band.lo, row)), np.abs(row_of(band.hi, row))).max())
