"""What Python's operators do to bands, and what raises instead of silently misbehaving."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn, Self

import numpy as np

from shaderlab.bands import arithmetic, matrices, stepwise
from shaderlab.bands.truth import Truth
from shaderlab.errors import FormulaError

if TYPE_CHECKING:
    from shaderlab.bands.band import Band

# What NumPy calls for `array + band`, and the operator of the band that answers.
_REFLECTED = {
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
}


def _refuse(what: str, remedy: str) -> NoReturn:
    raise FormulaError(f"{what} cannot take a band", remedy=remedy)


class Operators:
    """The arithmetic of bands, and guards for everything that would lose their intervals."""

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    def __add__(self: Any, other: Any) -> Band:
        return arithmetic.add(self, self.lift(other))

    def __radd__(self: Any, other: Any) -> Band:
        return arithmetic.add(self.lift(other), self)

    def __sub__(self: Any, other: Any) -> Band:
        return arithmetic.add(self, stepwise.negative(self.lift(other)))

    def __rsub__(self: Any, other: Any) -> Band:
        return arithmetic.add(self.lift(other), stepwise.negative(self))

    def __mul__(self: Any, other: Any) -> Band:
        return arithmetic.multiply(self, self.lift(other))

    def __rmul__(self: Any, other: Any) -> Band:
        return arithmetic.multiply(self.lift(other), self)

    def __truediv__(self: Any, other: Any) -> Band:
        return arithmetic.divide(self, self.lift(other))

    def __rtruediv__(self: Any, other: Any) -> Band:
        return arithmetic.divide(self.lift(other), self)

    def __neg__(self: Any) -> Band:
        return stepwise.negative(self)

    def __pos__(self) -> Self:
        return self

    def __abs__(self: Any) -> Band:
        return stepwise.absolute(self)

    def __lt__(self: Any, other: Any) -> Truth:
        return stepwise.less(self, self.lift(other))

    def __gt__(self: Any, other: Any) -> Truth:
        return stepwise.less(self.lift(other), self)

    def __ge__(self: Any, other: Any) -> Truth:
        return ~stepwise.less(self, self.lift(other))

    def __le__(self: Any, other: Any) -> Truth:
        return ~stepwise.less(self.lift(other), self)

    def __eq__(self: Any, other: Any) -> Truth:  # type: ignore[override]
        return stepwise.equal(self, self.lift(other))

    def __ne__(self: Any, other: Any) -> Truth:  # type: ignore[override]
        return ~stepwise.equal(self, self.lift(other))

    def __matmul__(self: Any, other: Any) -> Band:
        return matrices.matmul(self, self.lift(other))

    def __rmatmul__(self: Any, other: Any) -> Band:
        return matrices.matmul(self.lift(other), self)

    def __array_ufunc__(
        self: Any, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any
    ) -> Any:
        reflected = _REFLECTED.get(ufunc)
        if reflected and method == "__call__" and not options and inputs[1] is self:
            return getattr(self, reflected)(inputs[0])
        name = f"numpy.{ufunc.__name__}" + ("" if method == "__call__" else f".{method}")
        if options.get("out"):
            _refuse(f"{name} into an array", "write a = a + band, not a += band")
        _refuse(name, "use the function of the same purpose in shaderlab.glslmath")

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> NoReturn:
        _refuse(
            f"numpy.{function.__name__}",
            "use shaderlab.glslmath: vec2/vec3/vec4 to join, where to choose, dot to sum products",
        )

    def __array__(self, *args: Any, **kwargs: Any) -> NoReturn:
        _refuse("a NumPy array", "use shaderlab.glslmath's functions; the bounds are .lo and .hi")

    def __bool__(self) -> NoReturn:
        _refuse("a Python condition", "choose with glslmath.where(condition, a, b)")

    def __float__(self) -> NoReturn:
        _refuse("float() or math", "use shaderlab.glslmath's functions; the bounds are .lo and .hi")

    def __int__(self) -> NoReturn:
        _refuse("int()", "use glslmath.trunc or glslmath.floor")

    def __round__(self, *digits: Any) -> NoReturn:
        _refuse("Python's round()", "use glslmath.round or glslmath.roundEven")

    def __iter__(self) -> NoReturn:
        _refuse("a loop", "take components with glslmath.swizzle(v, 'xyz') or v[..., 0:1]")

    def __pow__(self, other: Any) -> NoReturn:
        _refuse("**", "use glslmath.pow(x, y), which has GLSL's precision; or multiply")

    __rpow__ = __pow__

    def __mod__(self, other: Any) -> NoReturn:
        _refuse("%", "use glslmath.mod(x, y)")

    __rmod__ = __mod__

    def __floordiv__(self, other: Any) -> NoReturn:
        _refuse("//", "use glslmath.floor(x / y)")

    __rfloordiv__ = __floordiv__
