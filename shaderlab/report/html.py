"""The report as a small site in the run's folder: a front page, and a page for each case.

It opens from disk, where a page may not read files but may link to them and run scripts: what is
shown on demand is a script. It asks nothing of any network. The same as one file is for mailing.
"""

from __future__ import annotations

import importlib
import threading
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from shaderlab.files import write_text
from shaderlab.model.records import Run
from shaderlab.report import mutants, parts
from shaderlab.report.build import build
from shaderlab.report.compare import compare
from shaderlab.report.drivers import driver_table
from shaderlab.report.environment import environment
from shaderlab.report.history import history, save
from shaderlab.report.inline import Pictures, Repeated
from shaderlab.report.page import Page
from shaderlab.report.search import script

FILE_NAME = "index.html"
AGAINST_NAME = "against.html"


def write(run: Run, folder: str | Path, against: tuple[Run, Path] | None = None) -> Path:
    """Write the pages of a run whose pictures lie in `folder`; return the front page's path.

    That is `folder`/index.html; with an earlier run and its folder in `against` it is
    `folder`/against.html and begins with what changed. Cases are in `folder`/cases, what the pages
    share in `folder`/page. Each file is written whole or not at all, the front page last.

    The results of `shaderlab mutate --report` in that folder are shown too, and what changed since
    earlier runs whose folders stand beside it.

    Raises:
        ShaderlabError: a file can't be written, or `mutation.json` is damaged. Missing pictures
            are only noted.
    """
    target = Path(folder)
    page = build(run, Pictures(target), mutants.load(target))
    shared = target / parts.FOLDER
    write_text(shared / "style.css", parts.style())
    write_text(shared / "script.js", parts.script())
    links = page.links(single=False)
    past = history(run, target, links)
    render = partial(_render, page=page, run=run, single=False, policy=parts.SITE_POLICY)

    for earlier, (chapter, case), later in _with_neighbours(page):
        pieces = render(
            "case_page.html.j2",
            root="../",
            level=1,
            here=chapter,
            case=case,
            earlier=earlier,
            later=later,
            trend=past and past.trends.get(case.group.id),
        )
        write_text(target / case.page, pieces)
    write_text(shared / "search.js", script((c.anchor, c.group.records) for c in page.cases))
    path = target / (AGAINST_NAME if against else FILE_NAME)
    front = render(
        "index.html.j2",
        root="",
        here="",
        against=against and compare(run, target, *against, links),
        drivers=driver_table(run, links),
        links=links,
        past=past,
    )
    save(run, target)
    write_text(path, front)
    return path


def write_single(run: Run, folder: str | Path, path: str | Path) -> None:
    """Write a run whose pictures lie in `folder` as one file that needs no other.

    Raises:
        ShaderlabError: as `write`.
    """
    page = build(run, Pictures(Path(folder)), mutants.load(Path(folder)))
    links = page.links(single=True)
    pieces = _render(
        "single.html.j2",
        page=page,
        run=run,
        single=True,
        root="",
        level=3,
        here="",
        policy=parts.single_policy(),
        style=parts.style(),
        script=parts.script(),
        repeated=Repeated(page.shown_apart()),
        against=None,
        drivers=driver_table(run, links),
        links=links,
        past=history(run, Path(folder), links),
    )
    write_text(path, pieces)


def load_libraries() -> None:
    """Import the page's libraries and read its templates in a background thread.

    This takes a tenth of a second, during which workers can draw; `write` does it otherwise. A
    run that is interrupted does not wait for the thread.
    """

    def load() -> None:
        for name in environment().list_templates():
            environment().get_template(name)
        coloured_lines = importlib.import_module("shaderlab.report.colouring").coloured_lines
        for language in ("glsl", "python"):
            coloured_lines("a\n", language)
        for name in ("markdown_it", "latex2mathml.converter"):
            importlib.import_module(name)
        _ = parts.style(), parts.script()

    threading.Thread(target=load, daemon=True).start()


def _render(template: str, **values: Any) -> Iterator[str]:
    return environment().get_template(template).generate(boot=parts.BOOT, **values)


def _with_neighbours(page: Page) -> Iterator[tuple[Any, Any, Any]]:
    """The case before, (its chapter's anchor, the case), and the case after."""
    cases = [(chapter.anchor, case) for chapter in page.chapters for case in chapter.cases]
    around = [None, *(case for _, case in cases), None]
    return zip(around, cases, around[2:], strict=False)
