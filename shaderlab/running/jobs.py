"""What is asked of a worker and what comes back, as plain data that crosses processes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from shaderlab.errors import CaseError, UsageError, nearest

DEFAULT_SECONDS = 30.0
DEFAULT_GIGABYTES = 4.0


@dataclass(frozen=True, kw_only=True)
class Setup:
    """How all scenes of a run are run; see `shaderlab.options.RunOptions`.

    Attributes:
        size: side in pixels of the square frame that is judged, where a case does not say.
        folder: the run's folder.
        pictures: whether pictures are drawn into it.
        shaders: replacements, as (shader name, file).
        driver: as in `shaderlab.backends.open_backend`; a worker keeps the first it is given.
        frames: the folder that keeps each scene's drawn values; None keeps none.
    """

    size: int = 64
    folder: Path | None = None
    pictures: bool = True
    shaders: tuple[tuple[str, Path], ...] = ()
    driver: str | None = None
    frames: Path | None = None


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What one scene may take: seconds of time, gigabytes (2^30 bytes) of memory, 0 for any."""

    seconds: float = DEFAULT_SECONDS
    gigabytes: float = DEFAULT_GIGABYTES


@dataclass(frozen=True, kw_only=True)
class CaseFacts:
    """What a case file holds, as far as choosing among its variants needs it.

    `formulas` says for each variant how many formulas its outputs are held against, `parameters`
    how many components each uniform and ramp has, by name; `sized` whether a pass has the size of
    the frame that is judged.
    `error` is why it could not be loaded; then `variants` is empty, and `status` says whether the
    file is wrong ("error") or took its process with it ("crash", "timeout").
    """

    file: str
    id: str
    title: str = ""
    section: str = ""
    variants: tuple[str, ...] = ()
    formulas: tuple[int, ...] = ()
    parameters: Mapping[str, int] = field(default_factory=dict)
    sized: bool = True
    error: CaseError | None = None
    status: str = "pass"


@dataclass(frozen=True, kw_only=True)
class Point:
    """One point of a sweep: the variant it starts from, the parameters' values, and the side of
    the frame that is judged (0: the run's)."""

    variant: str
    changes: Mapping[str, float]
    size: int = 0


@dataclass(frozen=True, kw_only=True)
class Job:
    """One variant to be run, or a case file that gave none: then `broken` says how that ended
    ("error", "crash" or "timeout") and `trouble` why. With a `point` it is that variant with other
    inputs, judged by its formulas alone; `variant` is then the point's own name."""

    file: str
    id: str
    variant: str
    title: str = ""
    section: str = ""
    broken: str = ""
    trouble: str = ""
    point: Point | None = None

    @property
    def key(self) -> tuple[str, str]:
        """What tells it from the others of a run."""
        return self.id, self.variant


@dataclass(frozen=True, kw_only=True)
class About:
    """What a worker says of the driver it runs on, and of the packages in use."""

    driver: Mapping[str, str] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Describe:
    """Asks for an `About` of the driver; the packages are those of whoever asks."""

    driver: str | None


@dataclass(frozen=True)
class Load:
    """Asks for a file's `CaseFacts`. A file that is wrong raises CaseError."""

    file: Path


@dataclass(frozen=True)
class Perform:
    """Asks for a job's `Record`; steps are noted in slot `slot` of the file `steps`."""

    setup: Setup
    job: Job
    steps: Path
    slot: int


Question = Describe | Load | Perform


def known(name: str) -> str:
    """`name`, if it is a driver's. Raises UsageError."""
    from shaderlab.backends import DRIVERS

    if name not in DRIVERS:
        raise UsageError(f"there is no driver {name!r}", remedy=nearest(name, DRIVERS))
    return name
