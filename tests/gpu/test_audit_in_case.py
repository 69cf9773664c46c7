"""Shaders audited on what a case gives them: `audit CASE`, and `portable`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab import Case, Ramp, fullscreen, portable
from shaderlab.cli.audit import command
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Outcome

SHADER = """#version 330 core
in vec2 place;
uniform float shift;
out vec4 color;
void main()
{
    float wave = sqrt(place.x + shift);
    color = vec4(vec3(fract(wave * SCALE)), 1.0);
}
"""
CASE = """from shaderlab import Case, Ramp, fullscreen, portable
case = Case(
    title="t",
    id="t",
    passes=fullscreen(
        "wave.frag",
        domain={"place": Ramp((0.25, 0.0), (0.5, 0.0), (0.0, 1.0))},
        uniforms={"shift": SHIFT},
    ),
    expect=[portable("color")],
)
"""


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16)) as found:
        yield found


def write(folder: Path, shift: float, scale: float = 0.5) -> Path:
    (folder / "wave.frag").write_text(SHADER.replace("SCALE", repr(scale)))
    case = folder / "t.py"
    case.write_text(CASE.replace("SHIFT", repr(shift)))
    return case


def audited(case: Path) -> tuple[int, str]:
    result = CliRunner().invoke(command, [str(case), "-j", "0"], standalone_mode=False)
    assert result.exception is None, result.exception
    return result.return_value, result.output


def test_a_case_s_own_inputs_decide(tmp_path: Path) -> None:
    status, output = audited(write(tmp_path, 0.0))
    assert (status, output.count("\n")) == (0, 1)
    status, output = audited(write(tmp_path, -0.5))
    assert status == 1
    assert "wave.frag:7: sqrt of a negative number" in output
    assert "shift: as in the case" in output


def judged(lab: SceneRunner, folder: Path, scale: float, expectation: portable) -> Outcome:
    folder = folder / str(scale)  # a lab reads a file once
    folder.mkdir(exist_ok=True)
    write(folder, 0.0, scale)
    case = Case(
        title="t", id="t", file=str(folder / "t.py"), expect=[expectation],
        passes=fullscreen(
            "wave.frag", uniforms={"shift": 0.0},
            domain={"place": Ramp((0.25, 0.0), (0.5, 0.0), (0.0, 1.0))},
        ),
    )  # fmt: skip
    (record,) = [lab.run(scene) for scene in case.scenes()]
    return record.expectations[0]


def test_what_devices_of_16_bits_draw_is_judged(lab: SceneRunner, tmp_path: Path) -> None:
    kind = portable("color", codes=1.0, precision="mediump")
    assert judged(lab, tmp_path, 0.5, kind).status == "pass"
    failed = judged(lab, tmp_path, 50.0, kind)
    assert failed.status == "fail"
    assert "color at mediump" in failed.message


def test_what_conforming_devices_draw_is_judged(lab: SceneRunner, tmp_path: Path) -> None:
    assert judged(lab, tmp_path, 0.5, portable("color", codes=0.01)).status == "pass"
    assert judged(lab, tmp_path, 0.5, portable("color", codes=1e-6)).status == "fail"


def test_only_two_precisions_are_known() -> None:
    with pytest.raises(CaseError, match="precision is 'lowp'"):
        portable("color", precision="lowp")  # type: ignore[arg-type]
