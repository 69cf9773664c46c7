"""One file to compile, as data that can be sent to another process, and what came of it."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from shaderlab.errors import DriverError, ShaderError
from shaderlab.glsl.compile import TARGETS, compile_program
from shaderlab.glsl.engines import Engine, choose, limited
from shaderlab.glsl.opinion import compared
from shaderlab.glsl.programs import CompilerDiedError
from shaderlab.glsl.sources import Shaders, Source, stage_of
from shaderlab.records import Diagnostic, Verdict

WORK = "shaderlab.glsl.jobs:work"


@dataclass(frozen=True, kw_only=True)
class Options:
    """How files are to be compiled.

    Attributes:
        roots: folders to include from, after a file's own root.
        defines: macros put after each `#version` line.
        stage: of every file; by default each file tells.
        engine: one of `engines.ENGINES`, or None for what there is.
        seconds: how long one file may take.
        opinion: what asks a driver, as "module:function", or "" for no second opinion.
        keep: whether the modules are wanted, and not only their size.
    """

    targets: tuple[str, ...] = TARGETS
    roots: tuple[str, ...] = ()
    defines: Mapping[str, str] = field(default_factory=dict)
    stage: str | None = None
    engine: str | None = None
    seconds: float = 10.0
    opinion: str = ""
    keep: bool = False


@dataclass(frozen=True)
class Job:
    """Files to be compiled as one program: the root and name of each."""

    path: str
    files: tuple[tuple[str, str], ...]
    options: Options


@dataclass(frozen=True, kw_only=True)
class FileResult:
    """What every target said of one file, or of the files that make one program.

    Attributes:
        path: as it was named; of a program, its files' paths with " + " between them.
        stage: one of `STAGES`, with " + " between those of a program; "" where nobody can tell.
        verdicts: one a target, in the order asked for, then the driver's where there is one to ask.
        spirv: each target's module (of a program, by stage in `STAGES`' order, end to end), if
            it was asked for.
    """

    path: str
    stage: str
    verdicts: tuple[Verdict, ...]
    spirv: Mapping[str, Mapping[str, bytes]] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether all targets accept it."""
        return all(verdict.ok for verdict in self.verdicts)


def work(jobs: Sequence[Job]) -> Iterator[FileResult]:
    """The jobs' results, in order. What is wrong with a file is in its verdicts."""
    options = jobs[0].options if jobs else Options()
    engine = limited(choose(options.engine), options.seconds)
    loaded = _load_all(jobs)
    engine.prepare([source for stages in loaded if isinstance(stages, list) for source in stages])
    for job, stages in zip(jobs, loaded, strict=True):
        if isinstance(stages, ShaderError):
            yield refused(job, stages)
        else:
            yield _compiled(job, stages, engine)


def refused(job: Job, error: ShaderError) -> FileResult:
    """A file that can't even be read, refused by every target for the same reason."""
    message = error.message + (f" ({error.remedy})" if error.remedy else "")
    said = Diagnostic(
        file=error.file or job.path, line=error.line, severity="error", message=message
    )
    return _same(job, Verdict(target="", ok=False, diagnostics=(said,)))


def lost(job: Job, status: str, message: str) -> FileResult:
    """A file that took its compiler down, or kept it too long."""
    word = "took the compiler down" if status == "crash" else "took the compiler too long"
    said = Diagnostic(
        file=job.path, line=None, severity="error", message=f"{status}: {word}: {message}"
    )
    verdict = Verdict(
        target="",
        ok=False,
        diagnostics=(said,),
        status="crash" if status == "crash" else "timeout",
    )
    return _same(job, verdict)


def _same(job: Job, verdict: Verdict) -> FileResult:
    return FileResult(
        path=job.path,
        stage=_stages_by_name(job),
        verdicts=tuple(replace(verdict, target=target) for target in job.options.targets),
    )


def _stages_by_name(job: Job) -> str:
    try:
        stages = [job.options.stage or stage_of(name, "") for _, name in job.files]
    except ShaderError:
        return ""
    return " + ".join(stages)


def _load_all(jobs: Sequence[Job]) -> list[list[Source] | ShaderError]:
    shaders: dict[str, Shaders] = {}
    found: list[list[Source] | ShaderError] = []
    for job in jobs:
        try:
            found.append([_load(root, name, job.options, shaders) for root, name in job.files])
        except ShaderError as error:
            found.append(error)
    return found


def _load(root: str, name: str, options: Options, shaders: dict[str, Shaders]) -> Source:
    if root not in shaders:
        roots = dict.fromkeys([root, *options.roots])
        shaders[root] = Shaders([Path(folder) for folder in roots], defines=options.defines)
    return shaders[root].load(name, options.stage)


def _compiled(job: Job, stages: Sequence[Source], engine: Engine) -> FileResult:
    try:
        compiled = compile_program(stages, job.options.targets, engine=engine)
    except CompilerDiedError as error:
        return lost(job, error.status, error.message)
    except ShaderError as error:
        return refused(job, error)
    verdicts = list(compiled.verdicts)
    if job.options.opinion:
        verdicts += _asked(job.options.opinion, stages)
    return FileResult(
        path=job.path,
        stage=" + ".join(source.stage for source in compiled.sources),
        verdicts=compared(verdicts) if job.options.opinion else compiled.verdicts,
        spirv=compiled.spirv if job.options.keep else {},
    )


def _asked(opinion: str, stages: Sequence[Source]) -> list[Verdict]:
    """The driver's verdict, or none where there is no driver or it lacks such a stage."""
    module, _, function = opinion.partition(":")
    try:
        return [getattr(importlib.import_module(module), function)(stages)]
    except DriverError:
        return []
