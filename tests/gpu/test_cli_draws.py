"""The command line on real cases, really drawn: results, exit codes, files."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from shaderlab.cli import cli

Call = Callable[..., Result]


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Call:
    """Calls the command line in an empty folder; it draws in this process."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SHADERLAB_JOBS", "0")

    def call(*args: str | Path) -> Result:
        return CliRunner().invoke(cli, [str(arg) for arg in args], catch_exceptions=False)

    return call


def results(file: Path) -> list[dict[str, Any]]:
    data = json.loads(file.read_text(encoding="utf-8"))
    assert set(data["driver"]) >= {"renderer", "vendor", "version", "glsl"}
    assert data["seconds"] > 0
    cases: list[dict[str, Any]] = data["cases"]
    return cases


def test_shipped_cases_pass_and_say_so_in_json(call: Call, tmp_path: Path) -> None:
    result = call("run", "glsl-types", "orange-triangle", "--no-pictures", "--json", "out.json")
    assert result.exit_code == 0, result.output
    cases = results(tmp_path / "out.json")
    assert [case["id"] for case in cases].count("glsl-types") == 3
    for case in cases:
        assert case["status"] == "pass"
        assert set(case["compile"]) >= {"glsl", "opengl", "vulkan"}
        assert case["expectations"]
        for expectation in case["expectations"]:
            assert set(expectation) >= {"name", "kind", "status", "worst", "vacuous"}


def test_one_variant_by_its_name(call: Call, tmp_path: Path) -> None:
    assert call("run", "attenuation[50]", "--no-pictures", "--json", "out.json").exit_code == 0
    (case,) = results(tmp_path / "out.json")
    assert case["variant"] == "50"


def test_pictures_are_in_the_run_folder(call: Call, tmp_path: Path) -> None:
    assert call("run", "orange-triangle", "--report", "out", "--json", "o.json").exit_code == 0
    (case,) = results(tmp_path / "o.json")
    assert case["images"]
    for image in case["images"].values():
        assert (tmp_path / "out" / image).is_file()


def test_a_wrong_shader_in_place_of_a_right_one_is_caught(
    call: Call, tmp_path: Path, repository: Path
) -> None:
    name = "lib/attenuation.glsl"
    text = (repository / "shaders" / name).read_text(encoding="utf-8")
    wrong = text.replace("linear", "quadratic_").replace("quadratic", "linear")
    (tmp_path / "wrong.glsl").write_text(wrong.replace("linear_", "quadratic"), encoding="utf-8")
    result = call("run", "attenuation[50]", "--shader", f"{name}=wrong.glsl", "--json", "o.json")
    assert result.exit_code == 1
    assert "worst pixel" in result.output and "reference" in result.output
    (case,) = results(tmp_path / "o.json")
    assert case["status"] == "fail"


def test_a_case_of_ones_own(call: Call, case_folder: Path) -> None:
    result = call("run", case_folder)
    assert result.exit_code == 0, result.output
    shader = case_folder / "lamp.frag"
    shader.write_text(shader.read_text().replace("0.5,", "0.75,"))
    result = call("run", case_folder / "lamp.py", "--variant", "far")
    assert result.exit_code == 1
    assert "lamp[far]" in result.output and "0.75" in result.output


def test_a_shader_need_not_read_the_default_domain(call: Call, case_folder: Path) -> None:
    shader = case_folder / "lamp.frag"
    text = shader.read_text().replace("in vec2 TexCoords;", "").replace(" + TexCoords.x", "")
    shader.write_text(text)
    result = call("run", case_folder)
    assert result.exit_code == 0, result.output


def test_a_shader_that_does_not_compile(call: Call, case_folder: Path) -> None:
    shader = case_folder / "lamp.frag"
    shader.write_text(shader.read_text().replace("min(reach", "min(raech"))
    result = call("run", case_folder, "--variant", "near")
    assert result.exit_code == 1
    assert "lamp.frag:8: error: " in result.output and "raech" in result.output


def test_a_formula_that_breaks_is_that_cases_error_alone(call: Call, case_folder: Path) -> None:
    file = case_folder / "lamp.py"
    text = file.read_text().replace("exact, ", "formula, ")
    text = text.replace('exact("FragColor", (1.0, 0.5, 0.25, 1.0))', 'formula("FragColor", broken)')
    file.write_text(text.replace("case =", "def broken(reach):\n    return [][1]\n\n\ncase ="))
    result = call("run", file, "orange-triangle")
    assert result.exit_code == 1
    assert "IndexError" in result.output and "Traceback" not in result.output
    assert "1 passed, 2 in error" in result.output


def test_the_report_can_be_made_once_more(call: Call, tmp_path: Path) -> None:
    assert call("run", "orange-triangle").exit_code == 0
    page = tmp_path / "reports" / "latest" / "index.html"
    page.unlink()
    result = call("report")
    assert result.exit_code == 0
    assert page.is_file() and "index.html" in result.output


@pytest.mark.parametrize("folder", ["gone", "."])
def test_a_report_of_nothing_is_wrong_usage(call: Call, folder: str) -> None:
    assert call("report", folder).exit_code == 2
    assert call("report").exit_code == 2


def test_doctor_finds_everything_here(call: Call) -> None:
    result = call("doctor")
    assert result.exit_code == 0, result.output
    assert "OpenGL" in result.output and "glslang" in result.output
