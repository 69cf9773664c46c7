"""Which rows of judged values are evaluated together: whole quads, where a formula sees them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any

import numpy as np

from .inputs import Inputs

PLACE = "frag_coord"


def chunks(inputs: Inputs, asked: Collection[str], count: int, size: int) -> Iterator[slice]:
    """Slices of `size` rows; one at least. A formula that asks for `frag_coord` may compare a
    pixel with its neighbours: then a slice ends where a row of 2 × 2 pixels does."""
    sees = PLACE in asked and PLACE in inputs.each
    ends = _ends_of_quads(inputs) if sees else None
    start = 0
    while start < max(count, 1):
        stop = start + size
        if ends is not None and stop < count:
            before = ends[(ends > start) & (ends <= stop)]
            stop = int(before[-1] if before.size else ends[ends > start][0])
        yield slice(start, min(stop, max(count, 1)))
        start = stop


def quad_rows(inputs: Inputs, asked: Collection[str], wanted: Sequence[slice]) -> Sequence[slice]:
    """Some slices of rows, and with `frag_coord` all the rows of their quads."""
    if PLACE not in asked or PLACE not in inputs.each:
        return wanted
    ends = _ends_of_quads(inputs)

    def whole(rows: slice) -> slice:
        first = ends[ends <= rows.start]
        return slice(int(first[-1]) if first.size else 0, int(ends[ends >= rows.stop][0]))

    return [whole(rows) for rows in wanted]


def _ends_of_quads(inputs: Inputs) -> Any:
    """Behind which rows another pair of pixel rows begins; the last is the number of rows."""
    pair = np.floor(inputs.each[PLACE][:, 1] / 2.0)
    return np.append(np.flatnonzero(np.diff(pair)) + 1, len(pair))
