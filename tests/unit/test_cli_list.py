"""The command line's other commands, its help, and how it says what is wrong."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import COMMANDS, cli, list_cases
from shaderlab.cli.selecting import select_jobs
from shaderlab.engine.jobs import CaseInfo
from shaderlab.errors import CaseError, UsageError
from tests.catalogue import shipped


def call(*args: str) -> Any:
    return CliRunner().invoke(cli, args)


@pytest.fixture(scope="module")
def listed(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Any]:
    """What `list` prints of the cases that ship with the lab, and what it writes."""
    file = tmp_path_factory.mktemp("listed") / "cases.json"
    return call("list", "--json", str(file)).output, json.loads(file.read_text())


def test_list_json_has_the_documented_fields(listed: tuple[str, Any]) -> None:
    entries = listed[1]["cases"]
    assert [entry["id"] for entry in entries] == list(shipped())
    for entry in entries:
        assert list(entry) == ["id", "section", "title", "variants", "file"]
        assert entry["variants"] and all(isinstance(name, str) for name in entry["variants"])
        assert Path(entry["file"]).is_file()


def test_list_names_every_case_once(listed: tuple[str, Any]) -> None:
    for case_id in shipped():
        assert listed[0].count(f"  {case_id} ") == 1


def test_shipped_cases_are_listed_by_their_texts_alone_and_as_when_loaded(
    listed: tuple[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(list_cases, "load_selected", lambda targets: pytest.fail("loaded"))
    assert call("list").output == listed[0]


def test_shipped_cases_written_in_another_way_are_loaded(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "own.py"
    file.write_text('from shaderlab import Case\nTITLE = "Own"\ncase = Case(title=TITLE)\n')
    monkeypatch.setattr(list_cases, "shipped_cases", lambda: [file])
    monkeypatch.setattr(list_cases, "load_selected", lambda targets: [])
    assert list_cases.read_shipped() == []
    file.write_text(file.read_text().replace("TITLE)", '"A \\"word\\"", section="1")'))
    assert list_cases.read_shipped() == []


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command: str) -> None:
    result = call(command, "--help")
    assert result.exit_code == 0
    assert f"Usage: cli {command}" in result.output
    assert "Examples:" in result.output or "Exit code" in result.output


def test_help_teaches() -> None:
    result = call("--help")
    assert result.exit_code == 0
    assert "shaderlab run attenuation" in result.output
    for command in COMMANDS:
        assert f"  {command}" in result.output


def test_a_misspelt_command_is_corrected() -> None:
    result = call("complie")
    assert result.exit_code == 2
    assert "compile" in result.output


@pytest.mark.parametrize(
    ("error", "code"),
    [(UsageError("not there", remedy="look"), 2), (CaseError("bad", file="a.py", line=3), 1)],
)
def test_errors_are_one_block_unless_debugging(
    monkeypatch: pytest.MonkeyPatch, error: Exception, code: int
) -> None:
    def fail(targets: object) -> None:
        raise error

    monkeypatch.setattr(list_cases, "load_selected", fail)
    result = call("list", ".")
    assert result.exit_code == code
    assert result.stderr == f"shaderlab: {error}\n"
    assert call("--debug", "list", ".").exception is error
    monkeypatch.setenv("SHADERLAB_DEBUG", "1")
    assert call("list", ".").exception is error


def load(files: Sequence[Path]) -> list[CaseInfo]:
    """What is in files that are all wrong."""
    return [CaseInfo(file=str(f), id=f.stem, error=CaseError(f.stem)) for f in files]


def test_of_several_wrong_files_each_is_a_job_and_one_alone_an_error(tmp_path: Path) -> None:
    for name in ("one.py", "two.py"):
        (tmp_path / name).touch()
    names = [str(tmp_path / "one.py"), str(tmp_path / "two.py")]
    assert [job.trouble for job in select_jobs(names, False, (), load)] == ["one", "two"]
    with pytest.raises(CaseError, match="one"):
        select_jobs(names[:1], False, (), load)


def test_cases_that_cannot_be_loaded_hide_no_others(tmp_path: Path) -> None:
    (tmp_path / "good.py").write_text(
        "from shaderlab import Case, coverage, fullscreen\n"
        'case = Case(title="Good", passes=fullscreen("a.frag"), expect=[coverage(1)])\n'
    )
    (tmp_path / "bad.py").write_text("from shaderlab import Case\nimport nothing\ncase = Case()\n")
    result = call("list", str(tmp_path))
    assert result.exit_code == 1
    assert "  good " in result.stdout and "bad" not in result.stdout
    assert "bad.py" in result.stderr and "No module named 'nothing'" in result.stderr


def test_a_link_to_itself_is_a_wrong_file_like_others(tmp_path: Path) -> None:
    for name in ("one.py", "two.py"):
        (tmp_path / name).symlink_to(name)
    assert [job.id for job in select_jobs([str(tmp_path)], False, (), load)] == ["one", "two"]
