"""Where the command line puts what it makes: run folders, the pointer to the latest, outputs."""

from __future__ import annotations

import contextlib
import datetime
import itertools
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from shaderlab.cli import FAILED, OK, USAGE
from shaderlab.cli.old_runs import mark_named, require_no_foreign_page
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import NO_ROOM, replacing, write_named
from shaderlab.report.formats import FINDING_FORMATS, FORMATS, Format

if TYPE_CHECKING:
    from shaderlab.model.records import Run
    from shaderlab.report.findings import Finding

REPORTS = Path("reports")
LATEST = "latest"
SUMMARY_VARIABLE = "GITHUB_STEP_SUMMARY"
Command = TypeVar("Command", bound=Callable[..., Any])


def new_run_folder(parent: Path = REPORTS) -> Path:
    """Make a new folder named by the time; runs that start together get different ones.

    On a full disk it is not made: what is run needs no file, and each file that can't be written
    is told.
    """
    stamp = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    for number in itertools.count(1):
        folder = parent / (stamp if number == 1 else f"{stamp}-{number}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            if not parent.is_dir():
                raise UsageError("this is not a folder", file=parent) from None
            continue
        except OSError as error:
            if error.errno not in NO_ROOM:
                raise _unwritable(parent, error, "name another folder: --report DIR") from error
        return folder
    raise AssertionError("unreachable")


def report_folder(folder: Path) -> Path:
    """Make the folder of `--report`, which may exist already; not on a full disk.

    Raises:
        UsageError: it can't be made, or has a page that is no report.
    """
    require_no_foreign_page(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        if error.errno not in NO_ROOM:
            raise _unwritable(folder, error, "name another folder") from error
    mark_named(folder)
    return folder


def latest(folder: Path) -> None:
    """Point `latest` beside `folder` to it, where the file system has symbolic links."""
    with contextlib.suppress(OSError), replacing(folder.parent / LATEST) as link:
        link.symlink_to(folder.name, target_is_directory=True)


def find_latest(parent: Path = REPORTS) -> Path:
    """The latest run's folder: what `latest` points to, else the last one by name.

    Raises:
        UsageError: there is no run.
    """
    pointer = parent / LATEST
    if (pointer / "run.json").is_file():
        return pointer.resolve()
    runs = sorted(path.parent for path in parent.glob("*/run.json"))
    if not runs:
        raise UsageError(
            f"there is no run in {parent}/", remedy="make one with: shaderlab run --all"
        )
    return runs[-1]


def output_options(command: Command) -> Command:
    """Give a command the option `--NAME FILE` for each output format.

    It gets those that were named as `outputs`, a file for each format, which `write_outputs` takes.
    """
    return _with_options(command, FORMATS)


def finding_options(command: Command) -> Command:
    """As `output_options`, for the formats of findings and `write_findings`."""
    return _with_options(command, FINDING_FORMATS)


def _with_options(command: Command, formats: Sequence[Format]) -> Command:
    def collect(context: click.Context, option: click.Parameter, file: str | None) -> None:
        outputs = context.params.setdefault("outputs", {})
        if file is not None:
            outputs[option.name] = file

    for name, help in reversed(formats):
        command = click.option(
            f"--{name}", metavar="FILE", help=help, expose_value=False, callback=collect
        )(command)
    return command


def uses_stdout(outputs: Mapping[str, str]) -> bool:
    """Whether one of the outputs goes to standard output.

    Raises:
        UsageError: several do.
    """
    names = [f"--{name}" for name, file in outputs.items() if file == "-"]
    if len(names) > 1:
        raise UsageError(f"only one of {' and '.join(names)} can go to standard output")
    return bool(names)


def write_outputs(run: Run, outputs: Mapping[str, str]) -> Iterator[ShaderlabError]:
    """Write each output of a run; yields an error for each that can't be written."""
    yield from _written(FORMATS, outputs, lambda format: format.render(run))


def write_findings(
    findings: Sequence[Finding], command: str, outputs: Mapping[str, str]
) -> Iterator[ShaderlabError]:
    """As `write_outputs`, for what a command found."""
    yield from _written(FINDING_FORMATS, outputs, lambda f: f.render_findings(findings, command))


def _written(
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


def tell(problems: Sequence[ShaderlabError]) -> int:
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
    """Write text to the file that a person named, or after what is in it; to standard output for
    "-"."""
    if file == "-":
        click.echo(text, nl=False)
        return
    if append:  # what is there may lack the end of its last line
        text = f"\n{text}"
    try:
        write_named(file, text.encode("utf-8", errors="replace"), append=append)
    except OSError as error:
        raise _unwritable(Path(file), error) from error


def _unwritable(path: Path, error: OSError, remedy: str | None = None) -> UsageError:
    return UsageError(f"can't write here: {error.strerror or error}", file=path, remedy=remedy)
