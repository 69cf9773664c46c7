"""Shaders of other dialects than the course's are drawn and judged, for targets that are chosen."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab import Case, formula, fullscreen, value
from shaderlab.cli import cli
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import swizzle, vec4
from shaderlab.model.options import RunOptions

ES = "#version 300 es\nprecision highp float;\n"
OLD = "#version 140\n"
BODY = "in vec2 TexCoords;\nuniform float gain;\nout vec4 color;\nvoid main() { color = RESULT; }\n"
RIGHT, WRONG = "vec4(gain * TexCoords, 0.0, 1.0)", "vec4(gain + TexCoords, 0.0, 1.0)"


def ramp(TexCoords, gain):
    return vec4(gain * TexCoords, 0.0, 1.0)


@pytest.fixture(scope="module")
def lab() -> SceneRunner:
    with SceneRunner(RunOptions(pictures=False, size=16)) as lab:
        yield lab


def case(folder: Path, text: str, targets: tuple[str, ...] = ()) -> Case:
    (folder / "a.frag").write_text(text)
    return Case(
        title="a",
        file=str(folder / "a.py"),
        passes=fullscreen("a.frag", uniforms={"gain": 0.5}),
        expect=[
            formula("color", ramp),
            value("color", at={"TexCoords": (1.0, 0.5)}, equals=(0.5, 0.25, 0.0, 1.0), digits=6),
        ],
        targets=targets,
    )


@pytest.mark.parametrize(("head", "refusing"), [(ES, set()), (OLD, {"opengl"})])
def test_older_versions_are_drawn_and_judged(
    lab: SceneRunner, tmp_path: Path, head: str, refusing: set[str]
) -> None:
    right, wrong = (head + BODY.replace("RESULT", result) for result in (RIGHT, WRONG))
    lab.configure(RunOptions(pictures=False, size=16))
    (scene,) = case(tmp_path, right, ("glsl",)).scenes()
    record = lab.run(scene)
    assert record.status == "pass", record.message
    assert record.compile == {"glsl": "pass", "driver": "pass"}
    assert all(o.status == "pass" and o.judged for o in record.expectations)
    everywhere = lab.run(replace(scene, case=replace(scene.case, targets=())))
    assert {t for t, verdict in everywhere.compile.items() if verdict == "fail"} == refusing
    other = tmp_path / "wrong"
    other.mkdir()
    (scene,) = case(other, wrong, ("glsl",)).scenes()
    outcomes = lab.run(scene).expectations
    assert [o.status for o in outcomes] == ["fail", "fail"]
    assert all("bands are those of highp" not in str(o.explanation) for o in outcomes)


def test_what_fails_below_highp_says_so(lab: SceneRunner, tmp_path: Path) -> None:
    lab.configure(RunOptions(pictures=False, size=16))
    text = ES.replace("highp", "mediump") + BODY.replace("RESULT", WRONG)
    (scene,) = case(tmp_path, text, ("glsl",)).scenes()
    explanation = lab.run(scene).expectations[0].explanation
    assert explanation is not None
    assert "a.frag:2: mediump is declared" in explanation.verdict
    assert "bands are those of highp" in explanation.verdict


def test_the_run_goes_before_the_case_and_the_case_before_the_project(
    lab: SceneRunner, tmp_path: Path
) -> None:
    (tmp_path / "pyproject.toml").write_text('[tool.shaderlab]\ntargets = ["glsl", "opengl"]\n')
    text = "#version 330 core\n" + BODY.replace("RESULT", RIGHT)
    lab.configure(RunOptions(pictures=False, size=16))
    (scene,) = case(tmp_path, text).scenes()
    assert set(lab.run(scene).compile) == {"glsl", "opengl", "driver"}
    scene = replace(scene, case=replace(scene.case, targets=("vulkan",)))
    assert set(lab.run(scene).compile) == {"vulkan", "driver"}
    lab.configure(RunOptions(pictures=False, size=16, targets=("glsl",)))
    assert set(lab.run(scene).compile) == {"glsl", "driver"}


def test_what_can_only_be_compiled_says_so(lab: SceneRunner, tmp_path: Path) -> None:
    lab.configure(RunOptions(pictures=False, size=16))
    text = "#version 450\nlayout (push_constant) uniform P { float gain; };\n"
    text += "layout (location = 0) out vec4 color;\nvoid main() { color = vec4(gain); }\n"
    (scene,) = case(tmp_path, text, ("vulkan",)).scenes()
    record = lab.run(scene)
    assert record.status == "error" and record.compile == {"vulkan": "pass"}
    assert "can be compiled, but not drawn" in record.message


SHADERTOY = """void mainImage(out vec4 fragColor, in vec2 fragCoord) {
    fragColor = vec4(fragCoord / iResolution.xy * iTime, 0.0, 1.0);
}
"""
WEBGL_1 = """precision highp float;
varying vec2 TexCoords;
uniform float gain;
void main() { gl_FragColor = vec4(gain * TexCoords, 0.0, 1.0); }
"""
GLSL_1_20 = """#version 120
varying vec3 normal; // unit
uniform sampler2D map;
uniform sampler2DShadow shadow;
void main() { gl_FragData[0] = texture2D(map, normal.xy) * shadow2D(shadow, normal).r; }
"""


def test_an_image_of_shadertoy_is_drawn_and_judged(lab: SceneRunner, tmp_path: Path) -> None:
    (tmp_path / "toy.glsl").write_text(SHADERTOY)
    uniforms = {"iResolution": (16.0, 16.0, 1.0), "iTime": 0.5}

    def image(frag_coord, iTime):
        return vec4(swizzle(frag_coord, "xy") / 16.0 * iTime, 0.0, 1.0)

    (scene,) = Case(
        title="toy",
        file=str(tmp_path / "a.py"),
        passes=fullscreen("toy.glsl", uniforms=uniforms),
        expect=[formula("shadertoy_color", image)],
    ).scenes()
    record = lab.run(scene)
    assert record.status == "pass", record.message


@pytest.mark.parametrize("command", ["audit", "explain"])
@pytest.mark.parametrize(
    "text", [SHADERTOY, WEBGL_1, GLSL_1_20, ES + BODY.replace("RESULT", RIGHT)]
)
def test_commands_for_one_shader_take_dialects(tmp_path: Path, command: str, text: str) -> None:
    file = tmp_path / ("a.glsl" if text is SHADERTOY else "a.frag")
    file.write_text(text)
    found = CliRunner().invoke(cli, [command, str(file), "-j", "0"])
    assert found.exit_code == 0, found.output
    assert "undetermined" not in found.output
