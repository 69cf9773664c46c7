"""SPIR-V files: audited, explained, and compared with text and with each other."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

TOOLS = Path(sys.executable).parent
TEXT = """#version 450
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;
layout(binding = 0) uniform Params { float gain; float k; };
void main() { color = vec4(RESULT, sqrt(abs(uv.y)), gain, 1.0); }
"""


def call(*words: str | Path) -> tuple[int, str]:
    found = CliRunner().invoke(cli, [*map(str, words), "-j", "0"])
    return found.exit_code, found.output


def compile_to_file(folder: Path, result: str, *options: str, name: str = "a") -> Path:
    """Write a shader, as text and compiled by glslang's own command; return the module's path."""
    text, module = folder / f"{name}.frag", folder / f"{name}.spv"
    text.write_text(TEXT.replace("RESULT", result))
    command = [TOOLS / "glslangValidator", "-V", *options, text, "-o", module]
    subprocess.run(command, check=True, capture_output=True)
    return module


@pytest.mark.parametrize(("option", "line"), [("-g", 5), ("-gVS", 5), ("-Od", None)])
def test_hazards_of_a_module_have_its_lines(tmp_path: Path, option: str, line: int | None) -> None:
    status, said = call("audit", compile_to_file(tmp_path, "uv.x / k", option))
    assert status == 1
    place = said.partition(": division by 0")[0].rpartition(":")[2]
    # Without lines it is the number of the instruction.
    assert int(place) == line if line else int(place) > 5


def test_a_module_is_explained(tmp_path: Path) -> None:
    status, said = call("explain", compile_to_file(tmp_path, "uv.x * k", "-g"))
    assert status == 0 and "a.spv:5" in said


@pytest.mark.parametrize("stripped", [False, True])
def test_modules_and_text_are_compared_by_place(tmp_path: Path, stripped: bool) -> None:
    same = compile_to_file(tmp_path, "uv.x * k")
    other = compile_to_file(tmp_path, "uv.x * k * 1.01", name="b")
    if stripped:
        for module in (same, other):
            command = [TOOLS / "spirv-opt", "--strip-debug", module, "-o", module]
            subprocess.run(command, check=True)
    text = tmp_path / "a.frag"
    status, said = call("diff", text, same)
    assert status == 0 and "same on" in said and "only" not in said
    status, said = call("diff", same, other)
    assert status == 1 and "different at" in said
    status, said = call("diff", other, text)
    assert status == 1 and "different at" in said


@pytest.mark.parametrize("content", [b"", b"text", bytes(100)])
def test_what_is_no_module_is_named(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "a.spv"
    file.write_bytes(content)
    status, said = call("audit", file)
    assert status == 2 and "a.spv: " in said and "Traceback" not in said


FUNCTIONS = """OpCapability Shader
OpCapability Linkage
OpMemoryModel Logical GLSL450
%void = OpTypeVoid
%kind = OpTypeFunction %void
%f = OpFunction %void None %kind
%block = OpLabel
OpReturn
OpFunctionEnd
"""


def test_functions_without_an_entry_point_are_told(tmp_path: Path) -> None:
    file = tmp_path / "a.spvasm"
    file.write_text(FUNCTIONS)
    status, said = call("audit", file)
    assert status == 2 and "a.spvasm: has functions and no entry point" in said


VULKAN = """#version 450
layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;
layout(constant_id = 1) const int STEPS = 2;
layout(set = 0, binding = 0) uniform texture2D map;
layout(set = 0, binding = 1) uniform sampler smooth_;
layout(push_constant) uniform Pushed { float gain; } pushed;
void main() {
    color = vec4(0.0);
    for (int i = 0; i < STEPS; ++i) color += texture(sampler2D(map, smooth_), PLACE);
    color /= pushed.gain;
}
"""


def test_glsl_for_vulkan_is_audited_and_compared(tmp_path: Path) -> None:
    right, wrong = tmp_path / "a.frag", tmp_path / "b.frag"
    right.write_text(VULKAN.replace("PLACE", "uv"))
    wrong.write_text(VULKAN.replace("PLACE", "uv.yx"))
    status, said = call("audit", right)
    assert status == 1 and "a.frag:11: division by 0" in said
    assert call("diff", right, right)[0] == 0
    assert call("diff", right, wrong)[0] == 1


def test_a_module_is_not_compiled(tmp_path: Path) -> None:
    status, said = call("compile", compile_to_file(tmp_path, "uv.x"))
    assert status == 1 and "is a SPIR-V module" in said


@pytest.mark.parametrize("suffix", [".hlsl", ".slang", ".wgsl", ".spvasm"])
def test_other_languages_are_compared_as_modules_of_their_compilers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    text = compile_to_file(tmp_path, "uv.x * k", name="b").with_suffix(".frag")
    module = compile_to_file(tmp_path, "uv.x * k * 1.01")
    if suffix == ".spvasm":
        command = [TOOLS / "spirv-dis", module, "-o", module.with_suffix(suffix)]
        subprocess.run(command, check=True)
    else:  # a compiler that writes the module into its last argument, and refuses "bad"
        module.with_suffix(suffix).write_text("an example")
        compiler = tmp_path / ("naga" if suffix == ".wgsl" else "slangc")
        refuse = 'for word; do grep -sq bad -- "$word" && cat "$word" && exit 1; done'
        compiler.write_text(f'#!/bin/sh\n{refuse}\ncp "{module}" "$word"\n')
        compiler.chmod(0o755)
        monkeypatch.setenv("PATH", "/usr/bin:/bin")
        status, said = call("diff", text, module.with_suffix(suffix))
        assert status == 2 and f"needs {compiler.name}" in said
        monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    status, said = call("diff", text, module.with_suffix(suffix))
    assert status == 1 and "different at" in said
    module.with_suffix(suffix).write_text("warning: an old name\nerror: a bad one\n")
    status, said = call("audit", module.with_suffix(suffix))
    assert status == 2 and "refuses it:\nerror" in said and "an old name" not in said


def test_functions_are_compared_across_languages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours, theirs = tmp_path / "lib.glsl", tmp_path / "lib.hlsl"
    ours.write_text(
        "float fade(float x, int n) { return x * x * float(n); }\n"
        "bvec2 both(ivec2 a, vec2 b) { return bvec2(a.x > 1, b.y > 0.5); }\n"
        "vec3 tone(vec3 c) { return c * 0.5; }\nfloat only(float x) { return x; }\n"
        "mat2 turn(float x) { return mat2(x); }\n"
    )
    theirs.write_text(
        "float fade(float x, int n) { return x * x * float(n); }\n"
        "bool2 both(int2 a, float2 b) { return bool2(a.x > 1, b.y > 0.5); }\n"
        "float3 tone(float3 c) { return c * 0.501; }\n"
        "float2x2 turn(float x) { return float2x2(x, 0, 0, x); }\n"
    )
    monkeypatch.setenv("PATH", "/usr/bin:/bin")
    status, said = call("diff", ours, theirs)
    assert status == 2 and "needs slangc" in said and str(theirs) in said
    compiler = tmp_path / "slangc"  # glslang reads HLSL, too
    command = f'exec "{TOOLS}/glslangValidator" -D -V -S frag -e main -I/ "$1" -o "$last"'
    compiler.write_text(f"#!/bin/sh\nfor last; do :; done\n{command}\n")
    compiler.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    for files in ((ours, theirs), (theirs, ours)):
        status, said = call("diff", *files)
        assert status == 1 and "fade: same" in said and "both: same" in said
        assert "tone: different" in said and "float only(float x): only one" in said
        assert "undetermined for turn: between languages" in said
    theirs.write_text("float fade(float x, int n) { return wrong; }\n")
    status, said = call("diff", ours, theirs)
    assert f"undetermined for fade: {theirs}: slangc refuses it" in said


def test_an_entry_point_is_found_by_what_people_call_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = compile_to_file(tmp_path, "uv.x * k")
    compiler = tmp_path / "slangc"
    note = f'echo "$@" > "{tmp_path}/said"; for last; do :; done'
    compiler.write_text(f'#!/bin/sh\n{note}\ncp "{module}" "$last"\n')
    compiler.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    stages = (
        "VSOut VSMain(VSIn i) { return o; }\nfloat4 PSMain(VSOut i) : SV_Target { return 1; }\n"
    )
    expected = {
        "float4 main(float2 uv : A) : SV_Target { return 1; }": "-stage fragment -entry main",
        "half4 frag(v2f i) : SV_Target { return 1; }": "-stage fragment -entry frag",
        stages: "-stage fragment -entry PSMain",
        "[numthreads(8,8,1)] void cs_main(uint3 id : SV_DispatchThreadID) { }": "-entry cs_main",
    }
    file = tmp_path / "b.hlsl"
    for text, words in expected.items():
        file.write_text(text)
        assert call("audit", file)[0] == 0
        assert words in (tmp_path / "said").read_text()
    file.write_text(stages)
    call("audit", file, "--stage", "vertex")
    assert "-stage vertex -entry VSMain" in (tmp_path / "said").read_text()


TWO_STAGES = """
    OpCapability Shader
    OpMemoryModel Logical GLSL450
    OpEntryPoint Fragment %fs "fs" %uv %color
    OpEntryPoint Vertex %vs "vs" %at %position
    OpExecutionMode %fs OriginUpperLeft
    OpName %at "at"
    OpName %uv "uv"
    OpDecorate %uv Location 0
    OpDecorate %color Location 0
    OpDecorate %at Location 0
    OpDecorate %position BuiltIn Position
    %void = OpTypeVoid
    %main = OpTypeFunction %void
    %float = OpTypeFloat 32
    %vec4 = OpTypeVector %float 4
    %in = OpTypePointer Input %vec4
    %out = OpTypePointer Output %vec4
    %uv = OpVariable %in Input
    %at = OpVariable %in Input
    %color = OpVariable %out Output
    %position = OpVariable %out Output
    %fs = OpFunction %void None %main
    %1 = OpLabel
    %2 = OpLoad %vec4 %uv
    %3 = OpFDiv %vec4 %2 %2
    OpStore %color %3
    OpReturn
    OpFunctionEnd
    %vs = OpFunction %void None %main
    %4 = OpLabel
    %5 = OpLoad %vec4 %at
    %6 = OpFAdd %vec4 %5 %5
    OpStore %position %6
    OpReturn
    OpFunctionEnd
"""


def test_of_several_entry_points_one_is_read(tmp_path: Path) -> None:
    file = tmp_path / "both.spvasm"
    file.write_text(TWO_STAGES)
    status, said = call("audit", file)
    assert status == 1 and "1 hazard" in said and "uv = " in said and "at" not in said.split()
    status, said = call("explain", file)
    assert status == 0 and "uv = " in said and "gl_Position" not in said
    status, said = call("audit", file, "--stage", "vertex")
    assert status == 0 and "at: " in said and "uv" not in said
