"""What each line of a shader computes: steps by the driver, the line where a failure comes from,
`shaderlab explain`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from shaderlab import Case, Ramp, formula, fullscreen
from shaderlab.analysis import invocations
from shaderlab.analysis.driver_values import find_statements
from shaderlab.analysis.explain import explain, reference_locals, widest_pixel
from shaderlab.analysis.interpreter import load
from shaderlab.cli.explain import command
from shaderlab.compiler import Shaders
from shaderlab.engine.judging.references import Inputs
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import UsageError
from shaderlab.glslmath import dot, max, normalize, vec3, vec4, where
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Outcome

SHADER = """#version 330 core
in vec2 at;
out vec4 color;
float share(float cosine)
{
    if (cosine > 0.9)
        return 1.0;
    return cosine * 0.5 + 0.25;
}
void main()
{
    vec3 toLight = normalize(vec3(at, 0.5));
    float cosine = max(dot(toLight, vec3(0.6, 0.0, 0.8)), 0.0);
    float sum = 0.0;
    for (int i = 0; i < 3; ++i)
        sum += cosine * 0.25;
    color.rgb = vec3(share(cosine), sum, at.x);
    color.a = 1.0;
}
"""


def share(cosine: Any) -> Any:
    return where(cosine > 0.9, 1.0, cosine * 0.5 + 0.25)


def lit(at: Any) -> Any:
    to_light = normalize(vec3(at, 0.5))
    cosine = max(dot(to_light, vec3(0.6, 0.0, 0.8)), 0.0)
    return vec4(share(cosine), cosine * 0.25 + cosine * 0.25 + cosine * 0.25, at.x, 1.0)


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16)) as made:
        yield made


def case_of(folder: Path, text: str = SHADER) -> Case:
    folder.mkdir(exist_ok=True)
    (folder / "lit.frag").write_text(text)
    passes = fullscreen("lit.frag", domain={"at": Ramp((-1.0, -1.0), (2.0, 0.0), (0.0, 2.0))})
    return Case(
        title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=[formula("color", lit)]
    )


def outcome_of(lab: SceneRunner, case: Case) -> Outcome:
    record = lab.run(case.scene("default"))
    assert record.expectations, record.message
    return record.expectations[0]


def test_each_line_has_the_driver_s_value_and_its_band(lab: SceneRunner, tmp_path: Path) -> None:
    scene = case_of(tmp_path).scene("default")
    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        explained = explain(evaluation, ("main", 0), (11, 8))
        assert widest_pixel(evaluation, ("main", 0)) != (0, 0)
        with pytest.raises(UsageError, match="is not seen at pixel"):
            explain(evaluation, ("main", 0), (99, 8))
    assert [(s.line, s.name, s.calls) for s in explained.steps] == [
        (12, "toLight", ()),
        (13, "cosine", ()),
        *[(line, "sum", ()) for line in (14, 16, 16, 16)],
        (7, "share()", (17,)),
        *[(17, f"color.{part}", ()) for part in "xyz"],
        (18, "color.w", ()),
    ]
    # Each turn of a loop is the driver's. One whose outputs change as soon as a statement's value
    # is written (llvmpipe's do by toLight) is not believed.
    assert all(s.by_driver for s in explained.steps[1:])
    assert explained.refused == "" and all(step.inside for step in explained.steps)
    assert all(
        abs(v - e) <= 1e-6 for s in explained.steps for v, e in zip(s.value, s.exact, strict=True)
    )
    losing = {step.name: step.lost for step in explained.steps}
    assert losing["toLight"] > 1.0 and losing["color.x"] == 0.0


@pytest.mark.parametrize(
    ("right", "wrong", "line", "name"),
    [
        ("vec3(0.6, 0.0, 0.8)", "vec3(0.6, 0.0, 0.81)", 13, "cosine"),
        ("vec3(at, 0.5)", "vec3(at, 0.55)", 12, "toLight"),
        ("cosine * 0.5 +", "cosine * 0.51 +", 8, "share()"),
    ],
)
def test_an_author_s_mistake_is_found_by_the_reference_s_names(
    lab: SceneRunner, tmp_path: Path, right: str, wrong: str, line: int, name: str
) -> None:
    outcome = outcome_of(lab, case_of(tmp_path / str(line), SHADER.replace(right, wrong)))
    assert outcome.status == "fail" and outcome.explanation is not None
    explained = outcome.explanation
    assert explained.verdict.startswith(
        "the driver follows the shader, which differs from the reference; first at "
    )
    assert f": {name} is " in explained.verdict
    assert (Path(explained.file).name, explained.line) == ("lit.frag", line)


@pytest.mark.parametrize(
    ("words", "wrong", "line", "said"),
    [
        ("max(dot", "0.999 * max(dot", 13, "cosine is "),
        ("share(cosine)", "share(at.x)", 17, "share(cosine) is "),
    ],
)
def test_a_driver_s_mistake_is_found_by_the_shader_s_own_band(
    lab: SceneRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    words: str, wrong: str, line: int, said: str,
) -> None:  # fmt: skip
    """The driver draws another text than the one that is interpreted."""
    meant = load(Shaders([]).from_text(SHADER, "fragment", "lit.frag"))
    monkeypatch.setattr(invocations, "program_of", lambda source: meant)
    explained = outcome_of(lab, case_of(tmp_path, SHADER.replace(words, wrong))).explanation
    assert explained is not None and explained.line == line
    assert explained.verdict.startswith("the driver is outside the shader's band; first at ")
    assert f":{line}: {said}" in explained.verdict


def test_what_cannot_be_interpreted_changes_no_verdict(lab: SceneRunner, tmp_path: Path) -> None:
    text = SHADER.replace("330 core", "430 core").replace(
        "color.a = 1.0;", "color.a = float(double(at.x) + 1.0lf);"
    )
    outcome = outcome_of(lab, case_of(tmp_path, text))
    assert outcome.status == "fail" and outcome.explanation is not None
    assert outcome.explanation.steps == ()
    assert outcome.explanation.refused.startswith("not interpreted: ")


def test_a_right_shader_is_not_explained(lab: SceneRunner, tmp_path: Path) -> None:
    outcome = outcome_of(lab, case_of(tmp_path))
    assert outcome.status == "pass" and outcome.explanation is None


def test_statements_of_a_text() -> None:
    found = [s for s in find_statements(SHADER) if s.kind != "entry"]
    assert [(s.first, s.name, s.place) for s in found] == [
        (7, "share()", ""),
        (8, "share()", ""),
        (12, "toLight", "toLight"),
        (13, "cosine", "cosine"),
        (14, "sum", "sum"),
        (16, "sum", "sum"),
        (17, "color", "color.rgb"),
        (18, "color", "color.a"),
    ]


def test_the_locals_of_a_reference() -> None:
    at = np.array([[0.0, 0.0], [1.0, 0.0]], np.float32)
    found, result = reference_locals(lit, Inputs(shared={}, each={"at": at}))
    assert set(found) == {"tolight", "cosine", "share()", "lit()"}
    np.testing.assert_allclose(found["cosine"][0], [[0.8], [0.8944272]], rtol=1e-6)
    assert result.shape == (2, 4)


CASE = '''
"""A case."""
from shaderlab import Case, Ramp, formula, fullscreen
from shaderlab.glslmath import vec4

case = Case(
    title="t",
    passes=fullscreen("lit.frag", domain={"at": Ramp((-1.0, -1.0), (2.0, 0.0), (0.0, 2.0))}),
    expect=[formula("color", lambda at: vec4(at, at))],
)
'''


def test_the_command(tmp_path: Path) -> None:
    (tmp_path / "lit.frag").write_text(SHADER)
    (tmp_path / "t.py").write_text(CASE)
    words = [str(tmp_path / "t.py"), "-j", "0", "--size", "16"]
    shown = CliRunner().invoke(command, [*words, "--pixel", "11,8"], standalone_mode=False)
    assert shown.exception is None and shown.return_value == 0, shown.output
    assert "pixel (11, 8), counted from the lower left, with " in shown.output
    assert "lit.frag:12" in shown.output and "ULP lost at" in shown.output

    file = tmp_path / "steps.json"
    shown = CliRunner().invoke(command, [*words, "--json", str(file)], standalone_mode=False)
    data = json.loads(file.read_text())
    assert data["steps"][0]["name"] == "toLight" and data["steps"][-1]["by_driver"]
    x, y = data["pixel"]
    assert data["inputs"]["at"] == [(2 * x + 1) / 16 - 1.0, (2 * y + 1) / 16 - 1.0]

    for wrong, said in ((["--pixel", "11"], "two numbers"), (["--variant", "no"], "no variant")):
        shown = CliRunner().invoke(command, [*words, *wrong], standalone_mode=False)
        assert said in str(shown.exception)
