"""`shaderlab run`: run scenes, show outcomes, write the report."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from shaderlab.cli.files import latest, output_options, write_outputs
from shaderlab.errors import ShaderlabError
from shaderlab.running.jobs import DEFAULT_GIGABYTES, DEFAULT_SECONDS
from shaderlab.running.sizing import WORDS

if TYPE_CHECKING:
    from shaderlab.cli.requesting import Request
    from shaderlab.records import Run


@click.command("run", short_help="Run cases, judge them, write the report.")
@click.argument("targets", nargs=-1, metavar="[ID | FILE.py | FOLDER]…")
@click.option("--all", "every", is_flag=True, help="Every case that comes with shaderlab.")
@click.option("--variant", "variants", multiple=True, metavar="V", help="Only this variant.")
@click.option(
    "--size",
    type=click.IntRange(1, 4096),
    default=64,
    show_default=True,
    metavar="N",
    help="Judge N × N pixels, where a case does not set a size itself.",
)
@click.option(
    "--shader",
    "shaders",
    multiple=True,
    metavar="NAME=FILE",
    help="Judge FILE in place of the shader called NAME: its path, or the end of it.",
)
@output_options
@click.option(
    "--report",
    "folder",
    metavar="DIR",
    help="Write the report into DIR instead of a new folder in reports/.",
)
@click.option(
    "--timeout",
    "seconds",
    type=click.FloatRange(min=0.1),
    default=DEFAULT_SECONDS,
    show_default=True,
    metavar="S",
    help="Give one variant up after S seconds.",
)
@click.option(
    "--memory",
    "gigabytes",
    type=click.FloatRange(min=0.0),
    default=DEFAULT_GIGABYTES,
    show_default=True,
    metavar="GB",
    help="Memory that one worker may have; 0 for any amount.",
)
@click.option(
    "-j",
    "--jobs",
    "workers",
    type=click.IntRange(min=0),
    default=None,
    show_default=WORDS,
    envvar="SHADERLAB_JOBS",
    metavar="N",
    help="Run in N worker processes; 0 for none, which isolates nothing.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Run on the Dask cluster of this scheduler, such as tcp://host:8786, in place of -j.",
)
@click.option(
    "--driver",
    metavar="NAME",
    help="llvmpipe, softpipe, or default for the machine's own.  [default: llvmpipe]",
)
@click.option(
    "--drivers",
    metavar="A,B",
    help="Run on each of these drivers, and show where they disagree.",
)
@click.option(
    "--resume",
    is_flag=False,
    flag_value="",
    metavar="[FOLDER]",
    help="Go on with the run in FOLDER (the last one) that did not get to its end.",
)
@click.option(
    "--pictures/--no-pictures", default=True, help="Draw pictures for the report, or only judge."
)
@click.option("--profile", is_flag=True, help="Show where the time went.")
@click.option("--open", "open_report", is_flag=True, help="Open the report in a browser.")
def command(open_report: bool, **asked: Any) -> None:
    """Run cases: compile, draw, judge every pixel, and write a report.

    A case is named by its id, by its id and a variant, or by its file; a folder stands for all
    case files below it.

    \b
    Examples:
      shaderlab run attenuation spotlight
      shaderlab run 'attenuation[50]'               one variant
      shaderlab run --all --json out.json           for other programs
      shaderlab run ./my_case.py --open             a case of your own
      shaderlab run gamma --shader gamma.frag=mine.frag
      shaderlab run --all --drivers llvmpipe,softpipe
      shaderlab run --resume                        after Ctrl-C or a power cut
      shaderlab run --all --scheduler tcp://host:8786

    Each variant runs in a worker process. One that crashes or takes too long is a "crash" or
    "timeout" of that variant, and everything else is run.

    With --scheduler (pip install 'shaderlab[cluster]') the processes are on the workers of a Dask
    cluster, which need the same versions and nothing else: a case of your own is sent with
    everything in its tree, records and pictures come back into the run's folder here.

    Exit code: 0 all passed, 1 something failed, 2 wrong usage. A case that needs a feature which
    this driver lacks is "unsupported", which is no failure.
    """
    from shaderlab.cli.requesting import Request

    request = Request(**asked)
    team = request.team()  # its workers get ready while what follows is imported
    try:
        from shaderlab.cli.performing import finish
        from shaderlab.report.plain_text import failed

        performed, show = finish(request, team)
        show.outcomes(performed.run)
        show.disagreements(performed.run)
        if request.profile:
            show.profile(performed.run)
        page, problems = write_all(performed.run, performed.folder, request)
        problems += performed.unread
    finally:
        team.close()
    if request.folder is None and request.resume is None:
        latest(performed.folder)
    if page is not None:
        show.where(page)
    for problem in problems[1:]:
        click.echo(f"shaderlab: {problem}", err=True)
    if problems:
        raise problems[0]
    if open_report and page is not None:
        click.launch(page.resolve().as_uri())
    if not performed.complete:
        show.go_on(performed.folder)
        raise KeyboardInterrupt
    records = performed.run.records
    others = any(result.status not in ("pass", "unsupported") for result in performed.run.drivers)
    if others or any(failed(r) for r in records) or not any(r.status == "pass" for r in records):
        raise SystemExit(1)


def write_all(run: Run, folder: Path, request: Request) -> tuple[Path | None, list[ShaderlabError]]:
    """Write the run, its page and its outputs; return what can't be written."""
    from shaderlab.report import html, store

    problems: list[ShaderlabError] = []
    page: Path | None = None
    with _collected(problems):
        store.save(run, folder)
    with _collected(problems):
        page = html.write(run, folder)
    problems += write_outputs(run, request.outputs)
    return page, problems


@contextlib.contextmanager
def _collected(problems: list[ShaderlabError]) -> Iterator[None]:
    try:
        yield
    except ShaderlabError as error:
        problems.append(error)
