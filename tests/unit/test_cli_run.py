"""`shaderlab run`, with a lab that draws nothing: what is selected, printed, written, returned."""

from __future__ import annotations

import dataclasses
import errno
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from shaderlab.cli import cli
from shaderlab.engine import worker
from shaderlab.model.records import Record

Install = Callable[[Mapping[str, Record]], list[Any]]


@pytest.fixture
def shaderlab(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Result]:
    """Calls the command line in an empty folder; anything but a clean exit is an error."""
    monkeypatch.chdir(tmp_path)

    def call(*args: str | Path) -> Result:
        result = CliRunner().invoke(cli, [str(arg) for arg in args])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result

    return call


def ran(log: list[Any]) -> list[str]:
    return [entry for entry in log if isinstance(entry, str) and entry != "closed"]


def test_a_case_file_runs_every_variant_and_reports(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install, tmp_path: Path
) -> None:
    log = fake_lab({})
    result = shaderlab("run", case_folder / "lamp.py")
    assert result.exit_code == 0, result.output
    assert ran(log) == ["lamp[near]", "lamp[far]"]
    assert log[-1] == "closed"
    assert "1 case, 2 variants: 2 passed" in result.output
    page = tmp_path / "reports" / "latest" / "index.html"
    assert page.is_file()
    assert result.output.splitlines()[-1].startswith("report: reports/")


def test_a_folder_stands_for_its_case_files(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install
) -> None:
    log = fake_lab({})
    (case_folder / "helper.py").write_text("raise SystemExit('helpers are not imported')\n")
    assert shaderlab("run", case_folder).exit_code == 0
    assert ran(log) == ["lamp[near]", "lamp[far]"]


def test_one_variant(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install
) -> None:
    log = fake_lab({})
    assert shaderlab("run", case_folder / "lamp.py", "--variant", "far").exit_code == 0
    assert ran(log) == ["lamp[far]"]


def test_a_failure_shows_the_worst_pixel_and_where_to_look(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install, failing: Record
) -> None:
    fake_lab({"far": failing})
    result = shaderlab("run", case_folder / "lamp.py")
    assert result.exit_code == 1
    for part in (
        "lamp[far]",
        "47 of 4096 values outside",
        "worst pixel (3, 17), component g",
        "measured   (0.5, 0.25)",
        "reference  (0.5, 0.125)",
        "[0.1249, 0.1251]",
        "distance = 2.5",
        "formula    reference/lamp.py:12",
        "shader     shaders/lamp.frag:7",
        "1 passed, 1 failed",
    ):
        assert part in result.output, part


@pytest.mark.parametrize("status", ["fail", "error", "crash", "timeout"])
def test_whatever_went_wrong_exits_1(
    shaderlab: Callable[..., Result],
    case_folder: Path,
    fake_lab: Install,
    passing: Record,
    status: Any,
) -> None:
    fake_lab({"far": dataclasses.replace(passing, status=status, message="went wrong")})
    result = shaderlab("run", case_folder / "lamp.py")
    assert result.exit_code == 1
    assert "went wrong" in result.output


def test_unsupported_is_no_failure_unless_nothing_else_ran(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install, passing: Record
) -> None:
    fake_lab({"far": dataclasses.replace(passing, status="unsupported", message="no tessellation")})
    assert shaderlab("run", case_folder / "lamp.py").exit_code == 0
    assert shaderlab("run", case_folder / "lamp.py", "--variant", "far").exit_code == 1


