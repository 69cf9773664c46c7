"""The vertex stage that lays a domain over the screen fits what the compiler says is declared."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from shaderlab.compiler import Shaders, Source
from shaderlab.compiler.compile import Compiled, compile_program
from shaderlab.drivers.programs.prepare import PreparedDraw, Preparer
from shaderlab.drivers.programs.stages import write_domain_stage
from shaderlab.errors import CaseError
from shaderlab.model.scene import Draw, Ramp

HEAD = "#version 330 core\nout vec4 c;\n"
MAIN = "void main() { c = vec4(uv, 0.0, 1.0); }\n"
RAMP = Ramp(0.0, dx=1.0)


def prepared(folder: Path, text: str, *inputs: str) -> tuple[PreparedDraw, list[Sequence[str]]]:
    """A draw of the text over a domain, and the stages of each program that was compiled for it."""
    (folder / "a.frag").write_text(text)
    compiled: list[Sequence[str]] = []

    def compiling(stages: Sequence[Source], targets: Sequence[str]) -> Compiled:
        compiled.append([stage.stage for stage in stages])
        return compile_program(stages, targets)

    draw = Draw(fragment="a.frag", domain=dict.fromkeys(inputs, RAMP))
    return Preparer(Shaders([folder]), compiling).prepare(draw), compiled


@pytest.mark.parametrize(
    "declared",
    [
        "#if 0\nin vec3 n;\n#endif\nin vec2 uv;",
        "#define vec3 vec2\nin vec3 uv;",
        "#define I in\nI vec2 uv;",
        "#define A in vec3 n;\nin vec2 uv;",
        "in vec2 uv, n;",
        "centroid in vec2 uv;",
        "float f(in float x) { return x; }\nin vec2 uv;",
        "in Data { vec2 uv; };",
    ],
)
def test_the_stage_has_the_inputs_that_the_compiler_says(tmp_path: Path, declared: str) -> None:
    text = f"{HEAD}{declared}\n{MAIN}"
    stage = Shaders([]).from_text(text, "fragment", "a.frag")
    interface = compile_program([stage]).interface
    assert interface is not None
    draw, compiled = prepared(tmp_path, text, *interface.varyings)
    assert draw.compiled.ok
    assert draw.texts["vertex"] == write_domain_stage(text, interface.varyings.values())
    assert ["fragment"] in compiled


def test_an_input_without_a_ramp_and_a_wrong_text_are_refused(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="uv"):
        prepared(tmp_path, f"{HEAD}in vec2 uv;\n{MAIN}", "other")
    draw, _ = prepared(tmp_path, f"{HEAD}in vec2 uv;\n{MAIN.replace('0.0', 'x')}", "uv")
    assert not draw.compiled.ok
    assert list(draw.texts) == ["fragment"]
