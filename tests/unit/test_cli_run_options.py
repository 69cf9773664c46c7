"""Options of `shaderlab run` that decide how, not what: in this process, with a lab that draws
nothing."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from shaderlab.cli import cli
from shaderlab.cli.recorded_run import read_journal
from shaderlab.model.records import Record

Install = Callable[[Mapping[str, Record]], list[Any]]


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Result]:
    """Calls `shaderlab run` in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return lambda *args: CliRunner().invoke(cli, ["run", *map(str, args)], catch_exceptions=False)


def test_without_pictures_the_lab_gets_no_folder(
    call: Callable[..., Result], case_folder: Path, fake_lab: Install
) -> None:
    log = fake_lab({})
    assert call(case_folder, "--report", "a").exit_code == 0
    assert call(case_folder, "--report", "b", "--no-pictures").exit_code == 0
    folders = [entry.picture_folder for entry in log if dataclasses.is_dataclass(entry)]
    assert folders == [Path("a"), None]
    assert Path("b/index.html").is_file() and len(read_journal(Path("b"))[1]) == 2


def test_a_broken_case_among_others_costs_only_itself(
    call: Callable[..., Result], case_folder: Path, fake_lab: Install
) -> None:
    fake_lab({})
    text = (case_folder / "lamp.py").read_text()
    (case_folder / "broken.py").write_text(text.replace("section=", "sektion="))
    result = call(case_folder, "--report", "out")
    assert result.exit_code == 1
    assert "2 passed, 1 in error" in result.output and "sektion" in result.output
    assert [record.status for record in read_journal(Path("out"))[1]] == ["error", "pass", "pass"]


def test_a_damaged_record_is_told_and_made_again(
    call: Callable[..., Result], case_folder: Path, fake_lab: Install
) -> None:
    log = fake_lab({})
    assert call(case_folder, "--report", "out").exit_code == 0
    journal = Path("out/records.jsonl")
    lines = journal.read_bytes().splitlines(keepends=True)
    journal.write_bytes(b"".join([lines[0], lines[1], b"x" + lines[2]]))
    log.clear()
    result = call("--resume", "out")
    assert result.exit_code == 0 and "2 passed" in result.output
    assert "out/records.jsonl:3: this record is damaged" in result.output
    assert [entry for entry in log if isinstance(entry, str)] == ["lamp[far]", "closed"]


def test_without_a_working_folder_a_run_says_so(
    call: Callable[..., Result], case_folder: Path, fake_lab: Install, tmp_path: Path
) -> None:
    fake_lab({})
    (tmp_path / "gone").mkdir()
    os.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    result = call(case_folder / "lamp.py")
    assert result.exit_code != 0 and "the working folder has been removed" in result.output


def test_what_an_interrupt_left_out_is_run_later(
    call: Callable[..., Result], case_folder: Path, fake_lab: Install, failing: Record
) -> None:
    log = fake_lab({"near": failing})
    assert call(case_folder, "--report", "out").exit_code == 1
    journal = Path("out/records.jsonl")
    lines = journal.read_text().splitlines(keepends=True)
    journal.write_text("".join(lines[:2]))
    log.clear()
    assert call("--resume", "out").exit_code == 1  # what had failed has failed
    assert [entry for entry in log if isinstance(entry, str)] == ["lamp[far]", "closed"]
    assert [record.variant for record in read_journal(Path("out"))[1]] == ["near", "far"]
    assert call("--resume", "out", "gamma").exit_code == 2


@pytest.mark.parametrize(
    "args",
    [
        ("--drivers", "llvmpipe"),
        ("--drivers", "llvmpipe,llvmpipe"),
        ("--drivers", "llvmpipe,mystery"),
        ("--drivers", "llvmpipe,softpipe", "--driver", "llvmpipe"),
        ("--drivers", "llvmpipe,softpipe", "--resume", "out"),
        ("--drivers", "llvmpipe,softpipe", "-j", "0"),
        ("--driver", "mystery"),
        *((name, x) for name in ("--timeout", "--memory") for x in ("nan", "inf", "1e12", "-1")),
    ],
)
def test_options_that_do_not_go_together_are_wrong_usage(
    call: Callable[..., Result], case_folder: Path, fake_lab: Install, args: tuple[str, ...]
) -> None:
    log = fake_lab({})
    assert call(case_folder, *args).exit_code == 2
    assert log == [] and not Path("reports").exists()
