"""`shaderlab report`: rebuild the pages of a run."""

from collections.abc import Mapping
from pathlib import Path

import click

from shaderlab.cli import options as shared
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.files import display_path


@click.command("report")
@click.argument("run_folder", required=False, metavar="[RUN_FOLDER]")
@click.option(
    "--single-file",
    metavar="FILE",
    help="Also write the report as one self-contained file, for mailing.",
)
@shared.output_options
def command(run_folder: str | None, single_file: str | None, outputs: Mapping[str, str]) -> int:
    """Rebuild the pages of a run from the run.json in its folder.

    \b
    Examples:
      shaderlab report                              rebuild the latest run
      shaderlab report reports/20260101-120000
      shaderlab report --single-file to-mail.html
      shaderlab report --markdown "$GITHUB_STEP_SUMMARY"
    """
    from shaderlab.model import store
    from shaderlab.report import html

    to_stderr = shared.uses_stdout(outputs)
    folder = shared.find_latest() if run_folder is None else _run_folder(Path(run_folder))
    run = store.load(folder)
    problems: list[ShaderlabError] = []
    try:
        page = html.write(run, folder)
        click.echo(f"report: {display_path(page)}", err=to_stderr)
    except ShaderlabError as error:  # the outputs are written all the same
        problems.append(error)
    if single_file is not None:
        try:
            shared.write_output(html.render_single(run, folder), single_file)
            click.echo(f"report in one file: {single_file}", err=to_stderr)
        except ShaderlabError as error:
            problems.append(error)
    problems += shared.write_outputs(run, outputs)
    return shared.report_problems(problems)


def _run_folder(folder: Path) -> Path:
    shared.mark_named(folder)
    if not (folder / "run.json").is_file():
        raise UsageError(
            "there is no run.json in this folder",
            file=folder,
            remedy="name the folder of a run, such as reports/latest",
        )
    return folder
