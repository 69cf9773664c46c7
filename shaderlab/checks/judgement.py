"""An outcome together with the arrays that pictures and curves are made from."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from shaderlab.frame import Array
from shaderlab.records import Curve, Outcome, Plot


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """One expectation judged.

    `pictures` has "measured" and "reference" (height, width, components) and "distance"
    (height, width: the distance in half band widths, NaN where nothing was judged), or is empty
    where the judged values are no picture. The numbers behind them are there too: "exact" (the
    reference, unrounded), "low", "high" and "outside" in the shape of "measured", "covered"
    (height, width), and "unit", the size of one code of a fixed-point format or 0.
    """

    outcome: Outcome
    pictures: Mapping[str, Array] = field(default_factory=dict)
    curve: Curve | None = None
    plot: Plot | None = None


class Lazy(Mapping[str, Array]):
    """Arrays that are made when the first of them is looked at: most runs look at none."""

    def __init__(self, make: Callable[[], Mapping[str, Array]]) -> None:
        self._make = make
        self._made: Mapping[str, Array] | None = None

    def _arrays(self) -> Mapping[str, Array]:
        if self._made is None:
            self._made = self._make()
        return self._made

    def __getitem__(self, name: str) -> Array:
        return self._arrays()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays())

    def __len__(self) -> int:
        return len(self._arrays())


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
