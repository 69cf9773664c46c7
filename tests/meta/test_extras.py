"""What comes with extras is needed by nothing else, and is asked for by name where it is needed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.meta.examples import execute
from tests.meta.test_layers import COURSE, OPTIONAL
from tests.small_case import example

__all__ = ["example"]

CASE = """\
from pathlib import Path
from shaderlab import Case, Ramp, computed, exact, fullscreen
from shaderlab.assets import load_obj, load_pcd

HERE = Path(__file__).parent
case = Case(
    title="Loads models",
    passes=fullscreen("lambert.frag", domain={"Normal": Ramp((0, 0, 1))},
                      uniforms={"lightDir": (0, 0, 1), "lightColor": (1, 1, 1)}),
    expect=[
        exact("FragColor", (1.0, 1.0, 1.0, 1.0)),
        computed("faces", lambda: len(load_obj(HERE / "a.obj")), equals=1, digits=0),
    ],
)
"""
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n"


@pytest.fixture
def engine(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """An environment in which every package of an extra is as good as not installed."""
    folder = tmp_path_factory.mktemp("missing")
    for name in (*OPTIONAL, *COURSE):
        (folder / f"{name}.py").write_text(f"raise ImportError('not there', name={name!r})\n")
    named = {"PYTHONPATH": f"{folder}{os.pathsep}{repository}", "SHADERLAB_JOBS": "0"}
    return {**os.environ, **named}


def run(env: dict[str, str], folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "shaderlab", *words]
    return subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, timeout=120)


def statuses(folder: Path) -> dict[str, str]:
    cases = json.loads((folder / "out.json").read_text())["cases"]
    return {case["id"]: case["status"] for case in cases}


def test_a_case_of_ones_own_needs_no_extra(engine: dict[str, str], example: Path) -> None:
    done = run(engine, example, "run", "./lambert.py", "--report", "out", "--json", "out.json")
    assert done.returncode == 0, done.stdout + done.stderr
    assert statuses(example) == {"lambert": "pass"}
    assert run(engine, example, "mutate", "./lambert.py", "--limit", "2", "-j", "0").returncode == 0


def test_a_loader_asks_for_its_extra(engine: dict[str, str], example: Path) -> None:
    (example / "model.py").write_text(CASE)
    (example / "a.obj").write_text(OBJ)
    words = ("run", "./model.py", "--no-pictures", "--json", "out.json")
    assert execute(" ".join(("shaderlab", *words)), example).returncode == 0
    done = run(engine, example, *words)
    assert done.returncode == 1
    assert "an OBJ file needs trimesh" in done.stdout
    assert "pip install 'shaderlab[models]'" in done.stdout


def test_cases_of_the_course_ask_for_its_extra(engine: dict[str, str], example: Path) -> None:
    cases = ("diffuse", "translate", "texture-compression")
    done = run(engine, example, "run", *cases, "--no-pictures", "--json", "out.json")
    assert done.returncode == 0
    assert statuses(example) == {
        "diffuse": "pass",
        "translate": "unsupported",
        "texture-compression": "unsupported",
    }
    # Where nothing is kept of an installation that could import them.
    listed = run({**engine, "SHADERLAB_CACHE_DIR": ""}, example, "list", *cases)
    assert listed.returncode == 0 and "  diffuse " in listed.stdout
    for said in (done.stdout, listed.stderr):
        assert "pip install 'shaderlab[course]'" in said
