"""Judged values at their pixels, computed for the part of a picture that is looked at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.model.frame import Array

Part = tuple[slice, slice]
WHOLE: Part = (slice(None), slice(None))


@dataclass(frozen=True)
class LaidOut:
    """Values of covered pixels, as far as they are looked at: `laid_out[ys, xs]`, or all of them as
    an array (height, width, …).

    Attributes:
        covered: booleans, (height, width).
        values: gives those of some of the covered pixels, by their numbers along rows, ascending;
            `slice(None)` are all.
        nothing: what stands at the others.
    """

    covered: Array
    values: Callable[[Array | slice], Array]
    nothing: float

    def __getitem__(self, part: Part) -> Array:
        where = self.covered[part]
        found = self.values(slice(None) if part == WHOLE else self._numbers(part))
        shape = (*where.shape, *found.shape[1:])
        if len(found) == where.size:  # as most draws have it: nothing need be copied
            return found.reshape(shape)
        full = np.full(shape, self.nothing, found.dtype)
        full[where] = found
        return full

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return self[WHOLE] if dtype is None else self[WHOLE].astype(dtype)

    def _numbers(self, part: Part) -> Array:
        rows, columns = part
        before = np.count_nonzero(self.covered[: rows.start])
        here = self.covered[rows]
        counted = before + np.cumsum(here).reshape(here.shape)
        return counted[:, columns][here[:, columns]] - 1
