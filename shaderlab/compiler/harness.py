"""Compiles many files, in this process or in a pool of processes that may crash."""

import importlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from shaderlab.errors import Diagnostic, DriverError, ShaderError, Verdict
from shaderlab.workers.pool import WorkerPool

from .dialects import raise_version
from .glslang import TARGETS
from .shader_files import EXTENSIONS, ShaderFile, is_library, stage_of
from .sources import Shaders, Source

WORK = "shaderlab.compiler.harness:Work"
"""What a pool of processes runs, by name: takes `CompileJob`s, returns `FileResult`s."""


@dataclass(frozen=True, kw_only=True)
class CompileOptions:
    """How to compile files: for which targets, with folders to include from after a file's own
    root, and with every file's stage, where its extension or `#pragma shader_stage` does not say
    it. `driver` is the function that returns a driver's verdict on a program, as "module:function",
    `driver_name` the driver to use, and what its verdicts' target is called."""

    targets: Sequence[str] = TARGETS
    include: Sequence[str | Path] = ()
    defines: Mapping[str, str] = field(default_factory=dict)
    stage: str | None = None
    driver: str = ""
    driver_name: str = ""


@dataclass(frozen=True)
class CompileJob:
    """Files to compile as one program."""

    files: Sequence[ShaderFile]
    options: CompileOptions

    @property
    def path(self) -> str:
        return " + ".join(file.path for file in self.files)


@dataclass(frozen=True, kw_only=True)
class FileResult:
    """Every target's verdict on one file, or on the files of one program, and then the driver's.
    The path is as it was named, the stage one of `STAGES` or "" if unknown; those of a program's
    files are joined by " + "."""

    path: str
    stage: str
    verdicts: tuple[Verdict, ...]

    @property
    def ok(self) -> bool:
        return all(verdict.ok for verdict in self.verdicts)


def compile_files(
    programs: Iterable[Sequence[ShaderFile]],
    options: CompileOptions,
    workers: WorkerPool | None = None,
) -> Iterator[FileResult]:
    """Compile programs, each of the files of its stages, and yield the results in their order:
    here, or in processes, where a file that crashes a compiler, hangs it or fills the memory does
    not affect the others. What is wrong with a file is in its result."""
    jobs = (CompileJob(files, options) for files in programs)
    if workers is None:
        yield from map(Work(), jobs)
        return
    waiting: dict[int, Any] = {}
    following = 0
    for result in workers.run(jobs):
        waiting[result.number] = result
        while following in waiting:  # yielded in their jobs' order
            yield _result_of(waiting.pop(following))
            following += 1


def _result_of(result: Any) -> FileResult:
    if result.status == "error":
        raise result.value
    if result.status == "done":
        value: FileResult = result.value
        return value
    message = f"{result.status}: {_DEATHS[result.status]}: {result.message}"
    return _report_failure(result.item, message, status=result.status)


class Work:
    """Compiles jobs, each file read once. What is wrong with a file is in its result."""

    def __init__(self, *_: object) -> None:
        self._shaders: dict[Any, Shaders] = {}  # what loads files

    def __call__(self, job: CompileJob) -> FileResult:
        options = job.options
        try:
            stages = [source for file in job.files for source in self._load(file, options)]
            return _compile(job, stages)
        except ShaderError as error:
            message = error.message + (f" ({error.remedy})" if error.remedy else "")
            return _report_failure(job, message, error.file, error.line)

    def _load(self, file: ShaderFile, options: CompileOptions) -> list[Source]:
        """A file's stages; a library of functions with a `main` that calls none."""
        folders = tuple(dict.fromkeys([file.root, *map(str, options.include)]))
        key = folders, tuple(options.defines.items())
        if key not in self._shaders:
            self._shaders[key] = Shaders(list(map(Path, folders)), defines=options.defines)
        if options.stage is not None or not is_library(file.path):
            return self._shaders[key].load_stages(file.name, options.stage)
        stage = EXTENSIONS.get(Path(file.name).suffix, "fragment")
        source = self._shaders[key].load(file.name, stage)
        if source.version == (110, ""):
            source = raise_version(source, f"#version {_NEWEST} core")
        return [replace(source, text=f"{source.text}\nvoid main() {{}}\n", stripped=None)]


_NEWEST = 450
_DEATHS = {"crash": "the compiler crashed", "timeout": "the compiler took too long"}


def _report_failure(
    job: CompileJob,
    message: str,
    file: str | None = None,
    line: int | None = None,
    status: Literal["", "crash", "timeout"] = "",
) -> FileResult:
    """Return the same error as every target's verdict."""
    error = Diagnostic(file=file or job.path, line=line, severity="error", message=message)
    try:
        stage = " + ".join(job.options.stage or stage_of(one.name, "") for one in job.files)
    except ShaderError:
        stage = ""
    verdicts = (
        Verdict(target=target, ok=False, diagnostics=(error,), status=status)
        for target in job.options.targets
    )
    return FileResult(path=job.path, stage=stage, verdicts=tuple(verdicts))


def _compile(job: CompileJob, stages: Sequence[Source]) -> FileResult:
    from .compile import compile_program  # not where workers do it
    from .diagnostics import DRIVER, mark_disagreement

    compiled = compile_program(stages, job.options.targets)
    verdicts = compiled.verdicts
    module, _, function = job.options.driver.partition(":")
    if module:
        with suppress(DriverError):  # there is no driver, or it lacks such a stage
            ask, name = getattr(importlib.import_module(module), function), job.options.driver_name
            verdict = ask(stages, name) if name else ask(stages)
            verdicts = mark_disagreement([*verdicts, verdict])
            verdicts = tuple(
                replace(v, target=name) if name and v.target == DRIVER else v for v in verdicts
            )
    return FileResult(
        path=job.path,
        stage=" + ".join(source.stage for source in compiled.sources),
        verdicts=verdicts,
    )