def test_an_interrupted_run_reports_what_it_did(
    shaderlab: Callable[..., Result],
    case_folder: Path,
    fake_lab: Install,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fake_lab({})
    lab = worker.SceneRunner()
    run = type(lab).run

    def interrupt(self: Any, scene: Any) -> Record:
        if scene.variant == "far":
            raise KeyboardInterrupt
        record: Record = run(self, scene)
        return record

    monkeypatch.setattr(type(lab), "run", interrupt)
    result = shaderlab("run", case_folder / "lamp.py")
    assert result.exit_code == 130
    assert "1 case: 1 passed" in result.output and "interrupted" in result.output
    assert (tmp_path / "reports" / "latest" / "index.html").is_file()


def test_compilers_messages_are_shown_once(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install, refused: Record
) -> None:
    fake_lab({"lamp": refused})
    result = shaderlab("run", case_folder / "lamp.py", "--variant", "near")
    assert result.exit_code == 1
    message = "shaders/lamp.frag:7: error: 'x' : undeclared identifier"
    assert result.output.count(message) == 1


def test_json_goes_to_the_file(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install, tmp_path: Path
) -> None:
    fake_lab({})
    assert shaderlab("run", case_folder / "lamp.py", "--json", "deep/out.json").exit_code == 0
    data = json.loads((tmp_path / "deep" / "out.json").read_text())
    assert set(data) >= {"driver", "seconds", "cases"}
    assert [(c["id"], c["variant"], c["status"]) for c in data["cases"]] == [
        ("lamp", "near", "pass"),
        ("lamp", "far", "pass"),
    ]


def test_json_on_stdout_is_all_that_is_there(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install
) -> None:
    fake_lab({})
    result = shaderlab("run", case_folder / "lamp.py", "--json", "-")
    assert len(json.loads(result.stdout)["cases"]) == 2
    assert "2 passed" in result.stderr


@pytest.mark.parametrize(("status", "exit_code"), [("pass", 2), ("fail", 1)])
def test_an_output_without_room_costs_neither_verdict_nor_report(
    shaderlab: Callable[..., Result],
    case_folder: Path,
    fake_lab: Install,
    passing: Record,
    tmp_path: Path,
    status: Any,
    exit_code: int,
) -> None:
    fake_lab({"far": dataclasses.replace(passing, status=status)})
    (tmp_path / "full").symlink_to("/dev/full")
    outputs = ("--json", "full", "--junit", "out.xml", "--report", "here")
    result = shaderlab("run", case_folder / "lamp.py", *outputs)
    assert result.exit_code == exit_code
    assert "full: can't write here: No space left on device" in result.stderr
    assert (tmp_path / "out.xml").is_file() and (tmp_path / "here" / "index.html").is_file()
    assert (tmp_path / "full").is_symlink()


@pytest.mark.parametrize("folder", [(), ("--report", "here")])
def test_where_nothing_may_be_written_another_folder_is_asked_for(
    shaderlab: Callable[..., Result],
    case_folder: Path,
    fake_lab: Install,
    monkeypatch: pytest.MonkeyPatch,
    folder: tuple[str, ...],
) -> None:
    def read_only(*_: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    fake_lab({})
    monkeypatch.setattr(os, "mkdir", read_only)
    result = shaderlab("run", case_folder / "lamp.py", *folder)
    assert result.exit_code == 2
    assert "Read-only file system" in result.stderr and "→ name another folder" in result.stderr


def test_junit(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install, tmp_path: Path
) -> None:
    fake_lab({})
    assert shaderlab("run", case_folder / "lamp.py", "--junit", "out.xml").exit_code == 0
    assert "<testcase" in (tmp_path / "out.xml").read_text()


def test_the_report_goes_where_it_is_asked_to(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install, tmp_path: Path
) -> None:
    log = fake_lab({})
    result = shaderlab("run", case_folder / "lamp.py", "--report", "here", "--size", "128")
    assert result.exit_code == 0
    assert (tmp_path / "here" / "index.html").is_file()
    assert not (tmp_path / "reports").exists()
    assert log[0].size == 128 and Path(log[0].folder) == Path("here")


def test_a_replaced_shader_is_handed_on(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install, tmp_path: Path
) -> None:
    log = fake_lab({})
    (tmp_path / "mine.frag").write_text("void main() {}\n")
    run = ("run", case_folder / "lamp.py", "--shader")
    assert shaderlab(*run, "lamp.frag=mine.frag").exit_code == 0
    assert dict(log[0].shaders) == {"lamp.frag": Path("mine.frag")}
    assert shaderlab(*run, "lamp.frag").exit_code == 2
    assert shaderlab(*run, "lamp.frag=gone.frag").exit_code == 2


def test_files_of_one_name_are_told_apart_by_their_folders(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install
) -> None:
    log = fake_lab({})
    for folder in ("a", "b"):
        (case_folder / folder).mkdir()
        (case_folder / folder / "lamp.py").write_text((case_folder / "lamp.py").read_text())
    result = shaderlab("run", case_folder, "--variant", "far", "--json", "out.json")
    assert result.exit_code == 0, result.output
    ids = ["a/lamp", "b/lamp", "my_cases/lamp"]
    assert ran(log) == [f"{case_id}[far]" for case_id in ids]
    assert [case["id"] for case in json.loads(Path("out.json").read_text())["cases"]] == ids
    listed = shaderlab("list", case_folder).output
    assert all(case_id in listed for case_id in ids)
    # Nothing tells these two apart.
    for name in ("sun_lamp.py", "sun-lamp.py"):
        (case_folder / name).write_text((case_folder / "lamp.py").read_text())
    result = shaderlab("run", case_folder)
    assert result.exit_code == 2 and "two cases of one folder have the id" in result.output


def test_what_takes_case_and_is_no_case_is_named(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install
) -> None:
    log = fake_lab({})
    case = case_folder / "lamp.py"
    case.rename(case_folder / "test_lamp.py")
    (case_folder / "many.py").write_text("from shaderlab import Case\ncases = []\n")
    result = shaderlab("run", "my_cases")  # a folder, though it is spelt like an id
    assert result.exit_code == 0 and ran(log) == ["test-lamp[near]", "test-lamp[far]"]
    assert "not a case: my_cases/many.py: it assigns no `case`" in result.output
    (case_folder / "test_lamp.py").unlink()
    result = shaderlab("run", "my_cases")
    assert result.exit_code == 2 and "many.py" in result.output
    result = shaderlab("run", "my_case")
    assert result.exit_code == 2 and "did you mean my_cases?" in result.output


@pytest.mark.parametrize(
    ("args", "hint"),
    [
        ((), "--all"),
        (("nowhere/lamp.py",), "no such file"),
        (("atenuation",), "attenuation"),
        (("attenuation[51]",), "[5"),
        (("attenuation", "--variant", "nothing"), "there is"),
        (("--size", "0", "attenuation"), "1<=x<=4096"),
        (("--no-such-option",), "--no-such-option"),
    ],
)
def test_wrong_usage_exits_2_with_a_hint(
    shaderlab: Callable[..., Result], fake_lab: Install, args: tuple[str, ...], hint: str
) -> None:
    fake_lab({})
    result = shaderlab("run", *args)
    assert result.exit_code == 2
    assert "Traceback" not in result.output
    assert hint.strip("[") in result.output


def test_a_wrong_case_file_is_one_message(
    shaderlab: Callable[..., Result], case_folder: Path, fake_lab: Install
) -> None:
    fake_lab({})
    file = case_folder / "lamp.py"
    file.write_text(file.read_text().replace("Variant(", "Variannt("))
    result = shaderlab("run", file)
    assert result.exit_code == 1
    assert "lamp.py" in result.output and "Traceback" not in result.output
    assert not (case_folder.parent / "reports").exists()
