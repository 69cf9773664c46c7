"""A run of several scenes, on one driver or several."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from .outcomes import Plot, Status
from .scenes import Record

Agreement = Literal["equal", "within", "outside"]


@dataclass(frozen=True, kw_only=True)
class DriverResult:
    """One scene's result on one of several drivers; `driver` is the name given to `--drivers`,
    `renderer` what draws there, "" if it never drew.
    `not_asked` counts its expectations about OpenGL's own calls, where another API draws.
    `ulp` and `widths` are the largest of its outcomes' worst values. `message` says why it did not
    pass; `agrees` how its outputs compare with those on the first driver: the worst of
    `Disagreement.verdict`, "" where either drew nothing."""

    driver: str
    renderer: str
    id: str
    variant: str
    status: Status
    ulp: float = 0.0
    widths: float = 0.0
    message: str = ""
    agrees: Literal["", "equal", "within", "outside"] = ""
    not_asked: int = 0


@dataclass(frozen=True, kw_only=True)
class Disagreement:
    """One output of one scene on two drivers: how many of its pixels differ, and the largest
    distance of two values, in units in the last place (steps of 1 for integers).

    `verdict` is "equal" to the bit, "within" where both are in their bands, "outside" where a
    driver leaves one; `outside` names those drivers. `cause` is what it comes from in a word, `why`
    in a sentence, "" where nobody looked. `pixel` is where most differs, `image` a picture of where
    and by how much, relative to the run's folder."""

    id: str
    variant: str
    output: str
    drivers: tuple[str, str]
    pixels: int
    differing: int
    ulp: float
    verdict: Agreement = "equal"
    outside: tuple[str, ...] = ()
    cause: str = ""
    why: str = ""
    pixel: tuple[int, int] | None = None
    image: str = ""


@dataclass(frozen=True, kw_only=True)
class CoverageGap:
    """Something that no judged pixel did: `what` it is, of the expression `text` at a line."""

    file: str
    line: int
    text: str
    what: str


@dataclass(frozen=True, kw_only=True)
class CodeCoverage:
    """What the judged draws of a case exercised of its shaders. `items` counts what its branches
    and terms can do (be true, be false, choose an argument), `gaps` is what none of them did."""

    id: str
    items: int = 0
    gaps: tuple[CoverageGap, ...] = ()
    message: str = ""


@dataclass(frozen=True, kw_only=True)
class Points:
    """All points of a sweep, where the run's records are some of them only: how many have each
    status, how many checks and judged values there were, and how many values were outside. `file`
    has all of them: its path, relative to the run's folder where it is in there."""

    statuses: Mapping[Status, int]
    checks: int
    judged: int
    outside: int
    file: str

    @property
    def count(self) -> int:
        """How many there are."""
        return sum(self.statuses.values())

    @property
    def failed(self) -> int:
        """How many did not pass; lacking a feature of the driver is no failure."""
        passable = ("pass", "unsupported")
        return sum(n for status, n in self.statuses.items() if status not in passable)


@dataclass(frozen=True, kw_only=True)
class Run:
    """All records of one command, with where they were made. `driver` has at least the keys
    "renderer", "vendor", "version" and "glsl"; `versions` maps package names to versions.

    `plots` show figures over all records, where these are the points of one case's sweep;
    `points` says what all points were, where there are too many to have a record each here.
    With several drivers, `records` and `driver` are those of the first, `drivers`
    has every scene on every driver, and `disagreements` compares each two of them.

    `replaced` are the files that stood in a shader's place, by the shader's name. `missing` is the
    number of scenes that were asked for and have no record, as the run was interrupted.
    `code_coverage` has an entry for each case that it was measured of.
    """

    driver: Mapping[str, str]
    versions: Mapping[str, str]
    started: str
    seconds: float
    records: tuple[Record, ...]
    plots: tuple[Plot, ...] = ()
    drivers: tuple[DriverResult, ...] = ()
    disagreements: tuple[Disagreement, ...] = ()
    replaced: Mapping[str, str] = field(default_factory=dict)
    missing: int = 0
    code_coverage: tuple[CodeCoverage, ...] = ()
    points: Points | None = None

    @property
    def failing_drivers(self) -> tuple[str, ...]:
        """Of several drivers those on which a scene failed."""
        bad = (r.driver for r in self.drivers if r.status not in ("pass", "unsupported"))
        return tuple(dict.fromkeys(bad))
