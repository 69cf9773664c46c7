"""What can happen to a whole run: interrupts, kills, a full disk, a second run, a poor driver."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from tests.gpu import faulty

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="signals and mounts of Linux")


@pytest.fixture
def cases(tmp_path: Path) -> Path:
    """A folder with three good cases, and a draw without end before the last of them."""
    for name in ("a", "b", "d"):
        faulty.write(tmp_path / "cases", name)
    faulty.write(tmp_path / "cases", "c", body=faulty.ENDLESS, before=faulty.in_draw("c", BEGUN))
    return tmp_path


BEGUN = "open('begun', 'w').close()"
# Where it does not matter that a driver is at work.
SLEEP = f"{BEGUN}; __import__('time').sleep(600)"


def begun(cases: Path, *args: str) -> subprocess.Popen[str]:
    """A run that has come to the draw without end, for which one thread of the driver will do; its
    workers are marked by its folder."""
    child = subprocess.Popen(
        faulty.command("./cases", "--report", "run", "--size", "16", "--timeout", "600", *args),
        cwd=cases,
        env=faulty.surroundings(SHADERLAB_TEST=str(cases), LP_NUM_THREADS="1"), text=True,
        start_new_session=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        preexec_fn=faulty.restore_interrupts,
    )  # fmt: skip
    journal = cases / "run" / "records.jsonl"
    # Whole lines are counted: the last one may be half there while it is written.
    until(lambda: journal.is_file() and journal.read_bytes().count(b"\n") > 2)
    until((cases / "begun").exists)
    return child


def ids(cases: Path) -> list[str]:
    return [record["id"] for record in faulty.kept(cases / "run")]


def until(happens: object, seconds: float = 600.0) -> None:
    assert callable(happens)
    end = time.monotonic() + seconds
    while not happens():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.05)


def alive(cases: Path) -> list[int]:
    """Processes that were started by this test's runs, workers included."""
    mark = f"SHADERLAB_TEST={cases}".encode()
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if mark in (entry / "environ").read_bytes().split(b"\0"):
                    found.append(int(entry.name))
            except OSError:
                continue
    return found


def test_ctrl_c_keeps_what_is_done_and_the_run_can_go_on(cases: Path) -> None:
    child = begun(cases)
    assert len(alive(cases)) >= 2
    os.killpg(child.pid, signal.SIGINT)  # as a terminal does: to the workers as well
    output, _ = child.communicate(timeout=600)
    assert child.returncode == 130, output
    assert "2 cases: 2 passed" in output and "shaderlab run --resume run" in output
    assert (cases / "run" / "index.html").is_file()
    until(lambda: not alive(cases))

    faulty.write(cases / "cases", "c", before=faulty.in_draw("c", faulty.HANG))
    done = faulty.shaderlab("--resume", "run", "--timeout", "60", "--json", "out.json", cwd=cases)
    assert done.returncode == 1, done.stdout + done.stderr
    found = {key: case["status"] for key, case in faulty.results(cases / "out.json").items()}
    assert found == {"a": "pass", "b": "pass", "c": "timeout", "d": "pass"}
    assert sorted(ids(cases)) == ["a", "b", "c", "d"]


def test_after_a_kill_no_process_is_left_and_the_records_are(cases: Path) -> None:
    faulty.write(cases / "cases", "c", before=faulty.in_draw("c", SLEEP))
    child = begun(cases, "-j", "2")
    assert len(alive(cases)) >= 3
    child.kill()
    child.communicate()
    until(lambda: not alive(cases))
    assert {"a", "b"} <= set(ids(cases))
    with open(cases / "run" / "records.jsonl", "ab") as file:
        file.write(b'{"id": "cut sho')  # as a power cut leaves it
    faulty.write(cases / "cases", "c")
    done = faulty.shaderlab("--resume", "run", cwd=cases)
    assert done.returncode == 0, done.stdout + done.stderr
    assert sorted(ids(cases)) == ["a", "b", "c", "d"]
    assert "4 cases: 4 passed" in done.stdout


def test_two_runs_do_not_share_a_folder(cases: Path) -> None:
    faulty.write(cases / "cases", "c", before=faulty.in_draw("c", SLEEP))
    child = begun(cases)
    second = faulty.shaderlab("./cases/a.py", "--report", "run", cwd=cases)
    assert second.returncode == 2
    assert "another run is writing" in second.stderr
    assert ids(cases) == ["a", "b"]
    child.kill()
    child.communicate()


