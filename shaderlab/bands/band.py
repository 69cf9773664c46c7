"""The band: per value, the interval that a conforming device's float32 result may lie in.

Python's operators work on bands, on literals of the shader, and on both; what would lose their
intervals raises.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NoReturn, Self

import numpy as np
from numpy.typing import ArrayLike

from shaderlab.bands import arithmetic, formats
from shaderlab.bands.bounds import NO, NOWHERE, Allowed, Bounds, Swizzled
from shaderlab.bands.exact import TriBool, absolute_value, equal, less, negate, not_less, union
from shaderlab.bands.rounding import Float64Array, Rules, round_outward
from shaderlab.errors import FormulaError
from shaderlab.model.checked import is_masked

_DEFAULT = Rules()
_FLOAT32 = np.dtype(np.float32)
WHOLE = "glslmath.int(x) makes an integer; where(c, 1, 2) and abs(3) of numbers alone give floats"

# What NumPy calls for `array + band`, and the band's operator that answers.
REFLECTED = {
    np.add: "__radd__",
    np.subtract: "__rsub__",
    np.multiply: "__rmul__",
    np.divide: "__rtruediv__",
    np.matmul: "__rmatmul__",
    np.less: "__gt__",
    np.greater: "__lt__",
    np.less_equal: "__ge__",
    np.greater_equal: "__le__",
    np.equal: "__eq__",
    np.not_equal: "__ne__",
    np.remainder: "__rmod__",
    np.bitwise_and: "__rand__",
    np.bitwise_or: "__ror__",
    np.bitwise_xor: "__rxor__",
    np.left_shift: "__rlshift__",
    np.right_shift: "__rrshift__",
}
_BOUNDS = "use shaderlab.glslmath's functions; the bounds are .lo and .hi"
# What would take one number for a band: what the error calls it, and what to write instead.
_OF_BITS = {"and": "&", "or": "|", "xor": "^", "lshift": "<<", "rshift": ">>"}
_REFUSED = {
    "__array__": ("a NumPy array", _BOUNDS),
    "__bool__": ("a Python condition", "choose with glslmath.where(condition, a, b)"),
    "__float__": ("float() or math", _BOUNDS),
    "__int__": ("Python's int()", "use glslmath.int, glslmath.trunc or glslmath.floor"),
    "__round__": ("Python's round()", "use glslmath.round or glslmath.roundEven"),
    "__iter__": ("a loop", "take components with glslmath.swizzle(v, 'xyz') or v[..., 0:1]"),
    "__pow__": ("**", "write x * x, or glslmath.pow(x, y), whose band is wider"),
    "__mod__": ("%", "use glslmath.mod(x, y)"),
    "__floordiv__": ("//", "use glslmath.floor(x / y)"),
    **{f"__{word}__": (sign, WHOLE) for word, sign in _OF_BITS.items()},
    **{f"__r{word}__": (sign, WHOLE) for word, sign in _OF_BITS.items()},
}


def _refuse(what: str, remedy: str) -> NoReturn:
    raise FormulaError(f"{what} cannot take a band", remedy=remedy)


def _refusal(what: str, remedy: str) -> Callable[..., NoReturn]:
    return lambda *values, **options: _refuse(what, remedy)


def _make_operators(operation: Callable[[Any, Any], Any]) -> tuple[Any, Any]:
    return (
        lambda self, other: operation(self, self.lift(other)),
        lambda self, other: operation(self.lift(other), self),
    )


class Band(Bounds, Swizzled):
    """An interval for every value of an array, on the float32 grid, rounded outward.

    The last axis is the vector's components, always: a per-pixel float is (N, 1), a uniform
    float (1,), a uniform vec3 (3,), a mat4 (4, 4) with m[row, column]; `v.xyz` are components by
    GLSL's names. Arithmetic with plain numbers and arrays takes those as literals of the shader
    (see `literal`). Two bands of different rules don't mix. GLSL's functions are in
    `shaderlab.glslmath`; NumPy's raise `FormulaError`, as do `if band` and `float(band)`.

    >>> x = Band.exact([0.1])
    >>> float((x * 0.5).lo[0]) == float((x * 0.5).hi[0]) == float(np.float32(0.1)) / 2
    True
    >>> third = Band.exact([1.0]) / 3.0
    >>> third.contains(np.float32(1 / 3)), third.contains(np.float32(0.3334))
    (array([ True]), array([False]))
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    @classmethod
    def exact(cls, values: ArrayLike, rules: Rules = _DEFAULT) -> Band:
        """The float32 values that the shader got: `values`, rounded to float32 once.

        A denormal includes zero where the rules let it flush; for NaN anything is legal.
        """
        got: Any = values
        if type(got) is not np.ndarray or got.dtype is not _FLOAT32 or not got.ndim:
            with np.errstate(all="ignore"):
                got = np.atleast_1d(np.asarray(values, dtype=np.float32))
        with np.errstate(all="ignore"):
            # Each component's values lie beside each other, as in all that is computed from them:
            # NumPy's loops over short last axes would take several times as long.
            wide = got.astype(np.float64, order="F")
        return cls._leaf(wide, wide, rules)

    @classmethod
    def between(cls, lo: ArrayLike, hi: ArrayLike, rules: Rules = _DEFAULT) -> Band:
        """Any float32 from `lo` to `hi`, both rounded outward. Raises FormulaError: where lo >
        hi."""
        low, high = (np.atleast_1d(np.asarray(bound, dtype=np.float64)) for bound in (lo, hi))
        if low.shape != high.shape:
            low, high = np.broadcast_arrays(low, high)
        if (low > high).any():
            raise FormulaError("a band's lower bound lies above its upper bound")
        first = np.asfortranarray(low)
        return cls._leaf(first, first if low is high else np.asfortranarray(high), rules)

    @classmethod
    def literal(cls, value: ArrayLike, rules: Rules = _DEFAULT) -> Band:
        """A constant of the shader's source: exact if it is a float32, else both neighbours.

        A Python number that needs more than nine digits, such as 1.0 / 2.2, was computed; the
        shader computes it in float32, so it has 3 ULP on either side.
        """
        if is_masked(value):
            raise FormulaError("a masked value is no number")
        given = np.atleast_1d(np.asarray(value, dtype=np.float64))
        if given.size > 16:
            return cls._leaf(given, given, rules)
        first, last, unknown = _literal_bounds(given.tobytes(), rules.flush)
        low = first.reshape(given.shape)
        high = low if first is last else last.reshape(given.shape)
        return cls._leaf(low, high, rules) if unknown else cls(low, high, rules)

    @classmethod
    def _leaf(cls, lo: Float64Array, hi: Float64Array, rules: Rules) -> Band:
        """The band of bounds in order, rounded outward; for NaN anything is legal."""
        unknown = np.isnan(lo) if lo is hi else np.isnan(lo) | np.isnan(hi)
        flags = NOWHERE
        if unknown.any():
            lo, hi = np.where(unknown, -np.inf, lo), np.where(unknown, np.inf, hi)
            flags = (unknown, unknown, NO)
        return cls(*round_outward(lo, hi, rules.flush), rules, flags)

    def quantise(self, fmt: str, *, tolerance: float | None = None) -> Allowed:
        """What reading these values back from a render target of this format may give.

        See `formats.quantise` for the formats, their units and their tolerances.
        """
        return formats.quantise(self, fmt, tolerance)

    def __repr__(self) -> str:
        if self.lo.size <= 4:
            return f"Band({self.lo.tolist()} … {self.hi.tolist()})"
        return f"Band(shape={self.shape})"

    def lift(self, other: Any) -> Band:
        """`other` as a band of this one's rules."""
        if type(other) is Band or isinstance(other, Band):
            if other.rules is not self.rules and other.rules != self.rules:
                raise FormulaError(
                    f"bands of different rules in one formula: {self.rules} and {other.rules}"
                )
            return other
        if isinstance(other, TriBool):
            raise FormulaError(
                "a condition is not a number", remedy="choose with glslmath.where(condition, a, b)"
            )
        # Literals and integers know how.
        as_band: Callable[[Rules], Band] | None = getattr(other, "as_band", None)
        return Band.literal(other, self.rules) if as_band is None else as_band(self.rules)

    __add__, __radd__ = _make_operators(arithmetic.add)
    __sub__, __rsub__ = _make_operators(arithmetic.subtract)
    __mul__, __rmul__ = _make_operators(arithmetic.multiply)
    __truediv__, __rtruediv__ = _make_operators(arithmetic.divide)
    __matmul__, __rmatmul__ = _make_operators(arithmetic.matmul)
    __lt__, __gt__ = _make_operators(less)
    __ge__, __le__ = _make_operators(not_less)

    def __eq__(self, other: Any) -> TriBool:  # type: ignore[override]
        return equal(self, self.lift(other))

    def __ne__(self, other: Any) -> TriBool:  # type: ignore[override]
        return ~equal(self, self.lift(other))

    def __neg__(self) -> Band:
        return negate(self)

    def __pos__(self) -> Self:
        return self

    def __abs__(self) -> Band:
        return absolute_value(self)

    def __array_ufunc__(
        self: Any, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any
    ) -> Any:
        reflected = REFLECTED.get(ufunc)
        if reflected and method == "__call__" and not options and inputs[1] is self:
            operation = getattr(self, reflected, None)
            if operation is not None:
                return operation(inputs[0])
        name = f"numpy.{ufunc.__name__}" + ("" if method == "__call__" else f".{method}")
        if options.get("out"):
            _refuse(f"{name} into an array", "write a = a + band, not a += band")
        _refuse(name, "use the function of the same purpose in shaderlab.glslmath")

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> NoReturn:
        _refuse(
            f"numpy.{function.__name__}",
            "use shaderlab.glslmath: vec2/vec3/vec4 to join, where to choose, dot to sum products",
        )


