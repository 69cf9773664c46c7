"""A program at mediump: by float16, and by devices that err within the table for 16 bits.

Intervals over-warn here: what no device gives would be most of them. So this samples devices, and
what it finds is what they gave.

Source: the Vulkan specification (Khronos), "Precision and Operation of SPIR-V Instructions".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.bands import Integer
from shaderlab.compiler.spirv import Decoration, Op
from shaderlab.errors import FormulaError, NotInterpretedError
from shaderlab.model.frame import Array

from ..equivalence.comparing import flattened, steps
from ..equivalence.comparison import example
from ..inputs import Given, Input
from ..interpreter import FLOAT16, FLOAT32, FLOAT64, Arithmetic, Numbers, Program
from ..interpreter.flow import HANDLERS
from ..interpreter.program import Instruction
from ..interpreter.running import Run, Watch
from ..interpreter.values import PathState
from .portability import CODES, Spread
from .watching import run_watched

_DEVICES = 6
_ROUNDED = frozenset({"add", "subtract", "multiply"})
_EXACT = frozenset(
    {"negate", "abs", "sign", "floor", "ceil", "trunc", "round", "roundEven", "min", "max",
     "clamp", "step", "transpose"}
)  # fmt: skip
_ULPS = {"divide": 2.5, "inversesqrt": 2.0, "sqrt": 2.0, "atan": 5.0, "asin": 5.0, "acos": 5.0,
         "pow": 4.0}  # fmt: skip
_WITHIN = {"sin": 2.0**-7, "cos": 2.0**-7}
_LOGARITHMS = ("log", "log2")


@dataclass(frozen=True)
class Half(Numbers):
    """float16 as one device has it: operations round its way, and functions err within the table.

    Attributes:
        seed: which device.
    """

    dtype: Any = np.float16
    seed: int = 0
    rng: np.random.Generator = field(default_factory=np.random.default_rng, compare=False)

    @classmethod
    def device(cls, seed: int) -> Half:
        """A device; an even one rounds to nearest, an odd one towards 0."""
        return cls(seed=seed, rng=np.random.default_rng([16, seed]))

    def call(self, function: str, *values: Any) -> Any:
        halves = [_half(value) for value in values]
        found = FLOAT16.call(function, *halves)
        if isinstance(found, Integer | tuple) or function in _EXACT:
            return found
        with np.errstate(all="ignore"):
            if function in _ROUNDED:
                return self._towards_0(found, function, halves) if self.seed % 2 else found
            return self._erring(found, function, halves)

    def _towards_0(self, found: Array, function: str, values: Sequence[Any]) -> Array:
        wide = FLOAT64.call(function, *(value.astype(np.float64) for value in values))
        beyond = np.abs(found.astype(np.float64)) > np.abs(wide)
        return np.where(beyond, np.nextafter(found, np.float16(0.0)), found)

    def _erring(self, found: Array, function: str, values: Sequence[Any]) -> Array:
        share = self.rng.uniform(-1.0, 1.0, found.shape)
        if function in _WITHIN:
            return (found + share * _WITHIN[function]).astype(np.float16)
        most: Any = _ULPS.get(function, 1.0)
        if function in ("exp", "exp2"):
            most = 1.0 + 2.0 * np.abs(values[0].astype(np.float64))
        wide = found.astype(np.float64)
        step = np.abs(np.spacing(found)).astype(np.float64)
        give = most * step
        if function in _LOGARITHMS:
            near_1 = (values[0] >= 0.5) & (values[0] <= 2.0)
            give = np.where(near_1, 2.0**-7, 3.0 * step)
        moved: Array = (wide + np.trunc(share * (give / step + 1.0)) * step).astype(np.float16)
        return np.where(np.abs(moved - wide) <= give, moved, found)


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


def mediump(program: Program, given: Given, inputs: Mapping[str, Input]) -> list[Spread]:
    """How far devices of 16 bits are off at each float output, in codes of 8 bits.

    What the shader declares as mediump or lowp is computed so; where it declares nothing,
    everything.

    Returns:
        nothing where the program can't be run so.
    """
    relaxed = any(_is_relaxed(program, id_) for id_ in program.definitions)
    try:
        exact = _outputs(program, given, FLOAT64)
        devices = [
            _outputs(program, given, *_as_device(device, relaxed))
            for device in (FLOAT16, *map(Half.device, range(_DEVICES)))
        ]
    except (NotInterpretedError, FormulaError):
        return []
    found = []
    for name, values in exact.items():
        off = np.max([_codes(device[name], values) for device in devices], axis=0)
        row = int(off.argmax())
        file, line = _first(program, given, row) if off[row] > 0.0 else ("", 0)
        found.append(
            Spread(
                output=name, precision="mediump", codes=float(off[row]), file=file, line=line,
                near=example(given, row, inputs) if off[row] > 0.0 else {},
            )
        )  # fmt: skip
    return found


def _as_device(device: Arithmetic, relaxed: bool) -> tuple[Arithmetic, Watch | None]:
    return (FLOAT32, _Relaxed(device)) if relaxed else (device, None)


def _outputs(
    program: Program, given: Given, arithmetic: Arithmetic, watch: Watch | None = None
) -> dict[str, Array]:
    outputs = run_watched(program, given, watch, arithmetic).outputs
    floats = {n: v for n, v in outputs.items() if isinstance(v, np.ndarray | tuple)}
    return dict(flattened(floats))


def _codes(values: Array, exact: Array) -> Array:
    """How many codes of 8 bits apart, (count,); infinite where only the exact one is a number."""
    known = np.isfinite(exact)
    with np.errstate(all="ignore"):
        off = np.abs(np.clip(values, 0.0, 1.0) - np.clip(exact, 0.0, 1.0)) * CODES
    off = np.where(np.isfinite(values), off, np.inf)
    found: Array = np.where(known, off, 0.0).max(axis=-1)
    return found


def _first(program: Program, given: Given, row: int) -> tuple[str, int]:
    """The line whose value is the first that lies far off: by more than a quarter of what is worst
    among all of them."""
    pairs = zip(
        steps(program, given, row, FLOAT16), steps(program, given, row, FLOAT64), strict=False
    )
    found = []
    for a, b in pairs:
        if a.name != b.name or not isinstance(a.value, np.ndarray):
            continue
        half, exact = a.value.astype(np.float64), b.value.astype(np.float64)
        with np.errstate(all="ignore"):
            size = np.maximum(np.abs(exact).max(), 2.0**-14)
            found.append((float(np.nan_to_num(np.abs(half - exact).max() / size, nan=np.inf)), a))
    worst = max((off for off, _ in found), default=0.0)
    far = 1e3 if np.isinf(worst) else worst / 4.0
    line = next((step.line for off, step in found if off > far), 0)
    return program.place(line) if line else ("", 0)
