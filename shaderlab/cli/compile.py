"""`shaderlab compile`: compile shader files without running anything."""

import contextlib
import dataclasses
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from shaderlab.cli import FAILED, options as shared
from shaderlab.compiler.glslang import TARGETS
from shaderlab.compiler.harness import WORK, CompileOptions, FileResult, compile_files
from shaderlab.compiler.shader_files import ShaderFile, find_shaders
from shaderlab.engine.jobs import check_driver, count_cores
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.model.options import Limits
from shaderlab.report.findings import Finding, collect_verdict_findings
from shaderlab.report.text import format_diagnostic
from shaderlab.workers.pool import WorkerPool

# Workers import the driver's module by this name; the command itself never touches a device.
_DRIVER = "shaderlab.drivers:driver_verdict"
_FILES_PER_WORKER = 500
_MOST_WORKERS = 4
_FEW = 50
_DIED = ("crash", "timeout")


@click.command("compile")
@click.argument("paths", nargs=-1, required=True, metavar="PATH…")
@shared.TARGET
@shared.stage_option("Compile every file as this stage, whatever its name.")
@click.option(
    "--define",
    "-D",
    "defines",
    multiple=True,
    metavar="NAME[=VALUE]",
    help="Define a macro; may be repeated.",
)
@shared.INCLUDE
@click.option("--link", is_flag=True, help="Link the files as stages of one program.")
@click.option(
    "--driver",
    "drivers",
    multiple=True,
    metavar="NAME",
    callback=lambda context, option, names: tuple(map(check_driver, dict.fromkeys(names))),
    help="Compile with this driver as well (names as for `run`); may be repeated.",
)
@shared.limits_option("Stop a file that takes longer than S seconds.", seconds=10.0)
@shared.jobs_option(f"one per {_FILES_PER_WORKER} files, at most {_MOST_WORKERS}")
@shared.JSON
@shared.finding_options
@click.option("--quiet", "-q", is_flag=True, help="Print compiler messages only.")
def command(
    paths: tuple[str, ...],
    compile_targets: tuple[str, ...],
    stage: str | None,
    defines: tuple[str, ...],
    includes: tuple[Path, ...],
    link: bool,
    drivers: tuple[str, ...],
    limits: Limits,
    workers: int | None,
    json_file: str | None,
    outputs: Mapping[str, str],
    quiet: bool,
) -> int:
    """Compile shader files, and all shaders in folders, as plain GLSL, as OpenGL SPIR-V and as
    Vulkan SPIR-V, and validate the SPIR-V.

    Each file is compiled separately unless --link joins them into one program. Messages have the
    FILE:LINE form that editors recognise. If a compiler crashes or hangs on a file, that file is
    reported and the others are still compiled.

    Exit code: 0 everything compiles, 1 something does not, 2 wrong usage.

    \b
    Examples:
      shaderlab compile lamp.frag
      shaderlab compile my_shaders/ --define LIGHTS=4 --include common/
      shaderlab compile --link lamp.vert lamp.frag --driver llvmpipe --driver lavapipe
    """
    if workers == 0 and len(drivers) > 1:
        raise UsageError("several drivers can't be combined with -j 0; a process has one driver")
    shaders, folders = _find_shaders(paths, stage, includes)
    programs = [shaders] if link else [[shader] for shader in shaders]
    options = CompileOptions(
        targets=compile_targets or TARGETS,
        include=folders,
        defines=dict(map(_parse_macro, defines)),
        stage=stage,
    )
    with contextlib.ExitStack() as stack:
        results = _compile(programs, options, drivers, limits, workers, stack)
        tally, problems = _print_results(
            _show_progress(results, len(programs), quiet), json_file, outputs, quiet
        )
    for name in drivers:
        if name not in tally.targets:
            click.echo(f"{name} gave no verdict; see `shaderlab doctor`", err=True)
    unwritten = shared.report_problems(problems)
    return FAILED if tally.refused else unwritten


