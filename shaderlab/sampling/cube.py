"""Cube maps: which face a direction meets, where on it, and what lies across its edges.

Source: OpenGL 4.5 core profile specification, §8.13, table 8.19 (selection of cube map images),
and §8.13.1 (seamless filtering: texels come from the neighbouring face; a corner has three
texels, whose mean is recommended for the missing fourth, and nothing is required of it but that
it equals them where they are equal).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.frame import Array
from shaderlab.sampling.reading import (
    EDGE,
    Integers,
    Sampler,
    level_values,
    looked_up,
    stored,
    wrapped,
)
from shaderlab.sampling.spans import Span, component, hull

Flags = npt.NDArray[np.bool_]

# By face: the major axis; then the axis and the sign of s and of t (table 8.19).
_TABLE = (
    (0, (2, -1), (1, -1)),
    (0, (2, 1), (1, -1)),
    (1, (0, 1), (2, 1)),
    (1, (0, 1), (2, -1)),
    (2, (0, 1), (1, -1)),
    (2, (0, -1), (1, -1)),
)
# What dividing by the major axis may lose, of 1: a division and the sum before it.
_ROUNDING = 4 * 2.0**-23


def cube_face(direction: Any) -> tuple[Integers, Array, Array]:
    """The face that a direction meets (0…5 for +X, −X, +Y, −Y, +Z, −Z), and s and t on it.

    Args:
        direction: (…, 3), of any length but 0.

    >>> face, s, t = cube_face(np.array([2.0, 0.5, -1.0]))
    >>> int(face), float(s), float(t)
    (0, 0.75, 0.375)
    """
    given = np.asarray(direction, np.float64)
    axis = np.argmax(np.abs(given), axis=-1)
    major = np.take_along_axis(given, axis[..., None], -1)[..., 0]
    face = 2 * axis + (major < 0.0)
    table = np.array([[s[0], s[1], t[0], t[1]] for _, s, t in _TABLE])[face]
    s, t = (
        0.5 * (np.take_along_axis(given, table[..., k, None], -1)[..., 0] * table[..., k + 1])
        / np.abs(major) + 0.5
        for k in (0, 2)
    )  # fmt: skip
    return face, s, t


def met_faces(direction: Span, exact: bool) -> Iterator[tuple[int, Flags, Span, Span]]:
    """Each face that some directions may select: its number, which directions, and s and t of all.

    `exact` for float64 directions, which select one face even if two components are equal.
    """
    axes = [component(direction, k) for k in range(3)]
    if exact:
        face, s, t = cube_face(direction[0])
        for number in np.unique(face):
            yield int(number), face == number, (s, s), (t, t)
        return
    sizes = [_size(axis) for axis in axes]
    for number, (axis, s_axis, t_axis) in enumerate(_TABLE):
        low, high = axes[axis] if number % 2 == 0 else (-axes[axis][1], -axes[axis][0])
        others = np.maximum.reduce([sizes[k][0] for k in range(3) if k != axis])
        may = (high > 0.0) & (high >= others)
        if not may.any():
            continue
        # Where this face is met, the major axis is no smaller than the others.
        least = np.maximum(np.maximum(low, others), np.finfo(np.float64).tiny)
        major = (np.where(may, least, 1.0), np.where(may, np.maximum(high, least), 1.0))
        of_s = _on_face(axes[s_axis[0]], s_axis[1], major, may)
        of_t = _on_face(axes[t_axis[0]], t_axis[1], major, may)
        yield number, may, of_s, of_t


def across_edges(sampler: Sampler, level: int, x: Array, y: Array, face: Integers) -> Span:
    """Texels of a face or beyond its edges: of the adjacent face where filtering is
    seamless, else by the wrap modes."""
    if not sampler.texels.seamless:
        return wrapped(sampler, level, x, y, face)
    size = level_values(sampler, level).shape[1]
    column, row = x.astype(np.int64), y.astype(np.int64)
    out_x, out_y = (column < 0) | (column >= size), (row < 0) | (row >= size)
    inside_x, inside_y = np.clip(column, 0, size - 1), np.clip(row, 0, size - 1)
    here = looked_up(sampler, level, x, y, face, EDGE, EDGE)
    if not (out_x | out_y).any():
        return here
    low = here[0].copy()
    high = low if here[0] is here[1] else here[1].copy()

    def put(where: Flags, texels: Span) -> None:
        low[where] = texels[0]
        if high is not low:
            high[where] = texels[1]

    for where, at in ((out_x, (column, inside_y)), (out_y, (inside_x, row))):
        if where.any():
            put(where, _neighbour(sampler, level, at[0][where], at[1][where], face[where], size))
    corner = out_x & out_y
    if not corner.any():
        return low, high
    three = [
        (here[0][corner], here[1][corner]),
        _neighbour(sampler, level, column[corner], inside_y[corner], face[corner], size),
        _neighbour(sampler, level, inside_x[corner], row[corner], face[corner], size),
    ]
    if sampler.rules is None:
        put(corner, ((three[0][0] + three[1][0] + three[2][0]) / 3.0,) * 2)
        return low, high
    if high is low:
        high = low.copy()
    put(corner, hull(three))
    return low, high


def _neighbour(
    sampler: Sampler, level: int, column: Integers, row: Integers, face: Integers, size: int
) -> Span:
    """The texel of the adjacent face that a position just outside a face falls on."""
    s, t = 2.0 * (column + 0.5) / size - 1.0, 2.0 * (row + 0.5) / size - 1.0
    direction = np.zeros((*np.shape(s), 3))
    for number, (axis, s_axis, t_axis) in enumerate(_TABLE):
        on = face == number
        for index, value in (
            (axis, 1.0 - 2.0 * (number % 2)), (s_axis[0], s * s_axis[1]), (t_axis[0], t * t_axis[1])
        ):  # fmt: skip
            direction[..., index] = np.where(on, value, direction[..., index])
    other, u, v = cube_face(direction)
    x = np.clip(np.floor(u * size).astype(np.int64), 0, size - 1)
    y = np.clip(np.floor(v * size).astype(np.int64), 0, size - 1)
    return stored(sampler, level, x, y, other)


def _size(span: Span) -> Span:
    """The bounds of a number's absolute value."""
    low, high = np.abs(span[0]), np.abs(span[1])
    least = np.where((span[0] < 0.0) & (span[1] > 0.0), 0.0, np.minimum(low, high))
    return least, np.maximum(low, high)


def _on_face(along: Span, sign: int, major: Span, may: Flags) -> Span:
    """0.5·(±along / major) + 0.5, in 0…1; the middle where the face is not met."""
    ends = [np.where(may, sign * a / m, 0.0) for a in along for m in major]
    low, high = np.minimum.reduce(ends), np.maximum.reduce(ends)
    return (
        np.clip(0.5 * low + 0.5 - _ROUNDING, 0.0, 1.0),
        np.clip(0.5 * high + 0.5 + _ROUNDING, 0.0, 1.0),
    )
