"""Invocations of one workgroup, which wait for each other and share variables.

They come one after the other, and take each step together: what one of them stored before a barrier
the others find after it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shaderlab.bands import Integer, Truth
from shaderlab.model.frame import Array

from .memory import Flags, indices
from .types import Type
from .values import Value, broadcast, component, composed, select

NUMBERS = (
    "gl_WorkGroupID", "gl_LocalInvocationID", "gl_GlobalInvocationID", "gl_LocalInvocationIndex"
)  # fmt: skip
"""The built-in inputs that number a compute stage's invocations."""
Size = tuple[int, int, int]


def numbered(size: Size, groups: Array, local: Array) -> dict[str, Array]:
    """`NUMBERS` of invocations by their workgroups and their places in these, (count, 3) each."""
    x, y, _ = size
    each = groups * np.array(size) + local
    index = (local @ np.array([1, x, x * y]))[:, None]
    return dict(zip(NUMBERS, (groups, local, each, index), strict=True))


def places_in(size: Size) -> Array:
    """Each invocation's gl_LocalInvocationID in a workgroup, by gl_LocalInvocationIndex, (n, 3)."""
    z, y, x = (axis.ravel() for axis in np.indices(size[::-1]))
    return np.stack([x, y, z], axis=1)


def shared(
    old: Value, type_: Type, path: Sequence[int | Integer], new: Value, mask: Flags, lanes: int
) -> Value:
    """A variable of whole workgroups after a store, the same for all of each: of several that store
    to one element the last counts."""
    if not path:
        return _last(old, new, mask, lanes)
    index, rest = path[0], path[1:]
    size = len(old) if isinstance(old, tuple) else old.shape[-1]
    parts = [component(old, k) for k in range(size)]
    here = indices(index, size, mask) if isinstance(index, Integer) else range(size)
    for k in here:
        at_k = index.lo[:, 0] == k if isinstance(index, Integer) else index == k
        stores = mask & at_k
        if stores.any():
            parts[k] = shared(parts[k], type_.part(k), rest, new, stores, lanes)
    return composed(type_, parts)


def _last(old: Value, new: Value, mask: Flags, lanes: int) -> Value:
    if isinstance(old, tuple):
        return tuple(_last(a, b, mask, lanes) for a, b in zip(old, new, strict=True))
    stores = mask.reshape(-1, lanes)
    last = lanes - 1 - stores[:, ::-1].argmax(axis=1)
    rows = np.repeat(np.arange(len(stores)) * lanes + last, lanes)
    wrote = np.repeat(stores.any(axis=1), lanes)[:, None]
    return select(Truth.known(wrote), broadcast(new, len(mask))[rows], old)
