"""An outcome together with the arrays that pictures and curves are made from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from shaderlab.frame import Array
from shaderlab.records import Curve, Outcome


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """One expectation judged.

    `pictures` has "measured" and "reference" (height, width, components) and "distance"
    (height, width: the distance in half band widths, NaN where nothing was judged), or is empty
    where the judged values are no picture.
    """

    outcome: Outcome
    pictures: Mapping[str, Array] = field(default_factory=dict)
    curve: Curve | None = None


def plain(values: Array) -> tuple[float, ...]:
    """A vector as a tuple of Python numbers."""
    return tuple(float(v) for v in np.ravel(values))


def shown(values: object, digits: int | None = None) -> str:
    """A number or vector for people: `digits` decimals, or nine significant digits.

    >>> shown((0.5, 1.0)), shown(0.25, 4)
    ('(0.5, 1)', '0.2500')
    """
    numbers = [float(v) for v in np.ravel(np.asarray(values, np.float64))]
    texts = [f"{n:.{digits}f}" if digits is not None else f"{n:.9g}" for n in numbers]
    return texts[0] if len(texts) == 1 else f"({', '.join(texts)})"
