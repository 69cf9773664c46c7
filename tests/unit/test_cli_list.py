"""The command line's other commands, its help, and how it says what is wrong."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import COMMANDS, cli, list_cases
from shaderlab.cli.selecting import load_shipped_cases, select_jobs
from shaderlab.engine import catalogue
from shaderlab.engine.jobs import CaseInfo
from shaderlab.errors import CaseError, UsageError
from tests.catalogue import shipped


def call(*args: str) -> Any:
    return CliRunner().invoke(cli, args)


@pytest.fixture
def loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    """The command takes the catalogue that this process has loaded."""
    cases = {Path(case.file): case for case in shipped().values()}
    monkeypatch.setattr(
        catalogue, "load_cases", lambda files: {cases[f].id: cases[f] for f in files}
    )


def test_list_json_has_the_documented_fields() -> None:
    entries = json.loads(call("list", "--json", "-").stdout)
    assert [entry["id"] for entry in entries] == list(shipped())
    for entry in entries:
        assert list(entry) == ["id", "section", "title", "variants", "file"]
        assert entry["variants"] and all(isinstance(name, str) for name in entry["variants"])
        assert Path(entry["file"]).is_file()


@pytest.mark.usefixtures("loaded")
def test_list_names_every_case_once() -> None:
    output = call("list").output
    for case_id in shipped():
        assert output.count(f"  {case_id} ") == 1


@pytest.mark.usefixtures("loaded")
def test_list_of_one_chapter() -> None:
    entries = json.loads(call("list", "--chapter", "5", "--json", "-").stdout)
    assert entries and all(entry["section"].startswith("5.") for entry in entries)
    nothing = call("list", "--chapter", "99")
    assert nothing.exit_code == 2 and "did you mean 9?" in nothing.output


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
    def fail() -> None:
        raise error

    monkeypatch.setattr(list_cases, "_load_shipped", fail)
    result = call("list")
    assert result.exit_code == code
    assert result.stderr == f"shaderlab: {error}\n"
    assert call("--debug", "list").exception is error
    monkeypatch.setenv("SHADERLAB_DEBUG", "1")
    assert call("list").exception is error


def test_facts_are_kept_for_these_very_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", str(tmp_path / "cache"))
    course = tmp_path / "course"
    (course / "chapter").mkdir(parents=True)
    lamp = course / "chapter" / "lamp.py"
    lamp.write_text("case = 1\n")
    loaded = []

    def load() -> list[CaseInfo]:
        loaded.append(lamp.read_text())
        return [CaseInfo(file=str(lamp), id="lamp", title="Ein Licht ☼", variants=("a", "b"))]

    first = load_shipped_cases(course, load)
    assert load_shipped_cases(course, load) == first == load()
    assert len(loaded) == 2  # the second one is the line above
    lamp.write_text("case = 2\n")
    load_shipped_cases(course, load)
    assert loaded[2:] == ["case = 2\n"]
    (kept,) = (tmp_path / "cache").glob("cases-*.json")
    for damaged in (b"", b"[]", b'{"key": 1}', kept.read_bytes().replace(b'"id"', b'"di"')):
        kept.write_bytes(damaged)
        assert load_shipped_cases(course, load) == first
    assert len(loaded) == 7
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", "")
    assert load_shipped_cases(course, load) == first and len(loaded) == 8


def test_all_shipped_cases_are_loaded_once_for_several_commands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", str(tmp_path / "cache"))
    own = tmp_path / "own.py"
    own.touch()
    asked: list[int] = []

    def load(files: Sequence[Path]) -> list[CaseInfo]:
        asked.append(len(files))
        return [CaseInfo(file=str(f), id=f.stem, section="2.1", variants=("a",)) for f in files]

    first = select_jobs([], True, (), load)
    assert select_jobs([], True, (), load) == first and len(first) == len(shipped())
    assert [job.id for job in select_jobs([str(own)], True, (), load)] == [
        *(j.id for j in first),
        "own",
    ]
    assert select_jobs([first[0].file], False, (), load) == first[:1]
    assert asked == [len(shipped()), 1, 1]


def test_what_a_case_raises_is_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", str(tmp_path / "cache"))

    def fails() -> list[CaseInfo]:
        raise CaseError("so it is")

    for _ in range(2):
        with pytest.raises(CaseError, match="so it is"):
            load_shipped_cases(tmp_path, fails)


def test_what_could_not_be_loaded_is_not_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", str(tmp_path / "cache"))
    broken = CaseInfo(file="a.py", id="a", error=CaseError("so it is"))
    assert load_shipped_cases(tmp_path, lambda: [broken]) == [broken]
    assert load_shipped_cases(tmp_path, list) == []


def test_of_several_wrong_files_each_is_a_job_and_one_alone_an_error(tmp_path: Path) -> None:
    def load(files: Sequence[Path]) -> list[CaseInfo]:
        return [CaseInfo(file=str(f), id=f.stem, error=CaseError(f.stem)) for f in files]

    for name in ("one.py", "two.py"):
        (tmp_path / name).touch()
    names = [str(tmp_path / "one.py"), str(tmp_path / "two.py")]
    assert [job.trouble for job in select_jobs(names, False, (), load)] == ["one", "two"]
    with pytest.raises(CaseError, match="one"):
        select_jobs(names[:1], False, (), load)


@pytest.mark.usefixtures("loaded")
def test_cases_that_miss_packages_hide_no_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    load = catalogue.load_cases

    def some(files: list[Path]) -> dict[str, Any]:
        if files[0].stem in ("gamma", "spotlight"):
            raise CaseError("this needs a package", remedy="pip install 'shaderlab[x]'")
        if files[0].stem == "scale":
            raise CaseError("so it is")
        return load(files)

    monkeypatch.setattr(catalogue, "load_cases", some)
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", "")
    result = call("list")
    assert result.exit_code == 1
    assert "  attenuation " in result.stdout and "spotlight " not in result.stdout
    assert result.stderr == (
        "shaderlab: so it is\n"
        "shaderlab: 2 more cases need packages that are not here: gamma, spotlight\n"
        "  → pip install 'shaderlab[x]'\n"
    )
