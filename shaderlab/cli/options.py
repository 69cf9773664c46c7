"""What several commands share: options, the executor that they describe, run folders, outputs."""

from __future__ import annotations

import contextlib
import dataclasses
import datetime
import errno
import fcntl
import functools
import itertools
import json
import os
import re
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from shaderlab import files
from shaderlab.analysis import CHECKING_WORK
from shaderlab.cli import FAILED, OK, USAGE
from shaderlab.compiler.shader_files import STAGES
from shaderlab.engine import jobs
from shaderlab.errors import ShaderlabError, UsageError, suggest
from shaderlab.model.options import Limits
from shaderlab.report.formats import FINDING_FORMATS, FORMATS, Format

if TYPE_CHECKING:
    from shaderlab.analysis.requests import ShaderOfFile
    from shaderlab.model.records import Run
    from shaderlab.report.findings import Finding


Command = TypeVar("Command", bound=Callable[..., Any])

INCLUDE = click.option(
    "--include",
    "-I",
    "includes",
    multiple=True,
    type=click.Path(path_type=Path, exists=True, file_okay=False, resolve_path=True),
    metavar="DIR",
    help='Also search DIR for shaders and for #include "…"; may be repeated.',
)
TARGET = click.option(
    "--target",
    "-t",
    "compile_targets",
    multiple=True,
    metavar="T",
    callback=lambda context, option, names: _check_targets(names),
    help="Compile for this target only (glsl, opengl, vulkan, vulkan-strict); may be repeated.",
)
JSON = click.option(
    "--json", "json_file", metavar="FILE", help="Write results as JSON; - writes to stdout."
)
DRIVER = click.option(
    "--driver",
    metavar="NAME",
    callback=lambda context, option, name: name if name is None else jobs.check_driver(name),
    help="OpenGL: llvmpipe, softpipe, llvmpipe-spirv (loads SPIR-V modules) or default (the "
    "machine's own driver); Vulkan: lavapipe, swiftshader or vulkan (the machine's own); webgl2 "
    "for headless Chromium.  [default: llvmpipe]",
)


def _check_targets(names: tuple[str, ...]) -> tuple[str, ...]:
    if names:
        from shaderlab.compiler.glslang import ALL_TARGETS

        for name in names:
            if name not in ALL_TARGETS:
                raise UsageError(f"there is no target {name!r}", remedy=suggest(name, ALL_TARGETS))
    return tuple(dict.fromkeys(names))


def report_option(help: str) -> Callable[[Command], Command]:
    """Add `--report DIR`, the folder of a run."""
    return click.option("--report", "folder", metavar="DIR", help=help)


def stage_option(help: str) -> Callable[[Command], Command]:
    """Add `--stage NAME`."""
    return click.option("--stage", type=click.Choice(STAGES), help=help)


def variants_option(help: str) -> Callable[[Command], Command]:
    """Add `--variant V`, given as `variants`."""
    return click.option("--variant", "variants", multiple=True, metavar="V", help=help)


def jobs_option(default: str = jobs.WORDS) -> Callable[[Command], Command]:
    """Add `--jobs N`, given as `workers`; None leaves the number to the lab."""
    return click.option(
        "-j",
        "--jobs",
        "workers",
        type=click.IntRange(min=0),
        default=int(default) if default.isdigit() else None,
        show_default=default,
        envvar="SHADERLAB_JOBS",
        metavar="N",
        help="Run in N worker processes; 0 runs in-process, without isolation or limits.",
    )


def collect(kind: type[Any], parameter: str) -> Callable[[Command], Command]:
    """Pass the options that are fields of a dataclass to a command as one value, `parameter`."""
    names = [field.name for field in dataclasses.fields(kind)]

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def collected(**values: Any) -> Any:
            value = kind(**{name: values.pop(name) for name in names})
            return command(**values, **{parameter: value})

        decorated: Any = collected
        return decorated  # type: ignore[no-any-return]

    return decorate


