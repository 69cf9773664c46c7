"""Shaders compared on what a case gives them: `diff --case`, `diff --against`."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab import Case
from shaderlab.analysis.answer import Answer
from shaderlab.analysis.comparison import Plan, compare_programs
from shaderlab.analysis.interpreter import load
from shaderlab.analysis.invocations import changed_stages
from shaderlab.cli.diff import command
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError, UsageError
from shaderlab.model.options import RunOptions

SHADER = """#version 330 core
#include "law.glsl"
in vec3 normal;
in vec3 position;
uniform vec3 lamp;
uniform sampler2D map;
out vec4 color;
void main()
{
    vec3 ray = lamp - position;
    float cosine = max(dot(normalize(normal), normalize(ray)), 0.0);
    if (cosine < 0.05)
        discard;
    color = vec4(texture(map, position.xy).rgb * cosine * fade(length(ray)), 1.0);
}
"""
LAW = "float fade(float d) { return 1.0 / (1.0 + d * d); }\n"
CASE = """from shaderlab import Case, Ramp, Texture, exact, fullscreen
import numpy as np
texels = np.linspace(0.1, 1.0, 64).reshape(4, 4, 4)
case = Case(
    title="t",
    id="t",
    passes=fullscreen(
        "lit.frag",
        domain={
            "normal": Ramp((-0.5, -0.5, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
            "position": Ramp((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.5)),
        },
        uniforms={"lamp": (0.5, 1.0, 2.0)},
        textures={"map": Texture(image=texels)},
    ),
    expect=[exact("color", 0.0)],
)
"""


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16)) as made:
        yield made


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in {
        "lit.frag": SHADER,
        "law.glsl": LAW,
        "lit.py": CASE,
    }.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def case_in(folder: Path) -> Case:
    names: dict[str, Any] = {}
    exec((folder / "lit.py").read_text(), names)
    case: Case = names["case"]
    object.__setattr__(case, "file", str(folder / "lit.py"))
    return case


def compared(lab: SceneRunner, folder: Path, before: str, after: str) -> Answer:
    change = {"lit.frag": SHADER.replace(before, after)}
    ((one,),) = changed_stages(lab, case_in(folder), [change])
    plan = Plan(rounds=1, accuracy=False)
    return compare_programs(load(one.old), load(one.new), plan, one.given)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("max(dot(normalize(normal), normalize(ray)), 0.0)",
         "clamp(dot(normal, ray) * inversesqrt(dot(ray, ray)) / length(normal), 0.0, 1.5)"),
        ("cosine < 0.05", "!(cosine >= 0.05)"),
        ("rgb * cosine * fade(length(ray))", "rgb * (fade(distance(position, lamp)) * cosine)"),
    ],
)  # fmt: skip
def test_a_right_rewrite_is_the_same(
    lab: SceneRunner, folder: Path, before: str, after: str
) -> None:
    found = compared(lab, folder, before, after)
    assert found.same, found
    assert found.outputs[0].judged >= 256


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("lamp - position", "lamp + position", "first at"),
        ("cosine < 0.05", "cosine < 0.06", "only one discards"),
        ("position.xy", "position.yx", "by up to"),
        # In the scene all of these are the same: the lamp is varied as well.
        ("lamp - position", "vec3(lamp.xy, 2.0) - position", "different"),
    ],
)
def test_a_wrong_one_is_not(
    lab: SceneRunner, folder: Path, before: str, after: str, words: str
) -> None:
    found = compared(lab, folder, before, after)
    assert found.same is False and words in str(found.outputs[0])


def test_a_library_file_is_compared_in_all_programs_that_include_it(
    lab: SceneRunner, folder: Path
) -> None:
    case = case_in(folder)
    ((one,),) = changed_stages(lab, case, [{"law.glsl": LAW.replace("1.0 + d", "2.0 + d")}])
    assert one.old.stage == "fragment" and sum(given.count for given in one.given) == 256
    assert "2.0 + d" in one.new.text and "1.0 + d" in one.old.text
    with pytest.raises(CaseError, match=r"no draw uses other\.frag"):
        changed_stages(lab, case, [{"other.frag": SHADER}])


def test_a_vertex_stage_that_the_lab_writes_is_not_compared(lab: SceneRunner, folder: Path) -> None:
    text = SHADER.replace("in vec3 normal;", "noperspective in vec3 normal;")
    ((one,),) = changed_stages(lab, case_in(folder), [{"lit.frag": text}])
    assert one.old.stage == "fragment"


def test_the_command_compares_on_a_case_and_against_a_revision(folder: Path) -> None:
    (folder / "new.glsl").write_text("float fade(float d) { return 1.0 / (d * d + 1.0); }\n")
    (folder / "wrong.glsl").write_text("float fade(float d) { return 1.0 / (d * d + 1.1); }\n")

    def diff(*words: str) -> tuple[Any, str]:
        paths = [str(folder / word) if "." in word else word for word in words]
        result = CliRunner().invoke(command, [*paths, "-j", "0"], standalone_mode=False)
        return result.exception or result.return_value, result.output

    status, text = diff("law.glsl", "new.glsl", "--case", "lit.py", "--json", "a.json")
    assert status == 0 and text.startswith("color: same on ")
    assert json.loads((folder / "a.json").read_text())[0]["same"] is True
    status, text = diff("law.glsl", "wrong.glsl", "--case", "lit.py")
    assert status == 1 and "first at" in text and "wrong.glsl:1" in text
    assert "normal: -inf..inf (learned)" in text
    assert isinstance(diff("law.glsl", "--against", "HEAD")[0], UsageError)

    git = ["git", "-C", str(folder), "-c", "user.name=a", "-c", "user.email=a@b"]
    for words in (["init", "-q"], ["add", "."], ["commit", "-qm", "first"]):
        subprocess.run([*git, *words], check=True)
    (folder / "law.glsl").write_text((folder / "wrong.glsl").read_text())
    status, text = diff("lit.frag", "--against", "HEAD")
    assert status == 1 and "law.glsl:1" in text
    status, text = diff("law.glsl", "--against", "HEAD", "--case", "lit.py")
    assert status == 1 and "law.glsl:1" in text
    (folder / "law.glsl").write_text(LAW)
    assert diff("lit.frag", "--against", "HEAD")[0] == 0
    for words in (
        ["lit.frag", "--against", "nowhere"],
        ["lit.frag"],
        ["no.frag", "--against", "HEAD"],
    ):
        assert isinstance(diff(*words)[0], UsageError)
