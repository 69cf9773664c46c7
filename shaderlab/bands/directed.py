"""Sums and float32 conversions rounded downward or upward instead of to nearest.

IEEE 754 (§4.3.2) has a rounding direction, and processors have a switch for it: C's `fesetround`
(C17, 7.6.3.2), which holds for NumPy's loops too. One instruction then gives what otherwise takes
the nearest number, a comparison and a step to its neighbour. `Switched` uses the switch where a
trial shows that it works, `Stepped` runs everywhere else; both give the same numbers.
"""

from __future__ import annotations

import ctypes
import platform
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

# <fenv.h>: FE_DOWNWARD and FE_UPWARD by processor; FE_TONEAREST is 0 on all of them.
_DIRECTIONS = {
    "x86_64": (0x400, 0x800),
    "aarch64": (0x800000, 0x400000),
    "arm64": (0x800000, 0x400000),
}


class Stepped:
    """Takes the nearest number and, where that lies past the true one, its neighbour."""

    def add_below(self, a: Floats, b: Floats) -> Floats:
        """The largest float64 not above a + b."""
        total, lost = two_sum(a, b)
        return np.where(lost < 0.0, np.nextafter(total, -np.inf), total) + 0.0

    def add_above(self, a: Floats, b: Floats) -> Floats:
        """The smallest float64 not below a + b."""
        total, lost = two_sum(a, b)
        return np.where(lost > 0.0, np.nextafter(total, np.inf), total)

    def narrow_below(self, x: Floats) -> Singles:
        """The largest float32 not above x."""
        nearest = x.astype(np.float32)
        return np.where(nearest > x, np.nextafter(nearest, np.float32(-np.inf)), nearest)

    def narrow_above(self, x: Floats) -> Singles:
        """The smallest float32 not below x."""
        nearest = x.astype(np.float32)
        return np.where(nearest < x, np.nextafter(nearest, np.float32(np.inf)), nearest)


class Switched(Stepped):
    """Sets the processor's rounding direction, and back to nearest after each call."""

    def __init__(self, switch: Callable[[int], int], downward: int, upward: int) -> None:
        self._switch = switch
        self._downward = downward
        self._upward = upward

    def _rounded(self, direction: int, compute: Callable[..., Any], *operands: Any) -> Any:
        self._switch(direction)
        try:
            return compute(*operands)
        finally:
            self._switch(0)

    def add_below(self, a: Floats, b: Floats) -> Floats:
        total: Floats = self._rounded(self._downward, np.add, a, b)
        # Downward, x - x is -0.
        total += 0.0
        return total

    def add_above(self, a: Floats, b: Floats) -> Floats:
        total: Floats = self._rounded(self._upward, np.add, a, b)
        return total

    def narrow_below(self, x: Floats) -> Singles:
        single: Singles = self._rounded(self._downward, x.astype, np.float32)
        return single

    def narrow_above(self, x: Floats) -> Singles:
        single: Singles = self._rounded(self._upward, x.astype, np.float32)
        return single


def two_sum(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """a + b rounded to float64, and what the rounding lost (Knuth, TAOCP 2, 4.2.2 theorem B).

    The loss is NaN where the sum or a step towards it overflows.
    """
    total = a + b
    b_part = total - a
    return total, (a - (total - b_part)) + (b - b_part)


def best() -> Stepped:
    """`Switched` if it works on this machine, else `Stepped`."""
    directions = _DIRECTIONS.get(platform.machine())
    if directions is None:
        return Stepped()
    try:
        # Not a CDLL: releasing the interpreter's lock takes longer than the call.
        switch: Any = ctypes.PyDLL(None).fesetround
    except (OSError, AttributeError, TypeError):
        return Stepped()
    switch.argtypes = [ctypes.c_int]
    switch.restype = ctypes.c_int
    switched = Switched(switch, *directions)
    return switched if works(switched) else Stepped()


def works(directed: Stepped) -> bool:
    """Whether trials of every length that loops treat differently agree with `Stepped`."""
    plain = Stepped()
    for count in (1, 3, 8, 37):
        a = np.linspace(-3.0, 3.0, count) * np.pi
        b = np.full(count, 1e-17)
        for name, operands in (
            ("add_below", (a, b)),
            ("add_above", (a, b)),
            ("narrow_below", (a,)),
            ("narrow_above", (a,)),
        ):
            got, expected = (getattr(by, name)(*operands) for by in (directed, plain))
            if not np.array_equal(got, expected):
                return False
    return True
