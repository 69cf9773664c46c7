"""`shaderlab list`: the cases there are."""

from __future__ import annotations

import json
from typing import Any

import click

from shaderlab.errors import UsageError, nearest
from shaderlab.model import DEFAULT_VARIANT, Case


@click.command("list", short_help="The cases there are.")
@click.option("--chapter", type=int, metavar="N", help="Only chapter N.")
@click.option("--json", "as_json", is_flag=True, help="As a JSON array on standard output.")
def command(chapter: int | None, as_json: bool) -> None:
    """List the cases that come with shaderlab, by chapter.

    \b
    Examples:
      shaderlab list
      shaderlab list --chapter 5
      shaderlab list --json | jq -r '.[].id'
    """
    from shaderlab.catalogue import Catalogue

    cases = Catalogue.shipped().cases
    if chapter is not None:
        chapters = sorted({case.chapter for case in cases})
        cases = tuple(case for case in cases if case.chapter == chapter)
        if not cases:
            raise UsageError(
                f"chapter {chapter} has no cases", remedy=nearest(str(chapter), map(str, chapters))
            )
    if as_json:
        click.echo(json.dumps([entry(case) for case in cases], indent=2, ensure_ascii=False))
    else:
        click.echo("\n".join(_lines(cases)))


def entry(case: Case) -> dict[str, Any]:
    """A case as `list --json` gives it."""
    return {
        "id": case.id,
        "section": case.section,
        "title": case.title,
        "variants": variant_names(case),
        "file": case.file,
    }


def variant_names(case: Case) -> list[str]:
    """The variants' names, in the order they are written; one, "default", without any."""
    return [variant.name for variant in case.variants] or [DEFAULT_VARIANT]


def _lines(cases: tuple[Case, ...]) -> list[str]:
    wide = max((len(case.id) for case in cases), default=0)
    lines: list[str] = []
    chapter = None
    for case in cases:
        if case.chapter != chapter:
            chapter = case.chapter
            lines += ["", f"Chapter {chapter}"] if lines else [f"Chapter {chapter}"]
        many = f"  ({len(case.variants)} variants)" if len(case.variants) > 1 else ""
        lines.append(f"  {case.id:<{wide}}  {case.section:<7} {case.title}{many}")
    return lines
