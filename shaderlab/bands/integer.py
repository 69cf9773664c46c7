"""A shader's integers: exact, 32 bits that wrap, signed or not.

Source: the OpenGL Shading Language 4.60 (Khronos), 4.1.3 "Integers" (overflow wraps) and 5.9
"Expressions" (division and remainder, shifts, conversion of both operands to one type).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands.band import Band
from shaderlab.bands.integer_operators import RANGE, IntegerOperators, Integers
from shaderlab.bands.operators import REFLECTED
from shaderlab.bands.rounding import Flags
from shaderlab.bands.swizzles import Swizzled, Vector
from shaderlab.errors import FormulaError

from .rounding import Rules


class Integer(IntegerOperators, Swizzled):
    """Integers between two bounds, both the same array where they are known exactly.

    Arithmetic with Python's integers and other integers is GLSL's: `/` truncates, `%`, `&`, `|`,
    `^`, `~`, `<<` and `>>` are there, results wrap at 32 bits, and one unsigned operand makes the
    result unsigned. With a float or a band it is that of floats, as GLSL converts implicitly.
    The last axis is the vector's components, as in bands.

    Attributes:
        lo, hi: int64 arrays.
        unsigned: whether this is a `uint`.
        rules: those of the bands that this turns into; None beside float64 arrays.
        anything: where GLSL defines no result; 0-d for nowhere.

    >>> n = Integer([16777217])
    >>> float((n - 16777216).to_float()[0])
    1.0
    >>> (Integer([2**31 - 1]) + 1).lo.tolist(), (Integer([-7]) / 2).lo.tolist()
    ([-2147483648], [-3])
    """

    __slots__ = ("anything", "hi", "lo", "rules", "unsigned")
    __hash__ = None  # type: ignore[assignment]

    def __init__(
        self,
        lo: Any,
        hi: Any = None,
        *,
        unsigned: bool = False,
        rules: Rules | None = None,
        anything: Any = np.False_,
    ) -> None:
        self.lo: Integers = np.atleast_1d(np.asarray(lo, np.int64))
        self.hi: Integers = self.lo if hi is None else np.atleast_1d(np.asarray(hi, np.int64))
        self.unsigned = unsigned
        self.rules = rules
        self.anything: Flags = np.asarray(anything)

    @property
    def shape(self) -> tuple[int, ...]:
        return self.lo.shape

    @property
    def ndim(self) -> int:
        return self.lo.ndim

    @property
    def least(self) -> int:
        """The smallest number of the type."""
        return 0 if self.unsigned else -(RANGE // 2)

    @property
    def known(self) -> bool:
        """Whether each value is one number."""
        return self.lo is self.hi

    def __getitem__(self, index: Any) -> Integer:
        lo = self.lo[index]
        anything = self.anything
        if anything.ndim:
            anything = np.broadcast_to(anything, self.shape)[index]
        return Integer(
            lo,
            None if self.known else self.hi[index],
            unsigned=self.unsigned,
            rules=self.rules,
            anything=anything,
        )

    def made(
        self, lo: Any, hi: Any = None, *others: Integer, anything: Any = None, unsigned: Any = None
    ) -> Integer:
        """A result of this and others with these bounds, which wrap at 32 bits."""
        kind = self.unsigned if unsigned is None else bool(unsigned)
        rules = self.rules or next((other.rules for other in others if other.rules), None)
        flags = self.anything
        for more in (*(other.anything for other in others), anything):
            if more is not None:
                flags = flags | more
        result = Integer(lo, hi, unsigned=kind, rules=rules, anything=flags)
        least = result.least
        low = (result.lo - least) % RANGE + least
        if hi is None:
            high = low
        else:
            high = (result.hi - least) % RANGE + least
            torn = (result.hi - result.lo >= RANGE) | (low > high)
            low = np.where(torn, least, low)
            high = np.where(torn, least + RANGE - 1, high)
        if flags.any():
            low = np.where(flags, least, low)
            high = np.where(flags, least + RANGE - 1, high)
            hi = high
        result.lo, result.hi = low, low if hi is None else high
        return result

    def unknown(self, *others: Integer, unsigned: Any = None) -> Integer:
        """Any number of the type: a function of bits of a value that is not known exactly."""
        shape = np.broadcast_shapes(self.shape, *(other.shape for other in others))
        low = np.full(shape, 0, np.int64)
        return self.made(low, low + RANGE - 1, *others, unsigned=unsigned)

    def converted(self, unsigned: bool) -> Integer:
        """GLSL's int(n) or uint(n): the same bits."""
        return self if unsigned == self.unsigned else self.made(
            self.lo, None if self.known else self.hi, unsigned=unsigned
        )  # fmt: skip

    def to_float(self) -> Any:
        """GLSL's float(n): a band, rounded to float32 either way; float64 without rules."""
        if self.rules is not None:
            return self.as_band(self.rules)
        return self.lo.astype(np.float64).view(Vector)

    def as_band(self, rules: Rules) -> Band:
        """The band of float(n) under these rules."""
        if self.known and (np.abs(self.lo) <= 2**24).all():
            band = Band.exact(self.lo, rules)
        else:
            band = Band.between(self.lo, self.hi, rules)
        return band.made(band.lo, band.hi, anything=self.anything) if self.anything.any() else band

    def lift(self, other: Any) -> Integer | None:
        """`other` as an integer; None if it is a float."""
        if isinstance(other, Integer):
            return other
        kind = type(other)
        array = isinstance(other, np.ndarray | np.generic)
        if kind is int or (array and other.dtype.kind in "iub"):
            number = Integer(other, unsigned=self.unsigned, rules=self.rules)
            return number.made(number.lo)
        return None

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        if self.rules is not None:
            raise FormulaError(
                "a NumPy array cannot take integers of a band",
                remedy="glslmath.array(table)[i] chooses from a table; the bounds are .lo and .hi",
            )
        return self.lo.astype(dtype or np.int64)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        reflected = REFLECTED.get(ufunc)
        if reflected and method == "__call__" and not options and inputs[1] is self:
            return getattr(self, reflected)(inputs[0])
        if self.rules is None:
            return getattr(ufunc, method)(*map(np.asarray, inputs), **options)
        raise FormulaError(
            f"numpy.{ufunc.__name__} cannot take integers of a band",
            remedy="use the function of the same purpose in shaderlab.glslmath",
        )

    def __bool__(self) -> bool:
        if self.rules is None:
            return bool(self.lo)
        raise FormulaError(
            "a Python condition cannot take integers of a band",
            remedy="choose with glslmath.where(condition, a, b)",
        )

    def __index__(self) -> int:
        """One number, to count a loop or to choose from a list."""
        if self.known and self.lo.size == 1 and not np.any(self.anything):
            return int(self.lo.reshape(-1)[0])
        raise FormulaError(
            "a loop or a list cannot take integers that differ from value to value",
            remedy="loop as often as the largest needs, and choose with glslmath.where; "
            "glslmath.array(table)[i] chooses from a table",
        )

    def __pos__(self) -> Integer:
        return self

    def __neg__(self) -> Integer:
        return self.made(-self.hi, None if self.known else -self.lo)

    def __invert__(self) -> Integer:
        return self.made(-1 - self.hi, None if self.known else -1 - self.lo)

    def __repr__(self) -> str:
        kind = "uint" if self.unsigned else "int"
        if self.lo.size > 4:
            return f"Integer({kind}, shape={self.shape})"
        return f"Integer({kind}, {self.lo.tolist()} … {self.hi.tolist()})"
