"""Shaders as people write them, in front of every command: read, or refused by words that help."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from shaderlab import glsl
from shaderlab.analysis.comparison import Plan, compare_programs
from shaderlab.analysis.interpreter import load
from shaderlab.cli import cli
from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program
from shaderlab.errors import CallError, ShaderError

ES = "#version 300 es\nprecision highp float;\n"
READ = {
    "webgl1.vert": """attribute vec3 position; uniform mat4 projection; varying vec3 at;
        mat3 transpose(mat3 m) { return mat3(m[0].x, m[1].x, m[2].x, m[0].y, m[1].y, m[2].y,
                                             m[0].z, m[1].z, m[2].z); }
        void main() { at = transpose(mat3(2.0)) * position;
                      gl_Position = projection * vec4(position, 1.0); }""",
    "words.frag": """precision mediump float; uniform sampler2D texture; varying vec2 uv;
        float round(float x) { return floor(x + 0.5); }
        void main() { vec4 sample = texture2D(texture, uv); float smooth = round(sample.r);
                      gl_FragColor = vec4(smooth, sample.gba); }""",
    "buffers.frag": """#extension GL_EXT_draw_buffers : require
        precision mediump float; varying vec3 n;
        void main() { gl_FragData[0] = vec4(n, 1.0); gl_FragData[1] = vec4(0.5); }""",
    "processing.glsl": """#ifdef GL_ES
        precision mediump float;
        #endif
        uniform sampler2D texture; varying vec4 vertTexCoord;
        void main() { gl_FragColor = texture2D(texture, vertTexCoord.st); }""",
    "cube.frag": """uniform samplerCube iChannel0;
        void mainImage(out vec4 c, in vec2 p) { c = texture(iChannel0, vec3(p, iTime)); }""",
    "pack.fsh": """#version 430 compatibility
        varying vec2 uv; uniform sampler2D colortex0;
        void main() { gl_FragColor = texture2D(colortex0, uv); }""",
    "pixi.frag": """in vec2 vTextureCoord; out vec4 finalColor; uniform sampler2D uTexture;
        void main(void) { finalColor = texture(uTexture, vTextureCoord); }""",
    "defold.fp": """#version 140
        in mediump vec2 at; out vec4 colour; uniform mediump sampler2D image;
        void main() { colour = texture(image, at); }""",
    "three.vert": """varying vec2 vUv;
        void main() { vUv = uv;
                      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }""",
    "three3.glsl": """out vec3 n; uniform float time;
        void main() { n = normalMatrix * normal; vec2 uv = vec2(time);
                      gl_Position = projectionMatrix * viewMatrix * vec4(position.xy, uv); }""",
    "three.frag": """precision mediump float; varying vec3 at;
        void main() { gl_FragColor = vec4(at - cameraPosition, 1.0); }""",
    "fixed.vert": """void main() {
        gl_Position = ftransform() + gl_ModelViewMatrix * gl_Vertex;
        gl_TexCoord[1] = gl_TextureMatrix[0] * gl_MultiTexCoord0;
        gl_FrontColor = gl_Color * dot(gl_NormalMatrix * gl_Normal, vec3(1.0)); }""",
    "fixed.frag": """#version 120
        uniform sampler2D texture;
        void main() { gl_FragColor = gl_Color * texture2D(texture, gl_TexCoord[1].st); }""",
    "own.vert": """#version 120
        #define viewMatrix gl_ModelViewMatrix
        varying vec4 gl_TexCoord[4];
        void main() { gl_TexCoord[0] = gl_Vertex; gl_Position = viewMatrix * gl_Vertex; }""",
    "macro.vert": """#define viewMatrix gl_ModelViewMatrix
        void main() { gl_Position = viewMatrix * gl_Vertex; }""",
    "part.fs": "float half_of(float x) { return 0.5 * x; }",
    "old.glsl": """vec4 both(sampler2D image, vec2 uv)
        { return texture2D(image, uv) + texture2D(image, -uv); }""",
    "mediump.glsl": """precision mediump float; varying vec2 uv; uniform sampler2D image;
        vec3 at(float s) { return texture2D(image, uv * s).rgb; }""",
    "twice.frag": ES.replace("highp", "mediump")
    + "uniform float k; in vec2 uv; out vec4 c; void main() { c = vec4(vec2(uv), float(k), 1.0); }",
    "whole.frag": ES
    + """precision highp usampler2D; precision highp isampler2D; precision highp sampler3D;
        uniform usampler2D ids; uniform isampler2D offsets; uniform sampler3D volume;
        uniform sampler2D image; in vec3 p; in float lod; out vec4 c;
        void main() { int k = texelFetch(offsets, ivec2(0), 0).x;
            c = texture(volume, p) + vec4(texture(ids, p.xy)) + float(k)
              + float(textureSize(image, int(lod)).x); }""",
}


def call(*words: str | Path) -> tuple[int, str]:
    found = CliRunner().invoke(cli, [*map(str, words), "-j", "0"])
    return found.exit_code, found.output


@pytest.mark.parametrize("name", READ)
def test_every_command_reads_it(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_text(READ[name])
    older = re.search("compatibility|#version 1[24]0|gl_Vertex", READ[name])
    targets = ["glsl"] if older else ["glsl", "opengl"]
    status, said = call("compile", file, *(f"--target={target}" for target in targets))
    assert status == 0, said
    status, said = call("audit", file)
    assert status in (0, 1) and "undetermined" not in said, said
    status, said = call("diff", file, file)
    assert status == 0 and "shaderlab_" not in said, said
    if "main" in READ[name]:
        status, said = call("explain", file)
        assert status == 0 and "shaderlab_" not in said.replace("shadertoy_", ""), said


def test_what_the_fixed_function_pipeline_gives_is_an_input_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "a.vert").write_text(READ["fixed.vert"])
    said = call("diff", tmp_path / "a.vert", tmp_path / "a.vert")[1]
    for name in ("gl_Position", "gl_TexCoord[1]", "gl_FrontColor"):
        assert f"{name}: same" in said
    said = call("audit", tmp_path / "a.vert")[1]
    names = re.findall(r"^  (gl_\w+)", said, re.MULTILINE)
    assert {"gl_Vertex", "gl_Normal", "gl_Color", "gl_TextureMatrix", "gl_NormalMatrix"} <= {*names}
    assert names.count("gl_TextureMatrix") == 1  # no more than its texts name


def test_words_of_other_languages_in_comments_are_no_other_language(tmp_path: Path) -> None:
    file = tmp_path / "a.glsl"
    words = (
        "shader_type spatial;\n@fragment\nin HLSL: SV_Target\ncbuffer A {\nusing namespace metal;"
    )
    file.write_text(f"/*\n{words}\n*/\nfloat half_of(float x) {{ return 0.5 * x; }}\n")
    assert call("audit", file)[0] == 0
    assert glsl.load(file).half_of(3.0) == 1.5


SEVERAL = {
    "pass.slang": """#version 450
        #include "common.h"
        layout(set = 0, binding = 0, std140) uniform UBO { mat4 MVP; float level; } global;
        #include "stage.inc"
        #pragma parameter level "#pragma stage geometry" 0.5 0.25 2.0 0.05
        #pragma stage fragment
        #include "common.h"
        layout(location = 0) in vec2 uv;
        layout(location = 0) out vec4 c;
        void main() { c = vec4(sqrt(half_of(uv.x))) / global.level; }""",
    "engine.glsl": """#version 450
        #[versions]
        plain = "";
        #[vertex]
        layout(location = 0) in vec2 at; layout(location = 0) out vec2 u; void main() { u = at;
            gl_Position = vec4(at, 0.0, 1.0); }
        #[fragment]
        #VERSION_DEFINES
        layout(location = 0) in vec2 u; layout(location = 0) out vec4 c; void main() { c = u.xxxx;
            c = sqrt(c); }""",
    "quad.glsl": """#type vertex
        #version 450 core
        layout(location = 0) in vec2 at;
        layout(location = 0) out vec2 uv;
        void main() { uv = at; gl_Position = vec4(at, 0.0, 1.0); }
        #type pixel
        #version 450 core
        layout(location = 0) in vec2 uv;
        layout(location = 0) out vec4 c;
        void main() { c = vec4(sqrt(uv.x)); }""",
}
PARTS = {
    "common.h": "#pragma once\nfloat half_of(float x) { return 0.5 * x; }\n",
    "stage.inc": """#pragma once
        #pragma stage vertex
        layout(location = 0) in vec2 at;
        layout(location = 0) out vec2 uv;
        void main() { uv = at; gl_Position = global.MVP * vec4(at, 0.0, 1.0); }""",
}


@pytest.mark.parametrize("name", SEVERAL)
def test_a_file_of_several_stages_is_one_program(tmp_path: Path, name: str) -> None:
    """Its fragment stage is audited, compared and explained, or the one that is asked for; lines
    are the file's own, and what stands before all stages is each one's."""
    file = tmp_path / name
    for part, text in PARTS.items():
        (tmp_path / part).write_text(text)
    file.write_text(SEVERAL[name])
    assert call("compile", file) == call("compile", tmp_path)
    status, said = call("compile", file)
    assert (status, said.count(" 1 ")) == (0, 3) and "warning" not in said, said
    status, said = call("audit", file)
    assert f"{name}:10: sqrt of a negative number" in said and "/ 0" not in said, said
    assert ("UBO.level: 0.25..2 (declared)" in said) is ("level" in SEVERAL[name])
    assert call("audit", file, "--stage", "vertex")[0] == 0
    assert "c: same" in call("diff", file, file)[1]
    assert "gl_Position" in call("diff", file, file, "--stage", "vertex")[1]
    assert f"{name}:10" in call("explain", file)[1]
    file.write_text(SEVERAL[name].replace(" = at;", " = att;"))
    for part, text in PARTS.items():
        (tmp_path / part).write_text(text.replace(" = at;", " = att;"))
    line = "stage.inc:5" if "inc" in SEVERAL[name] else f"{name}:5"
    assert f"{line}: error: 'att' : undeclared" in call("compile", file)[1]


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.rgen", "#version 460\nvoid main() {}", "is of a ray-tracing stage"),
        ("a.shader", 'Shader "X" { }', "is Unity's ShaderLab"),
        ("a.sc", "$input uv\nvoid main() {}", "is bgfx's dialect"),
        ("a.gdshader", "shader_type canvas_item;", "is Godot's language"),
        ("a.metal", "fragment float4 f() { return 1; }", "is the Metal Shading Language"),
        ("a.cginc", "float4 f() { return 1; }", "is HLSL"),
        ("a.frag", "shader_type spatial;\nvoid fragment() { ALBEDO = vec3(UV, 1.0); }",
         "is Godot's language"),
        ("a.frag", "vec4 effect(vec4 tint, Image image, vec2 uv, vec2 at) { return tint; }",
         "is LÖVE's dialect"),
        ("a.fs", '/*{ "INPUTS": [{"NAME": "level", "TYPE": "float"}] }*/\nvoid main() {\n'
         "gl_FragColor = vec4(level * TIME); }", "is of the Interactive Shader Format"),
        ("a.glsl", "float4 main(float2 uv : TEXCOORD0) : SV_Target { return uv.xyxy; }",
         "call it .hlsl"),
        ("a.frag", "@fragment\nfn main() -> @location(0) vec4f { return vec4f(1.0); }",
         "call it .wgsl"),
        ("a.vert", "#version 120\nvoid main() { gl_TexCoord[99999999] = gl_Vertex; }",
         "index out of range '99999999'"),
        ("a.glsl", "#type vertx\n#version 330\nvoid main() {}", "no such stage: 'vertx'"),
        ("a.frag", "#version 120\nvoid main() { gl_FragColor = gl_Fog.color; }",
         "declare it: nothing feeds the fixed-function pipeline"),
        ("a.frag", "#include <common>\nvoid main() {}", "no file to #include: 'common'"),
        ("a.frag", "#version 450\n#extension GL_EXT_scalar_block_layout : require\n"
         "layout(scalar) buffer B { vec3 v[]; };\nlayout(location = 0) out vec4 c;\n"
         "void main() { c = vec4(v[1], wrong); }", "'wrong' : undeclared identifier [vulkan]"),
        ("a.comp", "#version 450\nlayout(local_size_x = 8) in;\nlayout(rgba8) uniform image2D p;"
         "\nvoid main() { imageStore(p, ivec2(0), vec4(1)); imageStore(p, ivec2(1), imageLoad(p, "
         "ivec2(0))); }", "imageLoad of p, in which texels are stored before, at line 4"),
        ("a.frag", "#version 450\nlayout(input_attachment_index = 0) uniform subpassInput albedo;"
         "\nlayout(location = 0) out vec4 c;\nvoid main() { c = subpassLoad(albedo); }",
         "not interpreted: subpassInput albedo at line 4 → read a sampler2D: texelFetch("),
        ("a.frag", "void mainImage(out vec4 c, in vec2 p) { c = texture(iChannel0, vec3(p, 1)); }",
         "declare it, if it is no sampler2D: uniform samplerCube iChannel0;"),
        ("a.frag", "void mainImage(out vec4 c, in vec2 p) {\nc = texture(iChannel0, p);\n"
         "c += texture( iChannel3, vec3(p, 1)); }",
         "declare it, if it is no sampler2D: uniform samplerCube iChannel3;"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("command", ["audit", "explain", "diff"])
def test_what_is_refused_says_why(
    tmp_path: Path, command: str, name: str, text: str, words: str
) -> None:
    (tmp_path / "common").mkdir()
    file = tmp_path / name
    file.write_text(text)
    status, said = call(command, file, *[file] * (command == "diff"))
    assert status in (1, 2) and words in " ".join(said.split()), said


def test_an_include_from_the_root_is_one_from_the_shader_folder(tmp_path: Path) -> None:
    for folder in ("lib", "world/lib"):
        (tmp_path / folder).mkdir(parents=True)
        text = f"float {folder[0]}_half() {{ return 0.5; }}\n"
        (tmp_path / folder / "half.glsl").write_text(text)
    text = "out vec4 c;\nvoid main() { c = vec4(l_half()); }\n"
    file = tmp_path / "world" / "final.fsh"
    file.write_text(f'#version 330 core\n#include "/lib/half.glsl"\n{text}')
    assert call("compile", tmp_path)[0] == 0
    file.write_text(f'#version 330 core\n#include "/lib/other.glsl"\n{text}')
    assert "only files inside the shader folders are read" in call("compile", tmp_path)[1]


def test_an_include_that_leads_out_names_the_folder_to_add(tmp_path: Path) -> None:
    """No file outside of the named roots is read: the folder that has both is named in words."""
    library, elsewhere = tmp_path / "library", tmp_path / "elsewhere"
    for folder in (library / "light" / "point", library / "math", elsewhere):
        folder.mkdir(parents=True)
    (library / "math" / "half.glsl").write_text("float half_of(float x) { return 0.5 * x; }\n")
    file = library / "light" / "point" / "falloff.glsl"
    file.write_text(
        '#include "../../math/half.glsl"\nfloat falloff(float d) { return half_of(d); }\n'
    )
    status, said = call("audit", file)
    assert status == 2 and "half_of" not in said
    folder = said.split("--include ")[1].strip()
    assert call("audit", file, "--include", folder)[0] == 0


def test_a_vertex_stage_without_version_is_of_its_fragment_stages_dialect(tmp_path: Path) -> None:
    vertex, es, desktop = (tmp_path / name for name in ("a.vert", "es.frag", "desktop.frag"))
    vertex.write_text("attribute vec4 at;\nvoid main() { gl_Position = at; }\n")
    desktop.write_text("void main() { gl_FragColor = vec4(1.0); }\n")
    es.write_text("precision mediump float;\n" + desktop.read_text())
    assert call("compile", "--link", vertex, es)[0] == 0
    assert call("compile", "--link", "--target", "glsl", vertex, desktop)[0] == 0


def test_words_that_later_versions_took_are_names_of_functions(tmp_path: Path) -> None:
    text = (
        "uniform sampler2D texture; float round(float x) { return floor(x + 0.25); }\n"
        "vec3 centroid(vec3 a) { return a / 3.0; }\n"
        "vec4 f(vec2 uv) { vec4 smooth = texture2D(texture, uv); return smooth * round(0.8); }\n"
    )
    made = glsl.load(text)
    white = np.ones((2, 2, 4), np.float32)
    assert made.f((0.5, 0.5), texture=white).tolist() == [1.0] * 4
    assert made.round(0.7) == 0.0 and made.centroid([3.0, 6.0, 9.0]).tolist() == [1.0, 2.0, 3.0]


def test_text_includes_from_the_callers_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "law.glsl").write_text("float law(float x) { return 2.0 * x; }\n")
    monkeypatch.chdir(tmp_path)
    made = glsl.load('#include "law.glsl"\nfloat twice(float x) { return law(law(x)); }')
    assert made.twice(1.0) == 4.0


def test_an_overload_of_an_unknown_type_leaves_the_others(tmp_path: Path) -> None:
    made = glsl.load("float f(float x) { return x; }\nfloat f(Shading s) { return s.x; }\n")
    assert made.f["float"](2.0) == 2.0


def test_a_package_includes_by_its_own_name(tmp_path: Path) -> None:
    package = tmp_path / "lights"
    (package / "math").mkdir(parents=True)
    (package / "math" / "one.glsl").write_text("float one() { return 1.0; }\n")
    (package / "a.frag").write_text(
        '#version 330\n#include "lights/math/one.glsl"\nout float c;\nvoid main() { c = one(); }\n'
    )
    assert compile_program([Shaders([package]).load("a.frag")]).ok


def test_functions_are_matched_by_types_whatever_their_parameters_are_called(
    tmp_path: Path,
) -> None:
    old, new = tmp_path / "old.glsl", tmp_path / "new.glsl"
    old.write_text("float f(float a, vec2 b) { return a * b.x; }\n")
    new.write_text("float f(float x, vec2 y) { return y.x * x; }\n")
    status, said = call("diff", old, new)
    assert status == 0 and "f: same" in said


def test_what_float32_cannot_tell_is_no_difference() -> None:
    text = "#version 330\nin float x;\nout vec2 c;\nvoid main() { c = vec2(max(x, 0.5)RESULT); }\n"
    programs = [
        load(Shaders([]).from_text(text.replace("RESULT", word), "fragment", "a.frag"))
        for word in ("", " + 0.5e-9")
    ]
    (answer,) = compare_programs(*programs, Plan()).outputs
    assert answer.same


def test_a_sum_that_is_squared_for_long_has_a_band() -> None:
    text = """#version 330
        in float x; out float c;
        void main() { vec2 z = vec2(x, 0.1);
            for (int i = 0; i < 60; i++)
                z = vec2(z.x * z.x - z.y * z.y + x, 2.0 * z.x * z.y + 0.1);
            c = z.x; }"""
    program = load(Shaders([]).from_text(text, "fragment", "a.frag"))
    assert compare_programs(program, program, Plan(ranges={"x": "-0.2..0.2"})).outputs


def test_a_type_that_nothing_defines_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.glsl").write_text("float half_of(HIGHP in float x) { return 0.5 * x; }\n")
    with pytest.raises(CallError, match="HIGHP, which nothing defines"):
        glsl.load(tmp_path / "a.glsl").half_of(1.0)


def test_a_file_that_only_includes_has_what_it_includes(tmp_path: Path) -> None:
    (tmp_path / "math.glsl").write_text(
        "#define PI 3.14\nfloat half_of(float x) { return x / 2.0; }\n"
    )
    (tmp_path / "part.fs").write_text("float arc(float x) { return half_of(PI * x); }\n")
    whole = tmp_path / "whole.glsl"
    whole.write_text('#include "math.glsl"\n#include "part.fs"\n')
    status, said = call("audit", whole, "--inputs")
    assert status == 0 and "half_of: x" in said and "arc: x" in said
    status, said = call("diff", whole, whole)
    assert status == 0 and "half_of: same" in said and "arc: same" in said


def test_a_text_for_several_versions_has_the_outputs_of_the_one_that_it_is_read_as(
    tmp_path: Path,
) -> None:
    file = tmp_path / "several.frag"
    old = "#if __VERSION__ == 100\n{}\n#endif\n"
    new = "#if __VERSION__ != 100\nlayout(location = 0) out vec4 color;\n#endif\n"
    main = f"void main() {{ color = vec4(0.5);\n{old.format('gl_FragColor = color;')}}}"
    file.write_text(f"{old.format('vec4 color;')}{new}{main}")
    assert call("audit", file)[0] == 0


@pytest.mark.parametrize("suffix", ["cs", "tcs", "tes", "gs"])
def test_functions_of_a_later_stage_are_read_without_a_version(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"part.{suffix}"
    file.write_text("float half_of(float x) { return 0.5 * x; }")
    assert glsl.load(file).half_of(3.0) == 1.5


LIBRARY = {
    "pyproject.toml": '[tool.shaderlab]\nshaders = ["."]\n',
    "math/const.glsl": "#ifndef TAU\n#define TAU 6.25\n#endif\n",
    "math/types.glsl": "struct Ray { vec3 at; vec3 along; };\n",
    "math/half.glsl": "float half_of(float x)\n{\n    return 0.5 * x;\n}\n",
    "turn.glsl": """float turn(float x) {
        return half_of(x) * TAU; }
        float own(float x) { return x; }""",
    "ray.glsl": "float along(Ray ray) { return ray.along.x; }\n",
}


def write(folder: Path, **texts: str) -> Path:
    """A library with some other texts, by the names of .glsl files."""
    for name, text in {**LIBRARY, **{f"{name}.glsl": text for name, text in texts.items()}}.items():
        (folder / name).parent.mkdir(exist_ok=True, parents=True)
        (folder / name).write_text(text)
    return folder


def test_what_a_file_lacks_comes_from_its_library(tmp_path: Path) -> None:
    write(tmp_path)
    turn = glsl.load(tmp_path / "turn.glsl")
    with pytest.warns(UserWarning) as told:
        assert turn.turn(2.0) == 6.25
    said = "; ".join(str(one.message) for one in told)
    assert "turn.glsl lacks half_of: math/half.glsl, which defines it, is included" in said
    assert "turn.glsl lacks TAU: math/const.glsl" in said
    assert turn.turn.place == (str(tmp_path / "turn.glsl"), 1) and turn.own.place[1] == 3
    assert all(one.filename == __file__ for one in told)
    with pytest.warns(UserWarning, match="ray.glsl lacks Ray: math/types.glsl"):
        ray = {"at": np.zeros(3), "along": np.ones(3)}
        assert glsl.load(tmp_path / "ray.glsl").along(ray) == 1.0
    for name, function in (("turn", "turn: x"), ("ray", "along: ray_along")):
        status, said = call("audit", tmp_path / f"{name}.glsl", "--inputs")
        assert status == 0 and f"{name}.glsl lacks" in said and function in said
    (tmp_path / "new.glsl").write_text(LIBRARY["turn.glsl"].replace("half_of(x) * TAU", "x * 3.0"))
    status, said = call("diff", tmp_path / "turn.glsl", tmp_path / "new.glsl")
    assert status == 1 and "turn.glsl lacks TAU" in said and "turn: different" in said


def test_what_is_included_comes_after_what_it_needs(tmp_path: Path) -> None:
    write(
        tmp_path,
        far="float far(float x) { return near(x) * TAU; }\n",
        near="float near(float x) { return half_of(x) + 0.0 * TAU; }\n",
        use="float use(Ray ray) { return far(ray.at.x); }\n",
    )
    with pytest.warns(UserWarning):
        use = glsl.load(tmp_path / "use.glsl").use
        assert use({"at": np.full(3, 2.0), "along": np.ones(3)}) == 6.25
    places = [use.source.place(n + 1)[0] for n in range(use.source.text.count("\n"))]
    assert places[-1].endswith("use.glsl") and len(set(places)) == 6


@pytest.mark.filterwarnings("ignore:.* lacks TAU")
def test_mutants_of_a_file_have_what_it_lacks_from_anywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path / "library", turn="float turn(float x) { return max(x, x) * TAU; }\n")
    file = tmp_path / "test_turn.py"
    file.write_text(f"""from shaderlab import glsl
