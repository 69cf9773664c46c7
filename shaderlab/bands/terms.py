"""What a value is a sum of: how much rearranging its terms may change it.

A compiler that turns a·b + a·c into a·(b + c), or back, rounds at the size of the terms, not of
their sum. And it may multiply two small factors first, flush the denormal product to zero, and
multiply by a large one then: so what a flushed product may change is more than the smallest
normal number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands.rounding import RELATIVE_STEP, SMALLEST_NORMAL, Flags, Floats

if TYPE_CHECKING:
    from shaderlab.bands.band import Band

# Above this size no product of two terms is a denormal, and how terms were made is forgotten.
TINY = 2.0**-60


@dataclass(slots=True, eq=False)
class Terms:
    """The terms of a value that is a sum or a product.

    Attributes:
        mag: the sum of the terms' absolute values.
        slack: an error still to be added before the value is added to or multiplied with another.
        count: how many terms there may be, once all is distributed.
        reach: the factor by which a flushed partial product may be multiplied; None where no term
            is tiny.
    """

    mag: Floats
    slack: Floats | None = None
    count: int = 1
    reach: Floats | None = None
    _least: float | None = None

    @property
    def least(self) -> float:
        """The smallest `mag`."""
        if self._least is None:
            self._least = least_of(self.mag)
        return self._least

    @classmethod
    def of(
        cls, mag: Floats, reach: Callable[[], Floats], *parts: Terms | None, count: int = 1
    ) -> Terms:
        """Terms of these sizes, made from `parts`; `reach` is computed only where one is tiny."""
        least = least_of(mag)
        return cls(mag, None, count, reach() if is_tiny(mag, least, *parts) else None, least)

    def step(self) -> Floats:
        """What one rounding among these terms may change."""
        size: Floats = RELATIVE_STEP * self.mag
        if self.reach is not None or self.least < TINY:
            size = np.maximum(size, self._flushed())
        return size if self.least > 0.0 else np.where(self.mag > 0.0, size, 0.0)

    def safe(self) -> Flags:
        """Where the sum of these terms, settled, keeps its sign in any order: not among
        denormals, where flushing one of two terms of opposite signs may leave the other's."""
        found: Flags = (RELATIVE_STEP * self.mag >= self._flushed()) | (self.mag == 0.0)
        return found

    def _flushed(self) -> Floats | float:
        """What flushed products may change, all terms together."""
        if self.reach is None:
            return SMALLEST_NORMAL
        return SMALLEST_NORMAL * self.count * self.reach

    def mapped(self, moved: Callable[[Any], Any]) -> Terms:
        """The same terms, their arrays rearranged by `moved`."""
        return Terms(
            moved(self.mag),
            None if self.slack is None else moved(self.slack),
            self.count,
            None if self.reach is None else moved(self.reach),
        )


def reach_of(mag: Floats, terms: Terms | None) -> Floats:
    """`Terms.reach`, or for terms that are not tiny their own size, at least 1."""
    if terms is not None and terms.reach is not None:
        return terms.reach
    size: Floats = np.maximum(mag, 1.0)
    return size


def least_of(mag: Floats) -> float:
    """The smallest size; infinite for an empty array."""
    return float(mag.min()) if mag.size else np.inf


def is_tiny(mag: Floats, least: float, *parts: Terms | None) -> bool:
    """Whether products of terms of these sizes, the smallest of them `least`, may be denormal
    somewhere."""
    if any(part is not None and part.reach is not None for part in parts):
        return True
    return least < TINY and bool(((mag > 0.0) & (mag < TINY)).any())


def combined(parts: Sequence[Band], choose: Callable[[list[Any]], Any]) -> Terms | None:
    """The terms of bands put together by `choose` (joined, or chosen from); None if none has."""
    known = [band.terms for band in parts if band.terms is not None]
    if not known:
        return None
    sizes = [(band.mag, band.terms) for band in parts]
    slack = reach = None
    if any(terms.slack is not None for terms in known):
        slack = choose(
            [np.zeros(mag.shape) if t is None or t.slack is None else t.slack for mag, t in sizes]
        )
    if any(terms.reach is not None for terms in known):
        reach = choose([np.broadcast_to(reach_of(mag, t), mag.shape) for mag, t in sizes])
    return Terms(
        choose([mag for mag, _ in sizes]), slack, max(terms.count for terms in known), reach
    )
