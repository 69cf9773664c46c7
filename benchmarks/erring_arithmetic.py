"""An arithmetic for the interpreter that errs in every instruction as much as the rules allow, and
rearranges the module as an optimiser would.

Floats are float64 arrays on the float32 grid; what each operation may lose is `adversary_device`'s.
Textures are sampled in float64 and rounded. Every second sum or product of what sums and products
gave is computed in another order, distributed, factored, or fused.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.adversary_device import Device, ulp
from shaderlab.analysis.interpreter import FLOAT64, Bands
from shaderlab.analysis.interpreter.arithmetic import Numbers
from shaderlab.analysis.interpreter.program import Instruction
from shaderlab.analysis.interpreter.running import Run
from shaderlab.bands import Band, Integer

Floats = np.ndarray
_MADE = 1024  # results whose operands are remembered


@dataclass(frozen=True)
class Erring(Numbers):
    """Every operation errs, either way, and is rearranged or not, as `device` decides.

    Attributes:
        made: how sums and products were made, by id of the result: "add" or "multiply", both
            operands, and the result, which keeps its id from being another's.
    """

    dtype: Any = np.float64
    device: Device = field(default_factory=lambda: Device(0, "either"))
    made: dict[int, tuple[str, Floats, Floats, Floats]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return "erring"

    def literal(self, value: float) -> Floats:
        band = Bands().literal(value)
        return self._inside(band.lo, band.hi)

    @staticmethod
    def keep_folded(run: Run, at: Instruction, state: object, result: Any) -> Any:
        """A watch: what a compiler computes of constants alone is one number. GLSL 4.60, 4.3.3: the
        same constant expression has the same value everywhere, so no other sum takes it apart."""
        folded = at.id in run.program.folded and isinstance(result, np.ndarray)
        return result.copy() if folded else result

    def call(self, function: str, *values: Any) -> Any:
        own = getattr(self, f"_{function}", None)
        with np.errstate(all="ignore"):
            if own is not None and not any(isinstance(value, Integer) for value in values):
                return own(*(np.asarray(value, np.float64) for value in values))
            found = FLOAT64.call(function, *values)
            if isinstance(found, Integer | tuple) or function in _EXACT:
                return found
            return self.device.rounded(found)

    def rounded(self, value: Any) -> Any:
        if isinstance(value, np.ndarray) and value.dtype.kind == "f":
            return self.device.rounded(value)
        return super().rounded(value)

    def _inside(self, low: Floats, high: Floats) -> Floats:
        share = self.device.rng.choice([0.0, 0.5, 1.0], np.shape(low))
        return (low + share * (high - low)).astype(np.float32).astype(np.float64)

    def _add(self, a: Floats, b: Floats) -> Floats:
        return self._noted("add", a, b, self._sum(a, b))

    def _subtract(self, a: Floats, b: Floats) -> Floats:
        return self._add(a, self._negative(b))

    def _multiply(self, a: Floats, b: Floats) -> Floats:
        return self._noted("multiply", a, b, self._product(a, b))

    def _noted(self, how: str, a: Floats, b: Floats, result: Floats) -> Floats:
        if len(self.made) > _MADE:
            self.made.clear()
        self.made[id(result)] = how, a, b, result
        return result

    def _parts(self, value: Floats, how: str) -> tuple[Floats, Floats] | None:
        """The operands of a sum or product, where it is to be rearranged now."""
        known = self.made.get(id(value))
        if known is None or known[0] != how or self.device.rng.random() < 0.5:
            return None
        return known[1], known[2]

    def _negative(self, value: Floats) -> Floats:
        """-value, which was made as value was."""
        how, a, b, _ = self.made.get(id(value), ("", value, value, value))
        if not how:
            return -value
        return self._noted(how, -a, -b if how == "add" else b, -value)

    def _sum(self, a: Floats, b: Floats) -> Floats:
        """a + b: (x + y) + b as x + (y + b), x y + x z as x (y + z), x y + b fused."""
        if self.device.rng.random() < 0.5:
            a, b = b, a
        if (of_sum := self._parts(a, "add")) is not None:
            return self._add(of_sum[0], self._add(of_sum[1], b))
        if (factors := self._parts(a, "multiply")) is not None:
            others = self._parts(b, "multiply")
            if others is not None and others[0] is factors[0]:
                return self._multiply(factors[0], self._add(factors[1], others[1]))
            return self.device.multiply_add(*factors, b)
        return self.device.add(a, b)

    def _product(self, a: Floats, b: Floats) -> Floats:
        """a b: (x y) b as x (y b), (x + y) b as x b + y b."""
        if self.device.rng.random() < 0.5:
            a, b = b, a
        if (factors := self._parts(a, "multiply")) is not None:
            return self._multiply(factors[0], self._multiply(factors[1], b))
        if (of_sum := self._parts(a, "add")) is not None:
            return self._add(self._multiply(of_sum[0], b), self._multiply(of_sum[1], b))
        return self.device.mul(a, b)

    def _divide(self, a: Floats, b: Floats) -> Floats:
        return self.device.div(a, b)

    def _dot(self, a: Floats, b: Floats) -> Floats:
        return self.device.dot(a, b)

    def _sqrt(self, a: Floats) -> Floats:
        return self.device.sqrt(a)

    def _inversesqrt(self, a: Floats) -> Floats:
        return self.device.inversesqrt(a)

    def _length(self, a: Floats) -> Floats:
        return self._sqrt(self._dot(a, a))

    def _distance(self, a: Floats, b: Floats) -> Floats:
        return self._length(self._subtract(a, b))

    def _normalize(self, a: Floats) -> Floats:
        return self.device.normalize(a)

    def _mix(self, x: Floats, y: Floats, a: Floats) -> Floats:
        return self.device.mix(x, y, a)

    def _exp2(self, a: Floats) -> Floats:
        return self.device.exp2(a)

    def _exp(self, a: Floats) -> Floats:
        return self.device.within_ulps(np.exp(a), 3.0 + 2.0 * np.abs(a))

    def _log2(self, a: Floats) -> Floats:
        return self.device.log2(a)

    def _log(self, a: Floats) -> Floats:
        near_one = (a >= 0.5) & (a <= 2.0)
        return self.device.within(np.log(a), np.where(near_one, 2.0**-21, 3.0 * ulp(np.log(a))))

    def _pow(self, x: Floats, y: Floats) -> Floats:
        power = self._exp2(self._multiply(y, self._log2(np.where(x == 0.0, 1.0, x))))
        return np.where(x == 0.0, 0.0 * y, power)

    def _sin(self, a: Floats) -> Floats:
        return self.device.within(np.sin(a), 2.0**-11)

    def _cos(self, a: Floats) -> Floats:
        return self.device.within(np.cos(a), 2.0**-11)

    def _tan(self, a: Floats) -> Floats:
        return self._divide(self._sin(a), self._cos(a))

    def _atan(self, y: Floats, x: Floats | None = None) -> Floats:
        angle = np.arctan(y) if x is None else np.arctan2(y, x)
        return self.device.within_ulps(angle, 4096.0)

    def _asin(self, a: Floats) -> Floats:
        return self.device.within(np.arcsin(a), 2.0**-11)

    def _acos(self, a: Floats) -> Floats:
        return self.device.within(np.arccos(a), 2.0**-11)

    def _fract(self, a: Floats) -> Floats:
        return np.clip(self._subtract(a, np.floor(a)), 0.0, 1.0)

    def _mod(self, a: Floats, b: Floats) -> Floats:
        return self._subtract(a, self._multiply(b, np.floor(self._divide(a, b))))

    def _fma(self, a: Floats, b: Floats, c: Floats) -> Floats:
        return self.device.multiply_add(a, b, c)

    def _radians(self, a: Floats) -> Floats:
        return self._multiply(a, self.literal(math.pi / 180.0))

    def _degrees(self, a: Floats) -> Floats:
        return self._multiply(a, self.literal(180.0 / math.pi))

    def _smoothstep(self, edge0: Floats, edge1: Floats, x: Floats) -> Floats:
        t = self._divide(self._subtract(x, edge0), self._subtract(edge1, edge0))
        t = np.clip(t, 0.0, 1.0)
        return self._multiply(self._multiply(t, t), self._subtract(np.full(1, 3.0), 2.0 * t))

    def _cross(self, a: Floats, b: Floats) -> Floats:
        one, two = [1, 2, 0], [2, 0, 1]
        return self._subtract(
            self._multiply(a[..., one], b[..., two]), self._multiply(a[..., two], b[..., one])
        )

    def _reflect(self, i: Floats, n: Floats) -> Floats:
        return self._subtract(i, self._multiply(2.0 * self._dot(n, i), n))

    def _refract(self, i: Floats, n: Floats, eta: Floats) -> Floats:
        one, cos = np.ones(1), self._dot(n, i)
        inner = self._subtract(one, self._multiply(cos, cos))
        k = self._subtract(one, self._multiply(self._multiply(eta, eta), inner))
        along = self._add(self._multiply(eta, cos), self._sqrt(np.maximum(k, 0.0)))
        through = self._subtract(self._multiply(eta, i), self._multiply(along, n))
        return np.where(k < 0.0, 0.0, through)

    def _mul(self, m: Floats, v: Floats) -> Floats:
        rows = [self._dot(m[..., i, :], v) for i in range(m.shape[-2])]
        return np.concatenate(np.broadcast_arrays(*rows), axis=-1)

    def _matmul(self, a: Floats, b: Floats) -> Floats:
        columns = [self._mul(a, b[..., j]) for j in range(b.shape[-1])]
        return np.stack(np.broadcast_arrays(*columns), axis=-1)


_EXACT = frozenset({
    "negate", "abs", "sign", "floor", "ceil", "trunc", "round", "roundEven", "min", "max",
    "clamp", "step", "faceforward", "transpose", "uintBitsToFloat", "intBitsToFloat",
})  # fmt: skip


def outside(band: Band, values: Any) -> int:
    """How many values of a device lie outside of a band that says anything about them."""
    measured = np.asarray(values).astype(np.float32)
    return int((~(band.contains(measured) | band.vacuous)).sum())
