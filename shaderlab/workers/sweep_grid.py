"""Parameters of a sweep as given on the command line, and the grid of points that they span."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from shaderlab.errors import UsageError, nearest

from .jobs import CaseFacts, Job, Point

SIZE = "size"
"""The parameter that sets the side of the judged frame in pixels; it is not a shader input."""
LARGEST_SIZE = 4096
MOST_POINTS = 100_000
"""So many were measured: docs/internals/measurements.md has their time and memory."""
_RANGE = re.compile(r"(?P<start>[^:]+):(?P<stop>[^:]+):(?P<count>\d+)(?P<log>log)?")
_PARTS = "take fewer values, or sweep in parts, each into its own --report FOLDER"
_RIGHT = "write NAME=START:STOP:COUNT, NAME=START:STOP:COUNTlog or NAME=A,B,C"


@dataclass(frozen=True)
class Parameter:
    """One parameter and its values; `log` if they are logarithmically spaced."""

    name: str
    values: tuple[float, ...]
    log: bool = False

    @classmethod
    def parse(cls, word: str) -> Parameter:
        """From "reach=1:50:8", "reach=0.1:100:4log" or "reach=7,13,20".

        >>> Parameter.parse("size=64:1024:3log").values
        (64.0, 256.0, 1024.0)

        Raises:
            UsageError: the format is wrong; the remedy shows the right one.
        """
        name, equals, values = (part.strip() for part in word.partition("="))
        if not equals or not name or not values:
            raise UsageError(f"--param {word}: no name and values", remedy=_RIGHT)
        found = _RANGE.fullmatch(values)
        if found is None and ":" in values:
            raise UsageError(
                f"--param {word}: {values!r} is no range",
                remedy="write START:STOP:COUNT, such as 0:1:11, or 0.01:1:50log (logarithmic)",
            )
        if found is None:
            numbers = tuple(_number(word, text) for text in values.split(","))
        else:
            ends = _number(word, found["start"]), _number(word, found["stop"])
            numbers = _range(word, *ends, int(found["count"]), log=bool(found["log"]))
        if name == SIZE:
            numbers = _sizes(word, numbers)
        return cls(name, tuple(dict.fromkeys(numbers)), bool(found and found["log"]))

    @cached_property
    def spelt(self) -> list[str]:
        """The values with six digits, or with all digits where others would look the same."""
        short = [f"{value:.6g}" for value in self.values]
        alike = Counter(short)
        return [s if alike[s] == 1 else repr(v) for s, v in zip(short, self.values, strict=True)]


def parameters(words: Sequence[str]) -> tuple[Parameter, ...]:
    """All parameters of a sweep. Raises UsageError, also if one is given twice."""
    found = tuple(Parameter.parse(word) for word in words)
    names = [parameter.name for parameter in found]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(
                f"--param {name} is given twice", remedy="put all its values into one list"
            )
    points = math.prod(len(parameter.values) for parameter in found)
    if points > MOST_POINTS:
        sides = " × ".join(f"{len(parameter.values):,}" for parameter in found)
        raise UsageError(
            f"the grid has {points:,} points ({sides}), the limit is {MOST_POINTS:,}",
            remedy=_PARTS,
        )
    return found


@dataclass(frozen=True, kw_only=True)
class Grid:
    """The points that parameters of one case span, the last parameter varying fastest. Each is
    made when it is asked for.

    Attributes:
        file, id, title, section: of the case.
        variant: whose inputs all points have, except the swept ones.
        parameters: those that are swept.
    """

    file: str
    id: str
    title: str
    section: str
    variant: str
    parameters: tuple[Parameter, ...]

    def __len__(self) -> int:
        return math.prod(len(parameter.values) for parameter in self.parameters)

    def __iter__(self) -> Iterator[Job]:
        return map(self.__getitem__, range(len(self)))

    def __getitem__(self, number: int) -> Job:
        """The job of a point."""
        places = self.places(number)
        swept = list(zip(self.parameters, places, strict=True))
        given = {p.name: p.values[place] for p, place in swept}
        size = int(given.pop(SIZE, 0))
        return Job(
            file=self.file,
            id=self.id,
            variant=", ".join(f"{p.name}={p.spelt[place]}" for p, place in swept),
            title=self.title,
            section=self.section,
            point=Point(variant=self.variant, changes=given, size=size),
        )

    def places(self, number: int) -> list[int]:
        """Where a point is among each parameter's values. Raises IndexError."""
        if not 0 <= number < len(self):
            raise IndexError(number)
        places = []
        for parameter in reversed(self.parameters):
            number, place = divmod(number, len(parameter.values))
            places.append(place)
        return places[::-1]

    def coordinates(self, number: int) -> dict[str, float]:
        """The parameters of a point and their values; a size is a whole number."""
        places = zip(self.parameters, self.places(number), strict=True)
        found = {parameter.name: parameter.values[place] for parameter, place in places}
        if SIZE in found:  # as the last one
            found[SIZE] = int(found.pop(SIZE))
        return found


