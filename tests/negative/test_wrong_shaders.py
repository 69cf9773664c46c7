"""Every way in which a shader or its file can be wrong, and what the lab says of it."""

# Messages stand here as the compiler words them, in one piece.
# ruff: noqa: E501

from collections.abc import Callable
from pathlib import Path

import pytest

from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import Compiled, compile_program
from shaderlab.errors import ShaderError

HEAD = "#version 330 core\nout vec4 c;\n"
MAIN = "void main() { c = vec4(1.0); }\n"
VERTEX = (
    "#version 330 core\nin vec3 a;\nout vec3 n;\n"
    "void main() { n = a; gl_Position = vec4(a, 1.0); }\n"
)


def fragment(text: str) -> Compiled:
    return compile_program([Shaders([]).from_text(text, "fragment", "wrong.frag")])


def linked(vertex: str, text: str) -> Compiled:
    shaders = Shaders([])
    return compile_program(
        [
            shaders.from_text(text, "fragment", "wrong.frag"),
            shaders.from_text(vertex, "vertex", "v.vert"),
        ]
    )


# What is wrong: vertex and fragment text, the fragment's line, the name, the first message.
LINKS: dict[str, tuple[str, str, int | None, str, str]] = {
    "a varying of two types": (
        VERTEX,
        HEAD + "in vec4 n;\nvoid main() { c = n; }\n",
        3,
        "n",
        'Linking vertex and fragment stages: Types must match:\n    vertex stage: " vec3 n"\n    fragment stage: " vec4 n"',
    ),
    "a uniform of two types": (
        VERTEX.replace("out vec3 n", "uniform vec3 u;\nout vec3 n").replace("n = a", "n = u"),
        HEAD + "in vec3 n;\nuniform vec4 u;\nvoid main() { c = u + n.xyzz; }\n",
        4,
        "u",
        'Linking unknown stage and fragment stages: Types must match:\n    unknown stage stage: " vec3 u"\n    fragment stage: " vec4 u"',
    ),
    "array varyings of two sizes": (
        VERTEX.replace("vec3 n", "vec3 n[2]").replace(" n =", " n[0] ="),
        HEAD + "\nin vec3 n[3];\nvoid main() { c = n[0].xyzz; }\n",
        4,
        "n",
        'Linking vertex and fragment stages: Array sizes must be compatible:\n    vertex stage: " vec3 n[2]"\n    fragment stage: " vec3 n[3]"',
    ),
    "block members of two types": (
        VERTEX.replace("out vec3 n", "out B { vec3 n; } o").replace("n = a", "o.n = a"),
        HEAD + "in B { vec2 n; } i;\nvoid main() { c = i.n.xyxy; }\n",
        3,
        "n",
        'Linking vertex and fragment stages: Member names and types must match:\n    Block: B\n        vertex stage: " vec3 n"\n        fragment stage: " vec2 n"',
    ),
    "uniform blocks with other members": (
        VERTEX.replace("in", "layout (std140) uniform B { vec4 x; vec4 y; };\nin", 1),
        HEAD + "layout (std140) uniform B { vec4 x; };\nvoid main() { c = x; }\n",
        None,
        "",
        "Linking unknown stage and fragment stages: unknown stage block member has no "
        "corresponding member in fragment block:\n    unknown stage stage: Block: B, Member: y\n"
        "    fragment stage: Block: B, Member: n/a",
    ),
    "uniform blocks of two layouts": (
        VERTEX.replace("in", "layout (std140) uniform B { vec4 x; };\nin", 1),
        HEAD + "layout (shared) uniform B { vec4 x; };\nvoid main() { c = x; }\n",
        None,
        "",
        "Linking unknown stage and fragment stages: Interface block member layout offset "
        "qualifier must match:\n"
        '    unknown stage stage: Block: B, Member: x "layout( column_major std140 offset=0) '
        'uniform"\n'
        '    fragment stage: Block: B, Member: x "layout( column_major shared) uniform"',
    ),
    "uniforms with two initial values": (
        VERTEX.replace("in", "uniform float u = 1.0;\nin", 1),
        HEAD + "uniform float u = 2.0;\nvoid main() { c = vec4(u); }\n",
        None,
        "",
        "Linking unknown stage and fragment stages: Initializers must match:\n    u",
    ),
    "a function used but defined nowhere": (
        VERTEX,
        HEAD + "vec4 f();\nvoid main() { c = f(); }\n",
        3,
        "f",
        "Linking fragment stage: No function definition (body) found: \n    f(",
    ),
}


