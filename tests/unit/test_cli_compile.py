"""`shaderlab compile` on files and folders that are right, wrong, or not there."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

GOOD = "#version 330 core\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n"
BAD = "#version 330 core\nout vec4 c;\nvoid main()\n{\n    c = vec4(nothing);\n}\n"


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
    result = compile_(tmp_path, "--json", tmp_path / "out.json")
    assert result.exit_code == 1
    data = json.loads((tmp_path / "out.json").read_text())
    assert {Path(entry["file"]).name: entry["ok"] for entry in data} == {
        "good.frag": True,
        "bad.frag": False,
    }
    bad = next(entry for entry in data if not entry["ok"])
    assert bad["targets"]["glsl"]["diagnostics"][0]["line"] == 5


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


def test_an_include_folder_that_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "good.frag").write_text(GOOD)
    assert compile_(tmp_path / "good.frag", "-I", tmp_path / "gone").exit_code == 2


def test_no_path_is_wrong_usage() -> None:
    assert compile_().exit_code == 2
