"""Building and taking apart vectors and matrices: GLSL's constructors and swizzles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shaderlab.bands import Band
from shaderlab.bands.exact import concatenated, joined
from shaderlab.bands.swizzles import SETS, as_vector, components
from shaderlab.errors import FormulaError
from shaderlab.glslmath.dispatch import Value, bands


def stacked(parts: Sequence[Value], axis: int) -> Value:
    """Values one after the other along an axis, the other axes broadcast."""
    lifted = bands(*parts)
    if lifted is not None:
        return joined(lifted, axis)
    arrays = [np.atleast_1d(np.asarray(part, np.float64)) for part in parts]
    return as_vector(concatenated(arrays, axis), *parts)


def _vector(size: int, parts: Sequence[Value]) -> Value:
    name = f"vec{size}"
    if not parts:
        raise FormulaError(f"{name} needs at least one value")
    together = stacked(parts, -1)
    got = together.shape[-1]
    if got == size:
        return together
    if got == 1:
        return together[..., [0] * size]
    # GLSL takes what it needs of the last argument, but no argument may be left over.
    last = np.shape(parts[-1])[-1:] or (1,) if not isinstance(parts[-1], Band) else parts[-1].shape
    if got < size or got - last[-1] >= size:
        raise FormulaError(
            f"{name} of {got} components in {len(parts)} arguments",
            remedy=f"give it {size} components, or one number for all of them",
        )
    return together[..., :size]


def vec2(*parts: Value) -> Value:
    """Two components from numbers and vectors, or one number for both.

    >>> vec2(1.0, 2.0)
    array([1., 2.])
    """
    return _vector(2, parts)


def vec3(*parts: Value) -> Value:
    """Three components from numbers and vectors, or one number for all; the rest broadcasts.

    >>> vec3(np.array([1.0, 2.0]), 3.0)
    array([1., 2., 3.])
    """
    return _vector(3, parts)


def vec4(*parts: Value) -> Value:
    """Four components from numbers and vectors, or one number for all; the rest broadcasts.

    >>> vec4(np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]), 1.0)
    array([[1., 2., 3., 1.],
           [4., 5., 6., 1.]])
    """
    return _vector(4, parts)


def swizzle(v: Value, names: str) -> Value:
    """Components by GLSL's names: xyzw, rgba or stpq, of one set, any order, repeated or not;
    the values that a reference gets have them as attributes, too: `v.yxx`.

    >>> swizzle(np.array([1.0, 2.0]), "yxx")
    array([2., 1., 1.])
    """
    size = v.shape[-1] if hasattr(v, "shape") else np.shape(v)[-1]
    found = components(names, size)
    if found is None:
        raise FormulaError(
            f"no swizzle {names!r} of {size} components",
            remedy=f"use the letters of one of {', '.join(s[:size] for s in SETS)}",
        )
    return v[..., found]


def _matrix(columns: int, rows: int, parts: Sequence[Value]) -> Value:
    name = f"mat{columns}" if columns == rows else f"mat{columns}x{rows}"
    if len(parts) == 1:
        (m,) = parts
        shape = _shape(m)
        if len(shape) >= 2 and shape[-1] >= columns and shape[-2] >= rows:
            return m[..., :rows, :columns]
        if shape[-1:] in ((), (1,)):
            return _diagonal(columns, rows, m)
        raise FormulaError(
            f"{name} of an array of shape {shape}",
            remedy=f"give it one number, a larger matrix, or {columns * rows} components",
        )
    together = stacked(parts, -1) if parts else np.empty(0)
    got, size = together.shape[-1], columns * rows
    last = (_shape(parts[-1])[-1:] or (1,))[0] if parts else 0
    if got < size or got - last >= size:
        raise FormulaError(
            f"{name} of {got} components in {len(parts)} arguments",
            remedy=f"give it a larger matrix, {columns} columns of {rows}, or {size} components, "
            "column by column",
        )
    each = [together[..., n * rows : (n + 1) * rows, None] for n in range(columns)]
    return stacked(each, -1)


def _diagonal(columns: int, rows: int, value: Value) -> Value:
    parts = [value if row == column else 0.0 for column in range(columns) for row in range(rows)]
    return _matrix(columns, rows, parts)


def _shape(value: Value) -> tuple[int, ...]:
    return tuple(getattr(value, "shape", ()))


def mat2(*parts: Value) -> Value:
    """Two columns, or their four components; one number on the diagonal; or the upper left of a
    larger matrix."""
    return _matrix(2, 2, parts)


def mat3(*parts: Value) -> Value:
    """Three columns (tangent, bitangent, …), or their nine components; one number on the diagonal;
    or the upper left of a larger matrix."""
    return _matrix(3, 3, parts)


def mat4(*parts: Value) -> Value:
    """Four columns, or their sixteen components; one number on the diagonal.

    >>> mat4(1.0)[2]
    array([0., 0., 1., 0.])
    """
    return _matrix(4, 4, parts)
