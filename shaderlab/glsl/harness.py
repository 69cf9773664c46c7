"""Many files to their verdicts: `compile_glsl`, in this process or in workers that may die."""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from shaderlab.errors import ShaderError, nearest
from shaderlab.glsl.compile import ALL_TARGETS, TARGETS
from shaderlab.glsl.engines import COMMAND_VARIABLE, ENGINES
from shaderlab.glsl.jobs import FileResult, Job, Options, lost, work
from shaderlab.glsl.sources import STAGES
from shaderlab.glsl.tree import ShaderFile, find_shaders

_BATCH = 128
# Checks at once, then for each of three SPIR-V targets the compiler and the validator.
_COMMANDS_PER_FILE = 8


class Outcome(Protocol):
    """What became of one job in a worker."""

    @property
    def item(self) -> Any:
        """The job."""

    @property
    def status(self) -> str:
        """ "done", "crash", "timeout", or "error" where an exception was raised."""

    @property
    def result(self) -> Any:
        """The job's result, or the exception."""

    @property
    def message(self) -> str:
        """How the worker died."""


class Workers(Protocol):
    """Processes that do jobs, such as `shaderlab.workers.Pool(jobs.WORK)`."""

    def each(self, items: Iterable[Any]) -> Iterator[Outcome]:
        """Each job's outcome, in order."""


def compile_glsl(
    paths: Sequence[str | Path],
    *,
    targets: Sequence[str] = TARGETS,
    include: Sequence[str | Path] = (),
    defines: Mapping[str, str] | None = None,
    stage: str | None = None,
    engine: str | None = None,
    seconds: float = 10.0,
    link: bool = False,
    opinion: str = "",
    keep: bool = False,
    workers: Workers | None = None,
) -> Iterator[FileResult]:
    """What the compilers say of shader files, one result a file, sorted by path.

    Results come as they are made and are not kept, so that ten thousand files take no more
    memory than ten.

    Args:
        paths: files, and folders to search; see `find_shaders`.
        targets: some of `ALL_TARGETS`.
        include: more folders that `#include` may read from.
        defines: macros put after each `#version` line.
        stage: of every file; by default its extension or `#pragma shader_stage` tells.
        engine: "library", "process", or None for what there is.
        seconds: what one file may take; kept by `workers` and by the "process" engine, while a
            library in this process can't be stopped.
        link: whether all the files are one program's stages.
        opinion: a function that asks a driver about a program, as "module:function".
        keep: whether each result carries its SPIR-V modules.
        workers: where to compile, so that a file on which a compiler crashes, hangs or fills the
            memory is reported as such and costs nothing else. In this process by default.

    Raises:
        UsageError: nothing is there of one of the names, or a folder holds no shader.
        ShaderError: no such target, stage or engine, or no compiler here. What is wrong with a
            file never raises; it is in the file's result.
    """
    _check(targets, ALL_TARGETS, "compile target")
    _check([stage] if stage else [], STAGES, "stage")
    _check([engine] if engine else [], ENGINES, "engine")
    options = Options(
        targets=tuple(targets),
        roots=tuple(map(str, include)),
        defines=dict(defines or {}),
        stage=stage,
        engine=engine,
        seconds=seconds,
        opinion=opinion,
        keep=keep,
    )
    shaders = find_shaders(paths, [Path(folder) for folder in include], stage=stage)
    return compile_found([shaders] if link else [[one] for one in shaders], options, workers)


def compile_found(
    programs: Iterable[Sequence[ShaderFile]], options: Options, workers: Workers | None = None
) -> Iterator[FileResult]:
    """The same for files found already: each sequence of them is one program."""
    jobs = (
        Job(" + ".join(s.path for s in files), tuple((s.root, s.name) for s in files), options)
        for files in programs
    )
    if workers is None:
        for batch in iter(lambda: list(itertools.islice(jobs, _BATCH)), []):
            yield from work(batch)
        return
    for outcome in workers.each(jobs):
        if outcome.status == "done":
            yield outcome.result
        elif outcome.status == "error":
            raise outcome.result
        else:
            yield lost(outcome.item, outcome.status, outcome.message)


def patience(engine: str | None, seconds: float) -> float:
    """How long a worker may be busy with a file that may take so many seconds: commands have
    time limits of their own, and each of several may take that long."""
    driven = engine == "process" or (
        engine is None and (COMMAND_VARIABLE in os.environ or sys.platform != "linux")
    )
    return seconds * _COMMANDS_PER_FILE if driven else seconds


def _check(words: Sequence[str], known: Sequence[str], what: str) -> None:
    for word in words:
        if word not in known:
            raise ShaderError(f"no such {what}: {word!r}", remedy=nearest(word, known))
