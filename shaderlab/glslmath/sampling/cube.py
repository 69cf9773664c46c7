"""Cube maps: which face a direction meets, where on it, and what lies across its edges.

Source: OpenGL 4.5 core profile specification, §8.13, table 8.19 (selection of cube map images),
and §8.13.1 (seamless filtering: texels come from the neighbouring face; a corner has three
texels, whose mean is recommended for the missing fourth, and nothing is required of it but that
it equals them where they are equal).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.model.frame import Array

from .reading import Integers, Sampler, level_values, stored_at, wrapped
from .spans import Span, component, hull

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
    """Each face that some directions may select: its number, which directions, and their s and t.

    `exact` for float64 directions, which select one face even if two components are equal.
    """
    axes = [component(direction, k) for k in range(3)]
    if exact:
        face, s, t = cube_face(direction[0])
        for number in np.unique(face):
            on = face == number
            yield int(number), on, (s[on],) * 2, (t[on],) * 2
        return
    sizes = [_size(axis) for axis in axes]
    for number, (axis, s_axis, t_axis) in enumerate(_TABLE):
        low, high = axes[axis] if number % 2 == 0 else (-axes[axis][1], -axes[axis][0])
        others = np.maximum.reduce([sizes[k][0] for k in range(3) if k != axis])
        may = (high > 0.0) & (high >= others)
        if not may.any():
            continue
        # Where this face is met, the major axis is no smaller than the others.
        least = np.maximum(np.maximum(low[may], others[may]), np.finfo(np.float64).tiny)
        major = (least, np.maximum(high[may], least))
        of_s, of_t = (
            _on_face((axes[axis][0][may], axes[axis][1][may]), sign, major)
            for axis, sign in (s_axis, t_axis)
        )
        yield number, may, of_s, of_t


def across_edges(sampler: Sampler, level: int, x: Array, y: Array, face: Integers) -> Span:
    """Texels of a face or beyond its edges: of the adjacent face where filtering is
    seamless, else by the wrap modes."""
    if not sampler.texels.seamless:
        return wrapped(sampler, level, x, y, face)
    size = level_values(sampler, level).shape[1]
    column, row = x.astype(np.int64), y.astype(np.int64)
    inside_x, inside_y = (np.minimum(np.maximum(at, 0), size - 1) for at in (column, row))
    out_x, out_y = column != inside_x, row != inside_y
    place = (face * size + inside_y) * size + inside_x
    corner = out_x & out_y
    own = place[corner]
    for side, out, at, along in ((0, out_x, column, inside_y), (2, out_y, row, inside_x)):
        # Few texels lie beyond an edge. At a corner this ends with the neighbour above or below.
        few = out.nonzero()
        place[few] = _beyond(size)[face[few], side + (at[few] > 0), along[few]]
    low, high = stored_at(sampler, level, place)
    if not corner.any():
        return low, high
    beside = _beyond(size)[face[corner], (column[corner] > 0) + 0, inside_y[corner]]
    three = [stored_at(sampler, level, places) for places in (own, beside, place[corner])]
    if sampler.rules is None:
        low[corner] = sum(one for one, _ in three) / 3.0
        return low, low
    high = high.copy() if high is low else high
    low[corner], high[corner] = hull(three)
    return low, high


@lru_cache(maxsize=16)
def _beyond(size: int) -> Integers:
    """Where the texels of adjacent faces lie, (6, 4, size): by face, then beyond its left, right,
    lower and upper edge, along that edge."""
    along = 2.0 * (np.arange(size) + 0.5) / size - 1.0
    outside = 2.0 * (size + 0.5) / size - 1.0
    found = np.empty((6, 4, size), np.int64)
    for face, (axis, s_axis, t_axis) in enumerate(_TABLE):
        for side in range(4):
            direction = np.empty((size, 3))
            ends = np.full(size, outside if side % 2 else -outside)
            s, t = (ends, along) if side < 2 else (along, ends)
            direction[:, axis] = 1.0 - 2.0 * (face % 2)
            direction[:, s_axis[0]], direction[:, t_axis[0]] = s * s_axis[1], t * t_axis[1]
            other, u, v = cube_face(direction)
            x, y = (np.clip(np.floor(at * size).astype(np.int64), 0, size - 1) for at in (u, v))
            found[face, side] = (other * size + y) * size + x
    return found


def _size(span: Span) -> Span:
    """The bounds of a number's absolute value."""
    low, high = np.abs(span[0]), np.abs(span[1])
    least = np.where((span[0] < 0.0) & (span[1] > 0.0), 0.0, np.minimum(low, high))
    return least, np.maximum(low, high)


def _on_face(along: Span, sign: int, major: Span) -> Span:
    """0.5·(±along / major) + 0.5, in 0…1."""
    ends = [sign * a / m for a in along for m in major]
    low, high = np.minimum.reduce(ends), np.maximum.reduce(ends)
    return (
        np.clip(0.5 * low + 0.5 - _ROUNDING, 0.0, 1.0),
        np.clip(0.5 * high + 0.5 + _ROUNDING, 0.0, 1.0),
    )
