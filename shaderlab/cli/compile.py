"""`shaderlab compile`: ask the compilers about shader files, without running anything."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from shaderlab.cli import FAILED
from shaderlab.cli.files import finding_options, tell, uses_stdout, write_findings, write_json
from shaderlab.cli.options import INCLUDE, JSON, TARGET, jobs_option, limits_option
from shaderlab.cli.tallying import Tally, as_data, messages, progress_bar
from shaderlab.compiler.engines import ENGINES, TARGETS
from shaderlab.compiler.harness import WORK, CompileOptions, FileResult, compile_found, time_limit
from shaderlab.compiler.shader_files import STAGES, find_shaders
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.model.options import Limits
from shaderlab.report.findings import Finding, of_verdicts
from shaderlab.workers import WorkerPool
from shaderlab.workers.jobs import checked_driver
from shaderlab.workers.sizing import cores

# Workers import the driver's room by this name; the command itself never touches a device.
_DRIVER = "shaderlab.drivers:driver_verdict"
_FILES_PER_WORKER = 500
_MOST_WORKERS = 4
_DIED = ("crash", "timeout")


@click.command("compile")
@click.argument("paths", nargs=-1, required=True, metavar="PATH…")
@TARGET
@click.option("--stage", type=click.Choice(STAGES), help="Of every file, whatever its name says.")
@click.option("--define", "-D", "defines", multiple=True, metavar="NAME[=VALUE]", help="A macro.")
@INCLUDE
@click.option("--link", is_flag=True, help="The files are the stages of one program.")
@click.option(
    "--driver",
    "drivers",
    multiple=True,
    metavar="NAME",
    callback=lambda context, option, names: tuple(map(checked_driver, dict.fromkeys(names))),
    help="Ask this driver's own compiler as well, as of `run`; may be repeated.",
)
@click.option("--engine", type=click.Choice(ENGINES), help="Libraries, or the system's commands.")
@limits_option("Give one file up after S seconds.", seconds=10.0)
@jobs_option(f"one for every {_FILES_PER_WORKER} files, at most {_MOST_WORKERS}")
@JSON
@finding_options
@click.option("--quiet", "-q", is_flag=True, help="Print messages, and nothing else.")
def command(
    paths: tuple[str, ...],
    compile_targets: tuple[str, ...],
    stage: str | None,
    defines: tuple[str, ...],
    includes: tuple[Path, ...],
    link: bool,
    drivers: tuple[str, ...],
    engine: str | None,
    limits: Limits,
    workers: int | None,
    json_file: str | None,
    outputs: Mapping[str, str],
    quiet: bool,
) -> int:
    """Compile shader files, or all those in folders, as plain GLSL, as OpenGL SPIR-V and as
    Vulkan SPIR-V, and validate the SPIR-V.

    Each file is a program of its own here, unless --link makes one of them all. Messages have
    the form that editors jump from. A file on which a compiler crashes or hangs is named, and
    the others are compiled all the same.

    Exit code: 0 all accepted, 1 something refused, 2 wrong usage.

    \b
    Examples:
      shaderlab compile lamp.frag
      shaderlab compile my_shaders/ --define LIGHTS=4 --include common/
      shaderlab compile --link lamp.vert lamp.frag --driver llvmpipe --driver lavapipe
    """
    from shaderlab.engine.discovery import data_folder
    from shaderlab.settings import settings_of

    shipped = data_folder("shaders").resolve()
    shaders = find_shaders(paths, [shipped], stage=stage)
    folders = dict.fromkeys(path if path.is_dir() else path.parent for path in map(Path, paths))
    own = [each for folder in folders for each in settings_of(folder).shader_folders(folder)]
    programs = [shaders] if link else [[shader] for shader in shaders]
    options = CompileOptions(
        targets=compile_targets or TARGETS,
        include=tuple(map(str, dict.fromkeys([*includes, *own, shipped]))),
        defines=dict(map(_macro, defines)),
        stage=stage,
        engine=engine,
        seconds=limits.seconds,
    )
    if workers == 0 and len(drivers) > 1:
        raise UsageError("several drivers do not go with -j 0: a process has one")
    limits = replace(limits, seconds=time_limit(engine, limits.seconds))
    # A worker takes as long to start as two hundred files take to compile.
    most = min(cores(), _MOST_WORKERS, 1 + len(programs) // _FILES_PER_WORKER)
    with contextlib.ExitStack() as stack:

        def compiled(how: CompileOptions) -> Iterator[FileResult]:
            pool = None
            if workers != 0:
                pool = stack.enter_context(WorkerPool(WORK, limits=limits, jobs=workers or most))
            return compile_found(programs, how, pool)

        asked = [replace(options, driver=_DRIVER, driver_name=name) for name in drivers]
        first, *others = asked or [options]
        results = compiled(first)
        for how in others:
            answers = compiled(replace(how, targets=("glsl",)))
            results = _with_verdicts(results, answers, how.driver_name)
        tally, problems = _print_results(results, len(programs), json_file, outputs, quiet)
    for name in drivers:
        if name not in tally.targets:
            click.echo(f"{name} gave no verdict: see `shaderlab doctor`", err=True)
    unwritten = tell(problems)
    return FAILED if tally.refused else unwritten


def _with_verdicts(
    results: Iterator[FileResult], answers: Iterator[FileResult], driver: str
) -> Iterator[FileResult]:
    """The results with another driver's verdict on each; where it died, that is its verdict."""
    for result, answer in zip(results, answers, strict=True):
        died = [replace(v, target=driver) for v in answer.verdicts if v.status in _DIED]
        own = [v for v in answer.verdicts if v.target == driver]
        yield replace(result, verdicts=(*result.verdicts, *(own or died)))


def _print_results(
    results: Iterator[FileResult],
    count: int,
    json_file: str | None,
    outputs: Mapping[str, str],
    quiet: bool,
) -> tuple[Tally, list[ShaderlabError]]:
    """Print each result as it comes, then the summary; write all as JSON to `json_file`, and
    what is wrong to `outputs`. Returns what can't be written as well."""
    tally = Tally()
    entries: list[dict[str, Any]] = []
    found: list[Finding] = []
    files = dict(outputs) if json_file is None else {**outputs, "json": json_file}
    to_stderr = uses_stdout(files)
    with progress_bar(count, quiet=quiet) as advance:
        for result in results:
            for line in messages(result):
                click.echo(line, err=to_stderr)
            tally.add(result)
            advance()
            if json_file is not None:
                entries += as_data(result)
            if outputs:
                found += of_verdicts(result.verdicts, result.path)
    if not quiet:
        for line in tally.lines():
            click.echo(line, err=to_stderr)
    if json_file is not None:
        write_json({"files": entries}, json_file)
    return tally, list(write_findings(found, "compile", outputs))


def _macro(word: str) -> tuple[str, str]:
    name, equals, value = word.partition("=")
    return name, value if equals else "1"
