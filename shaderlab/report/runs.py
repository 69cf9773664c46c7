"""The page of all runs in a folder such as reports/: when each was, and what it said."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from shaderlab.files import read_regular, write_text
from shaderlab.report import html, parts
from shaderlab.report.grouping import STATUSES
from shaderlab.report.history import FILE_NAME

_MARK = "shaderlab: all runs"
"""The page's generator, as it says itself: what tells it from one that somebody else put there."""


@dataclass(frozen=True)
class Line:
    """A run: its folder's name, when it began, its status ("" where its summary has none), what its
    last line said, whether it was interrupted, its driver, and the shaders that were replaced."""

    name: str
    started: str
    status: str
    said: str
    interrupted: bool
    renderer: str
    replaced: tuple[str, ...]

    @property
    def link(self) -> str:
        """Where its front page is."""
        return f"{quote(os.fsencode(self.name))}/{html.FILE_NAME}"


def write(folder: Path) -> None:
    """Write `folder`/index.html: the runs whose folders lie there, the last one first.

    A page that is not of this kind stays as it is.

    Raises:
        ShaderlabError: it can't be written.
    """
    path = folder / html.FILE_NAME
    if path.exists() and not is_list(path):
        return
    from shaderlab.report.environment import environment

    lines = sorted(_lines(folder), key=lambda line: (line.started, line.name), reverse=True)
    template = environment().get_template("runs.html.j2")
    style, policy = parts.style(), parts.plain_policy()
    write_text(path, template.render(lines=lines, style=style, policy=policy, generator=_MARK))


def is_list(path: Path) -> bool:
    """Whether a file is such a page, of any run before."""
    try:
        return f'name="generator" content="{_MARK}"' in read_regular(path).decode(
            "utf-8", "replace"
        )
    except OSError:
        return False


def _lines(folder: Path) -> Iterator[Line]:
    for path in folder.glob(f"*/{FILE_NAME}"):
        if path.parent.is_symlink() or not (path.parent / html.FILE_NAME).is_file():
            continue
        try:
            found = json.loads(read_regular(path))
            status = found.get("status")
            yield Line(
                name=path.parent.name,
                started=str(found["started"]),
                status=status if status in STATUSES else "",
                said=str(found.get("said", "")),
                interrupted=bool(found.get("missing")),
                renderer=str(found["renderer"]),
                replaced=tuple(map(str, found["replaced"])),
            )
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            continue
