"""`shaderlab mutate`: make mistakes in a case's shaders or calls, and count what it notices."""

from __future__ import annotations

import contextlib
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from shaderlab.cli import FAILED, INTERRUPTED, OK, options as shared
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import display_path
from shaderlab.model.options import Limits

if TYPE_CHECKING:
    from rich.console import Console

    from shaderlab.cli.showing import Show
    from shaderlab.engine.jobs import Executor
    from shaderlab.mutation import CaseResult, MutationPlan, MutationRun, MutationTarget


@click.command("mutate")
@click.argument("targets", nargs=-1, metavar="[ID | FILE.py | FOLDER]…")
@click.option("--all", "every", is_flag=True, help="Mutate every case that ships with shaderlab.")
@shared.variants_option("Judge by this variant only; may be repeated.")
@click.option(
    "--state/--no-state",
    default=True,
    show_default=True,
    help="Mutate fixed-function state too: depth, stencil, blending, culling.",
)
@click.option(
    "--api",
    is_flag=True,
    help="Mutate OpenGL calls instead of shaders and state.",
)
@click.option(
    "--limit",
    type=click.IntRange(0),
    default=0,
    metavar="N",
    help="Judge at most N random mutants per case; 0, the default, judges all.",
)
@click.option(
    "--seed", type=int, default=0, metavar="N", help="The seed of the sample that --limit takes."
)
@shared.limits_option("Count a mutant as killed after S seconds.", seconds=20.0)
@shared.jobs_option()
@shared.JSON
@shared.report_option("Add the results to the run in DIR and to its page.")
@click.option(
    "--fail-under",
    type=click.FloatRange(0, 100),
    metavar="PERCENT",
    help="Exit with 1 if the score is lower.",
)
def command(
    targets: tuple[str, ...],
    every: bool,
    variants: tuple[str, ...],
    state: bool,
    api: bool,
    limit: int,
    seed: int,
    limits: Limits,
    workers: int | None,
    json_file: str | None,
    folder: str | None,
    fail_under: float | None,
) -> int:
    """Measure how much a case notices: plant realistic mistakes in its shaders, one at a time, and
    judge each by the case's own expectations.

    A mutant changes one place in one program. It is killed if an expectation fails. It survives if
    an output differs and all expectations pass: none reads that output, or none on these inputs.
    Equivalent mutants, which compile to the same program, and mutants that make no difference even
    on wide random inputs do not count.

    In a file of tests that load GLSL functions (glsl.load), the mutants are those of the functions
    that the tests use, and a failing test kills.

    With --api a mutant drops, repeats or delays one OpenGL call, or changes an argument. A mutant
    that changes no pixel counts if the case has a gl_calls expectation about such calls.

    \b
    Examples:
      shaderlab mutate spotlight                  mutate one case
      shaderlab mutate --all --json scores.json   mutate all cases
      shaderlab mutate mesh-class --api           mutate OpenGL calls
      shaderlab mutate ./my_case.py --limit 100   judge a sample
      shaderlab mutate tests/test_lighting.py     mutate the functions of tests
      shaderlab mutate gamma --report reports/latest

    Ctrl-C ends the run and keeps the results of complete cases.

    Exit code: 0 measured, 1 a case fails unmutated or the score is below --fail-under, 2 wrong
    usage, 130 interrupted.
    """
    from shaderlab.mutation import MutationPlan, score

    if api and folder is not None:
        raise UsageError(
            "--api can't be combined with --report: the page shows mistakes in shaders and state",
            remedy="write those in calls to a file, with --json",
        )
    plan = MutationPlan(variants=variants, state=state, api=api, limit=limit, seed=seed)
    results, ended = _measure(targets, every, plan, json_file == "-", limits, workers)
    _write(results, plan, ended is not None, folder, json_file)
    if isinstance(ended, ShaderlabError):
        raise ended
    if ended is not None:
        return INTERRUPTED
    failed = any(result.message for result in results) or _is_too_low(score(results), fail_under)
    return FAILED if failed else OK


def _is_too_low(reached: float | None, least: float | None) -> bool:
    """Whether a score is below the least percentage; one of no mutants is."""
    return least is not None and (reached is None or not 100.0 * reached >= least)


def _measure(
    targets: Sequence[str],
    every: bool,
    plan: MutationPlan,
    to_stderr: bool,
    limits: Limits,
    workers: int | None,
) -> tuple[list[CaseResult], BaseException | None]:
    """Make, judge and show all mutants; also say what ended it early, if anything did."""
    from shaderlab.cli.showing import Show
    from shaderlab.mutation import MutationRun

    shown = Show(to_stderr=to_stderr)
    console = shown.console
    with contextlib.closing(shared.make_executor(None, limits, workers, early=False)) as executor:
        run = MutationRun(_targets(targets, every, plan, executor), executor)
        ended = _judge(run, shown)
    results = run.results(complete=ended is not None)
    _show(console, results, "calls of OpenGL" if plan.api else "shaders")
    if ended is not None:
        console.print(
            f"interrupted: {run.judged} of {run.total} mutants were judged; "
            "the cases above are those with all of theirs"
        )
    return results, ended


