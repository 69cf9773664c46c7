"""Where the command line puts what it makes: run folders, the pointer to the latest, outputs; and
standard streams that a full disk can't break.
"""

from __future__ import annotations

import codecs
import contextlib
import datetime
import errno
import fcntl
import io
import itertools
import json
import os
import re
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO, TypeVar

import click

from shaderlab.cli import FAILED, OK, USAGE
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import NO_ROOM, replace_file, reserve_standard_descriptors, write_named
from shaderlab.report.formats import FINDING_FORMATS, FORMATS, Format

if TYPE_CHECKING:
    from shaderlab.model.records import Run
    from shaderlab.report.findings import Finding


FILE_NAME = "records.jsonl"
"""The journal of a run, in its folder."""
REPORTS = Path("reports")
LATEST = "latest"
SUMMARY_VARIABLE = "GITHUB_STEP_SUMMARY"
Command = TypeVar("Command", bound=Callable[..., Any])


def make_run_folder(parent: Path = REPORTS) -> Path:
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
                raise _unwritable_error(
                    parent, error, "name another folder: --report DIR"
                ) from error
        return folder
    raise AssertionError("unreachable")


def make_report_folder(folder: Path) -> Path:
    """Make the folder of `--report`, which may exist already; not on a full disk.

    Raises:
        UsageError: it can't be made, or has a page that is no report.
    """
    require_no_foreign_page(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        if error.errno not in NO_ROOM:
            raise _unwritable_error(folder, error, "name another folder") from error
    mark_named(folder)
    return folder


def point_latest(folder: Path) -> None:
    """Point `latest` beside `folder` to it, where the file system has symbolic links."""
    with contextlib.suppress(OSError), replace_file(folder.parent / LATEST) as link:
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
            f"there is no run in {parent}/", remedy="start one with: shaderlab run --all"
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

    for format in reversed(formats):
        command = click.option(
            f"--{format.name}",
            metavar="FILE",
            help=format.help,
            expose_value=False,
            callback=collect,
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
        raise _unwritable_error(Path(file), error) from error


def _unwritable_error(path: Path, error: OSError, remedy: str | None = None) -> UsageError:
    return UsageError(f"can't write here: {error.strerror or error}", file=path, remedy=remedy)


KEEP = 20
"""How many runs stay where the project does not say."""
NAMED = ".named"
_STAMP = re.compile(r"\d{8}-\d{6}(-\d+)?")
_OWN_FILES = (FILE_NAME, "run.json", "mutants.json")


def mark_named(folder: Path) -> None:
    """Note that somebody named this run's folder, so that it is never removed."""
    if _STAMP.fullmatch(folder.name):
        with contextlib.suppress(OSError):
            (folder / NAMED).touch()


def require_no_foreign_page(folder: Path) -> None:
    """Raise UsageError where a report would replace an index.html that is none."""
    page = folder / "index.html"
    if page.exists() and not any((folder / name).exists() for name in _OWN_FILES):
        from shaderlab.report.html import is_run_list

        if is_run_list(page):
            return
        raise UsageError(
            "this page is not a shaderlab report, and a report would replace it",
            file=page,
            remedy="name another folder with --report, or remove the page",
        )


def remove_old_runs(parent: Path, keep: int) -> int:
    """Remove all but the last `keep` of the runs that the lab named by their time; 0 keeps all.

    Folders of other names, those that were named on a command line, links, runs that are going on
    and folders without a journal stay, and don't count.

    Returns:
        How many were removed.
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


_PLAIN = {"✓": "+", "✗": "x", "–": "-", "→": "->", "…": "...", "·": "-", "×": "x", "≤": "<="}
"""What stands for a character in an encoding without it; "?" for all others."""


def _replace_characters(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(_PLAIN.get(character, "?") for character in lacking), error.end


codecs.register_error("shaderlab.plainly", _replace_characters)


class _Lasting(io.FileIO):
    """Writes to a descriptor; what can't be written is lost, and `problem` says why."""

    problem: OSError | None = None

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError as error:
            self.problem = error
            return len(data)


def open_lasting(stream: TextIO) -> TextIO:
    """A text stream to the same descriptor to which writing never fails.

    Characters that its encoding lacks are written in plain ones: a terminal without ✓ gets a "+".
    """
    raw = _Lasting(stream.fileno(), "wb", closefd=False)
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors="shaderlab.plainly",
        line_buffering=getattr(stream, "line_buffering", False),
    )


def find_lost_output(stream: TextIO) -> str:
    """Why something written to a `lasting` stream was lost; "" if nothing was, or if its reader
    has gone and so wants no more."""
    stream.flush()
    raw = getattr(getattr(stream, "buffer", None), "raw", None)
    found = raw.problem if isinstance(raw, _Lasting) else None
    return "" if found is None or found.errno == errno.EPIPE else found.strerror or str(found)


def open_streams() -> None:
    """Make this process's standard streams last, and keep their numbers from being given to
    files where they are closed."""
    reserve_standard_descriptors()
    for name in ("stdout", "stderr"):
        with contextlib.suppress(AttributeError, OSError):  # none, or none of the system's
            setattr(sys, name, open_lasting(getattr(sys, name)))


def final_status(status: str | int | None) -> str | int | None:
    """The exit status, which is no success where output was lost; says so on standard error."""
    lost = find_lost_output(sys.stdout) if sys.stdout is not None else ""
    if not lost:
        return status
    print(f"shaderlab: can't write to standard output: {lost}", file=sys.stderr)
    return status or FAILED