def limits_option(help: str, seconds: float = Limits.seconds) -> Callable[[Command], Command]:
    """Add `--timeout S` and `--memory GB`, given as `limits`."""
    timeout = click.option(
        "--timeout",
        "seconds",
        type=click.FloatRange(min=0.0, min_open=True),
        default=seconds,
        show_default=True,
        metavar="S",
        help=help,
    )
    memory = click.option(
        "--memory",
        "gigabytes",
        type=click.FloatRange(min=0.0),
        default=Limits.gigabytes,
        show_default=True,
        metavar="GB",
        help="Limit the memory of each worker; 0 sets no limit.",
    )
    return lambda command: timeout(memory(collect(Limits, "limits")(command)))


def make_executor(
    driver: str | None,
    limits: Limits,
    workers: int | None,
    *,
    early: bool = True,
    files_only: bool = False,
) -> jobs.Executor:
    """Return an executor on this machine: in this process for 0 workers. `files_only` if it is
    asked about shader files alone, which takes no driver."""
    work = jobs.FILE_WORK if files_only else CHECKING_WORK
    if workers == 0:
        return jobs.InProcessExecutor(driver, work)
    return jobs.ProcessExecutor(driver, limits, workers, early=early and not files_only, work=work)


def perform_one(executor: jobs.Executor, request: Any) -> Any:
    """Return the result of one request. Raises ShaderlabError."""
    (result,) = executor.perform([request])
    if isinstance(result.value, ShaderlabError):
        raise result.value
    if result.status != "done":
        ranges = ", or state ranges for shorter loops: --range NAME=A:B"
        raise ShaderlabError(jobs.describe_failure(result) + ranges * (result.status == "timeout"))
    return result.value


def _parse_range(word: str) -> tuple[str, str]:
    name, equals, values = word.partition("=")
    if not equals:
        raise UsageError(f"--range {word}", remedy="write --range NAME=A:B or NAME=unit")
    return name.strip(), values.strip()


RANGES = click.option(
    "--range",
    "ranges",
    multiple=True,
    metavar="NAME=A:B",
    callback=lambda context, option, words: dict(map(_parse_range, words)),
    help="Vary an input from A to B; NAME=unit makes it a unit vector. May be repeated.",
)


def resolve_shader(
    path: Path, includes: Sequence[Path], then: Callable[[Path], Path] | None = None
) -> ShaderOfFile:
    """Return a shader file with the folders that it includes from.

    `then` maps paths to those of an earlier revision. Raises UsageError: there is no such file, or
    it is a folder."""
    if path.is_dir():
        raise UsageError("this is a folder; name a shader file", file=path)
    (found,) = resolve_shaders([path], includes, then)
    return found


def resolve_shaders(
    paths: Sequence[Path], includes: Sequence[Path], then: Callable[[Path], Path] | None = None
) -> list[ShaderOfFile]:
    """Return the shader files at these paths and in these folders, as `resolve_shader` does."""
    from shaderlab.analysis.requests import ShaderOfFile
    from shaderlab.compiler.shader_files import find_shaders
    from shaderlab.engine.catalogue import data_folder
    from shaderlab.engine.settings import load_settings

    shipped = data_folder("shaders").resolve()
    note_other_languages(paths)
    found = []
    for path in paths:
        folder = path if path.is_dir() else path.parent
        own = load_settings(folder).shader_folders(folder)
        folders = tuple(str(then(f) if then else f) for f in [*includes, *own, shipped])
        shaders = find_shaders([then(path) if then else path], [shipped])
        found += [ShaderOfFile(file, folders) for file in shaders]
    return found


def note_other_languages(paths: Iterable[Path]) -> None:
    """Say how many files in these folders are left out, since they are in another language."""
    from shaderlab.compiler.shader_files import find_other_languages

    for path in filter(Path.is_dir, paths):
        if others := find_other_languages(path):
            more = f" and {len(others) - 1} more" if others[1:] else ""
            first = files.display_path(others[0])
            click.echo(f"shaderlab: not read, another language: {first}{more}", err=True)


