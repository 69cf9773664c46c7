"""`shaderlab sweep`: one case over a grid of inputs, as a table and as plots."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from shaderlab.cli.files import latest, new_run_folder, report_folder
from shaderlab.errors import UsageError
from shaderlab.running.jobs import DEFAULT_GIGABYTES, DEFAULT_SECONDS
from shaderlab.running.sizing import WORDS

if TYPE_CHECKING:
    from shaderlab.cli.performing import Performed
    from shaderlab.cli.requesting import Request
    from shaderlab.cli.showing import Show
    from shaderlab.running import Team
    from shaderlab.running.journal import Heading

TABLE = "sweep.csv"


@click.command("sweep", short_help="Run one case over a grid of inputs; a table and plots.")
@click.argument("target", required=False, metavar="ID | ID[VARIANT] | FILE.py")
@click.option(
    "--param", "params", multiple=True, metavar="NAME=VALUES",
    help="A uniform or ramp and its values: A:B:N, A:B:Nlog or A,B,C. Several span a grid.",
)  # fmt: skip
@click.option(
    "--table", metavar="FILE", help=f"Write the table here: .csv or .parquet.  [default: {TABLE}]"
)
@click.option("--report", "folder", metavar="DIR", help="The run's folder.  [default: a new one]")
@click.option(
    "--timeout", "seconds", type=click.FloatRange(min=0.1), default=DEFAULT_SECONDS,
    show_default=True, metavar="S", help="Give one point up after S seconds.",
)  # fmt: skip
@click.option(
    "--memory", "gigabytes", type=click.FloatRange(min=0.0), default=DEFAULT_GIGABYTES,
    show_default=True, metavar="GB", help="Memory that one worker may have; 0 for any amount.",
)  # fmt: skip
@click.option(
    "-j", "--jobs", "workers", type=click.IntRange(min=0), default=None, show_default=WORDS,
    envvar="SHADERLAB_JOBS", metavar="N", help="Run in N worker processes; 0 for none.",
)  # fmt: skip
@click.option("--scheduler", metavar="ADDRESS", help="Run on a Dask cluster; see `run --help`.")
@click.option("--driver", metavar="NAME", help="llvmpipe, softpipe, or default.")
@click.option(
    "--resume", metavar="FOLDER", help="Go on with the sweep in FOLDER that did not get to its end."
)
@click.option("--pictures/--no-pictures", default=False, help="Draw pictures of each point.")
def command(target: str | None, params: tuple[str, ...], table: str | None, **asked: Any) -> None:
    """Run one case at every point of a grid, and see where its formulas come near their bands.

    NAME is a uniform, a member of a uniform block, or a ramp (which then has that value on the
    whole screen), spelt as the case spells it, or `size`: the side in pixels of the judged frame.
    Everything else stays as the variant has it, without one as the first. VALUES are

    \b
      0:1:11          11 values from 0 to 1, equally spaced
      0.01:1:50log    50 values from 0.01 to 1, in equal ratios
      7,13,20         these values

    \b
    Examples:
      shaderlab sweep attenuation --param light.linear=0.01:1:50log --param size=64,256,1024
      shaderlab sweep 'blinn-phong[shininess 8]' --param shininess=1:1024:11log --table s.parquet
      shaderlab sweep attenuation --param light.quadratic=0:2:40 --scheduler tcp://host:8786

    The table has a row for each point: the parameters, status, the worst distance in half band
    widths (up to 1 is inside) and in ULP, how many values are outside and how many were judged,
    the share of bands that allow anything, and seconds by phase. Only formulas are judged: a
    case's figures hold for its own inputs.

    Exit code: 0 every point passed, 1 one did not, 2 wrong usage.
    """
    from shaderlab.cli.requesting import Request

    if table is not None:
        from shaderlab.report import table as tables

        tables.check(Path(table))
    request = Request(**asked)
    team = request.team()
    try:
        performed, heading, show = _performed(request, team, target, params)
    finally:
        team.close()
    performed = _told(performed, heading, show, table, request)
    if not performed.complete:
        click.echo(f"go on with: shaderlab sweep --resume {performed.folder}")
        raise KeyboardInterrupt
    from shaderlab.report.plain_text import failed

    if any(failed(record) for record in performed.run.records):
        raise SystemExit(1)


def _performed(
    request: Request, team: Team, target: str | None, params: Sequence[str]
) -> tuple[Performed, Heading, Show]:
    from shaderlab.cli.performing import perform
    from shaderlab.cli.showing import Show
    from shaderlab.records import Record
    from shaderlab.report.html import load_libraries
    from shaderlab.running.journal import Journal, read

    load_libraries()
    show = Show()
    done: list[Record] = []
    if request.resume is not None:
        if target or params:
            raise UsageError("--resume runs what was asked for then: name nothing else")
        folder = Path(request.resume)
        heading, done = read(folder)
        if not all(job.point for job in heading.jobs):
            raise UsageError("this is no sweep", file=folder, remedy="use shaderlab run --resume")
        heading = replace(heading, setup=replace(heading.setup, folder=folder))
    else:
        heading = _begun(request, team, target, params)
    assert heading.setup.folder is not None
    new = heading if request.resume is None else None
    with Journal(heading.setup.folder, new) as journal:
        return perform(team, heading, journal, done, show), heading, show


def _begun(request: Request, team: Team, target: str | None, params: Sequence[str]) -> Heading:
    from shaderlab.cli.selecting import one
    from shaderlab.running import Setup
    from shaderlab.running.grid import grid, parameters
    from shaderlab.running.journal import Heading

    if target is None:
        raise UsageError("nothing to sweep", remedy="name a case; `shaderlab list` shows all")
    if not params:
        raise UsageError(
            "no parameter to sweep", remedy="such as --param light.linear=0.01:1:50log"
        )
    swept = parameters(params)
    facts, variant = one(target, team.load)
    jobs = grid(facts, variant, swept)
    folder = new_run_folder() if request.folder is None else report_folder(Path(request.folder))
    setup = Setup(
        size=request.size, folder=folder, pictures=request.pictures, driver=request.driver
    )
    now = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    return Heading(started=now, setup=setup, jobs=tuple(jobs))


def _told(
    performed: Performed, heading: Heading, show: Show, table: str | None, request: Request
) -> Performed:
    """Show what was found, and write the table and the report."""
    from shaderlab.cli.running import write_all
    from shaderlab.report.table import write_table
    from shaderlab.running.tabulating import plots, rows

    found = rows(heading.jobs, performed.run.records)
    run = replace(performed.run, plots=plots(heading.jobs, found))
    performed = replace(performed, run=run)
    show.sweep(found, run)
    file = performed.folder / TABLE if table is None else Path(table)
    write_table(found, file)
    page, problems = write_all(run, performed.folder, request)
    if request.folder is None and request.resume is None:
        latest(performed.folder)
    show.console.print(f"table: {file}", markup=False)
    if page is not None:
        show.where(page)
    for problem in problems:
        raise problem
    return performed
