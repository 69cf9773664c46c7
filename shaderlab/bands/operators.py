"""What Python's operators do to bands, and what raises because it would lose their intervals."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NoReturn, Self

import numpy as np

from shaderlab.bands import arithmetic, exact, sums
from shaderlab.bands.integer_operators import WHOLE
from shaderlab.bands.truth import Truth
from shaderlab.errors import FormulaError

if TYPE_CHECKING:
    from shaderlab.bands.band import Band

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
    "__pow__": ("**", "use glslmath.pow(x, y), which has GLSL's precision; or multiply"),
    "__mod__": ("%", "use glslmath.mod(x, y)"),
    "__floordiv__": ("//", "use glslmath.floor(x / y)"),
    **{f"__{word}__": (sign, WHOLE) for word, sign in _OF_BITS.items()},
    **{f"__r{word}__": (sign, WHOLE) for word, sign in _OF_BITS.items()},
}


def _refuse(what: str, remedy: str) -> NoReturn:
    raise FormulaError(f"{what} cannot take a band", remedy=remedy)


def _refusal(what: str, remedy: str) -> Callable[..., NoReturn]:
    return lambda *values, **options: _refuse(what, remedy)


def _both_ways(operation: Callable[[Any, Any], Any]) -> tuple[Any, Any]:
    """`operation` as a band's operator, and with the band on the right."""
    return (
        lambda self, other: operation(self, self.lift(other)),
        lambda self, other: operation(self.lift(other), self),
    )


class Operators:
    """The arithmetic of bands, and guards for everything that would lose their intervals."""

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    __add__, __radd__ = _both_ways(arithmetic.add)
    __sub__, __rsub__ = _both_ways(arithmetic.subtract)
    __mul__, __rmul__ = _both_ways(arithmetic.multiply)
    __truediv__, __rtruediv__ = _both_ways(arithmetic.divide)
    __matmul__, __rmatmul__ = _both_ways(sums.matmul)
    __lt__, __gt__ = _both_ways(exact.less)
    __ge__, __le__ = _both_ways(exact.not_less)

    def __eq__(self: Any, other: Any) -> Truth:  # type: ignore[override]
        return exact.equal(self, self.lift(other))

    def __ne__(self: Any, other: Any) -> Truth:  # type: ignore[override]
        return ~exact.equal(self, self.lift(other))

    def __neg__(self: Any) -> Band:
        return exact.negative(self)

    def __pos__(self) -> Self:
        return self

    def __abs__(self: Any) -> Band:
        return exact.absolute(self)

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
    setattr(Operators, _name, _refusal(*_why))
for _name in ("pow", "mod", "floordiv"):
    setattr(Operators, f"__r{_name}__", _refusal(*_REFUSED[f"__{_name}__"]))