turn = glsl.load({str(tmp_path / "library/turn.glsl")!r}).turn
def test_turn(): assert turn(2.0) == 12.5
""")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    said = call("mutate", file)[1]
    assert "noticed: 100 %" in said and "gives other values" not in said


def test_what_a_file_lacks_is_not_guessed(tmp_path: Path) -> None:
    write(tmp_path, turn=LIBRARY["turn.glsl"].replace("half_of(x)", "0.5 * x"))
    path, other = tmp_path / "turn.glsl", tmp_path / "math/more.glsl"
    other.write_text("#define TAU 6.28318\n")
    with pytest.raises(ShaderError, match=r"math/const.glsl or math/more.glsl: include it first"):
        glsl.load(path).turn(1.0)
    assert glsl.load(path).own(1.0) == 1.0
    status, said = call("audit", path)
    assert status == 2 and "TAU is defined in" in said and "more.glsl: include it first" in said
    other.write_text("// a copy\n#define TAU   6.25\n")
    with pytest.warns(UserWarning, match="lacks TAU"):
        assert glsl.load(path).turn(2.0) == 6.25
    other.write_text("")
    (tmp_path / "math/const.glsl").unlink()
    other.unlink()
    outside = tmp_path.parent / f"{tmp_path.name}_const.glsl"
    outside.write_text("#define TAU 6.25\n")
    (tmp_path / "math/const.glsl").symlink_to(outside)
    with pytest.raises(ShaderError, match="define TAU first"):
        glsl.load(path).turn(1.0)
    (tmp_path / "math/const.glsl").unlink()
    (tmp_path / "math/const.glsl").write_text("#define TAU 6.25\nvoid main() {}\n")
    with pytest.raises(ShaderError, match=r"TAU is defined in math/const.glsl: include it first"):
        glsl.load(path).turn(1.0)


def test_a_function_that_compiles_keeps_its_text(tmp_path: Path) -> None:
    own = "float own(float x) {\n#ifdef TAU\n  return TAU;\n#endif\n  return x; }\n"
    write(tmp_path, own=f"{own}float turn(float x) {{ return x * TAU; }}\n")
    library = glsl.load(tmp_path / "own.glsl")
    assert library.own(2.0) == 2.0
    with pytest.raises(ShaderError, match=r"TAU is defined in math/const.glsl"):
        library.turn(1.0)
    over = "float own(int x) { return 1.0; }\n#define LACKED 2.0\n"
    write(tmp_path, more=over, own="float own(float x) { return x; }\nfloat f() { return LACKED; }")
    assert glsl.load(tmp_path / "own.glsl").own(3) == 3.0


def test_who_has_to_define_what_a_file_leaves_to_its_user_is_said(tmp_path: Path) -> None:
    write(
        tmp_path,
        march="float map(vec3 p);\nfloat march(vec3 p) { return 2.0 * map(p); }\n",
        size="float first(float a[SIZE]) { return a[0]; }\nfloat wide() { return float(WIDTH); }\n",
        lamp="#ifdef LIT\nfloat lamp() { return 1.0; }\n#endif\nfloat f() { return lamp(); }\n",
        own="float own(float x) { return x; }\nfloat two(float x) { return own(x, x); }\n",
    )
    with pytest.raises(ShaderError, match="map is declared, but has no body here") as refused:
        glsl.load(tmp_path / "march.glsl").march(np.ones(3))
    assert refused.value.remedy is not None and "text for glsl.load" in refused.value.remedy
    with pytest.raises(CallError, match="define SIZE first"):
        glsl.load(tmp_path / "size.glsl").first([1.0])
    with pytest.raises(ShaderError, match="define WIDTH first"):
        glsl.load(tmp_path / "size.glsl").wide()
    with pytest.raises(ShaderError, match=r"an #if leaves out lamp at .*lamp.glsl:2"):
        glsl.load(tmp_path / "lamp.glsl").f()
    assert glsl.load(tmp_path / "lamp.glsl", defines={"LIT": ""}).f() == 1.0
    with pytest.raises(ShaderError) as refused:
        glsl.load(tmp_path / "own.glsl").two(1.0)
    assert refused.value.remedy is None


def test_a_text_defines_what_a_file_leaves_to_its_user(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    write(tmp_path, march="float map(vec3 p);\nfloat march(vec3 p) { return 2.0 * map(p); }\n")
    monkeypatch.chdir(tmp_path)
    text = '#include "march.glsl"\nfloat map(vec3 p) { return length(p); }\n'
    assert glsl.load(text).march([3.0, 0.0, 4.0]) == 10.0


def test_uniforms_of_viewers_need_no_declaration(tmp_path: Path) -> None:
    write(
        tmp_path,
        seen="""vec2 seen(vec2 p) { return (u_projectionMatrix * vec4(p, u_time, 1.0)).xy; }
            vec4 at(vec2 p) { return texture2D(u_tex0, p); }""",
        own="uniform float u_time; float own() { return u_time; }",
    )
    seen = glsl.load(tmp_path / "seen.glsl", u_time=1.0)
    assert seen.seen([1.0, 2.0], u_projectionMatrix=3.0 * np.eye(4)).tolist() == [3.0, 6.0]
    assert seen.at([0.5, 0.5], u_tex0=np.full((2, 2, 4), 0.25, np.float32)).tolist() == [0.25] * 4
    assert glsl.load(tmp_path / "own.glsl").own(u_time=0.5) == 0.5
    status, said = call("audit", tmp_path / "seen.glsl", "--inputs")
    assert status == 0 and "seen: u_projectionMatrix" in said and "at: u_tex0" in said
    with pytest.raises(CallError, match="u_time, which is not given"):
        glsl.load(tmp_path / "seen.glsl").seen([1.0, 2.0], u_projectionMatrix=np.eye(4))


def test_a_text_may_only_include(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "const.glsl").write_text("#define TAU 6.25\n")
    (tmp_path / "turn.glsl").write_text("float turn(float x) { return x * TAU; }\n")
    both = '#include "const.glsl"\n#include "turn.glsl"\n'
    assert glsl.load(both).turn(2.0) == 12.5


def test_what_another_stage_has_is_not_taken_for_the_fixed_function_pipeline(
    tmp_path: Path,
) -> None:
    file = tmp_path / "part.cs"
    file.write_text("uint group() { return gl_WorkGroupID.x; }\n")
    said = call("audit", file)[1]
    assert "'gl_WorkGroupID' : undeclared" in said and "fixed-function" not in said


def test_a_function_that_can_not_be_compiled_takes_no_other_with_it(tmp_path: Path) -> None:
    good = "float half_of(float x) { return 0.5 * x; }\n"
    for name, half in (("old", "0.5"), ("new", "0.25")):
        lacking = (
            "float along(Ray ray) { return ray.along.x; }\nfloat turn(float x) { return TAU; }\n"
        )
        text = f"// {name}\n#version 330 core\n{lacking}{good.replace('0.5', half)}"
        (tmp_path / f"{name}.glsl").write_text(text)
    said = call("audit", tmp_path / "old.glsl")[1]
    assert "old.glsl: no hazards" in said and "half_of: x: 0..1" in said
    assert "along: " in said and "turn: " in said
    said = call("diff", tmp_path / "old.glsl", tmp_path / "new.glsl")[1]
    assert "half_of: different" in said and "undetermined for along" in said


def test_uniforms_of_three_js_are_given_to_functions_that_use_them() -> None:
    lib = glsl.load("vec3 seen(vec3 p) { return (viewMatrix * vec4(p, 1.0)).xyz; }")
    turn = np.diag([1.0, -1.0, 2.0, 1.0])
    assert lib.seen([1.0, 2.0, 3.0], viewMatrix=turn).tolist() == [1.0, -2.0, 6.0]


LIGHTS = """#version 330 core
struct Light { vec3 place, color; float a, b, c; };
uniform Light lights[40]; uniform vec4 table[400]; uniform int n; in vec3 p; out vec4 color;
void main() {
    vec3 sum = table[n % 400].rgb;
    for (int i = 0; i < n; i++) {
        float r = length(lights[i].place - p);
        sum += lights[i].color / (lights[i].a + lights[i].b * r + lights[i].c * r * r);
    }
    color = vec4(sum, 1.0);
}
"""


@pytest.mark.parametrize("words", ["audit", "explain", "prove", "diff"])
def test_large_arrays_take_little_memory(tmp_path: Path, words: str) -> None:
    """There are fewer inputs then; and an array is one line."""
    file = tmp_path / "lights.frag"
    file.write_text(LIGHTS)
    files = [str(file)] * (1 + (words == "diff"))
    limits = ("-j", "1", "--memory", "1")
    found = CliRunner().invoke(cli, [words, *files, *limits])
    assert found.exit_code in (0, 1) and "undetermined" not in found.output, found.output
    lines = found.output.splitlines()
    assert len(lines) < 30 and max(map(len, lines)) < 2500


def test_a_counterexample_of_many_inputs_is_not_run_on_the_driver(tmp_path: Path) -> None:
    """Which would compile for a minute."""
    file = tmp_path / "many.frag"
    text = "#version 330 core\nuniform vec4 v[%d]; flat in int n; out vec4 o;\n"
    text += "void main() { o = v[n] / v[n + 1].x; }\n"
    for length, said in ((20, "on the driver o = "), (250, "reads more than 200")):
        file.write_text(text % length)
        assert said in call("prove", file)[1]
