"""`shaderlab mutate`: make mistakes in a case's shaders on purpose, and count what it notices."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import UsageError
from .files import report_folder, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from ..model import Case
    from ..mutation import CaseResult, Fate, Watch


@click.command("mutate", short_help="Make mistakes in cases' shaders; see which get by.")
@click.argument("targets", nargs=-1, metavar="[ID | FILE.py | FOLDER]…")
@click.option("--all", "every", is_flag=True, help="Every case that comes with shaderlab.")
@click.option("--variant", "variants", multiple=True, metavar="V", help="Judge by this one only.")
@click.option(
    "--state/--no-state", default=True, show_default=True,
    help="Mutate fixed-function state too: depth, stencil, blending, culling.",
)  # fmt: skip
@click.option(
    "--limit", type=click.IntRange(0), default=0, metavar="N",
    help="At most N mutants a case, drawn at random. 0, the default, is all.",
)  # fmt: skip
@click.option("--seed", type=int, default=0, metavar="N", help="Which ones --limit draws.")
@click.option(
    "--timeout", type=click.FloatRange(0.5), default=20.0, show_default=True, metavar="S",
    help="Seconds after which a mutant that does not end counts as killed.",
)  # fmt: skip
@click.option("--jobs", type=click.IntRange(0), default=0, metavar="N", help="Processes; 0: cores.")
@click.option("--json", "json_file", metavar="FILE", help="Write results as JSON; - for stdout.")
@click.option(
    "--report", "folder", metavar="DIR",
    help="Add the results to this run's folder, and to its page.",
)  # fmt: skip
@click.option(
    "--fail-under", type=click.FloatRange(0, 100), metavar="PERCENT",
    help="Exit with 1 if the score is lower.",
)  # fmt: skip
def command(
    targets: tuple[str, ...],
    every: bool,
    variants: tuple[str, ...],
    state: bool,
    limit: int,
    seed: int,
    timeout: float,
    jobs: int,
    json_file: str | None,
    folder: str | None,
    fail_under: float | None,
) -> None:
    """Measure how much a case notices: make realistic mistakes in its shaders, one at a time, and
    judge each by the case's own expectations.

    A mutant is killed if an expectation fails, and has survived if outputs that expectations
    read changed and all passed. Equivalent ones change no bit of any output, on wide random
    inputs too; unjudged ones change only what no expectation reads, as in pictures for people.

    \b
    Examples:
      shaderlab mutate spotlight                  which mistakes would get by
      shaderlab mutate --all --json scores.json   all cases
      shaderlab mutate ./my_case.py --limit 100   a sample
      shaderlab mutate gamma --report reports/latest

    Exit code: 0 measured, 1 a case fails as it is or --fail-under is not reached, 2 wrong usage.
    """
    from ..mutation import Options, as_json, run, score

    cases = _cases(targets, every, variants)
    options = Options(
        variants=variants, state=state, limit=limit, seed=seed, timeout=timeout, jobs=jobs
    )
    console = _console(json_file == "-")
    with _progress(console) as watch:
        results = run(cases, options, watch)
    _show(console, results)
    data = as_json(results)
    if folder is not None:
        _into_report(data, report_folder(Path(folder)))
    if json_file is not None:
        write_json(data, json_file)
    reached = score(results)
    too_low = fail_under is not None and (reached is None or 100.0 * reached < fail_under)
    if too_low or any(result.message for result in results):
        raise SystemExit(1)


def _into_report(data: Mapping[str, Any], folder: Path) -> None:
    """Put the results beside those of earlier campaigns, and into the page if a run is there."""
    from ..report import html, mutants, store

    path = folder / mutants.FILE_NAME
    if mutants.load(folder):
        data = mutants.merged(json.loads(path.read_text(encoding="utf-8")), data)
    write_json(data, str(path))
    if (folder / store.FILE_NAME).is_file():
        click.echo(f"report: {html.write(store.load(folder), folder)}", err=True)


def _cases(targets: Sequence[str], every: bool, variants: tuple[str, ...]) -> list[Case]:
    from .selecting import select

    for target in targets:
        if target.endswith("]"):
            raise UsageError(f"{target}: name the case, and its variant with --variant")
    scenes = select(targets, every, variants)
    return list({(scene.case.file, scene.case.id): scene.case for scene in scenes}.values())


def _console(to_stderr: bool) -> Console:
    from rich.console import Console

    console = Console(file=sys.stderr if to_stderr else sys.stdout, highlight=False, soft_wrap=True)
    if not console.is_terminal:
        console.width = 120  # a file has no width, and cut numbers are of no use
    return console


@contextlib.contextmanager
def _progress(console: Console) -> Iterator[Watch | None]:
    if not console.is_terminal:
        yield None
        return
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=30),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True) as progress:
        yield _Live(progress)


class _Live:
    """A bar on a terminal, with what has survived so far."""

    def __init__(self, progress: object) -> None:
        from rich.progress import Progress

        assert isinstance(progress, Progress)
        self._progress = progress
        self._task = progress.add_task("", total=None)
        self._survived = 0

    def total(self, mutants: int) -> None:
        self._progress.update(self._task, total=mutants)

    def judged(self, case_id: str, fate: Fate | None) -> None:
        self._survived += fate is not None and fate.status == "survived"
        text = f"{case_id:<24} {self._survived} survived"
        self._progress.update(self._task, description=text, advance=1)


def _show(console: Console, results: Sequence[CaseResult]) -> None:
    from rich.table import Table

    from ..files import display_path
    from ..mutation import score

    table = Table(box=None, pad_edge=False, header_style="dim")
    table.add_column("case", no_wrap=True)
    headings = ("mutants", "killed", "survived", "score", "of state", "equivalent",
                "unjudged", "invalid")  # fmt: skip
    for heading in (*headings, "seconds"):
        table.add_column(heading, justify="right")
    for result in results:
        table.add_row(
            result.id,
            str(len(result.tried)),
            str(result.count("killed")),
            str(result.count("survived")),
            _percent(result.score),
            _percent(score([result], state=True)),
            *(str(result.count(s)) for s in ("equivalent", "unjudged", "invalid")),
            f"{result.seconds:.1f}",
            style="red" if result.message else None,
        )
    console.print(table)
    for result in results:
        if result.message:
            console.print(f"\n{result.id}: {result.message}", style="red", markup=False)
        if result.survivors:
            console.print(f"\nsurvived in {result.id}:", style="bold", markup=False)
        for tried in result.survivors:
            where = display_path(tried.file, tried.line or None)
            line = f"  {where}  {tried.operator}: {tried.before} → {tried.after}"
            console.print(f"{line}\n      {tried.fate.by}", markup=False)
    unjudged = sum(r.count("unjudged") for r in results)
    of_state = score(results, state=True)
    console.print(
        f"\nmistakes in shaders noticed: {_percent(score(results))}"
        + ("" if of_state is None else f" · in state: {_percent(of_state)}")
        + f" · {unjudged} more change only what no expectation reads",
        style="bold",
        markup=False,
    )


def _percent(share: float | None) -> str:
    """A share in per cent, never rounded up to all."""
    if share is None:
        return "–"
    return "100 %" if share == 1.0 else f"{min(100.0 * share, 99.9):.1f} %"
