"""`shaderlab run`: run scenes, show outcomes, write the report."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from shaderlab.cli import FAILED, OK, options as shared
from shaderlab.engine.jobs import check_driver
from shaderlab.errors import UsageError
from shaderlab.files import display_path
from shaderlab.model.options import Limits, RunOptions

if TYPE_CHECKING:
    from shaderlab.cli.recorded_run import RecordedRun, RunPlan
    from shaderlab.cli.showing import Show
    from shaderlab.engine.jobs import Executor
    from shaderlab.model.records import Run


@dataclass(frozen=True, kw_only=True)
class RunArguments:
    """The arguments and options of `shaderlab run`, as its help describes them."""

    targets: tuple[str, ...]
    every: bool
    variants: tuple[str, ...]
    size: int
    shaders: tuple[str, ...]
    renamed: tuple[str, ...]
    outputs: Mapping[str, str]
    includes: tuple[Path, ...]
    compile_targets: tuple[str, ...]
    driver: str | None
    drivers: tuple[str, ...]
    workers: int | None
    limits: Limits
    folder: str | None
    resume: str | None
    pictures: bool
    gl_calls: bool
    modules: bool | None

    def check(self) -> None:
        """Raise UsageError where options exclude each other."""
        resumes = self.resume is not None
        if self.drivers and (self.driver is not None or resumes or self.workers == 0):
            raise UsageError("--drivers can't be combined with --driver, --resume or -j 0")
        if resumes and (self.targets or self.every or self.variants or self.folder):
            raise UsageError("--resume takes no cases or options of a new run")

    @property
    def run_options(self) -> RunOptions:
        """How scenes are run, before shaders are replaced."""
        return RunOptions(
            size=self.size,
            pictures=self.pictures,
            include=self.includes,
            targets=self.compile_targets,
            gl_calls=self.gl_calls,
            modules=True if "lcov" in self.outputs else self.modules,
            driver=self.drivers[0] if self.drivers else self.driver,
            limits=self.limits,
        )


@click.command("run")
@click.argument("targets", nargs=-1, metavar="[ID | FILE.py | FOLDER]…")
@click.option("--all", "every", is_flag=True, help="Run every case that ships with shaderlab.")
@shared.variants_option("Run only this variant; may be repeated.")
@click.option(
    "--size",
    type=click.IntRange(1, 4096),
    default=RunOptions.size,
    show_default=True,
    metavar="N",
    help="Judge N × N pixels where a case sets no size.",
)
@click.option(
    "--shader",
    "shaders",
    multiple=True,
    metavar="NAME=FILE",
    help="Use FILE instead of the shader NAME (its path, or the end of it).",
)
@click.option(
    "--rename",
    "renamed",
    multiple=True,
    metavar="NAME=OTHER",
    help="Rename NAME in the files of --shader to OTHER, the name in the case.",
)
@shared.output_options
@shared.INCLUDE
@shared.TARGET
@shared.DRIVER
@shared.jobs_option()
@shared.limits_option("Stop a variant that takes longer than S seconds.")
@shared.report_option("Write the report to DIR instead of a new folder in reports/.")
@click.option(
    "--drivers",
    metavar="A,B,…",
    callback=lambda context, option, names: _parse_drivers(names),
    help="Run on each of these drivers, and show where they disagree.",
)
@click.option(
    "--resume",
    is_flag=False,
    flag_value="",
    metavar="[FOLDER]",
    help="Resume the unfinished run in FOLDER; by default the latest run.",
)
@click.option(
    "--pictures/--no-pictures", default=True, help="Render pictures for the report, or only judge."
)
@click.option(
    "--gl-calls", is_flag=True, help="List the OpenGL calls of each pass, here and in the report."
)
@click.option(
    "--modules/--no-modules",
    default=None,
    help="Check every pixel of every draw against its own shader, and try longer to prove what "
    "holds for all inputs; or check none.  [default: a sample of each program]",
)
@shared.collect(RunArguments, "arguments")
def command(arguments: RunArguments) -> int:
    """Run cases: compile, render, judge every pixel, and write a report.

    Name a case by its id, by its id and a variant, or by its file; a folder stands for all
    case files below it.

    \b
    Examples:
      shaderlab run attenuation spotlight
      shaderlab run 'attenuation[50]'               run one variant
      shaderlab run --all --json out.json           write results for other programs
      shaderlab run ./my_case.py                    run a case of your own
      shaderlab run gamma --shader gamma.frag=mine.frag
      shaderlab run --all --drivers llvmpipe,softpipe
      shaderlab run mesh-class --gl-calls           list the OpenGL calls
      shaderlab run --resume                        resume after Ctrl-C or a power cut

    Each variant runs in a worker process. If it crashes or takes too long, that variant is a
    "crash" or a "timeout", and all others still run.

    Exit code: 0 all passed, 1 something failed or nothing passed, 2 wrong usage. A case that needs
    a feature which the driver lacks is "unsupported": no failure if another case passes. Checks of
    OpenGL calls are skipped on drivers of another API; the number skipped is reported.
    """
    arguments.check()
    options, plan, done = arguments.run_options, None, None
    if arguments.resume is not None:
        from shaderlab.cli.recorded_run import load_plan

        plan, done = load_plan(arguments.resume, arguments.limits)
        options = plan.options
    # The first worker gets ready while what follows is imported.
    with contextlib.closing(
        shared.make_executor(options.driver, arguments.limits, arguments.workers)
    ) as executor:
        from shaderlab.cli.recorded_run import run_plan
        from shaderlab.cli.showing import Show
        from shaderlab.report import html

        html.preload()
        show = Show(to_stderr=shared.uses_stdout(arguments.outputs))
        plan = plan or _make_plan(arguments, options, executor)
        recorded = run_plan(executor, plan, show, done)
        if plan.options.frames is not None and recorded.complete:
            from shaderlab.cli.compare_drivers import add_comparison

            recorded = add_comparison(recorded, plan.options)
    return _finish(arguments, recorded, show)


def _make_plan(arguments: RunArguments, options: RunOptions, executor: Executor) -> RunPlan:
    """Select the jobs and the shaders that are replaced; make the run's folder."""
    from shaderlab.cli.recorded_run import new_plan
    from shaderlab.cli.selecting import replace_shaders, select_jobs, split_targets

    for folder in filter(os.path.isdir, arguments.targets):
        if tests := split_targets([folder])[0]:
            names = ", ".join(map(display_path, tests))
            click.echo(f"shaderlab: pytest runs the tests of functions: {names}", err=True)
    jobs = select_jobs(arguments.targets, arguments.every, arguments.variants, executor.load)
    options = replace_shaders(options, arguments.shaders, arguments.renamed, jobs)
    plan = new_plan(jobs, options, arguments.folder)
    if not arguments.drivers:
        return plan
    from shaderlab.cli.compare_drivers import plan_for_drivers

    return plan_for_drivers(plan, arguments.drivers)


def _finish(arguments: RunArguments, recorded: RecordedRun, show: Show) -> int:
    """Show the outcomes, write the report and the outputs; return the exit status."""
    from shaderlab.cli.recorded_run import finish

    run = recorded.run
    show.outcomes(run)
    show.gl_calls(run)
    if run.drivers:
        from shaderlab.cli.compare_drivers import show_drivers

        show_drivers(run, show.console)
    return finish(
        recorded,
        show,
        verdict=_verdict(run),
        is_latest=arguments.folder is None and arguments.resume is None,
        outputs=arguments.outputs,
    )


def _verdict(run: Run) -> int:
    from shaderlab.report.text import has_failed

    passed = any(record.status == "pass" for record in run.records)
    return FAILED if run.failing_drivers or not passed or any(map(has_failed, run.records)) else OK


def _parse_drivers(names: str | None) -> tuple[str, ...]:
    """Return the drivers to compare. Raises UsageError."""
    if names is None:
        return ()
    found = tuple(check_driver(name.strip()) for name in names.split(","))
    if len(set(found)) != len(found) or len(found) < 2:
        raise UsageError(f"--drivers {names}: name two or more drivers, each once")
    return found
