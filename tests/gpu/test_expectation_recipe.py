"""CONTRIBUTING's recipe for a built-in kind of expectation: a file, its lowercase name, a line."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

CASE = """\
from shaderlab import Case, across, darker, fullscreen

case = Case(
    title="A wall",
    passes=fullscreen("wall.frag", domain={"light": across(0.0, 1.0)}),
    expect=[darker("FragColor", than=THAN)],
)
"""
WALL = """\
#version 330 core
in float light;
out vec4 FragColor;
void main() { FragColor = vec4(vec3(0.5 * light), 0.0); }
"""


def test_a_new_kind_is_a_file_and_a_line(repository: Path, tmp_path: Path) -> None:
    page = (repository / "CONTRIBUTING.md").read_text(encoding="utf-8")
    recipe = page[page.index("## Add an expectation") : page.index("## Add a mutation operator")]
    for said in ("shaderlab/engine/expectations/NAME.py", "`name = Name`"):
        assert said in recipe
    line = recipe[recipe.index("`from .engine") + 1 :].split("`")[0].replace("NAME", "darker")
    guide = (repository / "docs" / "guide" / "expectations.md").read_text(encoding="utf-8")
    kind = guide[guide.index('"""darker:') :].split("```")[0] + "\ndarker = Darker\n"

    package = tmp_path / "shaderlab"
    shutil.copytree(repository / "shaderlab", package, copy_function=os.symlink)
    (package / "engine" / "expectations" / "darker.py").write_text(kind, encoding="utf-8")
    stub = (package / "__init__.pyi").read_text(encoding="utf-8")
    (package / "__init__.pyi").unlink()
    (package / "__init__.pyi").write_text(f"{stub}{line.replace('name', 'darker')}\n", "utf-8")

    (tmp_path / "wall.frag").write_text(WALL)
    for name, than in (("below", "0.6"), ("above", "0.3")):
        (tmp_path / f"{name}.py").write_text(CASE.replace("THAN", than))
    words = ["run", "below.py", "above.py", "-j", "0", "--no-pictures", "--json", "out.json"]
    done = subprocess.run(
        [sys.executable, "-m", "shaderlab", *words],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1, done.stdout + done.stderr
    assert "values are above 0.3" in done.stdout and "above 0.6" not in done.stdout
    cases = json.loads((tmp_path / "out.json").read_text())["cases"]
    assert {case["id"]: case["status"] for case in cases} == {"below": "pass", "above": "fail"}
