"""A case's author errs: each mistake is a sentence with what to do, and never the lab's defect."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from shaderlab import Case, formula, fullscreen
from shaderlab.cli import cli
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError
from shaderlab.glslmath import vec4
from shaderlab.model.options import RunOptions

PLAIN = (
    "#version 330 core\nin vec2 TexCoords;\nout vec4 color;\n"
    "void main() { color = vec4(TexCoords, 0.0, 1.0); }\n"
)
BLOCK = PLAIN.replace("in vec2", "uniform Lights { vec4 tint; } lights;\nin vec2").replace(
    "vec4(Tex", "lights.tint * vec4(Tex"
)
HASH = "#version 330 core\nuniform uint seed;\nout uint hash;\nvoid main() { hash = seed; }\n"


def right(TexCoords: Any) -> Any:
    return vec4(TexCoords, 0.0, 1.0)


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(pictures=False, size=8)) as lab:
        yield lab


def told(
    lab: SceneRunner, folder: Path, text: str, reference: Callable[..., Any], **given: Any
) -> str:
    """What the lab says of a case."""
    (folder / "a.frag").write_text(text)
    output = "hash" if "hash" in text else "color"
    case = Case(
        title="t",
        file=str(folder / "a.py"),
        passes=fullscreen("a.frag", **given),
        expect=[formula(output, reference)],
    )
    (scene,) = case.scenes()
    record = lab.run(scene)
    assert record.status in ("fail", "error")
    return "\n".join([record.message, *(o.message for o in record.expectations)])


@pytest.mark.parametrize(
    ("reference", "message"),
    [
        (lambda TexCoords: "red", "gives str 'red', no number"),
        (lambda TexCoords: (TexCoords.x, 0.0, 0.0, 1.0), "vec4(…, …, …, …)"),
        (lambda TexCoords: {}, "gives dict {}, no number"),
        (lambda TexCoords: 3 + 4j, "no number"),
        (lambda TexCoords: b"x", "no number"),
        (lambda TexCoords: [[1, 2], [3]], "no number"),
        (lambda TexCoords: np.array(["x"]), "no number"),
        (lambda TexCoords: TexCoords, "gives 2 components, the shader's output has 4\n→ v.x is"),
        (lambda TexCoords: np.sin(TexCoords), "gives 2 components"),
        (lambda TexCoords: vec4("a", 0, 0, 1), "fails: ValueError"),
        (lambda TexCoords: TexCoords.q, "a vec2 has no .q"),
        (lambda TexCoords: 1.0 if TexCoords.x > 0.5 else 0.0, "truth value"),
    ],
)
def test_a_reference_that_gives_no_vector(
    lab: SceneRunner, tmp_path: Path, reference: Callable[..., Any], message: str
) -> None:
    said = told(lab, tmp_path, PLAIN, reference)
    assert message in said and "defect" not in said


@pytest.mark.parametrize("name", ["tint", "Lights.tint", "lights.tint"])
def test_a_blocks_member_that_is_given_as_a_uniform(
    lab: SceneRunner, tmp_path: Path, name: str
) -> None:
    said = told(lab, tmp_path, BLOCK, right, uniforms={name: (1.0, 1.0, 1.0, 1.0)})
    assert f"{name!r} is a member of the uniform block Lights, given as a uniform" in said
    assert "blocks={'Lights': UniformBuffer(values={'tint': …})}" in said


@pytest.mark.parametrize("name", ["Lights", "lights"])
def test_a_block_that_is_given_as_a_uniform(lab: SceneRunner, tmp_path: Path, name: str) -> None:
    said = told(lab, tmp_path, BLOCK, right, uniforms={name: (1.0, 1.0, 1.0, 1.0)})
    assert f"{name!r} is a uniform block, given as a uniform" in said
    assert "blocks={'Lights': UniformBuffer(values={…})}" in said


@pytest.mark.parametrize(("value", "why"), [(-4, "beyond what uint holds"), (0.5, "no integer")])
def test_a_number_that_is_no_uint(lab: SceneRunner, tmp_path: Path, value: float, why: str) -> None:
    said = told(lab, tmp_path, HASH, lambda seed: seed, uniforms={"seed": value})
    assert f"uniform 'seed' is uint, but {value} is {why}" in said


@pytest.mark.parametrize("picture", ["colour", "main.colour", "mian.color"])
def test_a_picture_of_nothing(lab: SceneRunner, tmp_path: Path, picture: str) -> None:
    """Also where no pictures are drawn; a pass by its name as soon as the case is loaded."""
    (tmp_path / "a.frag").write_text(PLAIN)
    passes, file = fullscreen("a.frag"), str(tmp_path / "a.py")
    case = Case(title="t", passes=passes, expect=[formula("color", right)], picture=picture)
    object.__setattr__(case, "file", file)
    if picture.startswith("mian"):
        with pytest.raises(CaseError, match="there is no pass 'mian'"):
            list(case.scenes())
        return
    (scene,) = case.scenes()
    record = lab.run(scene)
    assert record.status == "error"
    assert record.message.startswith(f"there is no output {picture!r} to be the picture\n→ did you")


def test_a_dialect_says_which_targets_to_keep(lab: SceneRunner, tmp_path: Path) -> None:
    old = PLAIN.replace("330 core\n", "140\n")
    said = told(lab, tmp_path, old, lambda TexCoords: vec4(TexCoords, 0.0, 0.0))
    assert "does not compile for opengl" in said
    assert (
        "→ if it is meant for glsl and vulkan alone: targets=['glsl', 'vulkan'], in the case"
        in said
    )


def test_no_target_is_left_of_a_shader_that_all_refuse(lab: SceneRunner, tmp_path: Path) -> None:
    said = told(lab, tmp_path, PLAIN.replace("vec4(", "vec9("), right)
    assert "vec9" in said and "targets=" not in said


def test_integers_are_shown_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SHADERLAB_JOBS", "0")
    Path("a.frag").write_text(HASH)
    Path("a.py").write_text(
        "from shaderlab import Case, exact, fullscreen\n"
        'case = Case(title="t", passes=fullscreen("a.frag", uniforms={"seed": 2654435761}),\n'
        '    expect=[exact("hash", 2654435760)])\n'
    )
    result = CliRunner().invoke(cli, ["run", "a.py", "--size", "4", "--no-pictures"])
    assert "measured   2654435761\n" in result.output and "reference  2654435760" in result.output
    assert "e+09" not in result.output and "nan" not in result.output


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("return None", "Own.judge() gives None, no Judgement\n→ return self.judge_rows(…)"),
        ("raise RuntimeError('none')", "own.py:9: raised RuntimeError: none"),
        ("return [].pop(frame)", "own.py:9: raised TypeError: "),
        ("raise SystemExit(0)", "own.py:9: raised SystemExit: 0"),
    ],
)
def test_an_expectation_of_ones_own_that_fails_itself(
    lab: SceneRunner, tmp_path: Path, body: str, message: str
) -> None:
    (tmp_path / "a.frag").write_text(PLAIN)
    own = tmp_path / "own.py"
    own.write_text(
        "from dataclasses import dataclass\n"
        "from shaderlab import Case, fullscreen\n"
        "from shaderlab.model.expectation import Expectation\n"
        "@dataclass(frozen=True, kw_only=True)\n"
        "class Own(Expectation):\n"
        "    kind = 'own'\n"
        "    name = 'own'\n"
        "    def judge(self, scene, frame):\n"
        f"        {body}\n"
        "case = Case(title='t', passes=fullscreen('a.frag'), expect=[Own()])\n"
    )
    (scene,) = load_case(own).scenes()
    record = lab.run(scene)
    said = "\n".join([record.message, *(o.message for o in record.expectations)])
    assert record.status in ("fail", "error") and message in said and "defect" not in said


def test_a_shader_with_other_names_can_be_renamed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SHADERLAB_JOBS", "0")
    Path("a.frag").write_text(PLAIN.replace("in vec2", "uniform float gain;\nin vec2"))
    Path("a.py").write_text(
        "from shaderlab import Case, formula, fullscreen\n"
        "from shaderlab.glslmath import vec4\n"
        "def right(TexCoords): return vec4(TexCoords, 0.0, 1.0)\n"
        'case = Case(title="t", passes=fullscreen("a.frag", uniforms={"gain": 1.0}),\n'
        '    expect=[formula("color", right)])\n'
    )
    other = Path("a.frag").read_text().replace("TexCoords", "vTexCoords").replace("gain", "uGain")
    Path("mine.frag").write_text(other)

    def run(*words: str) -> tuple[int, str]:
        arguments = ["run", "a.py", "--size", "16", "--no-pictures", *words]
        result = CliRunner().invoke(cli, arguments)
        return result.exit_code, result.output

    status, output = run("--shader", "a.frag=mine.frag")
    renames = ("--rename", "vTexCoords=TexCoords", "--rename", "uGain=gain")
    assert status == 1 and "vTexCoords" in output
    assert run("--shader", "a.frag=mine.frag", *renames)[0] == 0
    Path("mine.frag").write_text(other.replace("vec4(v", "vec4(0.5 * v"))
    assert run("--shader", "a.frag=mine.frag", *renames)[0] == 1
    for wrong, message in {
        "vTexCoords": "write it as NAME=OTHER",
        "nothing=x": "has a name 'nothing'\n  → there is: ",
        "uGian=x": "→ did you mean uGain?",
        "uGain=color": "there is a 'color' already",
    }.items():
        status, output = run("--shader", "a.frag=mine.frag", "--rename", wrong)
        assert status == 2 and message in output
    assert "→ give the file: --shader NAME=FILE" in run("--rename", "uGain=gain")[1]