def test_two_runs_at_once_get_folders_of_their_own(cases: Path) -> None:
    (cases / "cases" / "c.py").unlink()
    children = [
        subprocess.Popen(
            faulty.command("./cases", "-j", "0"), cwd=cases, env=faulty.surroundings(),
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )
        for _ in range(2)
    ]  # fmt: skip
    outputs = [child.communicate(timeout=600)[0] for child in children]
    assert [child.returncode for child in children] == [0, 0], outputs
    runs = [p for p in (cases / "reports").iterdir() if p.is_dir() and not p.is_symlink()]
    assert len(runs) == 2
    for run in runs:
        assert len(faulty.kept(run)) == 3


def test_nothing_to_go_on_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for args in (["--resume"], ["--resume", "nowhere"], ["--resume", "nowhere", "gamma"]):
        assert CliRunner().invoke(cli, ["run", *args]).exit_code == 2


@pytest.fixture(params=["4k", "24k"])
def small_disk(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Path]:
    """A file system with room for next to nothing: without and with some for the journal."""
    place = tmp_path / "disk"
    place.mkdir()
    options = ["-t", "tmpfs", "-o", f"size={request.param}"]
    mounted = subprocess.run(["mount", *options, "tmpfs", str(place)], capture_output=True)
    if mounted.returncode:
        pytest.skip("a small file system can be mounted by root only")
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


def test_a_full_disk_costs_the_report_but_no_verdict(cases: Path, small_disk: Path) -> None:
    (cases / "cases" / "c.py").unlink()
    # Nothing reads the noise, but its picture has no room: an encoder once never came back from it.
    hashed = "fract(sin(dot(floor(gl_FragCoord.xy / 16.0), vec2(12.9898, 78.233))) * 43758.5453)"
    faulty.write(cases / "cases", "a", body=f"noise = {hashed} * vec3(1.0, 0.5, 0.25);")
    shader = cases / "cases" / "a.frag"
    shader.write_text(shader.read_text().replace("void main", "out vec3 noise;\nvoid main"))
    done = faulty.shaderlab(
        "./cases", "--report", small_disk / "run", "--json", "out.json", cwd=cases
    )
    assert done.returncode == 1
    assert "Traceback" not in done.stdout + done.stderr
    assert "3 cases: 3 passed" in done.stdout
    assert "No space left" in done.stderr
    assert "records.jsonl" in done.stderr or faulty.kept(small_disk / "run")  # what had room
    found = faulty.results(cases / "out.json")
    assert {case["status"] for case in found.values()} == {"pass"}


@pytest.mark.parametrize("place", ["page", "cases", "index.html", "run.json"])
def test_what_takes_a_place_of_the_report_meanwhile_costs_no_verdict(
    cases: Path, place: str
) -> None:
    (cases / "cases" / "c.py").unlink()
    takes = f"makedirs('run/{place}/x')" if "." in place else f"symlink('away', 'run/{place}')"
    makes = f"os.path.lexists('run/{place}') or os.{takes}"
    faulty.write(cases / "cases", "a", before=faulty.in_draw("a", makes))
    done = faulty.shaderlab("./cases", "--report", "run", "--json", "out.json", cwd=cases)
    assert "3 cases: 3 passed" in done.stdout
    assert done.returncode == 1 and f"run/{place}" in done.stderr, done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    assert {case["status"] for case in faulty.results(cases / "out.json").values()} == {"pass"}


def test_without_egl_every_case_says_so(cases: Path) -> None:
    (cases / "cases" / "c.py").unlink()
    done = faulty.shaderlab(
        "./cases", "--json", "out.json", cwd=cases,
        __EGL_VENDOR_LIBRARY_FILENAMES="/dev/null", __EGL_VENDOR_LIBRARY_DIRS="/nowhere",
    )  # fmt: skip
    assert done.returncode == 1
    assert "no OpenGL 3.3 context on EGL" in done.stdout
    assert "3 in error" in done.stdout and "Traceback" not in done.stdout + done.stderr


def test_a_driver_that_only_has_opengl_3_0(cases: Path) -> None:
    (cases / "cases" / "c.py").unlink()
    done = faulty.shaderlab(
        "./cases", cwd=cases, MESA_GL_VERSION_OVERRIDE="3.0", MESA_GLSL_VERSION_OVERRIDE="130"
    )
    assert done.returncode == 1
    assert "3 in error" in done.stdout and "OpenGL 3.3" in done.stdout
    assert "Traceback" not in done.stdout + done.stderr
