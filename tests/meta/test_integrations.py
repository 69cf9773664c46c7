"""What teams put into CI, hooks and editors, run as far as it runs here."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.compiler.shader_files import EXTENSIONS
from shaderlab.model.records import Record
from shaderlab.report.text import format_failure

GOOD = "#version 330 core\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n"
BAD = GOOD.replace("1.0", "nothing")
TEST = (
    'from shaderlab import glsl\nlib = glsl.load("float half_of(float x) { return 0.5 * x; }")\n'
    "def test_half(): assert lib.half_of(1.0) == 0.5\n"
)


def bash(script: str, folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a step's script as the runner does, with this Python's commands first."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        ["bash", "-e", "-o", "pipefail", "-c", script],
        cwd=folder,
        env={**os.environ, "PATH": path, **variables},
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_the_steps_of_the_action_compile_test_and_report(repository: Path, tmp_path: Path) -> None:
    action = yaml.safe_load((repository / "action.yml").read_text())
    steps = {step["name"]: step for step in action["runs"]["steps"]}
    assert list(steps) == ["install", "compile", "test", "report"]
    summary = str(tmp_path / "summary.md")
    given = {"shaders": "a.frag", "tests": "test_half.py"}
    inputs = {name: given.get(name, field["default"]) for name, field in action["inputs"].items()}

    def run(name: str) -> int:
        variables = {
            word: re.sub(r"\$\{\{ inputs\.(\w+) \}\}", lambda m: inputs[m[1]], value)
            for word, value in steps[name]["env"].items()
        }
        script = steps[name]["run"]
        return bash(script, tmp_path, GITHUB_STEP_SUMMARY=summary, **variables).returncode

    (tmp_path / "a.frag").write_text(GOOD)
    (tmp_path / "test_half.py").write_text(TEST.replace("== 0.5", "== 0.25"))
    assert [run(name) for name in ("compile", "test", "report")] == [0, 1, 0]
    assert "did not pass" in Path(summary).read_text()
    results = json.loads((tmp_path / inputs["sarif"]).read_text())["runs"][0]["results"]
    assert len(results) == 1
    assert (tmp_path / inputs["report"] / "tests.xml").is_file()


def test_hooks_take_each_shader_and_fail_on_a_wrong_one(
    repository: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHADERLAB_JOBS", "0")
    hooks = yaml.safe_load((repository / ".pre-commit-hooks.yaml").read_text())
    good, bad = tmp_path / "good.frag", tmp_path / "bad.frag"
    good.write_text(GOOD)
    bad.write_text(BAD)
    for hook in hooks:
        for suffix in (*EXTENSIONS, ".glsl"):
            assert re.search(hook["files"], f"shaders/a{suffix}")
        assert not re.search(hook["files"], "a.py") and hook["language"] == "python"
        command, *words = hook["entry"].split()
        assert command == "shaderlab"
        assert CliRunner().invoke(cli, [*words, str(good)]).exit_code == 0
        assert CliRunner().invoke(cli, [*words, str(good), str(bad)]).exit_code != 0


def test_the_image_has_what_the_drivers_need(repository: Path) -> None:
    text = (repository / "Dockerfile").read_text()
    system = (repository / ".ci" / "system").read_text()
    names = "libegl1|libgl1-mesa-dri|libgl1|libvulkan1|mesa-vulkan-drivers|chromium|spirv-cross"
    needed = set(re.findall(rf"\b(?:{names})\b", system))
    assert len(needed) == len(names.split("|"))
    assert all(re.search(rf"(?<=\s){name}(?=\s)", text) for name in needed)
    extras = re.findall(r"/src\[(.*)\]", text)[0].split(",")
    assert extras == ["course", "pytest", "vulkan", "webgl"]


def test_problem_matchers_match_what_is_printed(
    repository: Path, tmp_path: Path, failing: Record
) -> None:
    page = (repository / "docs/guide/ci.md").read_text()
    (block,) = re.findall(r'```json title=".vscode/tasks.json"\n(.*?)```', page, re.DOTALL)
    compiling, watching = (task["problemMatcher"] for task in json.loads(block)["tasks"])
    (tmp_path / "bad.frag").write_text(BAD)
    said = CliRunner().invoke(cli, ["compile", str(tmp_path / "bad.frag"), "-j", "0"]).output
    found = re.search(compiling["pattern"]["regexp"], said, re.MULTILINE)
    assert found and found[1].endswith("bad.frag") and found[2] == "3" and found[3] == "error"
    lines = list(format_failure(failing))
    places = [m for line in lines if (m := re.match(watching["pattern"]["regexp"], line))]
    assert places and all(m[3].isdigit() for m in places), lines
    source = (repository / "shaderlab/cli/watch.py").read_text()
    assert watching["background"]["endsPattern"].removeprefix("^") in source


def test_each_page_of_the_docs_has_a_place_in_the_site(repository: Path) -> None:
    site = yaml.safe_load((repository / "mkdocs.yml").read_text())
    named = set(re.findall(r"[\w/-]+\.md", json.dumps(site["nav"])))
    made = {"CONTRIBUTING.md", "api/cases.md", "api/functions.md", "api/formulas.md"}
    docs = repository / "docs"
    assert named == made | {page.relative_to(docs).as_posix() for page in docs.rglob("*.md")}


def test_the_jobs_run_what_there_is(repository: Path) -> None:
    jobs = yaml.safe_load((repository / ".github/workflows/ci.yml").read_text())["jobs"]
    commands = [s["run"] for job in jobs.values() for s in job["steps"] if "run" in s]
    targets = re.findall(r"^([a-z-]+):.*##", (repository / "Makefile").read_text(), re.MULTILINE)
    for word in commands:
        program, _, target = word.partition(" ")
        assert target in targets if program == "make" else os.access(repository / program, os.X_OK)
    text = (repository / "pyproject.toml").read_text()
    tested = {
        v
        for job in jobs.values()
        for v in job.get("strategy", {}).get("matrix", {}).get("python", [])
    }
    assert tested == set(re.findall(r"Python :: (3\.\d+)", text))