@pytest.mark.parametrize("kind", LINKS)
def test_stages_that_do_not_fit_are_rejected_at_the_declaration(kind: str) -> None:
    vertex, text, line, name, words = LINKS[kind]
    compiled = linked(vertex, text)
    assert [verdict.ok for verdict in compiled.verdicts] == [False, False, False]
    error = compiled.verdicts[0].diagnostics[0]
    assert error.message == words
    assert (error.file, error.line, error.token) == ("wrong.frag", line, name)


def test_an_input_that_nobody_writes_is_rejected_by_what_links() -> None:
    text = HEAD + "in vec3 n;\n// in vec3 m;\nin vec3 m;\nvoid main() { c = vec4(n + m, 1.0); }\n"
    compiled = linked(VERTEX, text)
    assert [verdict.ok for verdict in compiled.verdicts] == [True, False, False]
    error = compiled.verdicts[1].diagnostics[0]
    assert (error.file, error.line, error.token) == ("wrong.frag", 5, "m")
    assert error.message == "'m' : input of the fragment stage that the vertex stage never writes"
    assert linked(VERTEX, text.replace("n + m", "n")).ok, "an unused input is allowed"


def test_a_location_that_two_types_share_is_rejected_by_what_links() -> None:
    vertex = VERTEX.replace("330", "430").replace("out", "layout (location = 2) out")
    text = HEAD.replace("330", "430") + "layout (location = 2) in vec4 m;\nvoid main() { c = m; }\n"
    compiled = linked(vertex, text)
    assert [verdict.ok for verdict in compiled.verdicts] == [True, False, False]
    error = compiled.verdicts[1].diagnostics[0]
    assert (error.file, error.line, error.token) == ("wrong.frag", 3, "m")
    assert error.message == "'m' : vec4 at location 2, where the vertex stage writes the vec3 'n'"
    assert linked(vertex, text.replace("vec4 m", "vec3 m").replace("= m", "= m.xyzz")).ok


def test_a_version_too_old_for_spirv_is_rejected_there_only(
    capfd: pytest.CaptureFixture[str],
) -> None:
    compiled = fragment("#version 120\nvoid main() { gl_FragColor = vec4(1.0); }\n")
    assert [verdict.ok for verdict in compiled.verdicts] == [True, False, False]
    assert compiled.interface is not None
    for verdict in compiled.verdicts[1:]:
        assert "SPIR-V require version" in verdict.diagnostics[0].message
        assert verdict.diagnostics[0].line == 1
    fragment("void main() { gl_FragColor = vec4(1.0); }\n")
    assert capfd.readouterr().out == "", "glslang prints its built-in functions"


def test_a_sampler_in_a_struct_that_travels_is_rejected_for_vulkan_only() -> None:
    compiled = fragment(
        HEAD + "struct Material { sampler2D map; float s; };\nuniform Material material;\n"
        "vec4 look(Material m) { return texture(m.map, vec2(0.0)) * m.s; }\n"
        "void main() { c = look(material); }\n"
    )
    assert [verdict.ok for verdict in compiled.verdicts] == [True, True, False]
    error = compiled.verdicts[2].diagnostics[0]
    assert (error.line, error.token) == (3, "Material")
    assert "no samplers inside structs" in error.message


def test_strict_vulkan_rejects_loose_uniforms() -> None:
    text = HEAD + "uniform vec4 u;\nvoid main() { c = u; }\n"
    sources = [Shaders([]).from_text(text, "fragment", "wrong.frag")]
    compiled = compile_program(sources, ["vulkan", "vulkan-strict"])
    assert [verdict.ok for verdict in compiled.verdicts] == [True, False]
    assert "non-opaque uniforms outside a block" in compiled.verdicts[1].diagnostics[0].message


