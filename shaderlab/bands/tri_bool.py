"""Three-valued answers: a comparison of two bands is true, false, or undecided, value by value."""

from __future__ import annotations

from typing import Any, NoReturn

import numpy as np

from shaderlab.bands.rounding import Flags, Rules
from shaderlab.errors import FormulaError


class TriBool:
    """What a condition is at each value: true on every device, false on every device, or neither.

    `&`, `|`, `~` combine truths (and plain boolean arrays); `glslmath.where(truth, a, b)` chooses.
    `bool(truth)` raises `FormulaError`, because a Python `if` takes one side for all pixels.

    Attributes:
        all_true, all_false: boolean arrays of one shape; nowhere are both set.
        undecided: neither of them.
        rules: those of the bands compared; None if this came from plain booleans.
    """

    __slots__ = ("all_false", "all_true", "rules")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, all_true: Any, all_false: Any, rules: Rules | None = None) -> None:
        self.all_true: Flags
        self.all_false: Flags
        if all_true.shape != all_false.shape:
            all_true, all_false = np.broadcast_arrays(all_true, all_false)
        self.all_true, self.all_false = all_true, all_false
        self.rules = rules

    @classmethod
    def of(cls, values: Any) -> TriBool:
        """The truth of plain booleans."""
        flags = np.atleast_1d(np.asarray(values, dtype=np.bool_))
        return cls(flags, ~flags)

    @property
    def undecided(self) -> Flags:
        neither: Flags = ~(self.all_true | self.all_false)
        return neither

    @property
    def shape(self) -> tuple[int, ...]:
        return self.all_true.shape

    @property
    def ndim(self) -> int:
        return self.all_true.ndim

    def __getitem__(self, index: Any) -> TriBool:
        return TriBool(self.all_true[index], self.all_false[index], self.rules)

    def __and__(self, other: Any) -> TriBool:
        other = as_tri_bool(other)
        return TriBool(
            self.all_true & other.all_true,
            self.all_false | other.all_false,
            self.rules or other.rules,
        )

    def __or__(self, other: Any) -> TriBool:
        other = as_tri_bool(other)
        return ~(~self & ~as_tri_bool(other))

    __rand__ = __and__
    __ror__ = __or__

    def __invert__(self) -> TriBool:
        return TriBool(self.all_false, self.all_true, self.rules)

    def all(self) -> TriBool:
        """GLSL's `all`: over the last axis, which stays with size 1."""
        return TriBool(
            self.all_true.all(axis=-1, keepdims=True),
            self.all_false.any(axis=-1, keepdims=True),
            self.rules,
        )

    def any(self) -> TriBool:
        """GLSL's `any`: over the last axis, which stays with size 1."""
        return ~(~self).all()

    def __bool__(self) -> NoReturn:
        raise FormulaError(
            "a comparison of bands has no single answer: it may differ from pixel to pixel",
            remedy="choose with glslmath.where(condition, a, b); combine conditions with & | ~",
        )

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any
    ) -> TriBool:
        if method == "__call__" and len(inputs) == 2 and not options:
            left, right = (as_tri_bool(value) for value in inputs)
            if ufunc in (np.bitwise_and, np.logical_and):
                return left & right
            if ufunc in (np.bitwise_or, np.logical_or):
                return left | right
        raise FormulaError(
            f"numpy.{ufunc.__name__} cannot take a comparison of bands",
            remedy="combine conditions with & | ~ and choose with glslmath.where",
        )

    def __repr__(self) -> str:
        return (
            f"TriBool(shape={self.shape}, true={int(self.all_true.sum())}, "
            f"false={int(self.all_false.sum())}, undecided={int(self.undecided.sum())})"
        )


def as_tri_bool(condition: Any) -> TriBool:
    """`condition` itself, or plain booleans as a truth."""
    return condition if isinstance(condition, TriBool) else TriBool.of(condition)
