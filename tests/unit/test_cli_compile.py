"""`shaderlab compile` on files and folders that are right, wrong, or not there."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

GOOD = "#version 330 core\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n"
BAD = "#version 330 core\nout vec4 c;\nvoid main()\n{\n    c = vec4(nothing);\n}\n"


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files are compiled in this process, unless a test says otherwise: a worker takes its time to
    start."""
    monkeypatch.setenv("SHADERLAB_JOBS", "0")


def compile_(*args: str | Path) -> Any:
    return CliRunner().invoke(cli, ["compile", *map(str, args)], catch_exceptions=False)


def test_a_good_file(tmp_path: Path) -> None:
    (tmp_path / "good.frag").write_text(GOOD)
    result = compile_(tmp_path / "good.frag")
    assert result.exit_code == 0
    assert [line.split() for line in result.output.splitlines()] == [
        ["target", "accepted", "refused"],
        ["glsl", "1", "0"],
        ["opengl", "1", "0"],
        ["vulkan", "1", "0"],
    ]


def test_a_bad_file_is_named_with_its_line_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.frag").write_text(BAD)
    result = compile_("bad.frag")
    assert result.exit_code == 1
    assert result.output.count("bad.frag:5: error: ") == 1
    assert "nothing" in result.output


def test_a_folder_is_searched_and_each_file_counted(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "good.frag").write_text(GOOD)
    (tmp_path / "bad.frag").write_text(BAD)
    (tmp_path / "lib.glsl").write_text("float half_of(float x) { return 0.5 * x; }\n")
    result = compile_(tmp_path, "--json", tmp_path / "out.json", "-j", "1")
    assert result.exit_code == 1
    data = json.loads((tmp_path / "out.json").read_text())
    assert set(data) == {"files"}
    assert [(Path(e["path"]).name, e["target"], e["ok"]) for e in data["files"]] == [
        (name, target, name != "bad.frag")
        for name in ("good.frag", "bad.frag", "lib.glsl")
        for target in ("glsl", "opengl", "vulkan")
    ]
    keys = {"path", "stage", "target", "ok", "diagnostics", "spirv_bytes"}
    assert all(keys <= set(entry) for entry in data["files"])
    good, bad = data["files"][1], data["files"][3]
    assert good["stage"] == "fragment" and good["diagnostics"] == []
    assert good["spirv_bytes"] > 100 and good["instructions"] > 10 and good["valid"] is True
    assert bad["spirv_bytes"] == 0 and bad["diagnostics"][0]["line"] == 5
    assert bad["diagnostics"][0]["token"] == "nothing"


def test_defines_and_includes(tmp_path: Path) -> None:
    (tmp_path / "common").mkdir()
    (tmp_path / "common" / "half.glsl").write_text("float half_of(float x) { return 0.5 * x; }\n")
    (tmp_path / "lamp.frag").write_text(
        '#version 330 core\n#include "half.glsl"\nout vec4 c;\n'
        "void main() { c = vec4(half_of(LIGHTS)); }\n"
    )
    lamp = tmp_path / "lamp.frag"
    assert compile_(lamp, "--include", tmp_path / "common").exit_code == 1
    assert compile_(lamp, "--define", "LIGHTS=4.0").exit_code == 1
    assert compile_(lamp, "-I", tmp_path / "common", "-D", "LIGHTS=4.0").exit_code == 0


def test_shipped_shaders_find_their_own_library(repository: Path) -> None:
    result = compile_(repository / "shaders" / "ch05_lighting" / "attenuation.frag")
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("path", ["gone.frag", "gone/", "empty"])
def test_what_is_not_there_is_wrong_usage(tmp_path: Path, path: str) -> None:
    (tmp_path / "empty").mkdir()
    assert compile_(tmp_path / path).exit_code == 2


@pytest.mark.parametrize("command", ["compile", "audit"])
def test_files_of_other_languages_in_a_folder_are_told(tmp_path: Path, command: str) -> None:
    (tmp_path / "a.frag").write_text(
        "#version 330 core\nout vec4 c;\nvoid main() { c = vec4(1.0); }"
    )
    for name in ("b.hlsl", "c.WGSL"):
        (tmp_path / name).write_text("another language")
    result = CliRunner().invoke(cli, [command, str(tmp_path), "-j", "0"])
    assert result.exit_code == 0, result.output
    assert "b.hlsl and 1 more" in result.stderr
    result = CliRunner().invoke(cli, [command, str(tmp_path / "a.frag"), "-j", "0"])
    assert "b.hlsl" not in result.output


