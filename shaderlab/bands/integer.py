"""A shader's integers: exact, 32 bits that wrap, signed or not.

Source: the OpenGL Shading Language 4.60 (Khronos), 4.1.3 "Integers" (overflow wraps) and 5.9
"Expressions" (division and remainder, shifts, bits, conversion of both operands to one type).
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.bands.band import REFLECTED, WHOLE, Band
from shaderlab.bands.bounds import Swizzled, Vector
from shaderlab.bands.exact import TriBool, as_tri_bool
from shaderlab.bands.rounding import Flags, Rules
from shaderlab.errors import FormulaError

Integers = npt.NDArray[np.int64]
RANGE = 2**32
# Products of bounds below this are exact in float64, and far from int64's ends.
_EXACT = 2.0**53


def _add(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    return a.lo + b.lo, a.hi + b.hi, None


def _subtract(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    return a.lo - b.hi, a.hi - b.lo, None


def _multiply(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    if a.known and b.known:
        # int64 wraps at 2^64, which leaves the lower 32 bits right.
        return a.lo * b.lo, None, None
    corners = [x * y for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    sizes = [np.abs(x.astype(np.float64) * y) for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    far = (np.maximum.reduce(sizes) >= _EXACT) & ~_is_single(a, b)
    low, high = np.minimum.reduce(corners), np.maximum.reduce(corners)
    return np.where(far, 0, low), np.where(far, RANGE - 1, high), None


def _is_single(a: Integer, b: Integer) -> Flags:
    """Where both are one number each, though they may not be elsewhere."""
    single: Flags = (a.lo == a.hi) & (b.lo == b.hi)
    return single


def _divide(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    """Truncated; by zero, nothing is defined."""
    undefined = (b.lo <= 0) & (b.hi >= 0)
    divisors = [np.where(undefined, 1, bound) for bound in (b.lo, b.hi)]
    pairs = [(x, y) for x in (a.lo, a.hi) for y in divisors]
    corners = [np.abs(x) // np.abs(y) * np.sign(x) * np.sign(y) for x, y in pairs]
    return np.minimum.reduce(corners), np.maximum.reduce(corners), undefined


def _remainder(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    """a - b·(a / b); not defined where either may be negative, or b zero."""
    undefined = (a.lo < 0) | (b.lo <= 0)
    found = a.lo % np.where(undefined, 1, b.lo)
    if a.known and b.known:
        return found, None, undefined
    single, most = _is_single(a, b), np.minimum(a.hi, np.maximum(b.hi - 1, 0))
    return np.where(single, found, 0), np.where(single, found, most), undefined


def _shift_left(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    undefined = (b.lo < 0) | (b.hi > 31)
    low, high = (np.int64(1) << np.clip(bound, 0, 31) for bound in (b.lo, b.hi))
    if a.known and b.known:
        return a.lo * low, None, undefined
    corners = [x * y for x in (a.lo, a.hi) for y in (low, high)]
    return np.minimum.reduce(corners), np.maximum.reduce(corners), undefined


def _shift_right(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
    undefined = (b.lo < 0) | (b.hi > 31)
    corners = [x >> np.clip(y, 0, 31) for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    return np.minimum.reduce(corners), np.maximum.reduce(corners), undefined


def _make_bitwise(operation: Callable[[Any, Any], Any]) -> Callable[..., tuple[Any, Any, Any]]:
    def bits(a: Integer, b: Integer) -> tuple[Any, Any, Any]:
        found = operation(a.lo, b.lo)
        if a.known and b.known:
            return found, None, None
        single = _is_single(a, b)
        return np.where(single, found, 0), np.where(single, found, RANGE - 1), None

    return bits


# By Python's name: what integers do, what floats do, and whether the left operand alone decides
# whether the result is unsigned.
_OPERATIONS: dict[str, tuple[Any, Any, bool]] = {
    "add": (_add, operator.add, False),
    "sub": (_subtract, operator.sub, False),
    "mul": (_multiply, operator.mul, False),
    "truediv": (_divide, operator.truediv, False),
    "mod": (_remainder, None, False),
    "and": (_make_bitwise(operator.and_), None, False),
    "or": (_make_bitwise(operator.or_), None, False),
    "xor": (_make_bitwise(operator.xor), None, False),
    "lshift": (_shift_left, None, True),
    "rshift": (_shift_right, None, True),
}


def _make_operators(name: str) -> tuple[Any, Any]:
    whole, floating, left_alone = _OPERATIONS[name]

    def of(a: Integer, b: Integer) -> Integer:
        unsigned = a.unsigned or (b.unsigned and not left_alone)
        if not left_alone:
            a, b = a.convert(unsigned), b.convert(unsigned)
        lo, hi, undefined = whole(a, b)
        hi = None if hi is None or (a.known and b.known) else hi
        return a.derive(lo, hi, b, anything=undefined, unsigned=unsigned)

    def apply(self: Integer, other: Any, left: bool) -> Any:
        lifted = self.lift(other)
        if lifted is not None:
            return of(self, lifted) if left else of(lifted, self)
        if floating is None:
            raise FormulaError(f"GLSL has no {name} of an integer and a float", remedy=WHOLE)
        number = self.to_float()
        return floating(number, other) if left else floating(other, number)

    return lambda a, b: apply(a, b, True), lambda a, b: apply(a, b, False)


def _less(a: Integer, b: Integer) -> tuple[Flags, Flags]:
    return a.hi < b.lo, a.lo >= b.hi


def _equal(a: Integer, b: Integer) -> tuple[Flags, Flags]:
    return (a.lo == b.hi) & (a.hi == b.lo), (a.hi < b.lo) | (b.hi < a.lo)


def _make_comparison(compared: Any, floating: Any, *, swapped: bool, negated: bool) -> Any:
    def compare(self: Integer, other: Any) -> Any:
        lifted = self.lift(other)
        if lifted is None:
            return floating(self.to_float(), other)
        unsigned = self.unsigned or lifted.unsigned
        pair = self.convert(unsigned), lifted.convert(unsigned)
        yes, no = compared(*(reversed(pair) if swapped else pair))
        rules = self.rules or lifted.rules
        if rules is None:
            return no if negated else yes
        open_ = self.anything | lifted.anything
        truth = TriBool(yes & ~open_, no & ~open_, rules)
        return ~truth if negated else truth

    return compare


class Integer(Swizzled):
    """Integers between two bounds, both the same array where they are known exactly.

    Arithmetic with Python's integers and other integers is GLSL's: `/` truncates, `%`, `&`, `|`,
    `^`, `~`, `<<` and `>>` are there, results wrap at 32 bits, and one unsigned operand makes the
    result unsigned. With a float or a band it is that of floats, as GLSL converts implicitly.
    The last axis is the vector's components, as in bands.

    Attributes:
        lo, hi: int64 arrays.
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
        lo, hi = self.lo[index], None if self.known else self.hi[index]
        anything = self.anything
        if anything.ndim:
            anything = np.broadcast_to(anything, self.shape)[index]
        return Integer(lo, hi, unsigned=self.unsigned, rules=self.rules, anything=anything)

    def derive(
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

    def derive_unknown(self, *others: Integer, unsigned: Any = None) -> Integer:
        """Any number of the type: a function of bits of a value that is not known exactly."""
        shape = np.broadcast_shapes(self.shape, *(other.shape for other in others))
        low = np.full(shape, 0, np.int64)
        return self.derive(low, low + RANGE - 1, *others, unsigned=unsigned)

    def convert(self, unsigned: bool) -> Integer:
        """GLSL's int(n) or uint(n): the same bits."""
        if unsigned == self.unsigned:
            return self
        return self.derive(self.lo, None if self.known else self.hi, unsigned=unsigned)

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
        return (
            band.derive(band.lo, band.hi, anything=self.anything) if self.anything.any() else band
        )

    def lift(self, other: Any) -> Integer | None:
        """`other` as an integer; None if it is a float."""
        if isinstance(other, Integer):
            return other
        kind = type(other)
        array = isinstance(other, np.ndarray | np.generic)
        if kind is int or (array and other.dtype.kind in "iub"):
            number = Integer(other, unsigned=self.unsigned, rules=self.rules)
            return number.derive(number.lo)
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
        return self.derive(-self.hi, None if self.known else -self.lo)

    def __invert__(self) -> Integer:
        return self.derive(-1 - self.hi, None if self.known else -1 - self.lo)

    def __repr__(self) -> str:
        kind = "uint" if self.unsigned else "int"
        if self.lo.size > 4:
            return f"Integer({kind}, shape={self.shape})"
        return f"Integer({kind}, {self.lo.tolist()} … {self.hi.tolist()})"


for _name in _OPERATIONS:
    _straight, _reflected = _make_operators(_name)
    setattr(Integer, f"__{_name}__", _straight)
    setattr(Integer, f"__r{_name}__", _reflected)
for _name, _compared, _swapped, _negated in (
    ("lt", _less, False, False),
    ("ge", _less, False, True),
    ("gt", _less, True, False),
    ("le", _less, True, True),
    ("eq", _equal, False, False),
    ("ne", _equal, False, True),
):
    _floats = getattr(operator, _name)
    _made = _make_comparison(_compared, _floats, swapped=_swapped, negated=_negated)
    setattr(Integer, f"__{_name}__", _made)


def absolute_value(n: Integer) -> Integer:
    """|n|; the least integer stays what it is."""
    ends = np.abs(n.lo), np.abs(n.hi)
    low = np.where((n.lo < 0) & (n.hi > 0), 0, np.minimum(*ends))
    return n.derive(low, None if n.known else np.maximum(*ends))


def sign(n: Integer) -> Integer:
    """-1, 0 or 1."""
    return n.derive(np.sign(n.lo), None if n.known else np.sign(n.hi))


def minimum_of(a: Integer, b: Integer) -> Integer:
    """The smaller of two."""
    known = a.known and b.known
    return a.derive(np.minimum(a.lo, b.lo), None if known else np.minimum(a.hi, b.hi), b)


def maximum_of(a: Integer, b: Integer) -> Integer:
    """The larger of two."""
    known = a.known and b.known
    return a.derive(np.maximum(a.lo, b.lo), None if known else np.maximum(a.hi, b.hi), b)


def clamp(n: Integer, minimum: Integer, maximum: Integer) -> Integer:
    """min(max(n, minimum), maximum); undefined where minimum may exceed maximum."""
    found = minimum_of(maximum_of(n, minimum), maximum)
    undefined = minimum.hi > maximum.lo
    return found.derive(found.lo, None if found.known else found.hi, anything=undefined)


def select(condition: Any, a: Integer, b: Integer) -> Integer:
    """a where the condition holds, else b; the hull of both where it is undecided."""
    truth = as_tri_bool(condition)
    rules = a.rules or b.rules or truth.rules
    if rules is None and a.known and b.known and a.unsigned == b.unsigned:
        return Integer(np.where(truth.all_true, a.lo, b.lo), unsigned=a.unsigned)
    low = np.where(truth.all_true, a.lo, np.where(truth.all_false, b.lo, np.minimum(a.lo, b.lo)))
    high = np.where(truth.all_true, a.hi, np.where(truth.all_false, b.hi, np.maximum(a.hi, b.hi)))
    flags = (a.anything & ~truth.all_false) | (b.anything & ~truth.all_true)
    plain = Integer(0, unsigned=a.unsigned, rules=rules)
    return plain.derive(low, None if np.array_equal(low, high) else high, anything=flags)