# What is wrong: files below the root, then the error's file, line, message and remedy.
FILES: dict[str, tuple[dict[str, bytes], str, int | None, str, str]] = {
    "no such shader": (
        {"attenuation.frag": b"x"},
        "a.frag",
        None,
        "no shader 'a.frag' in ROOT",
        "",
    ),
    "a directory": (
        {"a.frag/b.frag": b"x"},
        "a.frag",
        None,
        "is a directory, not a shader",
        "name a file",
    ),
    "an empty file": ({"a.frag": b""}, "a.frag", None, "the shader is empty", ""),
    "a huge file": (
        {"a.frag": b"//" + b" " * (4 << 20)},
        "a.frag",
        None,
        "is larger than 4 MiB, which no shader is",
        "see whether",
    ),
    "only white space": ({"a.frag": b" \r\n\t\n"}, "a.frag", None, "the shader is empty", ""),
    "not UTF-8": (
        {"a.frag": b"ok\n// \xe9t\xe9\n"},
        "a.frag",
        2,
        "is not UTF-8: byte 6 is 0xe9",
        "UTF-8",
    ),
    "UTF-16": (
        {"a.frag": b"\xff\xfea\0"},
        "a.frag",
        None,
        "is not UTF-8: byte 0 is 0xff (it looks like UTF-16)",
        "UTF-8",
    ),
    "a NUL": (
        {"a.frag": b"a\nb\0c\n"},
        "a.frag",
        2,
        "holds a NUL character, at which compilers stop reading",
        "delete",
    ),
    "a missing include": (
        {"a.frag": b'\n#include "lib/lihgt.glsl"\n', "lib/light.glsl": b"x"},
        "a.frag",
        2,
        "no file to #include: 'lib/lihgt.glsl'",
        "lib/light.glsl",
    ),
    "a missing include, two deep": (
        {"a.frag": b'#include "x.glsl"\n', "x.glsl": b'\n\n#include "no.glsl"\n'},
        "x.glsl",
        3,
        "no file to #include: 'no.glsl' (included by ROOT/a.frag:1)",
        "",
    ),
    "an include of itself": (
        {"a.frag": b'#include "a.frag"\n'},
        "a.frag",
        1,
        "'a.frag' includes itself",
        "",
    ),
    "a cycle of includes": (
        {
            "a.frag": b'#include "x.glsl"\n',
            "x.glsl": b'\n#include "y.glsl"\n',
            "y.glsl": b'\n\n#include "x.glsl"\n',
        },
        "y.glsl",
        3,
        "'x.glsl' includes itself (included by ROOT/a.frag:1 → ROOT/x.glsl:2)",
        "break the cycle",
    ),
    "an include out of the root": (
        {"a.frag": b'#include "../secret.glsl"\n'},
        "a.frag",
        1,
        "#include '../secret.glsl' leads out of the shader folders",
        "",
    ),
    "an absolute include": (
        {"a.frag": b'#include "/etc/passwd"\n'},
        "a.frag",
        1,
        "#include '/etc/passwd' is an absolute path; only files inside the shader folders are read",
        "",
    ),
    "a backslash": (
        {"a.frag": b'#include "lib\\x.glsl"\n'},
        "a.frag",
        1,
        "#include 'lib\\\\x.glsl' has a backslash; write / between folders",
        "",
    ),
    "an include of nothing": (
        {"a.frag": b'#include ""\n'},
        "a.frag",
        1,
        "#include '' is empty; name a shader file",
        "",
    ),
    "an include without quotes": (
        {"a.frag": b"#include lib/x.glsl\n"},
        "a.frag",
        1,
        "malformed #include lib/x.glsl",
        'write #include "file.glsl"',
    ),
    "an include of a folder": (
        {"a.frag": b'#include "lib"\n', "lib/x.glsl": b"x"},
        "lib",
        None,
        "is a directory, not a shader (included by ROOT/a.frag:1)",
        "",
    ),
    "an included file that is empty": (
        {"a.frag": b'\n#include "x.glsl"\n', "x.glsl": b""},
        "x.glsl",
        None,
        "the shader is empty (included by ROOT/a.frag:2)",
        "",
    ),
    "a stage nobody knows": (
        {"a.txt": b"x"},
        "a.txt",
        None,
        "can't tell the shader's stage from its name",
        ".frag",
    ),
    "a pragma for no stage": (
        {"a.frag.txt": b"\n#pragma shader_stage(fragmet)\n"},
        "a.frag.txt",
        2,
        "#pragma shader_stage(fragmet) names no stage",
        "fragment",
    ),
}


