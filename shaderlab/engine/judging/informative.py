"""Whether bands exclude anything plausible: one that holds all that a formula gives can't fail.

A value is informative where its band has two ends and leaves out some of what the reference gives
over the frame. A component that hardly varies has no range to compare with: its band has to be
narrower than the magnitude of the whole vector, or the range of an attachment that holds codes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shaderlab.bands.compiled import compiled
from shaderlab.model.frame import Array

from .formats import FLOAT_FORMATS, INTEGER_FORMATS

MIN_INFORMATIVE = 0.99
"""The least share of an expectation's values that must be informative."""
MAX_UNDECIDED = 0.05
"""The largest share of values that may have taken both sides of a branch: the shipped cases, which
put none of their inputs onto a branch but by accident, have 0.013 at most."""
# A reference that varies by less than this part of its magnitude counts as a constant.
HARDLY = 1e-3
# Below this, a reference of floats counts as 0, whose scale is 1: what is left of a cancellation
# in float64 is no magnitude.
NOTHING = 1e-7
BLOCK = 16384


@dataclass(frozen=True)
class Plausible:
    """For each component what its band must leave something out of: from `low` to `high` where
    the reference `varies`, or else any range as wide as that."""

    low: Array
    high: Array
    varies: Array

    @classmethod
    @np.errstate(all="ignore")
    def of(cls, reference: Array, format: str) -> Plausible:
        """Read it from some values of a reference.

        Args:
            reference: in float64, (count, components), in the attachment's units.
            format: the attachment's format.
        """
        finite = np.isfinite(reference)
        low = np.where(finite, reference, np.inf).min(axis=0, initial=np.inf)
        high = np.where(finite, reference, -np.inf).max(axis=0, initial=-np.inf)
        none = low > high
        low, high = np.where(none, 0.0, low), np.where(none, 0.0, high)
        span, size = high - low, np.maximum(np.abs(low), np.abs(high))
        if format in INTEGER_FORMATS:
            varies, whole = span > 0.0, np.maximum(size, 1.0)
        elif format in FLOAT_FORMATS or format.endswith("16f"):
            varies = (span > HARDLY * size) & (size >= NOTHING)
            largest = float(size.max(initial=0.0))
            whole = np.full_like(size, largest if largest >= NOTHING else 1.0)
        else:
            limit = 1.0 if format.startswith("depth") else 255.0
            varies, whole = span > limit / 16.0, np.full_like(size, limit)
        return cls(np.where(varies, low, 0.0), np.where(varies, high, whole), varies)

    @np.errstate(all="ignore")
    def informative_share(self, low: Array, high: Array) -> float:
        """The share of values, (count, components), whose bands are informative."""
        if not low.size:
            return 1.0
        least, greatest = self.low.astype(low.dtype), self.high.astype(low.dtype)
        return informative(low, high, least, greatest, self.varies) / low.size


@compiled
def informative(low: Array, high: Array, least: Array, greatest: Array, varies: Array) -> int:
    """How many bands leave out some of what lies between `least` and `greatest` where the
    component `varies`, and elsewhere are narrower than `greatest`; all with two ends."""
    count = 0
    for start in range(0, len(low), BLOCK):
        one, other = low[start : start + BLOCK], high[start : start + BLOCK]
        width = other - one
        leaves_out = (one > least) | (other < greatest)
        narrow = np.where(varies, leaves_out, width < greatest)
        count += int(np.count_nonzero(narrow & (width < np.inf)))
    return count
