"""`shaderlab list`: list cases by chapter."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence

import click

from shaderlab.cli import FAILED, OK
from shaderlab.cli.options import JSON, make_executor
from shaderlab.cli.selecting import KEPT
from shaderlab.engine.jobs import CaseInfo
from shaderlab.errors import UsageError, suggest
from shaderlab.model.options import Limits


@click.command("list")
@click.argument("targets", nargs=-1, metavar="[ID | FILE.py | FOLDER]…")
@click.option("--chapter", type=int, metavar="N", help="List only chapter N.")
@JSON
def command(targets: tuple[str, ...], chapter: int | None, json_file: str | None) -> int:
    """List cases by chapter: those that ship with shaderlab, or your own in files and folders,
    which
    worker processes load.

    \b
    Examples:
      shaderlab list
      shaderlab list ./my_cases
      shaderlab list --chapter 5
      shaderlab list --json - | jq -r '.[].id'

    Exit code: 0 all cases load, 1 one does not, 2 wrong usage.
    """
    found = _load_cases(targets) if targets else _load_shipped()
    cases = [case for case in found if case.error is None]
    if chapter is not None:
        chapters = sorted({_chapter_of(case) for case in cases})
        cases = [case for case in cases if _chapter_of(case) == str(chapter)]
        if not cases:
            raise UsageError(
                f"chapter {chapter} has no cases", remedy=suggest(str(chapter), chapters)
            )
    if json_file is not None:
        from shaderlab.cli.options import write_json

        write_json([{name: getattr(case, name) for name in KEPT} for case in cases], json_file)
    if json_file != "-" and cases:
        click.echo("\n".join(_format_lines(cases)))
    for line in _format_problems(found):
        click.echo(line, err=True)
    return OK if all(case.error is None for case in found) else FAILED


def _format_problems(found: Sequence[CaseInfo]) -> Iterator[str]:
    """Why cases can't be loaded; those that miss packages of one extra in one message."""
    missing: dict[str, list[str]] = {}
    for case in found:
        if case.error is not None and (case.error.remedy or "").startswith("pip install"):
            missing.setdefault(case.error.remedy or "", []).append(case.id)
        elif case.error is not None:
            yield f"shaderlab: {case.error}"
    for remedy, ids in missing.items():
        what = "a case needs" if len(ids) == 1 else f"{len(ids)} more cases need"
        yield f"shaderlab: {what} packages that are not here: {', '.join(ids)}\n  → {remedy}"


def _load_shipped() -> list[CaseInfo]:
    from shaderlab.cli.selecting import load_shipped_cases
    from shaderlab.engine.catalogue import data_folder

    return load_shipped_cases(data_folder("cases"), _import_shipped)


def _import_shipped() -> list[CaseInfo]:
    from shaderlab.engine.catalogue import load_cases, shipped_cases
    from shaderlab.errors import CaseError

    found = []
    for file in shipped_cases():
        try:
            ((name, case),) = load_cases([file]).items()
        except CaseError as error:
            facts = CaseInfo(file=str(file), id=file.stem.replace("_", "-"), error=error)
        else:
            facts = CaseInfo(
                file=case.file,
                id=name,
                title=case.title,
                section=case.section,
                variants=tuple(scene.variant for scene in case.scenes()),
            )
        found.append(facts)
    return found


def _load_cases(targets: Sequence[str]) -> list[CaseInfo]:
    from shaderlab.cli.selecting import find_files, make_ids_distinct
    from shaderlab.engine.catalogue import sort_key

    with contextlib.closing(make_executor(None, Limits(), None, early=False)) as executor:
        found = make_ids_distinct(executor.load(find_files(targets)))
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
        many = f"  ({len(case.variants)} variants)" if len(case.variants) > 1 else ""
        lines.append(f"  {case.id:<{wide}}  {case.section:<7} {case.title}{many}")
    return lines
