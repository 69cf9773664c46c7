"""A driver's verdicts on programs, next to glslang's."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.diagnostics import mark_disagreement, parse_driver_log
from shaderlab.compiler.harness import WORK
from shaderlab.drivers import Backend, open_backend
from shaderlab.drivers.opengl.backend import OpenGLBackend
from shaderlab.drivers.opengl.device import GL, Device
from shaderlab.errors import DriverError
from shaderlab.workers.pool import WorkerPool
from tests.compiling import compile_glsl

VERTEX = (
    "#version 330 core\nin vec3 a;\nout vec3 n;\nvoid main() { n = a; gl_Position = a.xyzz; }\n"
)
FRAGMENT = "#version 330 core\nin vec3 n;\nout vec4 c;\nvoid main() {\n    c = vec4(n, 1.0);\n}\n"
# A name that nobody declared.
BROKEN = FRAGMENT.replace("vec4(n, 1.0)", "vec4(m, 1.0)")
COMPUTE = "#version 430 core\nlayout (local_size_x = 8) in;\nvoid main() {}\n"


@pytest.fixture(scope="module")
def device() -> Iterator[Backend]:
    try:
        made = open_backend()
    except DriverError as error:
        pytest.skip(error.message)
    yield made
    made.close()


def program(**stages: str) -> list[Any]:
    return [Shaders([]).from_text(text, stage, f"p.{stage}") for stage, text in stages.items()]


def test_a_right_program_is_accepted(device: Backend) -> None:
    verdict = device.driver_verdict(program(vertex=VERTEX, fragment=FRAGMENT))
    assert (verdict.target, verdict.ok) == ("driver", True)
    assert device.driver_verdict(program(fragment=FRAGMENT)).ok
    assert device.driver_verdict(program(compute=COMPUTE)).ok


def test_a_wrong_stage_is_refused_at_the_authors_line(device: Backend) -> None:
    verdict = device.driver_verdict(program(vertex=VERTEX, fragment=BROKEN))
    assert not verdict.ok
    first = next(d for d in verdict.diagnostics if d.severity == "error")
    assert (first.file, first.line) == ("p.fragment", 5)
    assert "m" in first.message


def test_stages_that_do_not_fit_are_refused_by_the_link(device: Backend) -> None:
    stages = program(
        vertex=VERTEX, fragment=FRAGMENT.replace("vec3 n", "vec4 n").replace("n, 1.0", "n")
    )
    assert device.driver_verdict(stages[1:]).ok
    verdict = device.driver_verdict(stages)
    assert not verdict.ok
    assert "n" in verdict.diagnostics[0].message


def test_nothing_is_left_in_the_context(device: Backend) -> None:
    def alive() -> int:
        return sum(bool(GL.glIsShader(n) or GL.glIsProgram(n)) for n in range(1, 500))

    before = alive()
    for _ in range(3):
        device.driver_verdict(program(vertex=VERTEX, fragment=BROKEN))
        device.driver_verdict(program(vertex=VERTEX, fragment=FRAGMENT))
    assert alive() == before
    assert GL.glGetError() == 0


def test_a_stage_that_the_driver_lacks_is_no_verdict() -> None:
    class Old(nullcontext[None]):
        version_code = 330
        objects = ()

    with pytest.raises(DriverError, match="has no compute stage"):
        OpenGLBackend(Device(Old(), {})).driver_verdict(program(compute=COMPUTE))


def test_a_disagreement_is_reported_in_both_directions() -> None:
    right = compile_program(program(fragment=FRAGMENT), ["glsl"]).verdicts[0]
    wrong = compile_program(program(fragment=BROKEN), ["glsl"]).verdicts[0]
    source = program(fragment=FRAGMENT)[0]
    said = parse_driver_log("0:5(11): error: `n' undeclared\n", source, ok=False)
    refusing = type(right)(target="driver", ok=False, diagnostics=said)
    accepting = type(right)(target="driver", ok=True)
    for plain, driver, words in [
        (right, refusing, "glslang accepts what the driver refuses: `n' undeclared"),
        (wrong, accepting, "the driver accepts what glslang refuses: 'm' : undeclared identifier"),
    ]:
        _, judged = mark_disagreement([plain, driver])
        assert (judged.status, judged.ok) == ("disagrees", driver.ok)
        first = judged.diagnostics[0]
        assert (first.severity, first.line) == ("warning", 5)
        assert first.message == f"disagreement: {words}"
    for plain, driver in [(right, accepting), (wrong, refusing)]:
        assert mark_disagreement([plain, driver]) == (plain, driver)


@pytest.mark.parametrize(
    ("log", "line", "severity", "message"),
    [
        ("0:5(3): warning: `x' used uninitialized\n", 5, "warning", "`x' used uninitialized"),
        ("0:2(1): preprocessor error: #error no\n", 2, "error", "#error no"),
        ("0(3) : error C1008: undefined variable\n", 3, "error", "C1008: undefined variable"),
        ("ERROR: 0:4: 'x' : undeclared\n", 4, "error", "'x' : undeclared"),
        ("error: no stage writes n\n", None, "error", "no stage writes n"),
        ("something else\n", None, "error", "the driver rejects it"),
        ("", None, "error", "the driver rejects it without a message"),
    ],
)
def test_logs_of_several_drivers_are_parsed(
    log: str, line: int | None, severity: str, message: str
) -> None:
    first = parse_driver_log(log, program(fragment=FRAGMENT)[0], ok=severity == "warning")[0]
    assert (first.line, first.severity, first.message) == (line, severity, message)


BOTH = ("--driver", "llvmpipe", "--driver", "llvmpipe-spirv")


@pytest.mark.usefixtures("device")
def test_the_command_reports_the_drivers_verdict(tmp_path: Path) -> None:
    (tmp_path / "a.frag").write_text(FRAGMENT)
    (tmp_path / "b.frag").write_text(BROKEN)
    result = CliRunner().invoke(cli, ["compile", str(tmp_path), *BOTH])
    assert result.exit_code == 1
    *_, first, second = (row.split() for row in result.output.splitlines())
    assert (first, second) == (["llvmpipe", "1", "1"], ["llvmpipe-spirv", "1", "0"])
    said = [row for row in result.output.splitlines() if "b.frag:5: error" in row]
    assert any("[llvmpipe]" in row for row in said)


@pytest.mark.usefixtures("device")
def test_workers_open_a_driver_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "a.frag").write_text(FRAGMENT)
    with WorkerPool(WORK) as pool:
        (result,) = compile_glsl(
            [tmp_path], driver="shaderlab.drivers:driver_verdict", workers=pool, targets=["glsl"]
        )
    assert [(v.target, v.ok, v.status) for v in result.verdicts] == [
        ("glsl", True, ""),
        ("driver", True, ""),
    ]


def test_no_driver_is_no_verdict(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.frag").write_text(FRAGMENT)
    monkeypatch.setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/dev/null")
    result = CliRunner().invoke(cli, ["compile", str(tmp_path), "--driver", "default"])
    assert result.exit_code == 0
    assert "default gave no verdict" in result.output
