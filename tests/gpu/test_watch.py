"""`shaderlab watch`: what depends on a saved file is judged again, and nothing else."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.cli.selecting import select_variants
from shaderlab.cli.watching import Session
from shaderlab.engine.jobs import CaseInfo, InProcessExecutor, Job
from shaderlab.model.options import RunOptions
from tests.gpu import faulty

SHADER = """\
#version 330 core
#include "law.glsl"
in vec2 TexCoords;
out vec4 FragColor;
void main() { FragColor = vec4(law(TexCoords.x)); }
"""
LAW = "float law(float x) { return 2.0 * x; }\n"
CASE = """\
from shaderlab import Case, formula, fullscreen
from shaderlab.glslmath import vec4

case = Case(
    title="{name}",
    passes=fullscreen("{name}.frag"),
    expect=[formula("FragColor", lambda TexCoords: vec4(2.0 * TexCoords.x))],
)
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shaders").mkdir()
    (tmp_path / "tests").mkdir()
    (tmp_path / "shaders" / "law.glsl").write_text(LAW)
    (tmp_path / "shaders" / "lamp.frag").write_text(SHADER)
    (tmp_path / "shaders" / "sky.frag").write_text(SHADER.replace('#include "law.glsl"', LAW))
    for name in ("lamp", "sky"):
        (tmp_path / "tests" / f"{name}_case.py").write_text(CASE.format(name=name))
    return tmp_path


@pytest.fixture
def session(project: Path) -> Iterator[Session]:
    def select(facts: Sequence[CaseInfo]) -> list[Job]:
        return [job for one in facts for job in select_variants(one, None)]

    session = Session(InProcessExecutor, select, RunOptions(pictures=False))
    new = session.follow(sorted((project / "tests").glob("*_case.py")))
    assert [record.status for record in session.judge(new)] == ["pass", "pass"]
    yield session
    session.close()


def judged(session: Session, *changed: Path) -> list[tuple[str, str]]:
    """The ids and statuses of what is judged because these files changed."""
    files = session.affected(changed)
    return [(record.id, record.status) for record in session.judge(files)]


def test_what_depends_on_a_file_is_judged_again(session: Session, project: Path) -> None:
    law, lamp = project / "shaders" / "law.glsl", project / "shaders" / "lamp.frag"
    case = project / "tests" / "lamp_case.py"
    assert {law, lamp, case} <= session.files

    law.write_text(LAW.replace("2.0", "2.5"))  # an include
    assert judged(session, law) == [("lamp-case", "fail")]
    lamp.write_text(SHADER.replace("law(", "law(("))  # while typing
    assert judged(session, lamp) == [("lamp-case", "error")]
    lamp.write_text(SHADER)
    law.unlink()
    assert judged(session, lamp) == [("lamp-case", "error")]
    law.write_text(LAW)  # it had no verdict: whatever changes may be what was missing
    assert judged(session, project / "new.glsl") == [("lamp-case", "pass")]
    assert judged(session, project / "README.md") == []

    case.write_text("from shaderlab import Case\ncase = Case(\n")
    assert judged(session, case) == [("lamp-case", "error")]
    case.write_text(CASE.format(name="lamp"))
    assert judged(session, case) == [("lamp-case", "pass")]
    session.follow([case])
    assert judged(session, case, project / "tests" / "sky_case.py") == [("lamp-case", "pass")]


def test_an_interrupted_round_is_taken_up_again(session: Session, project: Path) -> None:
    law, sky = project / "shaders" / "law.glsl", project / "shaders" / "sky.frag"
    sky.write_text(SHADER)
    assert judged(session, sky) == [("sky-case", "pass")]
    law.write_text(LAW.replace("2.0", "2.5"))
    both = session.affected([law])
    first = [record.id for record in session.judge(both, lambda: True)]
    assert first == ["lamp-case"]
    assert judged(session, project / "README.md") == [("lamp-case", "fail"), ("sky-case", "fail")]


def test_tests_of_functions_are_watched_too(session: Session, project: Path) -> None:
    file, law = project / "tests" / "test_law.py", project / "shaders" / "law.glsl"
    file.write_text(
        "from shaderlab import glsl\n"
        'LAW = glsl.load("law.glsl")\n'
        "def test_law():\n    assert LAW.law(2.0) == 4.0\n"
        "@glsl.given(LAW.law, x=glsl.floats(0, 1))\ndef test_given(x, y):\n    return y == 2 * x\n"
    )
    cases = sorted((project / "tests").glob("*_case.py"))
    assert session.follow(cases, [file]) == {file}
    assert [(r.variant, r.status) for r in session.judge([file])] == [
        ("test_law", "pass"), ("test_given", "pass"),
    ]  # fmt: skip
    assert {file, law} <= session.files and not any(".hyp" in str(p) for p in session.files)
    law.write_text(LAW.replace("2.0", "2.5"))
    assert judged(session, law) == [
        ("lamp-case", "fail"), ("test_law", "fail"), ("test_law", "fail"),
    ]  # fmt: skip
    law.write_text("float law(float x) { return")
    assert judged(session, law)[1:] == [("test_law", "error")]
    law.write_text(LAW)
    assert {status for _, status in judged(session, law)} == {"pass"}
    assert session.follow(cases) == set()
    assert judged(session, file) == []


def test_a_terminal_shows_verdicts_until_ctrl_c(project: Path) -> None:
    env = {**os.environ, "PYTHONUNBUFFERED": "1"}
    command = [sys.executable, "-m", "shaderlab", "watch", "tests/lamp_case.py"]
    law = project / "shaders" / "law.glsl"
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=env,
        preexec_fn=faulty.restore_interrupts,
    ) as watch:
        assert watch.stdout is not None

        def until(word: str) -> str:
            """What is printed up to a line with this word, and that."""
            lines = []
            assert watch.stdout is not None
            for line in watch.stdout:
                lines.append(line)
                if word in line:
                    return "".join(lines)
            raise AssertionError("".join(lines))

        def said() -> str:
            return until("watching")

        assert "✓ lamp-case\n1 case: 1 passed in " in said()
        law.with_suffix(".new").write_text(LAW.replace("2.0", "2.5"))
        law.with_suffix(".new").replace(law)
        failed = said()
        assert "shaders/law.glsl" in failed and "worst pixel (" in failed
        assert "first at shaders/" in failed and "1 case: 1 failed in " in failed
        law.write_text(LAW)
        assert "1 case: 1 passed in " in said()
        case = project / "tests" / "lamp_case.py"
        case.write_text(case.read_text().replace("2.0 *", "3.0 *"))
        failed = said()
        assert "tests/lamp_case.py" in failed and "1 case: 1 failed in " in failed
        draft = law.with_name("4913")  # as vim tries whether it may write
        draft.write_text("")
        draft.unlink()
        law.with_name("law.draft").write_text(LAW)
        law.with_name("law.draft").replace(law)
        case.write_text(case.read_text().replace("3.0 *", "2.0 *"))
        again = said()
        while "1 case: 1 passed in " not in again:
            again += said()
        assert "4913" not in again and "draft" not in again
        watch.send_signal(signal.SIGINT)
        assert watch.wait(20) == 0
        assert "Traceback" not in watch.stdout.read()


def test_wrong_usage_is_said(project: Path) -> None:
    for words, said in ((["-j", "0"], "needs workers"), (["gone.py"], "no such file")):
        result = CliRunner().invoke(cli, ["watch", *words])
        assert result.exit_code == 2 and said in result.output, result.output
