"""The report as a small site in the run's folder: a front page, and a page for each case.

It opens from disk, where a page may not read files but may link to them and run scripts: what is
shown on demand is a script. It requests nothing from a network. As one file it is for mailing.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from shaderlab.files import refuse_links, write_text
from shaderlab.model.records import Run
from shaderlab.report import rendering
from shaderlab.report.comparison import compare_drivers
from shaderlab.report.page import CaseView, Page, build_page, load_mutants
from shaderlab.report.pictures import Pictures
from shaderlab.report.sources import collect_words, colour_lines

FILE_NAME = "index.html"


def preload() -> None:
    """Build what colours sources, which takes about as long as to write a page."""
    for language in ("python", "glsl"):
        colour_lines("\n", language)


def write(run: Run, folder: str | Path) -> Path:
    """Write the pages of a run whose pictures lie in `folder`; return the front page's path.

    That is `folder`/index.html. Cases are in `folder`/cases, what the pages share in `folder`/page.
    Each file is written whole or not at all, the front page last.

    The results of `shaderlab mutate --report` in that folder are shown too. Raises ShaderlabError:
    a file can't be written, or `mutation.json` is damaged; missing pictures are only noted."""
    target = Path(folder)
    refuse_links(target)
    page = build_page(run, Pictures(target), load_mutants(target))
    shared = target / rendering.FOLDER
    write_text(shared / "style.css", rendering.style())
    write_text(shared / "script.js", rendering.script())
    write_text(shared / "live.js", rendering.live_script())
    links = page.links(single=False)
    render = partial(
        rendering.render, page=page, run=run, single=False, policy=rendering.SITE_POLICY
    )
    for earlier, (chapter, case), later in _with_neighbours(page):
        pieces = render(
            "case_page.html.j2",
            root="../",
            level=1,
            here=chapter,
            case=case,
            earlier=earlier,
            later=later,
        )
        write_text(target / case.page, pieces)
    write_text(shared / "search.js", _search_script(page))
    path = target / FILE_NAME
    front = render(
        "index.html.j2", root="", here="", drivers=compare_drivers(run, links), links=links
    )
    write_text(path, front)
    return path


def render_single(run: Run, folder: str | Path) -> str:
    """Return a run whose pictures lie in `folder` as one page that needs no other file."""
    page = build_page(run, Pictures(Path(folder)), load_mutants(Path(folder)))
    links = page.links(single=True)
    pieces = rendering.render(
        "index.html.j2",
        page=page,
        run=run,
        single=True,
        root="",
        level=3,
        here="",
        policy=rendering.single_policy(),
        style=rendering.style(),
        script=rendering.script(),
        drivers=compare_drivers(run, links),
        links=links,
    )
    return "".join(pieces)


def _with_neighbours(
    page: Page,
) -> Iterator[tuple[CaseView | None, tuple[str, CaseView], CaseView | None]]:
    """The case before, (its chapter's anchor, the case), and the case after."""
    cases = [(chapter.anchor, case) for chapter in page.chapters for case in chapter.cases]
    around = [None, *(case for _, case in cases), None]
    return zip(around, cases, around[2:], strict=False)


def _search_script(page: Page) -> Iterator[str]:
    yield "globalThis.shaderlabWords = {\n"
    for case in page.cases:
        words = json.dumps(collect_words(case.group.records), ensure_ascii=False)
        yield f"{json.dumps(case.anchor)}: {words},\n"
    yield "};\n"
