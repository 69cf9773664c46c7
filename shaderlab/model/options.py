"""How scenes are run, as one value that every package takes and that crosses processes."""

from collections.abc import Mapping
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path

from shaderlab.errors import UsageError


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What one job may take.

    Attributes:
        seconds: of time.
        gigabytes: of address space, 2^30 bytes each; 0 for any amount. It holds where the system
            limits processes (Linux, not Windows).

    Raises UsageError: one is negative, no number, or more than a system can count."""

    seconds: float = 30.0
    gigabytes: float = 4.0

    def __post_init__(self) -> None:
        if not (0.0 < self.seconds <= 1e9 and 0.0 <= self.gigabytes <= 1e9):
            said = f"a time limit of {self.seconds:g} s and {self.gigabytes:g} GB of memory"
            raise UsageError(f"{said} can't be set", remedy="give positive numbers up to 1e9")


CALL_LIMITS: ContextVar[Limits] = ContextVar("CALL_LIMITS")
"""Of each call of a GLSL function, where they are not the usual ones; read at the first call."""


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How scenes are run.

    Attributes:
        size: side in pixels of the square frame that is judged, where a case does not say.
        picture_size: side of the picture for people, likewise.
        folder: the run's folder; None writes no file.
        pictures: whether pictures are drawn into it.
        shaders: files that replace shaders, by the shader's name.
        texts: texts that replace shaders, likewise.
        renames: names in these files and texts, and what they are called instead.
        include: further folders in which shaders are found.
        targets: what programs are compiled for; if empty, what the case or its project says.
        gl_calls: whether the calls of OpenGL that drawing takes are recorded as well.
        modules: whether draws are held against their own shaders' bands as well: all pixels of
            all draws, none, or with None some of each program.
        driver: as in `shaderlab.drivers.open_backend`; a process keeps the first it is given.
        frames: the folder in which `shaderlab.engine.pictures` stores what each scene
            draws, on each of several drivers in a folder of its own; None stores nothing.
        limits: of each scene.
    """

    size: int = 64
    picture_size: int = 512
    folder: Path | None = None
    pictures: bool = True
    shaders: Mapping[str, Path] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)
    renames: Mapping[str, str] = field(default_factory=dict)
    include: tuple[Path, ...] = ()
    targets: tuple[str, ...] = ()
    gl_calls: bool = False
    modules: bool | None = None
    driver: str | None = None
    frames: Path | None = None
    limits: Limits = Limits()

    @property
    def replacements(self) -> dict[str, str | Path]:
        """The text or the file that replaces each shader."""
        return {**self.shaders, **self.texts}

    @property
    def picture_folder(self) -> Path | None:
        """The folder for pictures; None where none are drawn."""
        return self.folder if self.pictures else None
