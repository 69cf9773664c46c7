"""Calls of OpenGL as they were made: recorded, spelt, and judged."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab import Case, Depth, Mesh, State, Target, assets, gl_calls, mesh_pass
from shaderlab.cli import cli
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Expectation
from shaderlab.model.records import Record
from tests.catalogue import shipped

VERTEX = """#version 330 core
in vec3 aPos;
uniform vec2 shift;
void main() { gl_Position = vec4(aPos.xy + shift, aPos.z, 1.0); }
"""
FRAGMENT = """#version 330 core
out vec4 FragColor;
void main() { FragColor = vec4(1.0); }
"""


def scene(folder: Path, *expect: Expectation) -> Scene:
    (folder / "s.vert").write_text(VERTEX)
    (folder / "s.frag").write_text(FRAGMENT)
    passes = mesh_pass(
        "s.vert", "s.frag", Mesh(**assets.quad(1.0)).only("aPos"), uniforms={"shift": (0.25, -0.5)},
        target=Target(depth="depth24"), state=State(depth=Depth(func="lequal")),
    )  # fmt: skip
    case = Case(
        title="Calls", id="calls", file=str(folder / "calls.py"), passes=passes, expect=expect
    )
    return case.scene("default")


def judged(folder: Path, *expect: Expectation) -> Record:
    with SceneRunner() as lab:
        return lab.run(scene(folder, *expect))


RIGHT = {
    "once": gl_calls("glDrawElementsInstanced", mode="GL_TRIANGLES", count=6, times=1),
    "state": gl_calls("glDepthFunc", func="GL_LEQUAL", after="glLinkProgram"),
    "values": gl_calls("glUniform2fv", value="[0.25 -0.5]", times=1),
    "never": gl_calls("glBlendColor", red=1, times=0),
    "in a pass": gl_calls("glEnable", cap="GL_DEPTH_TEST", pass_name="main"),
}
WRONG = {
    "another mode": (gl_calls("glDrawElementsInstanced", mode="GL_LINES"), "called 0 times"),
    "too often": (gl_calls("glLinkProgram", times=2), "called 1 times, not 2"),
    "not never": (gl_calls("glDrawElementsInstanced", times=0), "called 1 times, not 0"),
    "too early": (gl_calls("glLinkProgram", after="glUseProgram"), "before glUseProgram"),
    "another value": (gl_calls("glUniform2fv", value="[0.25 0.5]"), "called 0 times"),
}


def test_calls_that_are_made(tmp_path: Path) -> None:
    record = judged(tmp_path, *RIGHT.values())
    assert record.status == "pass", [(o.name, o.message) for o in record.expectations]


def test_calls_that_are_not_made_so(tmp_path: Path) -> None:
    record = judged(tmp_path, *(expectation for expectation, _ in WRONG.values()))
    for outcome, (name, (_, said)) in zip(record.expectations, WRONG.items(), strict=True):
        assert outcome.status == "fail" and said in outcome.message, (name, outcome.message)


def test_a_parameter_that_is_none_is_an_error(tmp_path: Path) -> None:
    record = judged(tmp_path, gl_calls("glDepthFunc", function_="GL_LESS"))
    assert "glDepthFunc has no parameter 'function_'" in str(record.expectations or record.message)
    with pytest.raises(CaseError, match="a C name"):
        gl_calls("depth_func")


def test_recording_changes_nothing_that_is_drawn(tmp_path: Path) -> None:
    one = scene(tmp_path, RIGHT["once"])
    with SceneRunner() as lab, lab.evaluation(one, lab.prepare_for_opengl(one)) as evaluation:
        before = evaluation.session.draw().images["main", "FragColor"].values
        calls = [str(call) for call in evaluation.session.query("trace") if call.effective]
        again = evaluation.session.draw().images["main", "FragColor"].values
    assert before.tobytes() == again.tobytes()
    assert calls.count("glEnable(GL_DEPTH_TEST)") == 1
    assert "glUseProgram(program 1 (s.frag))" in calls
    assert not any(call.startswith(("glGet", "glBlend", "glStencil")) for call in calls)


def test_a_recording_leaves_nothing_behind(tmp_path: Path) -> None:
    asked = scene(tmp_path, RIGHT["once"])
    with SceneRunner() as lab:
        counts = []
        for _ in range(4):
            assert lab.run(asked).status == "pass"
            gc.collect()
            counts.append(len(gc.get_objects()))
    assert counts[3] - counts[1] < 2000, "each recording leaves its context's functions behind"


def test_making_mipmaps_makes_no_object() -> None:
    """Where a case has them made by the driver."""
    one = next(shipped()["mipmap-chain"].scenes())
    with SceneRunner() as lab, lab.evaluation(one, lab.prepare_for_opengl(one)) as evaluation:
        calls = {str(call) for call in evaluation.session.query("trace")}
    assert "glGenerateMipmap(GL_TEXTURE_2D)" in calls


def test_run_lists_them(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["run", "orange-triangle", "--gl-calls", "--no-pictures", "-j", "0", "--report", "out"]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0, done.output
    assert "pass 'main', draw 0:" in done.output
    assert "  glDrawArraysInstanced(GL_TRIANGLES, 0, 3, 1)" in done.output
    page = Path("out/cases/orange-triangle.html").read_text(encoding="utf-8")
    assert "OpenGL calls: pass" in page and "glDrawArraysInstanced(GL_TRIANGLES, 0, 3, 1)" in page
