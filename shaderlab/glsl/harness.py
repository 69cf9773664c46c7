"""Compiles many files, in this process or in a pool of processes that may crash."""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from shaderlab.errors import ShaderError, nearest
from shaderlab.glsl.engines import COMMAND_VARIABLE, ENGINES
from shaderlab.glsl.jobs import CompileJob, CompileOptions, FileResult, died, work
from shaderlab.glsl.shader_files import ShaderFile, find_shaders
from shaderlab.glsl.targets import ALL_TARGETS, TARGETS
from shaderlab.glsl.text import STAGES

_BATCH = 128
# One check, then for each of three SPIR-V targets the compiler and the validator; rounded up.
_COMMANDS_PER_FILE = 8


class Workers(Protocol):
    """A pool of processes, such as `shaderlab.execution.WorkerPool(jobs.WORK)`."""

    def run(self, items: Iterable[Any]) -> Iterator[Any]:
        """The jobs' results as they complete; see `shaderlab.execution.pool.ItemResult`."""


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
    driver: str = "",
    keep: bool = False,
    workers: Workers | None = None,
) -> Iterator[FileResult]:
    """Compiles shader files and yields one result for each, sorted by path.

    Results are yielded as they are made, so ten thousand files take no more memory than ten.

    Args:
        paths: files, and folders to search; see `find_shaders`.
        targets: some of `ALL_TARGETS`.
        include: more folders that `#include` may read from.
        defines: macros put after each `#version` line.
        stage: every file's stage; by default its extension or `#pragma shader_stage` says it.
        engine: "library", "process", or None for the default.
        seconds: time limit for one file, enforced by `workers` and by the "process" engine; a
            library in this process can't be stopped.
        link: whether the files are the stages of one program.
        driver: a function that returns a driver's verdict on a program, as "module:function".
        keep: whether to return each result's SPIR-V modules.
        workers: processes to compile in. A file that crashes a compiler, hangs it or fills the
            memory is then reported as such and does not affect the others. By default this
            process compiles.

    Raises:
        UsageError: a path does not exist, or a folder holds no shader.
        ShaderError: unknown target, stage or engine, or no compiler is installed. What is wrong
            with a file never raises; it is in the file's result.
    """
    _check(targets, ALL_TARGETS, "compile target")
    _check([stage] if stage else [], STAGES, "stage")
    _check([engine] if engine else [], ENGINES, "engine")
    options = CompileOptions(
        targets=tuple(targets),
        roots=tuple(map(str, include)),
        defines=dict(defines or {}),
        stage=stage,
        engine=engine,
        seconds=seconds,
        driver=driver,
        keep=keep,
    )
    shaders = find_shaders(paths, [Path(folder) for folder in include], stage=stage)
    return compile_found([shaders] if link else [[one] for one in shaders], options, workers)


def compile_found(
    programs: Iterable[Sequence[ShaderFile]],
    options: CompileOptions,
    workers: Workers | None = None,
) -> Iterator[FileResult]:
    """As `compile_glsl`, for files that `find_shaders` found; each sequence is one program."""
    jobs = (
        CompileJob(
            " + ".join(s.path for s in files), tuple((s.root, s.name) for s in files), options
        )
        for files in programs
    )
    if workers is None:
        for batch in iter(lambda: list(itertools.islice(jobs, _BATCH)), []):
            yield from work(batch)
        return
    for result in _in_order(workers.run(jobs)):
        if result.status == "done":
            yield result.value
        elif result.status == "error":
            raise result.value
        else:
            yield died(result.item, result.status, result.message)


def _in_order(results: Iterator[Any]) -> Iterator[Any]:
    """Results in their jobs' order, each as soon as all before it are there."""
    waiting: dict[int, Any] = {}
    following = 0
    for result in results:
        waiting[result.number] = result
        while following in waiting:
            yield waiting.pop(following)
            following += 1


def time_limit(engine: str | None, seconds: float) -> float:
    """The time limit for a process that compiles a file which may take so many seconds.

    Each of an engine's commands has a time limit of its own, and a file takes several.
    """
    commands = engine == "process" or (
        engine is None and (COMMAND_VARIABLE in os.environ or sys.platform != "linux")
    )
    return seconds * _COMMANDS_PER_FILE if commands else seconds


def _check(words: Sequence[str], known: Sequence[str], what: str) -> None:
    for word in words:
        if word not in known:
            raise ShaderError(f"no such {what}: {word!r}", remedy=nearest(word, known))
