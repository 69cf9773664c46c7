"""What was drawn of a case's variant, and how it was judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..observations import Observation
from .outcomes import Curve, Outcome, Plot, Status
from .programs import ProgramRecord


@dataclass(frozen=True, kw_only=True)
class ErratumNote:
    """Where the text that a case follows is wrong: what it says, what is true, which expectation
    proves it."""

    section: str
    says: str
    truth: str
    proof: str


@dataclass(frozen=True, kw_only=True)
class Attachment:
    """One attachment of a pass: its format, and a picture of it, a file relative to the run's
    folder, or ""."""

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
class ModulesRecord:
    """What a scene's fragment shaders were interpreted for, to judge what the driver drew: how many
    pixels' outputs lie inside or outside of their modules' bands, the outputs ("pass.output"), and
    the draws that were left out, each with the reason."""

    judged: int = 0
    outputs: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Record:
    """One variant of one case, run and judged. `id` and `variant` name it within a run.

    `chapter` is the title of the one that `section` lies in, "" where the case's tree has none.

    `images` maps "picture" (and what else there is) to files relative to the run's folder,
    `captions` the same names to how they are to be read. `passes` are in the order they ran.
    `buffers` are those of uniform blocks, and of meshes that say how they lie in memory.
    `unread` are the outputs that no expectation reads (`unread_outputs` in
    shaderlab/engine/expectations/reads.py): whatever is drawn there, the record passes.
    `not_asked` are the names of the expectations about OpenGL's own calls, where another API draws:
    the record may pass without them, and each report says how many they are.
    `gl_calls` are there where they were asked for. `modules` says what was judged by its own
    shader, None where nothing was; what is outside there is an outcome as well.

    `driver_name` is the name given to `--drivers`, "" where a run has one driver. Where there are
    several, `drawn` has each output, so that they can be compared; `observed` is what a record has
    instead of outcomes where some pixels were looked at.

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
    expectations: tuple[Outcome, ...] = ()
    curves: tuple[Curve, ...] = ()
    plots: tuple[Plot, ...] = ()
    errata: tuple[ErratumNote, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)
    notices: tuple[str, ...] = ()
    images: Mapping[str, str] = field(default_factory=dict)
    captions: Mapping[str, str] = field(default_factory=dict)
    passes: tuple[PassRecord, ...] = ()
    buffers: tuple[BufferRecord, ...] = ()
    driver: str = ""
    size: int = 0
    picture_size: int = 0
    chapter: str = ""
    unread: tuple[str, ...] = ()
    not_asked: tuple[str, ...] = ()
    gl_calls: tuple[CallsRecord, ...] = ()
    modules: ModulesRecord | None = None
    driver_name: str = ""
    drawn: tuple[DrawnOutput, ...] = ()
    observed: tuple[Observation, ...] = ()

    @property
    def key(self) -> tuple[str, str, str]:
        """What tells it from the others of a run."""
        return self.id, self.variant, self.driver_name
