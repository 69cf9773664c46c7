"""`shaderlab sweep`: one case over a grid of inputs, as a table and as plots."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from pathlib import Path

import click

from shaderlab.cli import FAILED, OK
from shaderlab.cli.options import make_executor, running_options
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.model.options import Limits, RunOptions

TABLE = "sweep.csv"


@click.command("sweep")
@click.argument("target", required=False, metavar="ID | ID[VARIANT] | FILE.py")
@click.option(
    "--param", "params", multiple=True, metavar="NAME=VALUES",
    help="A uniform or ramp and its values: A:B:N, A:B:Nlog or A,B,C. Several span a grid.",
)  # fmt: skip
@click.option(
    "--table", metavar="FILE", help=f"Write the table here: .csv or .parquet.  [default: {TABLE}]"
)
@running_options("point")
@click.option("--resume", metavar="FOLDER", help="Resume the unfinished sweep in FOLDER.")
@click.option("--pictures/--no-pictures", default=False, help="Draw pictures of each point.")
def command(
    target: str | None,
    params: tuple[str, ...],
    table: str | None,
    folder: str | None,
    includes: tuple[Path, ...],
    compile_targets: tuple[str, ...],
    limits: Limits,
    workers: int | None,
    scheduler: str | None,
    driver: str | None,
    resume: str | None,
    pictures: bool,
) -> int:
    """Run one case at every point of a grid of parameters, and see how close results come to the
    limits of their bands.

    NAME is a uniform, a member of a uniform block or a ramp, by the name that the case gives it (a
    ramp then has one value on the whole screen), or `size`: the side of the judged frame in pixels.
    All other inputs are those of the variant, by default the first. VALUES are

    \b
      0:1:11          11 values from 0 to 1, evenly spaced
      0.01:1:50log    50 values from 0.01 to 1, logarithmically spaced
      7,13,20         these values

    \b
    Examples:
      shaderlab sweep attenuation --param light.linear=0.01:1:50log --param size=64,256,1024
      shaderlab sweep 'blinn-phong[shininess 8]' --param shininess=1:1024:11log --table s.parquet
      shaderlab sweep attenuation --param light.quadratic=0:2:40 --scheduler tcp://host:8786

    The table has a row for each point: the parameters, the status, the largest distance in half
    band widths (inside up to 1) and in ULP, how many values are outside and how many were judged,
    the share of bands that allow any value, and the seconds of each phase. Only formulas are
    judged: a case's figures hold for its own inputs only.

    Exit code: 0 every point passed, 1 one did not, 2 wrong usage.
    """
    from shaderlab.report import table as tables

    if table is not None:
        tables.check(Path(table))
    options = RunOptions(
        pictures=pictures,
        include=includes,
        targets=compile_targets,
        driver=driver,
        limits=limits,
    )
    if resume is not None:
        from shaderlab.cli.recorded_run import resumed_plan

        if target or params:
            raise UsageError("--resume takes neither a case nor parameters: the sweep has its own")
        plan, _ = resumed_plan(resume, limits)
        options = plan.options
        if plan.grid is None:
            raise UsageError(
                "this run is not a sweep", file=resume, remedy="use shaderlab run --resume"
            )
    elif target is None:
        raise UsageError("no case to sweep", remedy="name a case; `shaderlab list` shows all")
    elif not params:
        raise UsageError(
            "no parameter to sweep", remedy="such as --param light.linear=0.01:1:50log"
        )
    with contextlib.closing(make_executor(options.driver, limits, workers, scheduler)) as executor:
        from shaderlab.cli.recorded_run import finish, new_plan
        from shaderlab.cli.running_sweeps import run_points, with_points
        from shaderlab.cli.selecting import one
        from shaderlab.cli.showing import Show
        from shaderlab.report.html import load_libraries
        from shaderlab.workers.journal import FILE_NAME
        from shaderlab.workers.sweep_grid import grid, parameters

        swept = parameters(params)
        load_libraries()
        show = Show()
        if target is not None:
            facts, variant = one(target, executor.load)
            plan = new_plan(grid(facts, variant, swept), options, folder)
        recorded, points = run_points(executor, plan, show, resume=resume is not None)
    show.sweep(points, recorded.run)
    file = recorded.folder / TABLE if table is None else Path(table)
    try:
        tables.write_table(points.rows, file)
        show.console.print(f"table: {file}")
    except ShaderlabError as error:  # the report is written all the same
        recorded = replace(recorded, problems=(*recorded.problems, error))
        file = recorded.folder / FILE_NAME
    recorded = with_points(recorded, points, file)
    is_latest = folder is None and resume is None
    verdict = FAILED if points.failed else OK
    return finish(recorded, show, "sweep", verdict=verdict, is_latest=is_latest)