FILE_NAME = "records.jsonl"
"""The journal of a run, in its folder."""
REPORTS = Path("reports")
LATEST = "latest"
SUMMARY_VARIABLE = "GITHUB_STEP_SUMMARY"


def make_run_folder(parent: Path = REPORTS) -> Path:
    """Make a new folder named by the time; runs that start together get different ones."""
    stamp = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    names = itertools.chain([stamp], (f"{stamp}-{number}" for number in itertools.count(2)))
    while True:
        folder = parent / next(names)
        try:
            folder.mkdir(parents=True)
            (folder / files.REPORT_MARK).touch()
            return folder
        except FileExistsError:
            if not parent.is_dir():
                raise UsageError("this is not a folder", file=parent) from None
        except OSError as error:
            raise _unwritable_error(parent, error, "name another folder: --report DIR") from error


def make_report_folder(folder: Path) -> Path:
    """Make the folder of `--report`. Raises UsageError: it can't be made, or has other files."""
    try:
        files.claim_folder(folder)
    except OSError as error:
        raise _unwritable_error(folder, error, "name another folder") from error
    mark_named(folder)
    return folder


def point_latest(folder: Path) -> None:
    """Point `latest` beside `folder` to it, where the file system has symbolic links."""
    with contextlib.suppress(OSError), files.replace_file(folder.parent / LATEST) as link:
        link.symlink_to(folder.name, target_is_directory=True)


def find_latest(parent: Path = REPORTS) -> Path:
    """The latest run's folder: what `latest` points to, else the last one by name. Raises
    UsageError: there is no run."""
    pointer = parent / LATEST
    if (pointer / "run.json").is_file():
        return pointer.resolve()
    runs = sorted(path.parent for path in parent.glob("*/run.json"))
    if not runs:
        raise UsageError(
            f"there is no run in {parent}/", remedy="start one with: shaderlab run --all"
        )
    return runs[-1]


def output_options(command: Command, formats: Sequence[Format] | None = None) -> Command:
    """Give a command the option `--NAME FILE` for each output format.

    It gets those that were named as `outputs`, a file for each format, which `write_outputs` takes.
    """

    def collect(context: click.Context, option: click.Parameter, file: str | None) -> None:
        outputs = context.params.setdefault("outputs", {})
        if file is not None:
            outputs[option.name] = file

    for format in reversed(FORMATS if formats is None else formats):
        command = click.option(
            f"--{format.name}",
            metavar="FILE",
            help=format.help,
            expose_value=False,
            callback=collect,
        )(command)
    return command


def finding_options(command: Command) -> Command:
    """As `output_options`, for the formats of findings and `write_findings`."""
    return output_options(command, FINDING_FORMATS)


def uses_stdout(outputs: Mapping[str, str | None]) -> bool:
    """Whether one of the outputs goes to standard output. Raises UsageError: several do."""
    names = [f"--{name}" for name, file in outputs.items() if file == "-"]
    if len(names) > 1:
        raise UsageError(f"only one of {' and '.join(names)} can go to standard output")
    return bool(names)


def write_outputs(run: Run, outputs: Mapping[str, str]) -> Iterator[ShaderlabError]:
    """Write each output of a run; yields an error for each that can't be written."""
    yield from _write_formats(FORMATS, outputs, lambda format: format.render(run))


def write_findings(
    findings: Sequence[Finding], command: str, outputs: Mapping[str, str]
) -> Iterator[ShaderlabError]:
    """As `write_outputs`, for what a command found."""
    yield from _write_formats(
        FINDING_FORMATS, outputs, lambda f: f.render_findings(findings, command)
    )


def _write_formats(
    formats: Sequence[Format], outputs: Mapping[str, str], text: Callable[[Format], str]
) -> Iterator[ShaderlabError]:
    for format in formats:
        if format.name in outputs:
            try:
                file = outputs[format.name]
                write_output(text(format), file, append=_is_summary(file))
            except ShaderlabError as error:
                yield error


