"""The results of running cases, as plain data: all that reports are made from.

Everything here is built of strings, numbers, lists and mappings, and converts to JSON and back
without loss. The public JSON of `shaderlab run --json` is a view of it (docs/guide/json.md).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from shaderlab.errors import Verdict

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
        bounds = zip(self.low, self.high, strict=True)
        shares = [(high - low) / (abs(low) + abs(high) or 1.0) for low, high in bounds]
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
    sources: "tuple[SourceText, ...]" = ()
    values: str = ""
    explanation: Explanation | None = None
    line: int = 0

    @classmethod
    def of_rows(
        cls,
        name: str,
        kind: str,
        rows: Sequence[Row],
        message: str,
        judged: int,
        rows_per_variant: bool = True,
    ) -> "Outcome":
        """Return the outcome of a table's rows: it fails where there is a message."""
        return cls(
            name=name,
            kind=kind,
            status="fail" if message else "pass",
            message=message,
            judged=judged,
            outside=sum(not row.ok for row in rows),
            rows=tuple(rows),
            rows_per_variant=rows_per_variant,
        )


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Measured points against their reference, for plotting: all lists have one length. Over two
    inputs `y` is the second one, which `y_label` names."""

    title: str
    x_label: str
    y_label: str
    x: tuple[float, ...]
    measured: tuple[float, ...]
    reference: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    log_x: bool = False
    y: tuple[float, ...] = ()


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


@dataclass(frozen=True, kw_only=True)
class SourceText:
    """A piece of source as its author wrote it: GLSL, or a Python formula."""

    file: str
    line: int
    language: Literal["glsl", "python"]
    text: str


@dataclass(frozen=True, kw_only=True)
class Declared:
    """One thing that a program declares, as reflection finds it.

    `kind` is "attribute", "varying", "output", "uniform" or "block"; `type` is GLSL's, with the
    size of an array behind it ("vec3[4]"). `used` is false where no function refers to it.
    """

    kind: str
    name: str
    type: str
    location: int | None = None
    used: bool = True


@dataclass(frozen=True, kw_only=True)
class ProgramRecord:
    """One linked program of a case: its stages' sources and each target's verdict.

    `declared` is its interface, empty where it does not compile.
    """

    files: tuple[str, ...]
    sources: "tuple[SourceText, ...]"
    verdicts: tuple[Verdict, ...]
    declared: tuple[Declared, ...] = ()


@dataclass(frozen=True, kw_only=True)
class ErratumNote:
    """Where the text that a case follows is wrong: what it says, what is true, what proves it."""

    section: str
    says: str
    truth: str
    proof: str


@dataclass(frozen=True, kw_only=True)
class Attachment:
    """One attachment of a pass: its format, and its picture, a path in the run's folder, or ""."""

    name: str
    format: str
    image: str = ""


@dataclass(frozen=True, kw_only=True)
class PassRecord:
    """One pass: the files of each of its draws, the earlier outputs that it reads
    ("pass.output"), and what it draws into. `size` is (width, height) in the picture."""

    name: str
    draws: tuple[tuple[str, ...], ...]
    reads: tuple[str, ...]
    attachments: tuple[Attachment, ...]
    size: tuple[int, int] | None = None


@dataclass(frozen=True, kw_only=True)
class BufferPart:
    """Where one attribute or member lies in a buffer, in bytes; `stride` is from one vertex, or
    one element of an array, to the next, `divisor` 1 where attributes go on once an instance."""

    name: str
    offset: int
    stride: int = 0
    divisor: int = 0


@dataclass(frozen=True, kw_only=True)
class BufferRecord:
    """One buffer that a scene's draws read: `kind` is "vertex" or "uniform", `used` says how many
    draws read it. `usage` and `upload` are as in `Mesh`."""

    name: str
    kind: str
    size: int
    used: int
    parts: tuple[BufferPart, ...]
    usage: str = ""
    upload: str = ""


@dataclass(frozen=True, kw_only=True)
class CallsRecord:
    """The calls of the API for one draw of a pass, or for its target where `draw` is None, each as
    it would stand in a C program; those that change nothing are left out."""

    pass_name: str
    draw: int | None
    calls: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class DrawnOutput:
    """One output of a scene, "pass.output": its (width, height), a digest of its values, and the
    names of the expectations that read it and fail."""

    name: str
    size: tuple[int, int]
    digest: str
    failed: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class LineCoverage:
    """A line of a shader: whether a fragment came to it, and each way of its branches in turn."""

    file: str
    line: int
    was_run: bool
    branches: tuple[bool, ...] = ()


