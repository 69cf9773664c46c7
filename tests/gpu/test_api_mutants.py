"""Mistakes in calls of OpenGL: made, drawn, recorded and judged."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from shaderlab import Case, Cell, Depth, Draw, Mesh, Pass, State, Target, assets, exact, gl_calls
from shaderlab.cli import cli
from shaderlab.engine.expectations.gl_call import CallTrace
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderlabError
from shaderlab.model.calls import CallEdit, ChangeCall, DropCall, PostponeCall, RepeatCall
from shaderlab.mutation.call_mutants import CallMutant, mutate_calls
from shaderlab.mutation.judging import Judge

VERTEX = """#version 330 core
in vec3 aPos;
void main() { gl_Position = vec4(aPos, 1.0); }
"""
FRAGMENT = """#version 330 core
out vec4 FragColor;
void main() { FragColor = vec4(1.0); }
"""
QUAD = Mesh(**assets.quad(2.0), upload="sub_data").only("aPos")
HALF = np.zeros((8, 16, 4), np.float32)
HALF[:, 8:] = 1.0


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner() as opened:
        yield opened


@pytest.fixture
def case(tmp_path: Path) -> Case:
    """Two draws of one mesh: one in the left half, kept out by a depth test, one in the right."""
    (tmp_path / "s.vert").write_text(VERTEX)
    (tmp_path / "s.frag").write_text(FRAGMENT)
    draws = tuple(
        Draw(
            vertex="s.vert", fragment="s.frag", mesh=QUAD,
            state=State(depth=Depth(func=func), cell=Cell(column=k, row=0, columns=2, rows=1)),
        )
        for k, func in enumerate(("greater", "less"))
    )  # fmt: skip
    target = Target(size=(16, 8), depth="depth24", clear=(0.0, 0.0, 0.0, 0.0))
    written = gl_calls("glBufferSubData", times=1)
    return Case(
        title="Halves", id="halves", file=str(tmp_path / "halves.py"),
        passes=[Pass(name="main", target=target, draws=draws)],
        expect=[exact("FragColor", HALF), written],
    )  # fmt: skip


def fate(lab: SceneRunner, case: Case, edit: CallEdit) -> tuple[str, str]:
    mutant = CallMutant(
        file=case.file, line=0, operator="", before="", after="", variant="default", edit=edit
    )
    found = Judge(lab, case).judge(mutant)
    return found.status, found.by


def which(function: str, number: int = 0) -> Mapping[str, object]:
    return {"function": function, "number": number}


FATES: Mapping[str, tuple[CallEdit, str, str]] = {
    "a draw is dropped": (
        DropCall(function="glDrawElementsInstanced", number=1), "killed", "FragColor",
    ),
    "the depth function of the left half": (
        ChangeCall(function="glDepthFunc", number=1, parameter="func", value="GL_LESS"),
        "killed", "FragColor",
    ),
    "nothing is written": (
        DropCall(function="glBufferSubData", number=0), "killed", "FragColor",
    ),
    "written before there is room": (
        PostponeCall(function="glBufferData", number=1, behind=("glBufferSubData", 0)),
        "killed", "FragColor",
    ),
    "written for each draw": (
        RepeatCall(function="glBufferSubData", number=0), "killed", "glBufferSubData",
    ),
    "a hint that nothing is said about": (
        ChangeCall(function="glBufferData", number=1, parameter="usage", value="GL_STREAM_DRAW"),
        "no difference", "the same pixels",
    ),
    "a binding that the next one replaces": (
        DropCall(function="glBindVertexArray", number=1), "equivalent", "the same state",
    ),
    "cleared to white": (
        ChangeCall(function="glClearBufferfv", number=0, parameter="value", value=1),
        "killed", "FragColor",
    ),
    "fewer bytes than were written": (
        ChangeCall(function="glBufferSubData", number=0, parameter="offset", value=-4),
        "killed", "FragColor",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FATES)
def test_fates(lab: SceneRunner, case: Case, name: str) -> None:
    edit, status, by = FATES[name]
    found = fate(lab, case, edit)
    assert found[0] == status and by in found[1], found


def test_another_hint_survives_where_the_case_is_about_such_calls(
    lab: SceneRunner, case: Case
) -> None:
    edit = ChangeCall(function="glBufferData", number=1, parameter="usage", value="GL_STREAM_DRAW")
    weak, strong = (
        Case(title="c", id="halves", file=case.file, passes=case.passes, expect=[told])
        for told in (
            gl_calls("glBufferData", times=2),
            gl_calls("glBufferData", times=2, usage="GL_STATIC_DRAW"),
        )
    )
    assert fate(lab, weak, edit)[0] == "survived"
    assert fate(lab, strong, edit)[0] == "killed"


def test_the_trace_has_the_edit_and_the_next_drawing_has_not(lab: SceneRunner, case: Case) -> None:
    scene = case.scene("default")
    programs = lab.prepare_for_opengl(scene)
    edit = ChangeCall(function="glViewport", number=2, parameter="x", value=3)
    with lab.edited_evaluation(scene, programs, edit) as edited:
        changed = Counter(map(str, edited.answer(CallTrace())))
    with lab.edited_evaluation(scene, programs, None) as plain:
        as_it_is = Counter(map(str, plain.answer(CallTrace())))
    assert len(changed - as_it_is) == len(as_it_is - changed) == 1
    assert next(iter(changed - as_it_is)).startswith("glViewport(3,")
    with lab.evaluation(scene, programs) as untouched:
        assert np.array_equal(untouched.drawn.images["main", "FragColor"].values, HALF)


def test_a_call_that_does_not_come_is_a_defect(lab: SceneRunner, case: Case) -> None:
    scene = case.scene("default")
    edit = DropCall(function="glDrawElementsInstanced", number=7)
    run = lab.edited_evaluation(scene, lab.prepare_for_opengl(scene), edit)
    with pytest.raises(ShaderlabError, match="no call 7 of glDrawElementsInstanced"), run:
        pass


def test_mutants_of_a_case(lab: SceneRunner, case: Case) -> None:
    mutants = mutate_calls(lab, case)
    kinds = Counter(mutant.operator for mutant in mutants)
    assert set(kinds) == {"argument", "call dropped", "call repeated", "calls reordered"}
    told = [str(mutant) for mutant in mutants]
    assert any("glDepthFunc(GL_GREATER) → func = GL_LESS" in text for text in told), told
    assert any("[0 0 0 0]) → value = 1" in text for text in told), told
    assert not any("glGet" in text or "glLinkProgram(program" in text for text in told)
    edits = [mutant.edit for mutant in mutants]
    assert len(set(edits)) == len(edits)


def test_the_page_is_not_about_calls() -> None:
    done = CliRunner().invoke(cli, ["mutate", "orange-triangle", "--api", "--report", "out"])
    assert done.exit_code == 2 and "--json" in done.output


def test_the_command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["mutate", "orange-triangle", "--api", "--limit", "12", "-j", "0", "--json", "a.json"]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0, done.output
    assert "mistakes in calls of OpenGL noticed:" in done.output
    data = json.loads(Path("a.json").read_text(encoding="utf-8"))
    assert data["api"] is True and data["cases"][0]["killed"] > 0
