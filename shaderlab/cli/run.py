"""`shaderlab run`: run scenes, show outcomes, write the report."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from shaderlab.cli import FAILED, OK
from shaderlab.cli.options import make_executor, running_options
from shaderlab.cli.outputs import output_options, uses_stdout
from shaderlab.engine.jobs import checked_driver
from shaderlab.errors import UsageError
from shaderlab.model.options import Limits, RunOptions

if TYPE_CHECKING:
    from shaderlab.model.records import Record, Run


@click.command("run")
@click.argument("targets", nargs=-1, metavar="[ID | FILE.py | FOLDER]…")
@click.option("--all", "every", is_flag=True, help="Every case that comes with shaderlab.")
@click.option("--variant", "variants", multiple=True, metavar="V", help="Only this variant.")
@click.option(
    "--size",
    type=click.IntRange(1, 4096),
    default=RunOptions.size,
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
@click.option(
    "--rename",
    "renamed",
    multiple=True,
    metavar="NAME=OTHER",
    help="Call NAME in the files of --shader OTHER, as the case does.",
)
@output_options
@running_options("variant")
@click.option(
    "--drivers",
    metavar="A,B,…",
    help="Run on each of these drivers, and show where they disagree and why.",
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
@click.option(
    "--coverage",
    is_flag=True,
    help="Also list what the judged pixels never exercise: branches, terms, clamps.",
)
@click.option(
    "--gl-calls",
    is_flag=True,
    help="Also list the calls of OpenGL that each pass takes, here and on the page.",
)
@click.option(
    "--modules/--no-modules",
    default=None,
    help="Judge every pixel of every draw by its own shader too, or none.  [default: some of each "
    "program]",
)
@click.option("--profile", is_flag=True, help="Show where the time went.")
@click.option("--open", "open_report", is_flag=True, help="Open the report in a browser.")
def command(
    targets: tuple[str, ...],
    every: bool,
    variants: tuple[str, ...],
    size: int,
    shaders: tuple[str, ...],
    renamed: tuple[str, ...],
    outputs: Mapping[str, str],
    folder: str | None,
    includes: tuple[Path, ...],
    compile_targets: tuple[str, ...],
    limits: Limits,
    workers: int | None,
    scheduler: str | None,
    driver: str | None,
    drivers: str | None,
    resume: str | None,
    pictures: bool,
    coverage: bool,
    gl_calls: bool,
    modules: bool | None,
    profile: bool,
    open_report: bool,
) -> int:
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
      shaderlab run spotlight --coverage            what its inputs never exercise
      shaderlab run mesh-class --gl-calls           what a driver gets
      shaderlab run --resume                        after Ctrl-C or a power cut
      shaderlab run --all --scheduler tcp://host:8786

    Each variant runs in a worker process. One that crashes or takes too long is a "crash" or
    "timeout" of that variant, and everything else is run.

    With --scheduler (pip install 'shaderlab[cluster]') the processes are on the workers of a Dask
    cluster, which need the same versions and nothing else: a case of your own is sent with
    everything below its folder, records and pictures come back into the run's folder here.

    Exit code: 0 all passed, 1 something failed, 2 wrong usage. A case that needs a feature which
    this driver lacks is "unsupported", which is no failure. Checks of OpenGL's own
    calls are not asked where another API draws; how many they are is said.
    """
    compared = _compared_drivers(drivers)
    if compared and (driver is not None or resume is not None or workers == 0):
        raise UsageError(
            "--drivers goes with neither --driver, --resume nor -j 0",
            remedy="--resume knows the drivers of its run" if resume is not None else None,
        )
    if coverage and scheduler is not None:
        raise UsageError("--coverage is measured on this machine: leave out --scheduler")
    if resume is not None and (targets or every or variants or folder):
        raise UsageError("--resume runs what was asked for then: name nothing else")
    options = RunOptions(
        size=size,
        pictures=pictures,
        include=includes,
        targets=compile_targets,
        gl_calls=gl_calls,
        modules=modules,
        driver=compared[0] if compared else driver,
        limits=limits,
    )
    done: list[Record] | None = None
    if resume is not None:
        from shaderlab.cli.recorded_run import resumed_plan

        plan, done = resumed_plan(resume, limits)
        options = plan.options
        if plan.grid is not None:
            raise UsageError(
                "this is a sweep",
                file=options.folder,
                remedy=f"use shaderlab sweep --resume {options.folder}",
            )

    # Workers get ready while what follows is imported.
    with contextlib.ExitStack() as workers_end:
        executor = make_executor(options.driver, limits, workers, scheduler)
        workers_end.callback(executor.close)
        from shaderlab.cli.compare_drivers import compared_drivers, on_each, show_drivers
        from shaderlab.cli.recorded_run import finish, new_plan, run_plan, with_coverage
        from shaderlab.cli.replacing import named, parsed
        from shaderlab.cli.selecting import choose
        from shaderlab.cli.showing import Show
        from shaderlab.report.html import load_libraries

        show = Show(to_stderr=uses_stdout(outputs))
        if resume is None:
            replacements = parsed(shaders)
            jobs = choose(targets, every, variants, executor.load)
            names = _renames(renamed, list(replacements.values()))
            in_place = named(replacements, jobs, includes, names)
            plan = new_plan(jobs, replace(options, shaders=in_place, renames=names), folder)
            plan = on_each(plan, compared)
        load_libraries()  # before this, workers that get ready keep the cores busy
        recorded = run_plan(executor, plan, show, done)
        recorded = compared_drivers(recorded, plan)
        if coverage and recorded.complete:
            recorded = with_coverage(recorded, executor, plan, show)
        with _beside(workers_end.close):
            show.outcomes(recorded.run)
            show.gl_calls(recorded.run)
            show.coverage(recorded.run)
            show_drivers(recorded.run, show.console)
            if profile:
                show.profile(recorded.run)
            return finish(
                recorded,
                show,
                "run",
                verdict=_status(recorded.run),
                is_latest=folder is None and resume is None,
                outputs=outputs,
                open_report=open_report,
            )


@contextlib.contextmanager
def _beside(*tasks: Callable[[], None]) -> Iterator[None]:
    """Have tasks done, one after the other, beside what goes on: ending processes is waiting."""

    def work() -> None:
        for task in tasks:
            task()

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    try:
        yield
    finally:
        thread.join()


def _renames(words: Sequence[str], files: Sequence[Path]) -> dict[str, str]:
    if not words:
        return {}
    from shaderlab.cli.replacing import renames  # it reads shaders, which few runs need here

    return renames(words, files)


def _status(run: Run) -> int:
    from shaderlab.report.text import has_failed

    passed = any(record.status == "pass" for record in run.records)
    return FAILED if run.failing_drivers or not passed or any(map(has_failed, run.records)) else OK


def _compared_drivers(names: str | None) -> tuple[str, ...]:
    """The drivers to be compared; none if there is only one. Raises UsageError."""
    if names is None:
        return ()
    found = tuple(checked_driver(name.strip()) for name in names.split(","))
    if len(set(found)) != len(found) or len(found) < 2:
        raise UsageError(f"--drivers {names}: name two or more, each once")
    return found