for _name, _why in _REFUSED.items():
    setattr(Band, _name, _refusal(*_why))
for _name in ("pow", "mod", "floordiv"):
    setattr(Band, f"__r{_name}__", _refusal(*_REFUSED[f"__{_name}__"]))


@lru_cache(maxsize=512)
@np.errstate(all="ignore")
def _literal_bounds(data: bytes, flush: bool) -> tuple[Float64Array, Float64Array, bool]:
    """The bounds of a few constants, and whether one is NaN; a formula has the same ones for
    every block of pixels, and its shader mostly as well."""
    given = np.frombuffer(data, np.float64)
    low, high = round_outward(given, given, False)
    if low is not high:
        computed = [float(f"{x:.9g}") != x for x in given.flat]
        if any(computed):
            wide = np.where(np.array(computed) & (low != high), 2.0 * (high - low), 0.0)
            low, high = low - wide, high + wide
    low, high = round_outward(low, high, flush)
    low.flags.writeable = high.flags.writeable = False
    return low, high, bool(np.isnan(given).any())


class Literal(float):
    """A float constant that remembers which float32 it may be; `band` has shape (1,).

    Where `0.52 - 0.02` stands in a shader, some compilers compute it in float32, whose result is
    not ½, and some in float64, whose result is: the band of a sum, product or quotient of
    literals holds both. To everything but bands and `shaderlab.glslmath` it is a plain float.

    >>> half = Literal.of(0.52) - Literal.of(0.02)
    >>> half == 0.5, bool(half.band.lo[0] < 0.5 < half.band.hi[0])
    (True, True)
    """

    __slots__ = ("band",)
    band: Band

    @classmethod
    def of(cls, value: float, rules: Rules | None = None) -> Literal:
        """The constant as it is written: exact if it is a float32, else both neighbours."""
        made = cls(value)
        made.band = Band.literal(value, rules or Rules())
        return made

    @classmethod
    def fold(cls, value: float, band: Band) -> Literal:
        """What a compiler makes of constants: `value` in float64, or anything in `band`."""
        made = cls(value)
        # No compiler rearranges what it has computed exactly.
        exact = band.lo is band.hi
        made.band = band.without_terms() if exact else union(band, Band.literal(value, band.rules))
        return made

    def as_band(self, rules: Rules) -> Band:
        """The band under these rules."""
        own = self.band.rules
        return self.band if rules is own or rules == own else Band.literal(float(self), rules)

    def __pow__(self, other: Any, modulo: None = None) -> Any:
        return Literal.of(float(self) ** float(other), self.band.rules)

    def __neg__(self) -> Literal:
        return Literal.fold(-float(self), -self.band)

    def __pos__(self) -> Literal:
        return self

    def __abs__(self) -> Literal:
        return Literal.fold(abs(float(self)), abs(self.band))


def _make_folding_operators(
    value_of: Callable[[Any, Any], Any], operation: Callable[[Any, Any], Any]
) -> tuple[Any, Any]:
    """An operation on floats, and on bands, as a literal's operator, and with the literal on the
    right."""

    def straight(self: Literal, other: Any) -> Any:
        if type(other) not in (float, int, Literal):
            return NotImplemented
        value = value_of(float(self), float(other))
        return Literal.fold(value, operation(self.band, self.band.lift(other)))

    def reflected(self: Literal, other: Any) -> Any:
        if type(other) not in (float, int):
            return NotImplemented
        value = value_of(float(other), float(self))
        return Literal.fold(value, operation(self.band.lift(other), self.band))

    return straight, reflected


for _name, _value_of, _operation in (
    ("add", operator.add, arithmetic.add),
    ("sub", operator.sub, arithmetic.subtract),
    ("mul", operator.mul, arithmetic.multiply),
    ("truediv", operator.truediv, arithmetic.divide),
):
    _straight, _reflected = _make_folding_operators(_value_of, _operation)
    setattr(Literal, f"__{_name}__", _straight)
    setattr(Literal, f"__r{_name}__", _reflected)