@dataclass(frozen=True, kw_only=True)
class ModulesRecord:
    """What a scene's fragment shaders were interpreted for, to judge what the driver drew: how many
    pixels' outputs lie inside or outside of their modules' bands, the outputs ("pass.output"), and
    the draws that were left out, each with the reason. `coverage` is known where all pixels were
    looked at; what is `proved` holds for all inputs between those pixels', what is `open` may."""

    judged: int = 0
    outputs: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    coverage: tuple[LineCoverage, ...] = ()
    proved: tuple[str, ...] = ()
    open: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where a lesson stands: `order` on its course's path, from 1, and the path's `stage`, each
    with its titles and why it comes next; ids of the lessons that it `assumes`; the name of its
    section; and the text that sections and errata are of. What the tree does not say is empty."""

    order: int = 0
    title_zh: str = ""
    because: str = ""
    assumes: tuple[str, ...] = ()
    stage: int = 0
    stage_title: str = ""
    stage_title_zh: str = ""
    stage_because: str = ""
    section_title: str = ""
    section_title_zh: str = ""
    text: str = ""


@dataclass(frozen=True, kw_only=True)
class Record:
    """One variant of one case, run and judged. `id` and `variant` name it within a run.

    `chapter` is the title of the one that `section` lies in, "" where the case's tree has none;
    `place` is where the case stands in its course.

    `images` maps "picture" (and what else there is) to files relative to the run's folder,
    `captions` the same names to how they are to be read; `columns` and `rows` name those of a
    picture that is a table. `passes` are in the order they ran.
    `buffers` are those of uniform blocks, and of meshes that say how they lie in memory.
    `unread` are the outputs that no expectation reads (`unread_outputs` in
    shaderlab/engine/expectations/base.py): whatever is drawn there, the record passes.
    `not_asked` are the names of the expectations about OpenGL's own calls, where another API draws:
    the record may pass without them, and each report says how many they are.
    `gl_calls` are there where they were asked for. `modules` says what was judged by its own
    shader, None where nothing was; what is outside there is an outcome as well.

    `live` is the file, as of pictures, of the calls that draw the picture in a browser, or "", and
    `not_live` why there is none though there is a picture.

    `driver_name` is the name given to `--drivers`, "" where a run has one driver. Where there are
    several, `drawn` has each output, so that they can be compared.

    `driver` (renderer and version), `size` and `picture_size` (sides in pixels of the judged frame
    and of the picture, where a pass has no size of its own) are what the values depend on besides
    the case's files and `Run.versions`: no law and no formula draws random numbers. They are "" and
    0 where the scene was not drawn, `picture_size` also in a run without pictures.
    """

    id: str
    variant: str
    title: str
    section: str
    lesson: str
    formula: str
    file: str
    status: Status
    message: str = ""
    seconds: float = 0.0
    timings: Mapping[str, float] = field(default_factory=dict)
    compile: Mapping[str, str] = field(default_factory=dict)
    programs: tuple[ProgramRecord, ...] = ()
    expectations: "tuple[Outcome, ...]" = ()
    curves: tuple[Curve, ...] = ()
    plots: tuple[Plot, ...] = ()
    errata: tuple[ErratumNote, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)
    notices: tuple[str, ...] = ()
    images: Mapping[str, str] = field(default_factory=dict)
    captions: Mapping[str, str] = field(default_factory=dict)
    columns: tuple[str, ...] = ()
    rows: tuple[str, ...] = ()
    passes: tuple[PassRecord, ...] = ()
    buffers: tuple[BufferRecord, ...] = ()
    driver: str = ""
    size: int = 0
    picture_size: int = 0
    chapter: str = ""
    place: Place = Place()
    unread: tuple[str, ...] = ()
    not_asked: tuple[str, ...] = ()
    gl_calls: tuple[CallsRecord, ...] = ()
    modules: ModulesRecord | None = None
    driver_name: str = ""
    drawn: tuple[DrawnOutput, ...] = ()
    live: str = ""
    not_live: str = ""

    @property
    def key(self) -> tuple[str, str, str]:
        """What tells it from the others of a run."""
        return self.id, self.variant, self.driver_name


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
    driver leaves one; `outside` names those. At `pixel`, (column, row), they differ most."""

    id: str
    variant: str
    output: str
    drivers: tuple[str, str]
    pixels: int
    differing: int
    ulp: float
    verdict: Agreement = "equal"
    outside: tuple[str, ...] = ()
    pixel: tuple[int, int] | None = None


@dataclass(frozen=True, kw_only=True)
class Run:
    """All records of one command, with where they were made. `driver` has at least the keys
    "renderer", "vendor", "version" and "glsl"; `versions` maps package names to versions.

    With several drivers, `records` and `driver` are those of the first, `drivers`
    has every scene on every driver, and `disagreements` compares each two of them.

    `replaced` are the files that stood in a shader's place, by the shader's name. `missing` is the
    number of requested scenes that have no record, because the run was interrupted.
    """

    driver: Mapping[str, str]
    versions: Mapping[str, str]
    started: str
    seconds: float
    records: tuple[Record, ...]
    drivers: tuple[DriverResult, ...] = ()
    disagreements: tuple[Disagreement, ...] = ()
    replaced: Mapping[str, str] = field(default_factory=dict)
    missing: int = 0

    @property
    def failing_drivers(self) -> tuple[str, ...]:
        """Of several drivers those on which a scene failed."""
        bad = (r.driver for r in self.drivers if r.status not in ("pass", "unsupported"))
        return tuple(dict.fromkeys(bad))
