"""The wheel is complete: installed in an empty environment elsewhere, it runs a case."""

from __future__ import annotations

import email
import json
import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

from tests.catalogue import shipped


def run(*command: str | Path, cwd: Path) -> str:
    """Run a command away from the checkout; its standard output. Failing shows all it said."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=clean,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def wheel(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built without network: the build backend is among the installed packages."""
    folder = tmp_path_factory.mktemp("wheel")
    build = (sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir")
    run(*build, folder, repository, cwd=folder)
    (found,) = folder.glob("*.whl")
    return found


@pytest.fixture(scope="module")
def elsewhere(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scripts' folder of a new environment that has the wheel, and the dependencies of this
    one by reference (nested .pth files are not followed, so not the checkout itself)."""
    folder = tmp_path_factory.mktemp("elsewhere") / "env"
    venv.create(folder, with_pip=False)
    scripts = folder / ("Scripts" if os.name == "nt" else "bin")
    python = scripts / "python"
    ask = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = Path(run(python, "-c", ask, cwd=folder).strip())
    pip = (sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index")
    run(*pip, "--quiet", wheel, cwd=folder)
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return scripts


def test_it_carries_every_shader_and_case(wheel: Path, repository: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        packed = set(archive.namelist())
    expected = {
        f"{inside}{file.relative_to(repository).as_posix()}"
        for kind, inside in (
            ("shaders", "shaderlab/_data/"),
            ("cases", "shaderlab/_data/"),
            ("shaderlab", ""),
        )
        for file in (repository / kind).rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }
    assert expected >= {"shaderlab/py.typed", "shaderlab/_data/cases/ch05_lighting/attenuation.py"}
    assert expected - packed == set()
    assert any(name.endswith("licenses/LICENSE") for name in packed)


def test_its_metadata_tell_what_it_needs(wheel: Path) -> None:
    assert wheel.name.endswith("-py3-none-any.whl")
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        told = email.message_from_bytes(archive.read(name))
    assert told["License-Expression"] == "MIT" and told["Requires-Python"] == ">=3.11"
    assert told["Description-Content-Type"] == "text/markdown"
    classifiers = told.get_all("Classifier") or []
    assert "Operating System :: POSIX :: Linux" in classifiers
    pythons = [c.rpartition(" ")[2] for c in classifiers if "Python :: 3." in c]
    assert pythons == ["3.11", "3.12", "3.13", "3.14"]
    for line in (*(told.get_all("Requires-Dist") or []), *(told.get_all("Project-URL") or [])):
        assert "file:" not in line and "localhost" not in line and str(Path.home()) not in line


def test_it_carries_nothing_else(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            assert name.startswith(("shaderlab/", "shaderlab-")), name
            assert "__pycache__" not in name


def test_it_runs_a_case(elsewhere: Path, repository: Path, tmp_path: Path) -> None:
    where = run(
        elsewhere / "python", "-c", "import shaderlab; print(shaderlab.__file__)", cwd=tmp_path
    )
    assert Path(where.strip()).is_relative_to(elsewhere.parent)
    output = run(
        elsewhere / "shaderlab", "run", "orange-triangle", "--json", "out.json", cwd=tmp_path
    )
    data = json.loads((tmp_path / "out.json").read_text())
    assert [(case["id"], case["status"]) for case in data["cases"]] == [("orange-triangle", "pass")]
    page = output.splitlines()[-1].removeprefix("report: ")
    assert (tmp_path / page).is_file()


def test_it_lists_the_same_cases(elsewhere: Path, tmp_path: Path) -> None:
    command = ("list", "--json", "-")
    there = json.loads(run(elsewhere / "shaderlab", *command, cwd=tmp_path))["cases"]
    assert {case["id"] for case in there} == set(shipped())
    assert all(Path(case["file"]).is_relative_to(elsewhere.parent) for case in there)


def test_its_pytest_plugin_is_registered(elsewhere: Path, case_folder: Path) -> None:
    command = (elsewhere / "python", "-m", "pytest", "--collect-only", "-q", case_folder)
    assert "lamp.py::lamp[near]" in run(*command, cwd=case_folder.parent)
