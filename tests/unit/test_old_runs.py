"""reports/ keeps the last runs and those that somebody named; no page of another's is replaced."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.cli.options import make_report_folder, mark_named, remove_old_runs
from shaderlab.cli.recorded_run import Journal, RunPlan, load_plan
from shaderlab.errors import UsageError
from shaderlab.files import REPORT_MARK
from shaderlab.model.options import Limits, RunOptions
from shaderlab.model.records import Run
from shaderlab.report import html


def run(parent: Path, name: str, age: int) -> Path:
    folder = parent / name
    (folder / "images").mkdir(parents=True)
    (folder / "records.jsonl").write_text("{}\n")
    (folder / "images" / "a.png").write_bytes(b"x")
    os.utime(folder, (1e9 - age, 1e9 - age))
    return folder


def test_the_last_runs_stay(tmp_path: Path) -> None:
    names = [f"20260101-00000{n}" for n in range(6)] + ["20260101-000005-2"]
    for age, name in enumerate(reversed(names)):
        run(tmp_path, name, age)
    assert remove_old_runs(tmp_path, 0) == 0 and len(list(tmp_path.iterdir())) == 7
    assert remove_old_runs(tmp_path, 3) == 4 and remove_old_runs(tmp_path, 3) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == names[-3:]
    assert remove_old_runs(tmp_path / "gone", 3) == 0


def test_what_was_named_or_is_not_a_run_of_the_labs_is_never_removed(tmp_path: Path) -> None:
    old = [run(tmp_path, f"2025010{n}-000000", 100 + n) for n in range(1, 6)]
    mark_named(old[0])
    (old[1] / REPORT_MARK).touch()
    make_report_folder(old[1])
    (old[2] / "records.jsonl").unlink()
    run(tmp_path, "before-the-change", 200)
    (tmp_path / "20250109-000000").symlink_to(old[3], target_is_directory=True)
    (tmp_path / "notes").write_text("")
    with (old[3] / "records.jsonl").open("rb") as going_on:
        fcntl.flock(going_on, fcntl.LOCK_EX)
        for n in range(3):
            run(tmp_path, f"20260101-00000{n}", 9 - n)
        assert remove_old_runs(tmp_path, 1) == 3  # old[4] and two new ones
        assert all(folder.is_dir() for folder in old[:4]) and not old[4].exists()
    assert (tmp_path / "before-the-change").is_dir() and (tmp_path / "notes").exists()
    assert remove_old_runs(tmp_path, 1) == 1 and not old[3].exists()


@pytest.mark.parametrize("name", ["index.html", "run.json", "page/style.css", "thesis.txt"])
def test_a_folder_with_files_of_others_takes_no_report(tmp_path: Path, name: str) -> None:
    file = tmp_path / "site" / name
    file.parent.mkdir(parents=True)
    file.write_text("mine")
    with pytest.raises(UsageError, match="no report's"):
        make_report_folder(tmp_path / "site")
    assert [path for path in (tmp_path / "site").rglob("*") if path.is_file()] == [file]


EMPTY = Run(driver={}, versions={}, started="", seconds=0.0, records=())
TAKING: dict[str, Callable[[Path], object]] = {
    "run": make_report_folder,
    "run --resume": lambda folder: load_plan(str(folder), Limits()),
    "report": lambda folder: html.write(EMPTY, folder),
}


@pytest.mark.parametrize("name", ["images", "page", "records.jsonl"])
@pytest.mark.parametrize("command", TAKING)
def test_a_report_is_not_written_through_links(tmp_path: Path, name: str, command: str) -> None:
    folder = make_report_folder(tmp_path / "run")
    assert make_report_folder(folder) == folder
    (folder / name).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(UsageError, match="of its own here"):
        TAKING[command](folder)
    assert not (tmp_path / "elsewhere").exists()


def test_a_copy_that_shares_a_run_s_files_keeps_what_it_has(tmp_path: Path) -> None:
    """As `cp -al` makes one: a new run into either folder is not written into the other."""
    folder = make_report_folder(tmp_path / "run")
    with Journal(folder, RunPlan(started="earlier", options=RunOptions())):
        pass
    (tmp_path / "copy").hardlink_to(folder / "records.jsonl")
    kept = (tmp_path / "copy").read_bytes()
    with Journal(folder, RunPlan(started="now", options=RunOptions())):
        pass
    assert (tmp_path / "copy").read_bytes() == kept and b"earlier" in kept
    assert b'"now"' in (folder / "records.jsonl").read_bytes()


def test_a_run_removes_what_the_project_does_not_keep(
    fake_lab: Callable[..., list[Any]],
    case_folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fake_lab({})
    monkeypatch.chdir(case_folder)
    Path("pyproject.toml").write_text("[tool.shaderlab]\nkeep = 2\n")
    Path("site").mkdir()
    Path("site/index.html").write_text("mine")
    result = CliRunner().invoke(cli, ["run", "lamp.py", "--report", "site"])
    assert result.exit_code == 2 and Path("site/index.html").read_text() == "mine"
    old = [run(Path("reports"), f"2025010{n}-000000", 100 - n) for n in range(1, 4)]
    result = CliRunner().invoke(cli, ["run", "lamp.py"])
    assert result.exit_code == 0 and "removed 2 old runs from reports/" in result.output
    assert [folder.exists() for folder in old] == [False, False, True]
    assert Path("reports/latest/index.html").is_file()
