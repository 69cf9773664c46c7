"""measure: statistics of what was drawn, held against bounds; one figure, a table, or a curve.

A measure is for what no single pixel shows: the share of pixels in the wrong shadow, a picture's
distance from another one, the energy that a model of reflection loses.
"""

import math
import re
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, fields, replace
from typing import Any

import numpy as np

from shaderlab.engine.expectations.base import DrawExpectation
from shaderlab.engine.expectations.needs import find_image
from shaderlab.errors import CaseError, ShaderlabError, suggest
from shaderlab.model.case import Scene
from shaderlab.model.checked import Checked, is_masked
from shaderlab.model.expectation import Judgement, Read
from shaderlab.model.frame import Array, Bindings, Frame
from shaderlab.model.phases import phase
from shaderlab.model.records import Outcome, Plot, PlotPoint, Row
from shaderlab.model.scene import UniformValue

from ..judging.references import locate_error, make_error, parameter_name, parameters_of, source_of


@dataclass(frozen=True, kw_only=True)
class Bound:
    """low ≤ figure ≤ high. `digits` is for a printed figure, which is in the middle, else None."""

    low: float = -math.inf
    high: float = math.inf
    digits: int | None = None

    def __contains__(self, figure: float) -> bool:
        return math.isfinite(figure) and self.low <= figure <= self.high

    def __str__(self) -> str:
        if self.digits is not None:
            return f"{(self.low + self.high) / 2:.{self.digits}f}"
        if math.isinf(self.low):
            return f"≤ {self.high:g}"
        if math.isinf(self.high):
            return f"≥ {self.low:g}"
        return f"{self.low:g} … {self.high:g}"


@dataclass(frozen=True, kw_only=True)
class Bounded(Checked):
    """What has a figure with a bound, given in one of three ways: the figure rounds to `equals` at
    so many `digits`; it is `at_most` or `at_least` so much, or both; or lies `between` two ends."""

    label: str | float
    equals: float | None = None
    digits: int | None = None
    at_most: float | None = None
    at_least: float | None = None
    between: tuple[float, float] | None = None

    @property
    def bound(self) -> Bound | None:
        """The bound, if given. Raises CaseError: two are, or one that holds no number, or all."""
        ways = [(self.equals, self.digits), (self.at_most, self.at_least), (self.between,)]
        given = sum(any(part is not None for part in way) for way in ways)
        what = f"measure {self.label!r}"
        if given > 1:
            raise CaseError(f"{what}: give equals, or between, or at_most and at_least")
        if (self.equals is None) != (self.digits is None):
            raise CaseError(f"{what}: equals and digits go together")
        if not given:
            return None
        if self.equals is not None and self.digits is not None:
            half = 0.5 * 10.0**-self.digits * (1.0 + 1e-6)
            low, high = self.equals - half, self.equals + half
            return Bound(low=low, high=high, digits=self.digits)
        low, high = self.between or (
            -math.inf if self.at_least is None else self.at_least,
            math.inf if self.at_most is None else self.at_most,
        )
        if not low <= high or (math.isinf(low) and math.isinf(high)):
            raise CaseError(f"{what}: {low} … {high} bounds no figure")
        return Bound(low=float(low), high=float(high))


@dataclass(frozen=True)
class Reading(Bounded):
    """One row of a `measure`: what it reads and is given, and where the figure must lie.

    Args:
        label: a word, or a number: then the row is a point of a curve at this x.
        reads: outputs by parameter: {"lit": "near.FragColor"}.
        given: constants by parameter.
        series: the curve that the point belongs to, where there are several.
        note: a remark in the table.
        equals, digits: the figure rounds to `equals` at that many decimals.
        at_most, at_least, between: the figure lies in these bounds. Without any bound the row is
            only shown.

    Raises CaseError: bounds that say two things, or hold no number."""

    label: str | float
    _: KW_ONLY
    reads: Mapping[str, str] = field(default_factory=dict)
    given: Mapping[str, UniformValue] = field(default_factory=dict)
    series: str = ""
    note: str = ""

    def __post_init__(self) -> None:
        _ = self.bound  # raises where it is wrong

    @property
    def x(self) -> float | None:
        """Its place along the curve; None where its label is a word."""
        return None if isinstance(self.label, str) else float(self.label)

    @property
    def word(self) -> str:
        return self.label if isinstance(self.label, str) else f"{self.label:g}"

    def row(self, figure: float) -> Row:
        """The line of a table that shows a measured figure."""
        bound = self.bound
        digits = None if bound is None else bound.digits
        more = 6 if digits is None else digits + 3
        return Row(
            label=f"{self.series}, {self.word}" if self.series else self.word,
            expected="–" if bound is None else str(bound),
            measured=f"{figure:.{more}g}" if digits is None else f"{figure:.{min(more, 9)}f}",
            ok=math.isfinite(figure) if bound is None else figure in bound,
            note=self.note,
        )


