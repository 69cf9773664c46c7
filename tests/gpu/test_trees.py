"""A tree of cases with a shared folder, and helpers of one name in two folders: every command loads
it, and so does pytest."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

CASE = '''"""A lamp of the tree."""

from shaderlab import Case, formula, fullscreen

from ..scenes.factors import half
from .helper import COLOUR


def light(reach):
    return half(reach) * COLOUR


case = Case(
    title="A lamp",
    section="5.1",
    passes=fullscreen("lamp.frag", uniforms={"reach": 0.5, "colour": COLOUR}),
    expect=[formula("light", light)],
)
'''
SHADER = """#version 330 core
in vec2 TexCoords;
uniform float reach;
uniform float colour;
out float light;

void main()
{
    light = 0.5 * reach * colour;
}
"""
FILES = {
    "cases.toml": '[chapters]\n5 = "Lamps"\n',
    "scenes/factors.py": "from .halves import HALF\n\n\ndef half(x):\n    return x * HALF\n",
    "scenes/halves.py": "HALF = 0.5\n",
    "red/helper.py": "COLOUR = 0.75\n",
    "red/red_lamp.py": CASE,
    "red/lamp.frag": SHADER,
    "blue/helper.py": "COLOUR = 0.25\n",
    "blue/blue_lamp.py": CASE,
    "blue/lamp.frag": SHADER,
}
LAMPS = {"red-lamp": 0.75, "blue-lamp": 0.25}


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in FILES.items():
        file = tmp_path / "tree" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "tree"


def statuses(*words: str) -> dict[str, str]:
    result = CliRunner().invoke(cli, ["run", *words, "--json", "run.json"], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    found = json.loads(Path("run.json").read_text())["cases"]
    return {case["id"]: case["status"] for case in found}


@pytest.mark.parametrize("jobs", ["0", "2"])
def test_run(tree: Path, monkeypatch: pytest.MonkeyPatch, jobs: str) -> None:
    monkeypatch.setenv("SHADERLAB_JOBS", jobs)
    assert statuses("./tree", "--no-pictures") == dict.fromkeys(LAMPS, "pass")


def test_every_record_has_its_chapter_also_that_of_a_case_whose_process_died(tree: Path) -> None:
    deadly = CASE.replace("return half(reach)", "os._exit(3)").replace(
        "from shaderlab", "import os\nfrom shaderlab", 1
    )
    (tree / "red" / "deadly.py").write_text(deadly)
    CliRunner().invoke(cli, ["run", "./tree", "--no-pictures", "--report", "out"])
    records = json.loads(Path("out", "run.json").read_text())["records"]
    assert {(record["id"], record["status"], record["chapter"]) for record in records} == {
        ("blue-lamp", "pass", "Lamps"),
        ("deadly", "crash", "Lamps"),
        ("red-lamp", "pass", "Lamps"),
    }


def test_one_case_alone_from_within_its_folder(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tree / "blue")
    monkeypatch.setenv("SHADERLAB_JOBS", "0")
    assert statuses("./blue_lamp.py", "--no-pictures") == {"blue-lamp": "pass"}


def test_mutate(tree: Path) -> None:
    file = str(tree / "red" / "red_lamp.py")
    words = ("--jobs", "0", "--limit", "4", "--json", "mutants.json")
    done = CliRunner().invoke(cli, ["mutate", file, *words])
    assert done.exit_code in (0, 1) and Path("mutants.json").is_file(), done.output


def test_pytest(tree: Path, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHADERLAB_JOBS", "0")
    pytester.runpytest_inprocess(tree).assert_outcomes(passed=2)