@pytest.mark.parametrize("kind", FILES)
def test_a_wrong_file_is_named_with_its_line_and_a_remedy(tmp_path: Path, kind: str) -> None:
    files, file, line, words, remedy = FILES[kind]
    (tmp_path / "secret.glsl").write_text("secret\n")
    root = tmp_path / "shaders"
    for name, data in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_bytes(data)
    asked = next((name for name in files if name.startswith("a.")), "a.frag").partition("/")[0]
    with pytest.raises(ShaderError) as raised:
        Shaders([root]).load(asked)
    error = raised.value
    assert error.message.replace(str(root), "ROOT") == words
    assert remedy in (error.remedy or "")
    assert (error.file or "").endswith(file)
    assert error.line == line


def test_a_link_out_of_the_root_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "secret.glsl").write_text("secret\n")
    root = tmp_path / "shaders"
    root.mkdir()
    (root / "link.glsl").symlink_to(tmp_path / "secret.glsl")
    (root / "a.frag").write_text('#include "link.glsl"\n')
    (root / "gone.frag").symlink_to(root / "nowhere.frag")
    for name, words in [
        ("a.frag", "symbolic link leads out"),
        ("link.glsl", "symbolic link leads out"),
        ("gone.frag", "no such shader file"),
    ]:
        with pytest.raises(ShaderError, match=words) as raised:
            Shaders([root]).load(name, "fragment")
        assert "secret\n" not in str(raised.value)


def test_includes_that_grow_without_end_are_stopped(tmp_path: Path) -> None:
    for level in range(25):
        text = f'#include "{level + 1}.glsl"\n' * 2
        (tmp_path / f"{level}.glsl").write_text(text)
    (tmp_path / "25.glsl").write_text("float x; // and a comment to make it longer\n")
    with pytest.raises(ShaderError, match="more than 10,000 times"):
        Shaders([tmp_path]).load("0.glsl", "fragment")


def test_includes_nested_too_deep_are_stopped(tmp_path: Path) -> None:
    for level in range(100):
        (tmp_path / f"{level}.glsl").write_text(f'#include "{level + 1}.glsl"\n')
    (tmp_path / "100.glsl").write_text("\n//\n")
    with pytest.raises(ShaderError, match="nest deeper than 64"):
        Shaders([tmp_path]).load("0.glsl", "fragment")


# What is asked of the lab that makes no sense, and what it answers.
MISUSES: dict[str, tuple[Callable[[], object], str]] = {
    "no stages": (lambda: compile_program([]), "at least one stage"),
    "two of one stage": (
        lambda: compile_program([Shaders([]).from_text(HEAD, "fragment", n) for n in "ab"]),
        "one fragment stage; b is another",
    ),
    "compute with others": (
        lambda: compile_program(
            [Shaders([]).from_text(HEAD, stage, stage) for stage in ("compute", "vertex")]
        ),
        "can't be linked with a vertex stage",
    ),
    "no such target": (
        lambda: compile_program([Shaders([]).from_text(HEAD, "vertex", "a")], ["vulcan"]),
        "did you mean vulkan",
    ),
    "no such stage": (
        lambda: Shaders([]).from_text(HEAD, "fragmant", "a"),
        "did you mean fragment",
    ),
    "a define that is no name": (lambda: Shaders([], defines={"1x": ""}), "not a GLSL name"),
    "a name out of the roots": (lambda: Shaders([]).load("../a.frag"), "leads out of"),
}


@pytest.mark.parametrize("kind", MISUSES)
def test_what_makes_no_sense_is_said(kind: str) -> None:
    misuse, words = MISUSES[kind]
    with pytest.raises(ShaderError) as raised:
        misuse()
    assert words in str(raised.value)
