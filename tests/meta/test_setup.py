"""Set-up on machines that lack something, played with stand-ins for the system's commands.

Each stand-in is a small shell script put first on the PATH; nothing is really installed.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the set-up is made of shell scripts")

# A Python that has no venv module and no driver until the file `installed` is there.
BARE_PYTHON = """\
case "$*" in
*version_info*) echo 3.11 ;;
*ensurepip*) test -e installed ;;
*opengl.py*) test -e installed || { echo "no libEGL.so.1"; exit 1; } ;;
esac
"""


class Machine:
    """A folder with the set-up's files, and commands that stand in for the system's."""

    def __init__(self, folder: Path, repository: Path) -> None:
        self.folder = folder
        shutil.copytree(repository / ".ci", folder / ".ci")
        for name in ("Makefile", "pyproject.toml", "constraints.txt"):
            shutil.copy(repository / name, folder / name)
        self.commands = folder / "commands"
        self.commands.mkdir()
        self.path = os.environ["PATH"]

    def command(self, name: str, text: str) -> None:
        file = self.commands / name
        file.write_text(f"#!/bin/sh\n{text}\n")
        file.chmod(0o755)

    def hide(self, *names: str) -> None:
        """Leave only the system's own commands on the PATH, without these."""
        others = self.folder / "others"
        others.mkdir()
        for command in (*Path("/bin").iterdir(), *Path("/usr/bin").iterdir()):
            if command.name not in names and not (others / command.name).exists():
                (others / command.name).symlink_to(command)
        self.path = str(others)

    def run(self, *words: str) -> subprocess.CompletedProcess[str]:
        # As from a shell: `make test` tells what it starts that another make runs above.
        outside = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))}
        return subprocess.run(
            words,
            cwd=self.folder,
            env={**outside, "PATH": f"{self.commands}{os.pathsep}{self.path}"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=60,
        )


@pytest.fixture
def machine(tmp_path: Path, repository: Path) -> Machine:
    machine = Machine(tmp_path, repository)
    machine.command("bare", BARE_PYTHON)
    machine.command("id", "echo 1000")
    machine.command("sudo", "exit 1")
    machine.command("apt-get", 'echo "$@" >>log; case "$*" in *install*) touch installed ;; esac')
    return machine


def test_here_nothing_is_missing(machine: Machine) -> None:
    done = machine.run(".ci/system", "ensure", sys.executable)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_without_rights_it_says_the_one_command_for_each_system(machine: Machine) -> None:
    done = machine.run(".ci/system", "ensure", "bare")
    assert done.returncode != 0
    assert "venv module of Python 3.11" in done.stderr and "no libEGL.so.1" in done.stderr
    for line in (
        "sudo apt-get update && sudo apt-get install -y python3.11-venv libegl1 libgl1 libgl1-mesa",
        "sudo dnf install -y python3 mesa-libEGL",
        "sudo pacman -S --needed --noconfirm python mesa",
        "brew install python mesa",
    ):
        assert line in done.stderr
    assert not (machine.folder / "log").exists()


def test_with_sudo_that_asks_no_password_it_installs(machine: Machine) -> None:
    machine.command("sudo", 'shift; exec "$@"')
    done = machine.run(".ci/system", "ensure", "bare")
    assert done.returncode == 0, done.stderr
    update, install = (machine.folder / "log").read_text().splitlines()
    assert update.startswith("update")
    assert "libegl1 libgl1 libgl1-mesa-dri" in install


def test_root_needs_no_sudo(machine: Machine) -> None:
    machine.command("id", "echo 0")
    assert machine.run(".ci/system", "ensure", "bare").returncode == 0
    assert (machine.folder / "installed").exists()


def test_an_installation_that_fails_is_shown(machine: Machine) -> None:
    machine.command("id", "echo 0")
    machine.command("apt-get", "echo 'E: no space left'; exit 100")
    done = machine.run(".ci/system", "ensure", "bare")
    assert done.returncode != 0
    assert "E: no space left" in done.stderr and "sudo apt-get" in done.stderr


def test_an_installation_that_does_not_help_is_no_success(machine: Machine) -> None:
    machine.command("id", "echo 0")
    machine.command("apt-get", "exit 0")
    assert machine.run(".ci/system", "ensure", "bare").returncode != 0


def test_no_python_at_all(machine: Machine) -> None:
    for name in ("python3", *(f"python3.{minor}" for minor in range(11, 15))):
        machine.command(name, "echo 'no such interpreter' >&2; exit 127")
    done = machine.run(".ci/setup")
    assert done.returncode != 0
    assert "no Python 3.11 or newer" in done.stderr and "PYTHON=" in done.stderr
    assert not (machine.folder / ".venv").exists()


def ready(machine: Machine, folder: Path) -> None:
    """Make it look as if `make setup` had been done for `folder`."""
    python = machine.folder / ".venv" / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.symlink_to(sys.executable)
    (machine.folder / ".venv" / ".ready-for-work").touch()
    (machine.folder / ".venv" / ".ready").write_text(f"{folder}\n")


def test_running_cases_waits_for_no_package_that_only_tests_need(machine: Machine) -> None:
    assert ".ci/setup course,pytest,vulkan\n" in machine.run("make", "--dry-run", "run").stdout
    ready(machine, machine.folder)
    (machine.folder / ".venv" / ".ready-for-work").unlink()
    assert ".ci/setup" not in machine.run("make", "--dry-run", "run").stdout
    for what in ("test", "lint", "wheel", "docs", "setup"):
        done = machine.run("make", "--dry-run", what).stdout
        assert ".ci/setup dev\n" in done and done.count(".ci/setup") == 1


def test_a_run_keeps_what_python_compiles(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    asked = """--eval=said: ; @echo "[$$PYTHONDONTWRITEBYTECODE]" """
    assert machine.run("make", asked, "said").stdout == "[1]\n"
    ready(machine, machine.folder)
    lab = machine.folder / "shaderlab"
    lab.mkdir()
    (lab / "__main__.py").write_text("import sys\nprint(sys.flags.dont_write_bytecode)\n")
    assert machine.run("make", "run").stdout == "0\n"


def test_a_second_run_sets_nothing_up(machine: Machine) -> None:
    ready(machine, machine.folder)
    for what in ("run", "test", "lint"):
        done = machine.run("make", "--dry-run", what)
        assert done.returncode == 0 and ".ci/setup" not in done.stdout


@pytest.mark.parametrize("change", ["pyproject.toml", "constraints.txt", ".ci/system"])
def test_a_change_of_what_is_needed_sets_up_again(machine: Machine, change: str) -> None:
    ready(machine, machine.folder)
    stamp = (machine.folder / ".venv" / ".ready").stat().st_mtime
    os.utime(machine.folder / change, (stamp + 5, stamp + 5))
    assert ".ci/setup" in machine.run("make", "--dry-run", "run").stdout


def test_an_environment_from_elsewhere_or_without_python_is_made_anew(machine: Machine) -> None:
    ready(machine, machine.folder / "elsewhere")
    assert ".ci/setup" in machine.run("make", "--dry-run", "run").stdout
    assert not (machine.folder / ".venv" / ".ready-for-work").exists()
    shutil.rmtree(machine.folder / ".venv")
    ready(machine, machine.folder)
    (machine.folder / ".venv" / "bin" / "python").unlink()
    assert ".ci/setup" in machine.run("make", "--dry-run", "run").stdout


def test_ci_fails_where_tests_or_style_fail(machine: Machine) -> None:
    for bad in ("test", "lint", "neither"):
        machine.command("make", f'case "$*" in *{bad}*) exit 2 ;; esac')
        done = machine.run(".ci/run")
        assert (done.returncode == 0) is (bad == "neither")
        assert ("FAILED" in done.stdout) is (bad != "neither")


def test_tests_get_what_they_need_where_no_password_is_asked(machine: Machine) -> None:
    machine.command("id", "echo 0")
    machine.hide("chromium", "chromium-browser", "google-chrome-stable", "google-chrome")
    done = machine.run(".ci/system", "tests")
    assert done.returncode == 0
    assert "setup: installing what only tests need: Chromium" in done.stderr
    assert "install -y -qq --no-install-recommends chromium" in (machine.folder / "log").read_text()


def test_without_rights_the_command_for_tests_is_explained(machine: Machine) -> None:
    machine.hide("chromium", "chromium-browser", "google-chrome-stable", "google-chrome")
    done = machine.run(".ci/system", "tests")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert not (machine.folder / "log").exists()
    explained = machine.run(".ci/system", "explain-tests").stdout
    assert explained.startswith("sudo apt-get update && sudo apt-get install -y chromium")


def test_ci_does_nothing_that_make_does_not(repository: Path) -> None:
    lines = (repository / ".ci" / "run").read_text(encoding="utf-8").splitlines()
    commands = [line for line in lines if ".ci/" in line or "pip" in line or "apt" in line]
    assert commands == []


def test_no_registry_is_named(repository: Path) -> None:
    files = [*(repository / ".ci").iterdir(), repository / "Makefile"]
    files.append(repository / "constraints.txt")
    for file in files:
        text = file.read_text(encoding="utf-8")
        assert "index-url" not in text and "://" not in text, file


def test_every_dependency_is_pinned_exactly(repository: Path) -> None:
    import importlib.metadata
    import tomllib

    from packaging.requirements import Requirement
    from packaging.utils import canonicalize_name

    def needed(lines: Iterable[str]) -> set[str]:
        found = map(Requirement, lines)
        return {
            canonicalize_name(r.name)
            for r in found
            if r.marker is None or r.marker.evaluate({"extra": ""})
        }

    lines = (repository / "constraints.txt").read_text().splitlines()
    pins = [Requirement(line) for line in lines if line and not line.startswith("#")]
    assert all(str(pin.specifier).startswith("==") for pin in pins)
    pinned = {canonicalize_name(pin.name) for pin in pins}
    project = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    extras = dict(project["optional-dependencies"])
    assert needed([*extras.pop("docs"), *extras.pop("publish")]) <= pinned  # not in .venv
    lines = [line for extra in extras.values() for line in extra]
    wanted = needed([*project["dependencies"], *lines])
    seen = {"shaderlab"}
    while wanted := wanted - seen:
        name = wanted.pop()
        seen.add(name)
        # `make docs` and `make wheel` install what they need, with all that this needs.
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            wanted |= needed(importlib.metadata.requires(name) or [])
    assert seen - pinned == {"shaderlab"}
