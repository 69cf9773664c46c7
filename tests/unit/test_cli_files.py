"""Where the command line writes: run folders, the pointer to the latest, JSON files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from shaderlab.cli.options import (
    find_latest,
    make_report_folder,
    make_run_folder,
    point_latest,
    write_json,
    write_output,
)
from shaderlab.errors import UsageError


def test_runs_that_start_together_get_folders_of_their_own(tmp_path: Path) -> None:
    folders = [make_run_folder(tmp_path / "reports") for _ in range(5)]
    assert len(set(folders)) == 5
    assert all(folder.is_dir() for folder in folders)


def test_latest_follows_the_last_run(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no run"):
        find_latest(tmp_path)
    for name in ("1", "2"):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "run.json").write_text("{}")
        point_latest(folder)
        assert find_latest(tmp_path) == folder
    assert sorted(path.name for path in tmp_path.iterdir()) == ["1", "2", "latest"]
    (tmp_path / "latest").unlink()
    assert find_latest(tmp_path).name == "2"


def test_latest_leaves_a_real_folder_alone(tmp_path: Path) -> None:
    (tmp_path / "latest").mkdir()
    (tmp_path / "latest" / "kept").write_text("")
    (tmp_path / "1").mkdir()
    point_latest(tmp_path / "1")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["1", "latest"]
    assert (tmp_path / "latest" / "kept").exists()


def test_what_cannot_be_written_is_wrong_usage(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for attempt in (
        lambda: make_run_folder(tmp_path / "file"),
        lambda: make_report_folder(tmp_path / "file"),
        lambda: write_json([], str(tmp_path / "file" / "out.json")),
        lambda: write_json([], str(tmp_path)),
    ):
        with pytest.raises(UsageError, match=r"folder|can't write"):
            attempt()


def test_json_replaces_the_file_whole(tmp_path: Path) -> None:
    file = tmp_path / "out.json"
    file.write_text('[{"a": "' + "x" * 10_000)
    write_json([{"a": "½"}], str(file))
    assert json.loads(file.read_text(encoding="utf-8")) == [{"a": "½"}]
    assert [path.name for path in tmp_path.iterdir()] == ["out.json"]


@pytest.mark.parametrize("there", ["#version 330 core\n", "[project]\n", "my thesis", "\0\0"])
def test_an_output_replaces_no_file_of_another_kind(tmp_path: Path, there: str) -> None:
    """A shader or a case that is named as an output by mistake stays."""
    file = tmp_path / "out"
    for text in ('{"cases": []}', "[]", "<?xml?>\n<testsuites>", "## passed", "<!doctype html>"):
        file.write_text(there)
        with pytest.raises(UsageError, match="would be replaced"):
            write_output(text, str(file))
        assert file.read_text() == there
        file.write_text("")
        for _ in range(2):
            write_output(text, str(file))