def test_an_include_folder_that_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "good.frag").write_text(GOOD)
    assert compile_(tmp_path / "good.frag", "-I", tmp_path / "gone").exit_code == 2


def test_no_path_is_wrong_usage() -> None:
    assert compile_().exit_code == 2


def test_targets_and_stage_can_be_chosen(tmp_path: Path) -> None:
    (tmp_path / "lamp.txt").write_text(GOOD)
    result = compile_(tmp_path / "lamp.txt", "--stage", "fragment", "-t", "vulkan", "-t", "glsl")
    assert result.exit_code == 0, result.output
    assert [line.split()[0] for line in result.output.splitlines()] == ["target", "vulkan", "glsl"]
    (tmp_path / "any.txt").write_text("#version 330 core\nvoid main() {}\n")
    assert compile_(tmp_path / "any.txt").exit_code == 1
    assert compile_(tmp_path / "lamp.txt", "--target", "metal").exit_code == 2
    assert compile_(tmp_path / "lamp.txt", "--stage", "pixel").exit_code == 2


def test_quiet_prints_messages_only(tmp_path: Path) -> None:
    (tmp_path / "good.frag").write_text(GOOD)
    assert compile_(tmp_path / "good.frag", "--quiet").output == ""
    (tmp_path / "bad.frag").write_text(BAD)
    lines = compile_(tmp_path, "-q").output.splitlines()
    assert len(lines) == 1 and ":5: error: 'nothing' : undeclared identifier" in lines[0]


def test_json_on_standard_output_is_all_there_is_on_it(tmp_path: Path) -> None:
    (tmp_path / "bad.frag").write_text(BAD)
    result = compile_(tmp_path, "--json", "-")
    assert len(json.loads(result.stdout)["files"]) == 3
    assert "undeclared identifier" in result.stderr and "refused" in result.stderr


def test_a_program_is_linked(tmp_path: Path) -> None:
    vertex = "#version 330 core\nin vec3 a;\nout vec3 n;\nvoid main() { n = a; }\n"
    (tmp_path / "p.vert").write_text(vertex)
    (tmp_path / "p.frag").write_text(GOOD.replace("out", "in vec4 n;\nout").replace("1.0", "n"))
    both = (tmp_path / "p.vert", tmp_path / "p.frag")
    assert compile_(*both).exit_code == 0
    result = compile_(*both, "--link")
    assert result.exit_code == 1 and "Types must match" in result.output
    assert (
        result.output.splitlines()[1].split() == ["glsl", "0", "1"] or "p.frag:2" in result.output
    )


def test_a_file_that_takes_too_long_is_counted_apart(tmp_path: Path) -> None:
    (tmp_path / "a.frag").write_text(GOOD)
    result = compile_(tmp_path, "--timeout", "0.000001", "-j", "1")
    assert result.exit_code == 1
    assert "a.frag: error: timeout: the compiler took too long" in result.output
    assert result.output.splitlines()[-1].split() == ["vulkan", "0", "0", "1"]
    assert compile_(tmp_path, "--timeout", "0").exit_code == 2


@pytest.mark.parametrize(("terminal", "drawn"), [(True, True), (False, False)])
def test_progress_is_drawn_on_a_terminal_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, terminal: bool, drawn: bool
) -> None:
    stderr, stdout = io.StringIO(), io.StringIO()
    monkeypatch.setattr(stderr, "isatty", lambda: terminal)
    monkeypatch.setenv("TERM", "xterm")
    for number in range(50):
        (tmp_path / f"{number}.frag").write_text(GOOD)
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stderr", stderr)
        patch.setattr(sys, "stdout", stdout)
        with pytest.raises(SystemExit):
            cli(["compile", str(tmp_path), "-j", "0"])
    assert ("compiling" in stderr.getvalue()) is drawn
    assert "accepted" in stdout.getvalue() and "compiling" not in stdout.getvalue()
