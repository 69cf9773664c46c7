"""What relaxed Vulkan rules can't express: all that docs/guide/compiling.md names."""

from __future__ import annotations

from pathlib import Path

import pytest

from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program

HEAD = "#version 450 core\nout vec4 c;\n"
COMPATIBILITY = "compilation for SPIR-V does not support the compatibility profile"
# What it is: stage, text, whether OpenGL SPIR-V has it, line and beginning of the message.
ROWS: dict[str, tuple[str, str, bool, int | None, str]] = {
    "a struct with a sampler as an argument": (
        "fragment",
        HEAD + "struct Material { sampler2D map; float s; };\nuniform Material material;\n"
        "vec4 look(Material m) { return texture(m.map, vec2(0.0)) * m.s; }\n"
        "void main() { c = look(material); }\n",
        True,
        3,
        "invalid SPIR-V: 'Material' : Vulkan has no samplers inside structs",
    ),
    "sampler2DRect": (
        "fragment",
        HEAD + "uniform sampler2DRect s;\nvoid main() { c = texture(s, vec2(1.0)); }\n",
        True,
        None,
        "invalid SPIR-V: Capability SampledRect is not allowed",
    ),
    "atomic_uint": (
        "fragment",
        HEAD + "layout (binding = 0) uniform atomic_uint a;\n"
        "void main() { c = vec4(atomicCounterIncrement(a)); }\n",
        True,
        None,
        "invalid SPIR-V: ID '11', member '0' decorated with Coherent multiple times",
    ),
    "pixel_center_integer": (
        "fragment",
        HEAD + "layout (pixel_center_integer) in vec4 gl_FragCoord;\n"
        "void main() { c = gl_FragCoord; }\n",
        True,
        None,
        "invalid SPIR-V: [VUID-StandaloneSpirv-PixelCenterInteger-04654]",
    ),
    "gl_DepthRange": (
        "fragment",
        HEAD + "void main() { c = vec4(gl_DepthRange.near); }\n",
        False,
        3,
        "'gl_DepthRange' : undeclared identifier",
    ),
    "a bool in a varying's struct": (
        "vertex",
        "#version 450 core\nstruct S { bool b; };\nout S s;\n"
        "void main() { s.b = true; gl_Position = vec4(1.0); }\n",
        False,
        None,
        "invalid SPIR-V: [VUID-StandaloneSpirv-Input-07290]",
    ),
    "the compatibility profile": (
        "fragment",
        "#version 450 compatibility\nvoid main() { gl_FragColor = gl_ModelViewMatrix[0]; }\n",
        False,
        1,
        COMPATIBILITY,
    ),
}
# Accepted, with a warning that something is ignored.
IGNORED = {
    "uniform float u = 2.0;": "'u' : Ignoring initializer for uniform",
    "layout (location = 3) uniform float u;": (
        "'u' : ignoring layout qualifier for uniform location"
    ),
}


@pytest.fixture(scope="module")
def page(repository: Path) -> str:
    text = (repository / "docs" / "guide" / "compiling.md").read_text(encoding="utf-8")
    return " ".join(text.replace("`", "").split())


@pytest.mark.parametrize("kind", ROWS)
def test_messages_about_what_vulkan_lacks_are_as_documented(kind: str, page: str) -> None:
    stage, text, opengl, line, message = ROWS[kind]
    compiled = compile_program([Shaders([]).from_text(text, stage, "a.vert")])
    assert [verdict.ok for verdict in compiled.verdicts] == [True, opengl, False]
    first = compiled.verdicts[2].diagnostics[0]
    assert first.line == line
    assert first.message.startswith(message)
    assert kind in page


@pytest.mark.parametrize("declared", IGNORED)
def test_what_vulkan_ignores_is_a_warning(declared: str, page: str) -> None:
    text = HEAD + declared + "\nvoid main() { c = vec4(u); }\n"
    compiled = compile_program([Shaders([]).from_text(text, "fragment", "a.frag")])
    assert compiled.ok
    (said,) = compiled.verdicts[2].diagnostics
    assert (said.severity, said.line, said.message) == ("warning", 3, IGNORED[declared])
    assert "A uniform's initial value and its layout (location = …) are ignored" in page


def test_vertex_and_instance_numbers_are_repaired() -> None:
    text = "#version 450 core\nvoid main() { gl_Position = vec4(gl_VertexID + gl_InstanceID); }\n"
    assert compile_program([Shaders([]).from_text(text, "vertex", "a.vert")]).ok