def _compile(
    programs: Sequence[Sequence[ShaderFile]],
    options: CompileOptions,
    drivers: Sequence[str],
    limits: Limits,
    workers: int | None,
    stack: contextlib.ExitStack,
) -> Iterator[FileResult]:
    """Compile programs for all targets and drivers; pools of workers end with the stack."""
    # A worker takes as long to start as two hundred files take to compile.
    most = min(count_cores(), _MOST_WORKERS, 1 + len(programs) // _FILES_PER_WORKER)

    def compile_with(how: CompileOptions) -> Iterator[FileResult]:
        pool = None
        if workers != 0:
            pool = stack.enter_context(WorkerPool(WORK, limits=limits, jobs=workers or most))
        return compile_files(programs, how, pool)

    per_driver = [replace(options, driver=_DRIVER, driver_name=name) for name in drivers]
    first, *others = per_driver or [options]
    results = compile_with(first)
    for how in others:
        answers = compile_with(replace(how, targets=("glsl",)))
        results = _add_verdicts(results, answers, how.driver_name)
    return results


def _find_shaders(
    paths: Sequence[str], stage: str | None, includes: Sequence[Path]
) -> tuple[list[ShaderFile], tuple[str, ...]]:
    """Return the shaders at these paths, and the folders that they include from."""
    from shaderlab.engine.catalogue import data_folder
    from shaderlab.engine.settings import load_settings

    shipped = data_folder("shaders").resolve()
    shared.note_other_languages(map(Path, paths))
    shaders = find_shaders(paths, [shipped], stage=stage)
    folders = dict.fromkeys(path if path.is_dir() else path.parent for path in map(Path, paths))
    own = [each for folder in folders for each in load_settings(folder).shader_folders(folder)]
    return shaders, tuple(map(str, dict.fromkeys([*includes, *own, shipped])))


def _add_verdicts(
    results: Iterator[FileResult], answers: Iterator[FileResult], driver: str
) -> Iterator[FileResult]:
    """The results with another driver's verdict on each; where it died, that is its verdict."""
    for result, answer in zip(results, answers, strict=True):
        died = [replace(v, target=driver) for v in answer.verdicts if v.status in _DIED]
        own = [v for v in answer.verdicts if v.target == driver]
        yield replace(result, verdicts=(*result.verdicts, *(own or died)))


def _print_results(
    results: Iterator[FileResult], json_file: str | None, outputs: Mapping[str, str], quiet: bool
) -> "tuple[Tally, list[ShaderlabError]]":
    """Print each result as it comes, then the summary; write all as JSON to `json_file`, and
    what is wrong to `outputs`. Returns what can't be written as well."""
    tally = Tally()
    entries: list[dict[str, Any]] = []
    found: list[Finding] = []
    to_stderr = shared.uses_stdout({**outputs, "json": json_file})
    for result in results:
        for line in format_messages(result):
            click.echo(line, err=to_stderr)
        tally.add(result)
        if json_file is not None:
            entries += make_entries(result)
        if outputs:
            found += collect_verdict_findings(result.verdicts, result.path)
    if not quiet:
        for line in tally.lines():
            click.echo(line, err=to_stderr)
    if json_file is not None:
        shared.write_json({"files": entries}, json_file)
    return tally, list(shared.write_findings(found, "compile", outputs))


def _show_progress(results: Iterator[FileResult], count: int, quiet: bool) -> Iterator[FileResult]:
    """Yield the results; for many files, with a progress bar where standard error is a terminal."""
    if quiet or count < _FEW or not sys.stderr.isatty():
        yield from results
        return
    from rich.console import Console  # takes as long as compiling fifty files
    from rich.progress import Progress

    console, redirects = Console(stderr=True), sys.stdout.isatty()  # a pipe gets its messages
    with Progress(console=console, transient=True, redirect_stdout=redirects) as progress:
        yield from progress.track(results, total=count, description="compiling")


def _parse_macro(word: str) -> tuple[str, str]:
    name, equals, value = word.partition("=")
    return name, value if equals else "1"


class Tally:
    """How many files each target accepted and refused, and on how many it gave no answer."""

    def __init__(self) -> None:
        self.targets: dict[str, Counter[str]] = {}
        self.refused = 0

    def add(self, result: FileResult) -> None:
        self.refused += not result.ok
        for verdict in result.verdicts:
            counts = self.targets.setdefault(verdict.target, Counter())
            kind = verdict.status if verdict.status in _DIED else ""
            counts[kind or ("accepted" if verdict.ok else "refused")] += 1
            counts["disagrees"] += verdict.status == "disagrees"

    def lines(self) -> Iterator[str]:
        """A table by target; without columns for crashes, timeouts and such if there were none."""
        rare = [
            kind
            for kind in ("crash", "timeout", "disagrees")
            if any(counts[kind] for counts in self.targets.values())
        ]
        columns = ["accepted", "refused", *rare]
        yield f"{'target':<14}" + "".join(f"{column:>10}" for column in columns)
        for target, counts in self.targets.items():
            yield f"{target:<14}" + "".join(f"{counts[column]:>10}" for column in columns)


def format_messages(result: FileResult) -> Iterator[str]:
    """Each message once, with its targets unless all of them have it."""
    targets_of: dict[str, list[str]] = {}
    for verdict in result.verdicts:
        for diagnostic in dict.fromkeys(verdict.diagnostics):
            targets_of.setdefault(format_diagnostic(diagnostic), []).append(verdict.target)
    for line, targets in targets_of.items():
        few = len(targets) < len(result.verdicts)
        yield f"{line} [{', '.join(targets)}]" if few else line


def make_entries(result: FileResult) -> Iterator[dict[str, Any]]:
    """An entry of the JSON for each target's verdict on the file."""
    for verdict in result.verdicts:
        said = dataclasses.asdict(verdict)
        del said["assembly"]
        yield {"path": result.path, "stage": result.stage, **said}
