"""The driver that gets programs as SPIR-V modules: what cases draw with text they draw so."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.glslang import validate
from shaderlab.compiler.module_edits import add_feedback
from shaderlab.compiler.sources import Shaders
from shaderlab.drivers.opengl import device
from shaderlab.drivers.opengl.linking import SpirvProgram
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import DriverError, UnsupportedError
from shaderlab.model.options import RunOptions
from shaderlab.report.text import format_failure
from tests.catalogue import judged_only

VERTEX = """#version 330 core
in vec3 corner;
out VS_OUT { vec2 uv; float shade[2]; } vs_out;
out mat2 turn;
void main() {
    vs_out.uv = corner.xy;
    vs_out.shade[0] = 0.0;
    vs_out.shade[1] = 1.0;
    turn = mat2(1.0);
    gl_Position = vec4(corner, 1.0);
}
"""


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(driver="llvmpipe-spirv", pictures=False, modules=False)) as opened:
        yield opened


@pytest.mark.parametrize(
    "case_id",
    # uniforms of every kind, doubles too; a geometry stage that is captured; uniform blocks;
    # samplers in structs; instanced attributes; calls of glUniform that are asked for
    [
        "glsl-types",
        "geometry-explode",
        "uniform-buffer",
        "lighting-maps",
        "batching",
        "uniform-types",
    ],
)
def test_a_case_passes_as_with_text(lab: SceneRunner, case_id: str) -> None:
    scene = list(judged_only(case_id).scenes())[-1]
    record = lab.run(scene)
    assert record.status == "pass", format_failure(record)
    assert record.driver.partition(";")[0].endswith("SPIR-V")
    linked = lab.backend.linker._made.values()  # type: ignore[attr-defined]
    assert linked and all(isinstance(program, SpirvProgram) for program in linked)


def test_a_captured_module_is_valid_and_whole_variables_are_captured() -> None:
    source = Shaders([]).from_text(VERTEX, "vertex", "v.vert")
    module = compile_program([source], ("glsl", "opengl")).spirv["opengl"]["vertex"]
    sizes = {"gl_Position": 4, "VS_OUT.uv": 2, "VS_OUT.shade": 2, "turn": 4}
    assert validate(add_feedback(module, sizes), "opengl4.5") is None
    with pytest.raises(UnsupportedError, match="no such output"):
        add_feedback(module, {"VS_OUT.normal": 3})


def test_a_driver_without_spirv_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device, "SPIRV_EXTENSION", "GL_ARB_no_such_thing")
    with pytest.raises(DriverError, match=r"llvmpipe-spirv: .* takes no SPIR-V"):
        device.open_device("llvmpipe-spirv")
