"""A kind of expectation from outside the package is one like the lab's own, wherever cases go.

The kind, its case and its shader are the guide's ("Expectations of your own").
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.meta.examples import File, examples, execute

NAME = "light ≤ 0.5"


@pytest.fixture(scope="module")
def folder(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the guide's example, and a run of it."""
    folder = tmp_path_factory.mktemp("own")
    for each in examples(repository / "docs" / "guide" / "expectations.md"):
        if isinstance(each, File):
            (folder / each.name).write_text(each.text, encoding="utf-8")
    done = execute("shaderlab run wall.py --report out --json run.json", folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def outcome(folder: Path, variant: str, file: str) -> dict[str, Any]:
    cases = json.loads((folder / file).read_text(encoding="utf-8"))["cases"]
    (found,) = (c["expectations"][0] for c in cases if c["variant"] == variant)
    assert isinstance(found, dict)
    return found


def test_run_passes_and_the_report_shows_its_rows(folder: Path) -> None:
    found = outcome(folder, "dim", "run.json")
    assert (found["name"], found["kind"], found["status"]) == (NAME, "darker", "pass")
    assert found["judged"] == 64 * 64
    (row,) = found["values"]
    assert (row["label"], row["expected"], row["measured"]) == ("brightest", "≤ 0.5", "0.246")
    page = (folder / "out" / "cases" / "wall.html").read_text(encoding="utf-8")
    assert NAME in page and "brightest" in page and "0.246" in page


def test_mutate_kills_by_it(folder: Path) -> None:
    line = "shaderlab mutate wall.py --variant dim --json mutants.json --report out"
    done = execute(line, folder)
    assert done.returncode == 0, done.stdout + done.stderr
    (case,) = json.loads((folder / "mutants.json").read_text(encoding="utf-8"))["cases"]
    assert case["killed"] >= 1 and case["survived"]  # an upper bound can't see what is too dark
    page = (folder / "out" / "cases" / "wall.html").read_text(encoding="utf-8")
    assert case["survived"][0]["operator"] in page


def test_a_wrong_shader_fails_in_run_and_in_pytest(folder: Path, pytester: pytest.Pytester) -> None:
    line = "shaderlab run wall.py --shader wall.frag=bright.frag --report failed --json failed.json"
    right = (folder / "wall.frag").read_text(encoding="utf-8")
    wrong = right.replace("TexCoords.x *", "3.0 * TexCoords.x *")
    (folder / "bright.frag").write_text(wrong, encoding="utf-8")
    done = execute(line, folder)
    assert done.returncode == 1
    assert "values are above 0.5" in done.stdout and "brightest" in done.stdout
    assert [outcome(folder, v, "failed.json")["status"] for v in ("dim", "half")] == [
        "fail",
        "fail",
    ]

    text = (folder / "wall.py").read_text(encoding="utf-8")
    (folder / "bright.py").write_text(text.replace("wall.frag", "bright.frag"), encoding="utf-8")
    done = execute("pytest wall.py bright.py", folder, pytester)
    assert "2 failed, 2 passed" in done.stdout and "values are above 0.5" in done.stdout