def _is_summary(file: str) -> bool:
    """Whether a file is the summary of a CI job, to which each step adds its own."""
    summary = os.environ.get(SUMMARY_VARIABLE, "")
    return bool(summary) and os.path.realpath(file) == os.path.realpath(summary)


def report_problems(problems: Sequence[ShaderlabError]) -> int:
    """Say what could not be written; returns the exit status that follows from it."""
    for problem in problems:
        click.echo(f"shaderlab: {problem}", err=True)
    if not problems:
        return OK
    return USAGE if isinstance(problems[0], UsageError) else FAILED


def write_json(data: Mapping[str, Any] | Sequence[Any], file: str) -> None:
    """Write `data` to the file that a person named, or to standard output for "-"."""
    write_output(json.dumps(data, indent=2, ensure_ascii=False) + "\n", file)


def write_output(text: str, file: str, *, append: bool = False) -> None:
    """Write text to the file that a person named, or append it; to standard output for "-"."""
    if file == "-":
        click.echo(text, nl=False)
        return
    if append:  # what is there may lack the end of its last line
        text = f"\n{text}"
    else:
        require_output_of_kind(Path(file), text)
    try:
        files.write_named(file, text.encode("utf-8", errors="replace"), append=append)
    except OSError as error:
        raise _unwritable_error(Path(file), error) from error


def require_output_of_kind(path: Path, text: str) -> None:
    """Raise UsageError where a text would replace a file that is not of its kind, such as a shader
    that was named by mistake, or the record of a run."""
    try:
        there = files.read_regular(path, 200).decode("utf-8", "replace")
    except OSError:  # nothing, a terminal, or what can't be written either
        return
    old, new = map(_kind, (there, text))
    own = path.name == "run.json" and (path.parent / files.REPORT_MARK).exists()
    if own or (there and not old.startswith(new) and not new.startswith(old)):
        raise UsageError(
            "this file is no earlier output of this kind, and would be replaced",
            file=path,
            remedy="name another file, or remove this one",
        )


def _kind(text: str) -> str:
    found = _KIND.match("".join(text[:200].split()).replace("[]", "[{"))
    return found[1] if found else ""


def _unwritable_error(path: Path, error: OSError, remedy: str | None = None) -> UsageError:
    said = "nothing reads from it" if error.errno == errno.ENXIO else error.strerror or error
    remedy = files.suggest_limit(error, remedy)
    return UsageError(f"can't write here: {said}", file=path, remedy=remedy)


KEEP = 20
"""How many runs stay where the project does not say."""
NAMED = ".named"
_STAMP = re.compile(r"\d{8}-\d{6}(-\d+)?")
# How an output begins, by which another one of its kind is known; white space does not count.
_KIND = re.compile(r'(?:<\?xml.*?\?>)?(##|<!doctypehtml><htmllang="en"data-root|\W*\w*)')


def mark_named(folder: Path) -> None:
    """Note that somebody named this run's folder, so that it is never removed."""
    if _STAMP.fullmatch(folder.name):
        with contextlib.suppress(OSError):
            (folder / NAMED).touch()


def remove_old_runs(parent: Path, keep: int) -> int:
    """Remove all but the last `keep` of the runs that the lab named by their time; 0 keeps all.

    Folders of other names, those that were named on a command line, links, runs that are going on
    and folders without a journal stay, and don't count. Returns how many were removed.
    """
    if not keep:
        return 0
    with contextlib.suppress(OSError):
        runs = sorted(filter(_is_removable, parent.iterdir()), key=lambda run: run.stat().st_mtime)
        for run in runs[:-keep]:
            shutil.rmtree(run, ignore_errors=True)
        return len(runs[:-keep])
    return 0


def _is_removable(folder: Path) -> bool:
    made = _STAMP.fullmatch(folder.name) and not folder.is_symlink() and folder.is_dir()
    journal = folder / FILE_NAME
    if not made or (folder / NAMED).exists() or not journal.is_file():
        return False
    try:
        with journal.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # another process is writing to it
        return False
    return True
