"""Sums and float32 conversions rounded downward or upward instead of to nearest.

IEEE 754 (§4.3.2) has a rounding direction, and processors have a switch for it: C's `fesetround`
(C17, 7.6.3.2), which holds for NumPy's loops too. So one instruction gives what otherwise takes
the nearest number, a comparison and a step to its neighbour. `Switched` uses it where a trial
shows that it works, `Stepped` is for everywhere else; both give the same numbers.
"""

from __future__ import annotations

import ctypes
import platform
from collections.abc import Callable
from typing import Any, Protocol

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


class Directed(Protocol):
    """Bounds of exact sums and of float64 numbers; arrays broadcast as everywhere."""

    def add_below(self, a: Floats, b: Floats) -> Floats:
        """The largest float64 not above a + b."""

    def add_above(self, a: Floats, b: Floats) -> Floats:
        """The smallest float64 not below a + b."""

    def narrow_below(self, x: Floats) -> Singles:
        """The largest float32 not above x."""

    def narrow_above(self, x: Floats) -> Singles:
        """The smallest float32 not below x."""


class Switched:
    """By the processor's rounding direction, which is to nearest again after each call."""

    def __init__(self, switch: Callable[[int], int], downward: int, upward: int) -> None:
        self._switch = switch
        self._downward = downward
        self._upward = upward

    def add_below(self, a: Floats, b: Floats) -> Floats:
        self._switch(self._downward)
        try:
            total: Floats = np.add(a, b)
        finally:
            self._switch(0)
        # Downward, x - x is -0.
        total += 0.0
        return total

    def add_above(self, a: Floats, b: Floats) -> Floats:
        self._switch(self._upward)
        try:
            total: Floats = np.add(a, b)
        finally:
            self._switch(0)
        return total

    def narrow_below(self, x: Floats) -> Singles:
        self._switch(self._downward)
        try:
            return x.astype(np.float32)
        finally:
            self._switch(0)

    def narrow_above(self, x: Floats) -> Singles:
        self._switch(self._upward)
        try:
            return x.astype(np.float32)
        finally:
            self._switch(0)


class Stepped:
    """By the nearest number and, where that lies past the true one, its neighbour."""

    def add_below(self, a: Floats, b: Floats) -> Floats:
        total, lost = two_sum(a, b)
        return np.where(lost < 0.0, np.nextafter(total, -np.inf), total) + 0.0

    def add_above(self, a: Floats, b: Floats) -> Floats:
        total, lost = two_sum(a, b)
        return np.where(lost > 0.0, np.nextafter(total, np.inf), total)

    def narrow_below(self, x: Floats) -> Singles:
        nearest = x.astype(np.float32)
        return np.where(nearest > x, np.nextafter(nearest, np.float32(-np.inf)), nearest)

    def narrow_above(self, x: Floats) -> Singles:
        nearest = x.astype(np.float32)
        return np.where(nearest < x, np.nextafter(nearest, np.float32(np.inf)), nearest)


def two_sum(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    """a + b rounded to float64, and what the rounding lost (Knuth, TAOCP 2, 4.2.2 theorem B).

    Nothing is known to be lost (NaN) where the sum or a step towards it overflows.
    """
    total = a + b
    b_part = total - a
    return total, (a - (total - b_part)) + (b - b_part)


def best() -> Directed:
    """`Switched` if it works on this machine, else `Stepped`."""
    directions = _DIRECTIONS.get(platform.machine())
    if directions is None:
        return Stepped()
    try:
        # Not a CDLL: to let other threads run in between takes longer than the call.
        switch: Any = ctypes.PyDLL(None).fesetround
    except (OSError, AttributeError, TypeError):
        return Stepped()
    switch.argtypes = [ctypes.c_int]
    switch.restype = ctypes.c_int
    switched = Switched(switch, *directions)
    return switched if works(switched) else Stepped()


def works(directed: Directed) -> bool:
    """Whether trials of all lengths that loops treat differently come out as `Stepped` has them."""
    plain = Stepped()
    for count in (1, 3, 8, 37):
        a = np.linspace(-3.0, 3.0, count) * np.pi
        b = np.full(count, 1e-17)
        pairs: list[tuple[Any, Any]] = [
            (directed.add_below(a, b), plain.add_below(a, b)),
            (directed.add_above(a, b), plain.add_above(a, b)),
            (directed.narrow_below(a), plain.narrow_below(a)),
            (directed.narrow_above(a), plain.narrow_above(a)),
        ]
        if not all(np.array_equal(got, expected) for got, expected in pairs):
            return False
    return True