def _write(
    results: Sequence[CaseResult],
    plan: MutationPlan,
    stopped: bool,
    folder: str | None,
    json_file: str | None,
) -> None:
    from shaderlab.mutation import results_to_json

    data = {**results_to_json(results), "api": plan.api, "limit": plan.limit, "seed": plan.seed}
    if stopped:
        data["interrupted"] = True
    try:
        if folder is not None:
            _into_report(data, shared.make_report_folder(Path(folder)))
    finally:  # what took so long to measure is written wherever it can be
        if json_file is not None:
            shared.write_json(data, json_file)


def _into_report(data: Mapping[str, Any], folder: Path) -> None:
    """Put the results beside those of earlier runs, and into the page if a run is there."""
    from shaderlab.model import store
    from shaderlab.report import html, page

    path = folder / page.MUTATION_NAME
    if page.load_mutants(folder):
        data = page.merge_mutants(json.loads(path.read_text(encoding="utf-8")), data)
    shared.write_json(data, str(path))
    if (folder / store.FILE_NAME).is_file():
        click.echo(f"report: {html.write(store.load(folder), folder)}", err=True)


def _targets(
    targets: Sequence[str], every: bool, plan: MutationPlan, executor: Executor
) -> list[MutationTarget]:
    """The cases that are named, and the files of tests. Raises UsageError."""
    from shaderlab.cli.selecting import split_targets
    from shaderlab.mutation import CaseTarget

    files, rest = split_targets(targets)
    found: list[MutationTarget] = []
    if rest or every or not files:
        cases = _cases(rest, every, plan.variants, executor)
        found += [CaseTarget(file, case_id, plan) for file, case_id in cases.items()]
    if files:
        from shaderlab.mutation.function_tests import TestFileTarget

        if plan.api:
            raise UsageError(f"--api is about cases, and {display_path(files[0])} has tests")
        stems = Counter(file.stem for file in files)
        for file in files:  # on a page a file of tests goes by its stem
            test_id = file.stem if stems[file.stem] == 1 else display_path(file)
            found.append(TestFileTarget(file, test_id, plan))
    return found


def _cases(
    targets: Sequence[str], every: bool, variants: tuple[str, ...], executor: Executor
) -> dict[Path, str]:
    """The files of the cases that are named, and their ids. Raises UsageError."""
    from shaderlab.cli.selecting import select_jobs

    for target in targets:
        if target.endswith("]"):
            raise UsageError(f"{target}: name the case, and its variant with --variant")
    jobs = select_jobs(targets, every, variants, executor.load)
    return {Path(job.file): job.id for job in jobs}  # what a broken file lacks is said at the end


def _judge(run: MutationRun, show: Show) -> BaseException | None:
    """Judge all mutants; on a terminal with a bar, and with what has survived so far. Returns what
    ended it before the last one: Ctrl-C, or that no worker could be started any more."""
    with show.bar() as progress:
        task = progress.add_task("", total=run.total)
        survived = 0
        try:
            for case_id, result in run.judge():
                survived += result is not None and result.status == "survived"
                progress.update(task, description=f"{case_id:<24} {survived} survived", advance=1)
        except (KeyboardInterrupt, ShaderlabError) as error:
            return error
    return None


def _show(console: Console, results: Sequence[CaseResult], mutated: str) -> None:
    from shaderlab.cli.showing import make_table
    from shaderlab.mutation import score
    from shaderlab.report.text import clean

    headings = ("mutants", "killed", "survived", "score", "of state", "equivalent",
                "no difference", "invalid", "seconds")  # fmt: skip
    table = make_table("case", *headings, right=headings)
    for result in results:
        table.add_row(
            clean(result.id),
            str(len(result.runs)),
            str(result.count("killed")),
            str(result.count("survived")),
            _percent(result.score),
            _percent(score([result], state=True)),
            *(str(result.count(s)) for s in ("equivalent", "no difference", "invalid")),
            f"{result.seconds:.1f}",
            style="red" if result.message else None,
        )
    console.print(table)
    for result in results:
        if result.message:
            console.print(clean(f"\n{result.id}: {result.message}"), style="red")
        if result.survivors:
            console.print(clean(f"\nsurvived in {result.id}:"), style="bold")
        for run in result.survivors:
            console.print(clean(f"  {run.mutant}\n      {run.result.by}"))
        if result.noticed:
            console.print(clean(f"\nnoticed in {result.id}, by test:"), style="bold")
        for name, count in result.noticed.items():
            console.print(clean(f"  {count:>5}  {name}"))
    of_state = score(results, state=True)
    console.print(
        f"\nmistakes in {mutated} noticed: {_percent(score(results))}"
        + ("" if of_state is None else f" · in state: {_percent(of_state)}"),
        style="bold",
    )


def _percent(share: float | None) -> str:
    """A share in per cent, never rounded up to all."""
    if share is None:
        return "–"
    return "100 %" if share == 1.0 else f"{min(100.0 * share, 99.9):.1f} %"
