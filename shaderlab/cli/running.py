"""`shaderlab run`: run scenes, show outcomes, write the report."""

from __future__ import annotations

import contextlib
import datetime
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from shaderlab.cli.files import latest, new_run_folder, report_folder, write_json
from shaderlab.errors import UsageError

if TYPE_CHECKING:
    from shaderlab.cli.showing import Show
    from shaderlab.model import Scene
    from shaderlab.records import Record, Run


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
    help="Use FILE in place of the shader called NAME, to try a change.",
)
@click.option("--json", "json_file", metavar="FILE", help="Write results as JSON; - for stdout.")
@click.option("--junit", "junit_file", metavar="FILE", help="Write results as JUnit XML.")
@click.option(
    "--report",
    "folder",
    metavar="DIR",
    help="Write the report into DIR instead of a new folder in reports/.",
)
@click.option("--open", "open_report", is_flag=True, help="Open the report in a browser.")
def command(
    targets: tuple[str, ...],
    every: bool,
    variants: tuple[str, ...],
    size: int,
    shaders: tuple[str, ...],
    json_file: str | None,
    junit_file: str | None,
    folder: str | None,
    open_report: bool,
) -> None:
    """Run cases: compile, draw, judge every pixel, and write a report.

    A case is named by its id, by its id and a variant, or by its file; a folder stands for all
    case files below it.

    \b
    Examples:
      shaderlab run attenuation spotlight
      shaderlab run 'attenuation[50]'               one variant
      shaderlab run --all --json out.json           for other programs
      shaderlab run ./my_case.py --open             a case of your own
      shaderlab run gamma --shader ch05_lighting/gamma.frag=mine.frag

    Exit code: 0 all passed, 1 something failed, 2 wrong usage. A case that needs a feature which
    this driver lacks is "unsupported", which is no failure.
    """
    from shaderlab.cli.selecting import select
    from shaderlab.cli.showing import Show
    from shaderlab.terminal import failed

    replacements = _replacements(shaders)
    scenes = select(targets, every, variants)
    default_place = folder is None
    run_folder = new_run_folder() if folder is None else report_folder(Path(folder))
    show = Show(to_stderr=json_file == "-")
    run = _run(scenes, size, run_folder, replacements, show)
    interrupted = len(run.records) < len(scenes)
    show.outcomes(run)
    page = _write(run, run_folder, json_file, junit_file)
    if default_place:
        latest(run_folder)
    show.where(page)
    if open_report:
        click.launch(page.resolve().as_uri())
    if interrupted:
        raise KeyboardInterrupt
    if any(failed(record) for record in run.records) or not any(
        record.status == "pass" for record in run.records
    ):
        raise SystemExit(1)


def _run(
    scenes: Sequence[Scene],
    size: int,
    folder: Path,
    shaders: dict[str, str | Path],
    show: Show,
) -> Run:
    from shaderlab.pipeline import Lab, Options
    from shaderlab.records import Run

    started = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    clock = time.perf_counter()
    records: list[Record] = []
    options = Options(size=size, folder=folder, shaders=shaders)
    with Lab(options) as lab, show.progress(len(scenes)) as progress:
        with contextlib.suppress(KeyboardInterrupt):  # what is done is reported all the same
            for scene in scenes:
                progress.starts(scene.case.id, scene.variant)
                record = lab.run(scene)
                records.append(record)
                progress.ends(record)
        driver, versions = lab.driver, lab.versions
    return Run(
        driver=driver,
        versions=versions,
        started=started,
        seconds=time.perf_counter() - clock,
        records=tuple(records),
    )


def _write(run: Run, folder: Path, json_file: str | None, junit_file: str | None) -> Path:
    from shaderlab.report import html, junit, store

    store.save(run, folder)
    page = html.write(run, folder)
    if json_file is not None:
        write_json(store.public_json(run), json_file)
    if junit_file is not None:
        junit.write_junit(run, Path(junit_file))
    return page


def _replacements(words: Sequence[str]) -> dict[str, str | Path]:
    found: dict[str, str | Path] = {}
    for word in words:
        name, equals, file = word.partition("=")
        if not equals or not name or not file:
            raise UsageError(f"--shader {word}: write it as NAME=FILE")
        if not Path(file).is_file():
            raise UsageError("there is no such file", file=file)
        found[name] = Path(file)
    return found
