"""`shaderlab report`: make a run's page once more."""

from __future__ import annotations

from pathlib import Path

import click

from shaderlab.cli.files import find_latest
from shaderlab.errors import UsageError


@click.command("report", short_help="Make a run's page once more, or show where it is.")
@click.argument("run_folder", required=False, metavar="[RUN_FOLDER]")
@click.option("--open", "open_report", is_flag=True, help="Open it in a browser.")
def command(run_folder: str | None, open_report: bool) -> None:
    """Make the page of a run once more, from the run.json in its folder.

    \b
    Examples:
      shaderlab report                              the latest run
      shaderlab report reports/20260101-120000 --open
    """
    from shaderlab.report import html, store
    from shaderlab.terminal import shown_path

    folder = find_latest() if run_folder is None else Path(run_folder)
    if not (folder / "run.json").is_file():
        raise UsageError(
            "there is no run.json in this folder",
            file=folder,
            remedy="name a folder that `shaderlab run` made, such as reports/latest",
        )
    page = html.write(store.load(folder), folder)
    click.echo(f"report: {shown_path(page)}")
    if open_report:
        click.launch(page.resolve().as_uri())
