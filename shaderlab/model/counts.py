"""Expectations of what drawing costs: what the driver counts, and how long passes take."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from shaderlab.errors import CaseError
from shaderlab.model.state import one_of

COUNTERS = (
    "samples_passed",
    "primitives_generated",
    "vertices_submitted",
    "primitives_submitted",
    "vertex_shader_invocations",
    "geometry_shader_invocations",
    "geometry_primitives_emitted",
    "clipping_input_primitives",
    "clipping_output_primitives",
    "fragment_shader_invocations",
)
Number = Callable[[float], int]


@dataclass(frozen=True, kw_only=True)
class Query:
    """What a draw makes the driver count lies in `low` … `high`."""

    counter: str
    low: int
    high: int | None
    pass_name: str | None = None
    draw: int = -1
    name: str = ""


@dataclass(frozen=True, kw_only=True)
class Cost:
    """A table of passes by a number N: draw calls, vertices, time. Time is never judged."""

    series: Mapping[str, Mapping[float, tuple[str, ...]]]
    claim: str = ""
    cheaper: tuple[str, str] | None = None
    draw_calls: Mapping[str, Number] = field(default_factory=dict)
    vertices: Mapping[str, Number] = field(default_factory=dict)
    over: str = "N"
    repeats: int = 5
    name: str = ""

    @property
    def passes(self) -> tuple[str, ...]:
        """All passes of the table, each once."""
        found = [p for row in self.series.values() for names in row.values() for p in names]
        return tuple(dict.fromkeys(found))


def query(
    counter: str,
    *,
    equals: int | None = None,
    at_least: int | None = None,
    at_most: int | None = None,
    pass_name: str | None = None,
    draw: int = -1,
    name: str = "",
) -> Query:
    """A draw makes the driver count exactly this much, or at least or at most so much.

    The pass is drawn once more with a query around the draw, earlier draws having filled the
    depth and stencil buffers. "samples_passed" are the samples that pass all tests and are not
    discarded: exact on every driver. What pipeline statistics count ("…_invocations" and the
    like) a driver may exceed where it works in blocks, and one without them leaves the case
    unsupported.

    Raises:
        CaseError: the counter is unknown, or nothing is expected of it.
    """
    one_of("query", "counter", counter, COUNTERS)
    if (equals is None) == (at_least is None and at_most is None):
        raise CaseError(f"query {counter!r}: give equals=, or at_least= and at_most=")
    low, high = (equals, equals) if equals is not None else (at_least or 0, at_most)
    return Query(
        counter=counter,
        low=low,
        high=high,
        pass_name=pass_name,
        draw=draw,
        name=name or counter.replace("_", " "),
    )


def cost(
    series: Mapping[str, Mapping[float, str | Sequence[str]]],
    *,
    claim: str = "",
    cheaper: tuple[str, str] | None = None,
    draw_calls: Mapping[str, Number] | None = None,
    vertices: Mapping[str, Number] | None = None,
    over: str = "N",
    repeats: int = 5,
    name: str = "cost",
) -> Cost:
    """What passes cost: a table of draw calls, vertices, and the best time of several; and a plot
    of the times over N.

    Draw calls and vertices are judged where a formula for them is given. Time never is: it is
    another one on each machine, and only its ratios are of interest. Whether a claim about it
    holds is said, for this driver.

    Args:
        series: for each way of drawing, the pass (or passes) by N: `{"instanced": {4: "few", …}}`.
        claim: the claim in words ("one draw call is cheaper than N").
        cheaper: the series that it says takes less time, and the one that takes more.
        draw_calls: the number of draw calls as a function of N, by series.
        vertices: likewise the number of vertices submitted, those of all instances together.
        over: what N is, for the table and the plot.
        repeats: how often each pass is drawn; the fastest one counts.

    Raises:
        CaseError: a name is that of no series, or a claim is not complete.
    """
    tuples = {
        label: {float(n): (p,) if isinstance(p, str) else tuple(p) for n, p in row.items()}
        for label, row in series.items()
    }
    for owner, names in (
        ("cheaper", cheaper or ()), ("draw_calls", draw_calls or ()), ("vertices", vertices or ()),
    ):  # fmt: skip
        for label in names:
            one_of("cost", owner, label, tuple(tuples))
    if bool(claim) != (cheaper is not None):
        raise CaseError("cost: a claim needs both claim= and cheaper=(series, series)")
    if not tuples or not all(tuples.values()):
        raise CaseError("cost: there are no passes to compare")
    if repeats < 1:
        raise CaseError(f"cost: repeats must be at least 1, not {repeats}")
    return Cost(
        series=tuples,
        claim=claim,
        cheaper=cheaper,
        draw_calls=draw_calls or {},
        vertices=vertices or {},
        over=over,
        repeats=repeats,
        name=name,
    )
