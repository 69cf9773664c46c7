"""`shaderlab list`: list cases by chapter."""

import contextlib
import re
from collections.abc import Sequence

import click

from shaderlab.cli import FAILED, OK
from shaderlab.cli.options import JSON, make_executor, write_json
from shaderlab.cli.selecting import find_files, make_ids_distinct
from shaderlab.engine.catalogue import shipped_cases, sort_key
from shaderlab.engine.jobs import CaseInfo
from shaderlab.model.options import Limits
from shaderlab.report.grouping import PASSABLE
from shaderlab.report.text import DEFAULT_VARIANT, clean

_CASE = re.compile(r'^case = Case\(\n    title="([^"\\\n]+)",\n    section="([^"\n]+)",$', re.M)
FIELDS = ("id", "section", "title", "variants", "file")
"""What JSON has of each case."""
VERSION = 1
"""Of the form of the JSON: another one where a field goes or changes its meaning."""


@click.command("list")
@click.argument("targets", nargs=-1, metavar="[ID | FILE.py | FOLDER]…")
@JSON
def command(targets: tuple[str, ...], json_file: str | None) -> int:
    """List cases by chapter: those that ship with shaderlab, or your own in files and folders.

    Those that ship are read, not loaded, unless --json asks for the names of their variants.

    \b
    Examples:
      shaderlab list
      shaderlab list ./my_cases
      shaderlab list --json - | jq -r '.cases[].id'

    Exit code: 0 all cases load, 1 one does not, 2 wrong usage.
    """
    found = load_selected(targets) if targets or json_file is not None else read_shipped()
    cases = [case for case in found if case.error is None]
    if json_file is not None:
        listed = [{name: getattr(case, name) for name in FIELDS} for case in cases]
        write_json({"version": VERSION, "cases": listed}, json_file)
    if json_file != "-" and cases:
        click.echo(clean("\n".join(_format_lines(cases))))
    errors = [case.error for case in found if case.error is not None]
    for error in errors:
        click.echo(f"shaderlab: {error}", err=True)
    return FAILED if any(case.status not in PASSABLE for case in found) else OK


def load_selected(targets: Sequence[str]) -> list[CaseInfo]:
    """Load targets' cases in worker processes, or all shipped ones here, which is quicker."""
    files = find_files(targets) if targets else list(shipped_cases())
    workers = None if targets else 0
    with contextlib.closing(make_executor(None, Limits(), workers, early=False)) as executor:
        found = make_ids_distinct(executor.load(files))
    return sorted(found, key=lambda case: sort_key(case.section, case.id))


def read_shipped() -> list[CaseInfo]:
    """What the texts of the shipped cases say, which importing them would take twenty times as long
    to tell; without `variants` where a case has some of its own."""
    found = []
    for file in shipped_cases():
        id, text = file.stem.replace("_", "-"), file.read_text(encoding="utf-8")
        names = () if "\n    variants=" in text else (DEFAULT_VARIANT,)
        said = _CASE.search(text)
        if said is None:  # one that was changed
            return load_selected(())
        title, section = said.groups()
        found.append(CaseInfo(file=str(file), id=id, title=title, section=section, variants=names))
    return sorted(found, key=lambda case: sort_key(case.section, case.id))


def _chapter_of(case: CaseInfo) -> str:
    return case.section.partition(".")[0]


def _format_lines(cases: Sequence[CaseInfo]) -> list[str]:
    wide = max(len(case.id) for case in cases)
    lines: list[str] = []
    chapter = None
    for case in cases:
        if _chapter_of(case) != chapter:
            chapter = _chapter_of(case)
            heading = f"Chapter {chapter}" if chapter else "Without a chapter"
            lines += ["", heading] if lines else [heading]
        many = "" if case.variants == (DEFAULT_VARIANT,) else "  (variants)"
        lines.append(f"  {case.id:<{wide}}  {case.section:<7} {case.title}{many}")
    return lines