_INDEXED = re.compile(r"\[\d+\]")

Statistic = Callable[..., Any]


@dataclass(frozen=True)
class Measure(DrawExpectation, Bounded):
    """A figure that `statistic` computes from the frame lies within its bound.

    The parameters of `statistic` are found by name: outputs of any pass as float64 arrays
    (height, width, components), `FragColor` of the last pass or `shadow_depth` for
    "shadow.depth"; uniforms and textures of a draw; what `reads` and `given` say; and
    `subpixel_step`, the grid that corners are moved to before they are rasterised, in pixels, for
    figures that grow with it: 1/256 on llvmpipe, 1/16 where a driver has the least allowed.

    Args:
        label: how tables and outcomes call it.
        statistic: a Python function that returns one number; NumPy may be used.
        readings: rows, from `reading`; without them there is one, with `label` for its name.
        reads: outputs by parameter, in every row that does not say otherwise.
        given: constants by parameter, likewise.
        pass_name, draw: whose uniforms and textures are meant; the last draw of the last pass.
        x_label, y_label: what the axes of the curve say, where labels of rows are numbers.
        log_x, log_y: logarithmic axes.
        own_types: outputs come in the types that they were read back in, read-only, where a copy of
            a large picture in float64 would take too much memory.
        note: a remark in the table, where there is one row.
        equals, digits, at_most, at_least, between: the bound of the rows that have none, as in
            `reading`.

    Raises CaseError: there is no bound at all, or two rows are alike."""

    kind = "measure"
    named = "{self.label}"

    label: str
    statistic: Statistic
    _: KW_ONLY
    readings: Sequence[Reading] = ()
    reads: Mapping[str, str] = field(default_factory=dict)
    given: Mapping[str, UniformValue] = field(default_factory=dict)
    x_label: str = ""
    y_label: str = ""
    log_x: bool = False
    log_y: bool = False
    own_types: bool = False
    note: str = ""

    def __post_init__(self) -> None:
        common = {each.name: getattr(self, each.name) for each in fields(Bounded)}
        del common["label"]
        readings = self.readings if len(self.readings) else (Reading(self.label, note=self.note),)
        rows = []
        for row in readings:
            reads, given = {**self.reads, **row.reads}, {**self.given, **row.given}
            rows.append(replace(row, reads=reads, given=given, **({} if row.bound else common)))
        object.__setattr__(self, "readings", tuple(rows))
        self._check_readings()

    def _check_readings(self) -> None:
        if all(row.bound is None for row in self.readings):
            raise CaseError(
                f"measure {self.label!r} has no bound, so it could not fail",
                remedy="give equals with digits, at_most, at_least or between",
            )
        names = [(row.series, row.word) for row in self.readings]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise CaseError(f"measure {self.label!r}: two readings are called {twice[1]!r}")
        for row in self.readings:
            if both := row.reads.keys() & row.given.keys():
                raise CaseError(f"measure {self.label!r}: {min(both)!r} is both read and given")
            if len({*row.reads.values()}) < len(row.reads):
                raise CaseError(
                    f"measure {self.label!r}: two parameters read one output, which is then "
                    "compared with itself"
                )

    def find_reads(self, scene: Scene) -> Iterable[Read]:
        """The outputs that its parameters may mean.

        Where a parameter could also mean a uniform, or an output of either of two passes, all of
        them are there: nothing that it reads is missing.
        """
        for row in self.readings:
            for parameter in parameters_of(self.statistic):
                if parameter in row.given:
                    continue
                if parameter in row.reads:
                    pass_name, name = scene.split_output(row.reads[parameter])
                    yield Read(scene.find_pass(pass_name).name, name)
                    continue
                yield Read(scene.find_pass(None).name, parameter)
                for description in scene.passes:
                    head = parameter_name(description.name) + "_"
                    if parameter.startswith(head):
                        yield Read(description.name, parameter.removeprefix(head))

    def passes(self, scene: Scene) -> frozenset[str]:
        return super().passes(scene) | {read.pass_name for read in self.find_reads(scene)}

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        known = self._find_known(scene, frame)
        figures = [self._figure(row, known, scene, frame) for row in self.readings]
        rows = tuple(r.row(v) for r, v in zip(self.readings, figures, strict=True))
        wrong = [row for row in rows if not row.ok]
        message = ""
        if wrong:
            first = wrong[0]
            what = "" if len(rows) == 1 else f"{first.label}: "
            others = f" (and {len(wrong) - 1} more of {len(rows)})" if len(wrong) > 1 else ""
            message = f"{what}measured {first.measured}, expected {first.expected}{others}"
        outcome = Outcome(
            name=self.name,
            kind=self.kind,
            status="fail" if wrong else "pass",
            message=message,
            judged=sum(row.bound is not None for row in self.readings),
            outside=len(wrong),
            rows=rows,
            rows_heading=self.name if len(rows) > 1 else "",
            sources=(source_of(self.statistic),),
        )
        return Judgement(outcome=outcome, plot=self._plot(figures, rows))

    def _find_known(self, scene: Scene, frame: Frame) -> dict[str, Array]:
        known = _draw_values(frame.bindings[self.key(scene)])
        known["subpixel_step"] = np.array(frame.subpixel_step)
        last = frame.order[-1]
        for (pass_name, name), image in frame.images.items():
            known[parameter_name(f"{pass_name}.{name}")] = image.values
        for (pass_name, name), image in frame.images.items():
            if pass_name == last:
                known[parameter_name(name)] = image.values
        return known

    def _figure(
        self, row: Reading, known: Mapping[str, Array], scene: Scene, frame: Frame
    ) -> float:
        arguments = self._arguments(row, known, scene, frame)
        try:
            with phase("reference"), np.errstate(all="ignore"), warnings.catch_warnings():
                # The mean of nothing is NaN, which fails; NumPy need not say so as well.
                warnings.simplefilter("ignore", RuntimeWarning)
                got = self.statistic(**arguments)
        except ShaderlabError:
            raise
        except Exception as error:
            raise locate_error(
                self.statistic,
                error,
                "a statistic gets arrays (height, width, components) and returns one number",
            ) from error
        try:
            array = np.empty(0) if is_masked(got) else np.asarray(got, np.float64)
        except (TypeError, ValueError):
            array = np.empty(0)
        if array.size != 1:
            gives = f"{type(got).__name__} of shape {np.shape(array)}"
            message = f"{self.name}: the statistic gives {gives}, not one number"
            raise make_error(self.statistic, message)
        return float(array.reshape(()))

    def _arguments(
        self, row: Reading, known: Mapping[str, Array], scene: Scene, frame: Frame
    ) -> dict[str, Any]:
        arguments: dict[str, Any] = {}
        parameters = parameters_of(self.statistic)
        images = {id(image.values) for image in frame.images.values()}
        drawn = False
        for name in (*row.reads, *row.given):
            if name not in parameters:
                raise CaseError(
                    f"measure {self.name!r}: its function has no parameter {name!r}",
                    remedy=suggest(name, parameters),
                )
        for parameter in parameters.values():
            name = parameter.name
            if name in row.given:
                value = row.given[name]
                arguments[name] = value if np.isscalar(value) else np.asarray(value, np.float64)
            elif name in row.reads:
                arguments[name] = self._prepare_output(
                    find_image(row.reads[name], scene, frame).values
                )
                drawn = True
            elif name in known and id(known[name]) in images:
                arguments[name] = self._prepare_output(known[name])
                drawn = True
            elif name in known:
                arguments[name] = np.asarray(known[name], np.float64)
            elif parameter.default is parameter.empty:
                choices = [*known, *row.given]
                raise CaseError(
                    f"measure {self.name!r}: its function asks for {name!r}, which is neither "
                    "an output nor a uniform nor given",
                    remedy=suggest(name, choices),
                )
        if not drawn:
            raise CaseError(
                f"measure {self.name!r} reads no output, so no shader could break it",
                remedy="computed(…) is for figures of formulas alone",
            )
        return arguments

    def _prepare_output(self, values: Array) -> Array:
        """An output as the statistic gets it: a copy, or what all expectations see."""
        if not self.own_types:
            return values.astype(np.float64)
        seen = values.view()
        seen.flags.writeable = False
        return seen

    def _plot(self, figures: list[float], rows: tuple[Row, ...]) -> Plot | None:
        points = tuple(
            PlotPoint(
                series=reading.series,
                x=reading.x,
                y=figure,
                low=-math.inf if reading.bound is None else reading.bound.low,
                high=math.inf if reading.bound is None else reading.bound.high,
                ok=row.ok,
            )
            for reading, figure, row in zip(self.readings, figures, rows, strict=True)
            if reading.x is not None
        )
        if len(points) < 2:
            return None
        return Plot(
            title=self.name,
            x_label=self.x_label,
            y_label=self.y_label or self.label,
            points=points,
            log_x=self.log_x,
            log_y=self.log_y,
        )


def _draw_values(bindings: Bindings) -> dict[str, Array]:
    """Uniforms and textures, members of arrays of structs together as one array; where they are
    single numbers, without an axis for components."""
    known: dict[str, Array] = {}
    lists: dict[str, list[Array]] = {}
    for name, values in bindings.uniforms.items():
        known[parameter_name(name)] = values[..., 0] if values.shape[-1] == 1 else values
        if _INDEXED.search(name):
            lists.setdefault(parameter_name(_INDEXED.sub("", name)), []).append(
                known[parameter_name(name)]
            )
    known |= {name: np.stack(values) for name, values in lists.items()}
    known |= {parameter_name(n): texels.values for n, texels in bindings.textures.items()}
    return known


measure = Measure
reading = Reading
