"""One program to compile, as data that another process can take, and its result."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from shaderlab.errors import DriverError, ShaderError
from shaderlab.glsl.compile import compile_program
from shaderlab.glsl.driver_verdict import mark_disagreement
from shaderlab.glsl.engines import CompilerDiedError, Engine, choose, limited
from shaderlab.glsl.sources import Shaders, Source
from shaderlab.glsl.targets import TARGETS
from shaderlab.glsl.text import stage_of
from shaderlab.records import Diagnostic, Verdict

WORK = "shaderlab.glsl.jobs:work"
"""What a pool of processes runs, by name: takes `CompileJob`s, yields `FileResult`s."""


@dataclass(frozen=True, kw_only=True)
class CompileOptions:
    """How to compile files.

    Attributes:
        targets: some of `ALL_TARGETS`.
        roots: folders to include from, after a file's own root.
        defines: macros to put after each `#version` line.
        stage: every file's stage; by default each file's name or pragma says it.
        engine: one of `engines.ENGINES`, or None for the default.
        seconds: time limit for one file.
        driver: the function that returns a driver's verdict, as "module:function", or "".
        keep: whether to return SPIR-V modules.
    """

    targets: tuple[str, ...] = TARGETS
    roots: tuple[str, ...] = ()
    defines: Mapping[str, str] = field(default_factory=dict)
    stage: str | None = None
    engine: str | None = None
    seconds: float = 10.0
    driver: str = ""
    keep: bool = False


@dataclass(frozen=True)
class CompileJob:
    """Files to compile as one program: the root and name of each."""

    path: str
    files: tuple[tuple[str, str], ...]
    options: CompileOptions


@dataclass(frozen=True, kw_only=True)
class FileResult:
    """Every target's verdict on one file, or on the files of one program.

    Attributes:
        path: as it was named; of a program, its files' paths joined by " + ".
        stage: one of `STAGES`; of a program, its stages joined by " + "; "" if unknown.
        verdicts: one for each target, in the order they were given, then the driver's if any.
        spirv: each target's modules by stage, if they were requested.
    """

    path: str
    stage: str
    verdicts: tuple[Verdict, ...]
    spirv: Mapping[str, Mapping[str, bytes]] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether all targets accept it."""
        return all(verdict.ok for verdict in self.verdicts)


def work(jobs: Sequence[CompileJob]) -> Iterator[FileResult]:
    """Compiles jobs of one set of options, in order. What is wrong with a file is in its result."""
    options = jobs[0].options if jobs else CompileOptions()
    engine = limited(choose(options.engine), options.seconds)
    shaders: dict[str, Shaders] = {}
    loaded = [_load(job, shaders) for job in jobs]
    engine.prepare([source for stages in loaded if isinstance(stages, list) for source in stages])
    for job, stages in zip(jobs, loaded, strict=True):
        try:
            if isinstance(stages, ShaderError):
                raise stages
            yield _compile(job, stages, engine)
        except CompilerDiedError as error:
            yield died(job, error.status, error.message)
        except ShaderError as error:
            message = error.message + (f" ({error.remedy})" if error.remedy else "")
            yield _failed(job, message, error.file, error.line)


def died(job: CompileJob, status: str, message: str) -> FileResult:
    """The result of a job whose compiler crashed or timed out."""
    if status == "crash":
        return _failed(job, f"crash: took the compiler down: {message}", status="crash")
    return _failed(job, f"{status}: took the compiler too long: {message}", status="timeout")


def _failed(
    job: CompileJob,
    message: str,
    file: str | None = None,
    line: int | None = None,
    status: Literal["", "crash", "timeout"] = "",
) -> FileResult:
    """The same error as every target's verdict."""
    error = Diagnostic(file=file or job.path, line=line, severity="error", message=message)
    try:
        stage = " + ".join(job.options.stage or stage_of(name, "") for _, name in job.files)
    except ShaderError:
        stage = ""
    verdicts = (
        Verdict(target=target, ok=False, diagnostics=(error,), status=status)
        for target in job.options.targets
    )
    return FileResult(path=job.path, stage=stage, verdicts=tuple(verdicts))


def _load(job: CompileJob, shaders: dict[str, Shaders]) -> list[Source] | ShaderError:
    """The job's sources; `shaders` holds what loads them, by root, for all jobs."""
    options = job.options
    try:
        sources = []
        for root, name in job.files:
            if root not in shaders:
                folders = map(Path, dict.fromkeys([root, *options.roots]))
                shaders[root] = Shaders([*folders], defines=options.defines)
            sources.append(shaders[root].load(name, options.stage))
        return sources
    except ShaderError as error:
        return error


def _compile(job: CompileJob, stages: Sequence[Source], engine: Engine) -> FileResult:
    options = job.options
    compiled = compile_program(stages, options.targets, engine=engine)
    verdicts = compiled.verdicts
    if options.driver:
        verdicts = mark_disagreement([*verdicts, *_driver_verdict(options.driver, stages)])
    return FileResult(
        path=job.path,
        stage=" + ".join(source.stage for source in compiled.sources),
        verdicts=verdicts,
        spirv=compiled.spirv if options.keep else {},
    )


def _driver_verdict(name: str, stages: Sequence[Source]) -> Iterator[Verdict]:
    """The driver's verdict; none if there is no driver or it lacks such a stage."""
    module, _, function = name.partition(":")
    with suppress(DriverError):
        yield getattr(importlib.import_module(module), function)(stages)
