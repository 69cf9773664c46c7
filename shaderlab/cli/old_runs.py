"""Old runs: the last ones stay in reports/, and whatever somebody named."""

from __future__ import annotations

import contextlib
import fcntl
import re
import shutil
from pathlib import Path

from shaderlab.errors import UsageError
from shaderlab.workers.journal import FILE_NAME

KEEP = 20
"""How many runs stay where the project does not say."""
NAMED = ".named"
_STAMP = re.compile(r"\d{8}-\d{6}(-\d+)?")
_OWN_FILES = (FILE_NAME, "run.json", "mutants.json")


def mark_named(folder: Path) -> None:
    """Note that somebody named this run's folder, so that it is never removed."""
    if _STAMP.fullmatch(folder.name):
        with contextlib.suppress(OSError):
            (folder / NAMED).touch()


def require_no_foreign_page(folder: Path) -> None:
    """Raise UsageError where a report would replace an index.html that is none."""
    page = folder / "index.html"
    if page.exists() and not any((folder / name).exists() for name in _OWN_FILES):
        from shaderlab.report.runs import is_list

        if is_list(page):
            return
        raise UsageError(
            "this page is no report of shaderlab, and a report would replace it",
            file=page,
            remedy="name a folder of its own with --report, or remove the page",
        )


def remove_old(parent: Path, keep: int) -> int:
    """Remove all but the last `keep` of the runs that the lab named by their time; 0 keeps all.

    Folders of other names, those that were named on a command line, links, runs that are going on
    and folders without a journal stay, and don't count.

    Returns:
        How many were removed.
    """
    if not keep:
        return 0
    with contextlib.suppress(OSError):
        runs = sorted(filter(_may_go, parent.iterdir()), key=lambda run: run.stat().st_mtime)
        for run in runs[:-keep]:
            shutil.rmtree(run, ignore_errors=True)
        return len(runs[:-keep])
    return 0


def _may_go(folder: Path) -> bool:
    made = _STAMP.fullmatch(folder.name) and not folder.is_symlink() and folder.is_dir()
    journal = folder / FILE_NAME
    if not made or (folder / NAMED).exists() or not journal.is_file():
        return False
    try:
        with journal.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # another process is writing to it
        return False
    return True
