"""What became of a case's expectations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from .programs import SourceText

Status = Literal["pass", "fail", "error", "unsupported", "timeout", "crash"]


@dataclass(frozen=True, kw_only=True)
class Worst:
    """The value that is furthest from its band (or, all passing, comes nearest to leaving it).

    Vectors are lists, one entry a component; `component` says which of them is meant.
    `pixel` is (x, y) from the lower left, or None where the value is not a pixel.
    `ulp` is the distance to the reference in float32 units in the last place, `widths` the
    distance from the band's middle in half band widths: at most 1 inside, more outside.
    """

    pixel: tuple[int, int] | None
    component: int
    measured: tuple[float, ...]
    reference: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    ulp: float
    widths: float
    inputs: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def whole(self) -> bool:
        """Whether these are integers, of which `ulp` is the difference."""
        pairs = zip(self.low, self.high, self.reference, self.measured, strict=True)
        integers = all(low == high == r and m % 1 == r % 1 == 0 for low, high, r, m in pairs)
        off = abs(self.measured[self.component] - self.reference[self.component])
        return integers and self.ulp == off

    @property
    def exact(self) -> bool:
        """Whether the value is its reference to the last bit. Then its place in the band says
        nothing of it: a clamp's band, for one, begins or ends at the reference."""
        if not self.widths <= 1 or self.ulp != 0:
            return False
        measured, reference = self.measured[self.component], self.reference[self.component]
        return abs(measured - reference) <= abs(reference) * 2.0**-23


@dataclass(frozen=True, kw_only=True)
class Row:
    """One line of an expected-against-measured table, ready to print."""

    label: str
    expected: str
    measured: str
    ok: bool
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class Step:
    """What one statement of a shader stored at one pixel, as its SPIR-V is interpreted.

    `name` is the variable as GLSL writes it, "f()" for the result of f; `calls` are the lines of
    the calls that led there, the outermost first. `value` is the driver's where `by_driver` says
    so, else that of float32 arithmetic; `exact` that of float64. `low` and `high` are the bounds
    of the band that the instructions alone allow. `off` is how far the value is from the exact one
    and `width` how wide the band is, in ULP, for the component where that is most; `lost` is the
    part of the width that the statement's operands did not have yet.
    """

    file: str
    line: int
    name: str
    calls: tuple[int, ...]
    value: tuple[float, ...]
    by_driver: bool
    exact: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    off: float
    width: float
    lost: float

    @property
    def wrong(self) -> list[bool]:
        """Of each component, whether it lies outside of the band."""
        bounds = zip(self.value, self.low, self.high, strict=True)
        return [not low <= value <= high and value == value for value, low, high in bounds]

    @property
    def inside(self) -> bool:
        """Whether the value lies in the band."""
        return not any(self.wrong)

    @property
    def component(self) -> int:
        """The component to show of a vector: one that is wrong, else the one known worst."""
        if not self.inside:
            return self.wrong.index(True)
        shares = [
            (high - low) / (abs(low) + abs(high) or 1.0)
            for low, high in zip(self.low, self.high, strict=True)
        ]
        return max(range(len(shares)), key=lambda i: shares[i])

    @property
    def label(self) -> str:
        """The name, with that component's letter behind it."""
        return self.name + (f".{'xyzw'[self.component]}" if len(self.value) > 1 else "")


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """What each line of a fragment shader computes at one pixel, in the order of execution.

    `verdict` says where a wrong value comes from, "" where nothing was wrong or that is not known;
    `file` and `line` are that place. `refused` says why the driver's values are missing, if so.
    """

    pixel: tuple[int, int]
    steps: tuple[Step, ...]
    verdict: str = ""
    file: str = ""
    line: int = 0
    refused: str = ""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One expectation's verdict.

    `vacuous` is the share (0–1) of judged values whose band allows anything, `undecided` the
    share that went both ways of a branch. `informative` is the share whose band excludes something
    plausible, None where values are not held against bands. `images` maps "measured", "reference"
    and "distance" to picture files, relative to the run's folder, and `captions` the same names to
    how they are to be read ("one channel in false colour, 0 to 2"). `values` is the file of the
    numbers behind those pictures (`shaderlab.model.pictures.Values`), likewise relative, or "".
    `sources` are the formula and the shader. `explanation` is there for a formula that fails over
    pixels, if the shader can be interpreted. `line` is that of the record's file at which the
    expectation stands, 0 where that is not known.

    Where the rows of several outcomes stand in one table, `rows_heading` goes before each label;
    `rows_per_variant` says whether they differ between a case's variants. `rows_show_worst` says
    that they tell all there is to know about `worst` where it is inside its band.
    """

    name: str
    kind: str
    status: Literal["pass", "fail", "error"]
    message: str = ""
    judged: int = 0
    outside: int = 0
    worst: Worst | None = None
    vacuous: float = 0.0
    undecided: float = 0.0
    informative: float | None = None
    rows: tuple[Row, ...] = ()
    rows_heading: str = ""
    rows_per_variant: bool = True
    rows_show_worst: bool = False
    images: Mapping[str, str] = field(default_factory=dict)
    captions: Mapping[str, str] = field(default_factory=dict)
    sources: tuple[SourceText, ...] = ()
    values: str = ""
    explanation: Explanation | None = None
    line: int = 0


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Measured points against their reference, for plotting: all lists have one length."""

    title: str
    x_label: str
    y_label: str
    x: tuple[float, ...]
    measured: tuple[float, ...]
    reference: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    log_x: bool = False


@dataclass(frozen=True, kw_only=True)
class PlotPoint:
    """One point of a plot, with the bounds that it was held against (infinite: none)."""

    series: str
    x: float
    y: float
    low: float
    high: float
    ok: bool


@dataclass(frozen=True, kw_only=True)
class Plot:
    """Measured figures over a number, in one or several named series."""

    title: str
    x_label: str
    y_label: str
    points: tuple[PlotPoint, ...]
    log_x: bool = False
    log_y: bool = False


def significant(value: float) -> str:
    """A number in the nine digits that tell float32 values apart, or the ten of a whole number of
    32 bits.

    >>> significant(0.1), significant(2654435761.0), significant(2.0**40)
    ('0.1', '2654435761', '1.09951163e+12')
    """
    whole = float(value).is_integer() and abs(value) < 2.0**32
    return f"{value:.{10 if whole else 9}g}"