def grid(facts: CaseFacts, variant: str, swept: Sequence[Parameter]) -> Grid:
    """The grid of a case's parameters.

    Args:
        facts: of the case.
        variant: whose inputs all points have, except the swept ones.
        swept: the parameters.

    Raises:
        UsageError: the case has no such parameter, it is not a single number, or the case has no
            formula, so that nothing can be judged at other inputs.
    """
    if not facts.formulas[facts.variants.index(variant)]:
        raise UsageError(
            f"{facts.id} has no formula, and its figures hold for its own inputs only",
            file=facts.file,
            remedy="sweep a case with a formula(…) expectation",
        )
    for parameter in swept:
        _check(facts, parameter)
    return Grid(
        file=facts.file,
        id=facts.id,
        title=facts.title,
        section=facts.section,
        variant=variant,
        parameters=tuple(swept),
    )


def _check(facts: CaseFacts, parameter: Parameter) -> None:
    if parameter.name == SIZE:
        if not facts.sized:
            raise UsageError(f"every pass of {facts.id} has a fixed size", file=facts.file)
        return
    single = [name for name, components in facts.parameters.items() if components == 1]
    components = facts.parameters.get(parameter.name)
    if components is None:
        raise UsageError(
            f"{facts.id} has no uniform or ramp {parameter.name!r}",
            file=facts.file,
            remedy=nearest(parameter.name, [*single, SIZE]),
        )
    if components != 1:
        raise UsageError(
            f"{parameter.name!r} of {facts.id} has {components} components, not one",
            file=facts.file,
            remedy=f"single numbers are {', '.join([*single, SIZE])}",
        )


def _number(word: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise UsageError(f"--param {word}: {text!r} is no number", remedy=_RIGHT) from None
    if not math.isfinite(value):
        raise UsageError(f"--param {word}: {text} is not finite", remedy=_RIGHT)
    return value


def _range(word: str, start: float, stop: float, count: int, *, log: bool) -> tuple[float, ...]:
    if count < 2:
        raise UsageError(f"--param {word}: a range needs 2 values or more", remedy=_RIGHT)
    if count > MOST_POINTS:
        raise UsageError(
            f"--param {word}: {count:,} values, the limit is {MOST_POINTS:,} points", remedy=_PARTS
        )
    if log and not start * stop > 0.0:
        raise UsageError(
            f"--param {word}: a logarithmic range can't go from {start:g} to {stop:g}",
            remedy="both ends must be above 0, or both below",
        )
    import numpy as np  # a run that is resumed needs none of it

    space = np.geomspace if log else np.linspace
    # Twelve digits, so that 0.3 does not become 0.30000000000000004.
    return tuple(float(f"{value:.12g}") for value in space(start, stop, count))


def _sizes(word: str, values: Sequence[float]) -> tuple[float, ...]:
    sizes = [float(round(value)) for value in values]
    if not all(1 <= size <= LARGEST_SIZE for size in sizes):
        raise UsageError(f"--param {word}: sizes are 1…{LARGEST_SIZE} pixels")
    return tuple(sizes)
