"""Every way in which a shader or its file can be wrong, and what the lab says of it."""

from collections.abc import Callable
from pathlib import Path

import pytest

from shaderlab.errors import ShaderError
from shaderlab.glsl import Compiled, Shaders, compile_program

HEAD = "#version 330 core\nout vec4 c;\n"
MAIN = "void main() { c = vec4(1.0); }\n"
VERTEX = (
    "#version 330 core\nin vec3 a;\nout vec3 n;\n"
    "void main() { n = a; gl_Position = vec4(a, 1.0); }\n"
)


def fragment(text: str) -> Compiled:
    return compile_program([Shaders([]).from_text(text, "fragment", "wrong.frag")])


# What is wrong: the text, the line, and words of the message.
TEXTS = {
    "a name nobody declared": (HEAD + "void main() { c = vec4(x); }\n", 3, "'x' : undeclared"),
    "a missing semicolon": (
        HEAD + "void main() {\n c = vec4(1.0)\n}\n",
        5,
        "unexpected RIGHT_BRACE",
    ),
    "a missing brace": (HEAD + "void main() {\n c = vec4(1.0);\n", 5, "unexpected end of file"),
    "a type that does not convert": (HEAD + "void main() { int i = 1.0; }\n", 3, "cannot convert"),
    "too few components": (HEAD + "void main() { c = vec4(vec2(1.0)); }\n", 3, "not enough data"),
    "a swizzle out of range": (HEAD + "void main() { c = vec2(1).xyzz; }\n", 3, "vector swizzle"),
    "an unknown function": (HEAD + "void main() { c = vec4(sinn(1.0)); }\n", 3, "no matching"),
    "a wrong argument": (HEAD + "void main() { c = cross(c, c); }\n", 3, "no matching overloaded"),
    "writing a uniform": (
        HEAD + "uniform vec4 u;\nvoid main() { u = c; }\n",
        4,
        "can't modify a uniform",
    ),
    "writing an input": (HEAD + "in vec4 i;\nvoid main() { i = c; }\n", 4, "l-value required"),
    "a reserved word": (HEAD + "vec4 output;\n" + MAIN, 3, "Reserved word"),
    "a double definition": (HEAD + "float a;\nfloat a;\n" + MAIN, 4, "'a' : redefinition"),
    "a uniform of two types": (
        HEAD + "uniform vec3 a;\nuniform vec4 a;\n" + MAIN,
        4,
        "redefinition",
    ),
    "no main": (HEAD + "void mane() { c = vec4(1.0); }\n", None, "Missing entry point"),
    "a function without body": (
        HEAD + "float f();\nvoid main() { c = vec4(f()); }\n",
        3,
        "No function definition",
    ),
    "recursion": (
        HEAD + "float f() { return f(); }\nvoid main() { c = vec4(f()); }\n",
        3,
        "Recursion detected",
    ),
    "a wrong profile": ("#version 330_core\n" + HEAD[18:] + MAIN, 1, "bad profile name"),
    "a version that is not": ("#version 999\n" + HEAD[18:] + MAIN, 1, "version not supported"),
    "words after the version": ("#version 330 core 0\n" + HEAD[18:] + MAIN, 1, "bad tokens"),
    "a version too late": ("\nfloat a;\n#version 330 core\n" + MAIN, 3, "must occur first"),
    "#error": (HEAD + "#error not like this\n" + MAIN, 3, "not like this"),
    "an extension that is not": (
        HEAD + "#extension GL_no : require\n" + MAIN,
        3,
        "not supported: GL_no",
    ),
    "#if without #endif": (HEAD + MAIN + "#if 1\n", 5, "missing #endif"),
    "a letter GLSL lacks": (HEAD + "float é;\n" + MAIN, 3, "unexpected token"),
    "an int attribute not flat": (HEAD + "in int i;\n" + MAIN, 3, "must be qualified as flat"),
    "double in 330": (HEAD + "dvec3 d;\n" + MAIN, 3, "Reserved word"),
    "two outputs in one place": (
        HEAD + "layout(location=0) out vec4 d;\nlayout(location=0) out vec4 e;\n" + MAIN,
        4,
        "overlapping use of location",
    ),
    "a sampler indexed by a variable": (
        HEAD + "uniform sampler2D t[2]; uniform int i;\nvoid main() { c = texture(t[i], c.xy); }\n",
        4,
        "variable indexing sampler array",
    ),
    "a sum that overflows the stack": (
        HEAD + "uniform float x;\nvoid main() { c = vec4(" + "+".join(["x"] * 100_000) + "); }\n",
        4,
        "more than 5000 operators",
    ),
    "macros that unfold to such a sum": (
        HEAD
        + "#define A 1.0\n"
        + "".join(
            f"#define {b} {a}+{a}\n"
            for a, b in zip("ABCDEFGHIJKLMN", "BCDEFGHIJKLMNO", strict=True)
        )
        + "void main() { c = vec4(O); }\n",
        18,
        "more than 5000 operators",
    ),
    "branches too deep": (
        HEAD + "uniform float x;\nvoid main() {\n" + "if (x > 0.0) {\n" * 1000 + "}" * 1001 + "\n",
        None,
        "nests deeper than 200",
    ),
    "a chain of branches too long": (
        HEAD + "uniform float x;\nvoid main() {" + "if (x > 0.0) {} else " * 400 + "{} }\n",
        4,
        "nests deeper than 200",
    ),
    "a block's member named as a built-in": (
        HEAD + "uniform S {\n float gl_InstanceID; };\n" + MAIN,
        4,
        "'gl_InstanceID' : identifiers starting with",
    ),
    "a block's name taken by an array": (
        HEAD + "uniform S { float m; };\nconst float S[2] = float[2](1.0, 1.0);\n" + MAIN,
        4,
        "'S' : redefinition",
    ),
}


@pytest.mark.parametrize("kind", TEXTS)
def test_a_wrong_text_is_rejected_at_its_line(kind: str) -> None:
    text, line, words = TEXTS[kind]
    compiled = fragment(text)
    assert not compiled.ok
    assert compiled.interface is None
    assert compiled.spirv == {}
    assert [verdict.ok for verdict in compiled.verdicts] == [False, False, False]
    errors = [d for d in compiled.verdicts[0].diagnostics if d.severity == "error"]
    assert words in errors[0].message, errors[0].message
    assert errors[0].file == "wrong.frag"
    if line is not None:
        assert errors[0].line == line
    with pytest.raises(ShaderError) as raised:
        compiled.require()
    assert words in str(raised.value)
    assert (raised.value.file, raised.value.line) == ("wrong.frag", errors[0].line)


def linked(vertex: str, text: str) -> Compiled:
    shaders = Shaders([])
    return compile_program(
        [
            shaders.from_text(text, "fragment", "wrong.frag"),
            shaders.from_text(vertex, "vertex", "v.vert"),
        ]
    )


# What is wrong: vertex and fragment text, the fragment's line, the name, words of the message.
LINKS = {
    "a varying of two types": (
        VERTEX,
        HEAD + "in vec4 n;\nvoid main() { c = n; }\n",
        3,
        "n",
        "Types must match",
    ),
    "a uniform of two types": (
        VERTEX.replace("out vec3 n", "uniform vec3 u;\nout vec3 n").replace("n = a", "n = u"),
        HEAD + "in vec3 n;\nuniform vec4 u;\nvoid main() { c = u + n.xyzz; }\n",
        4,
        "u",
        "Types must match",
    ),
    "array varyings of two sizes": (
        VERTEX.replace("vec3 n", "vec3 n[2]").replace(" n =", " n[0] ="),
        HEAD + "\nin vec3 n[3];\nvoid main() { c = n[0].xyzz; }\n",
        4,
        "n",
        "Array sizes must be compatible",
    ),
    "block members of two types": (
        VERTEX.replace("out vec3 n", "out B { vec3 n; } o").replace("n = a", "o.n = a"),
        HEAD + "in B { vec2 n; } i;\nvoid main() { c = i.n.xyxy; }\n",
        3,
        "n",
        "Member names and types must match",
    ),
}


@pytest.mark.parametrize("kind", LINKS)
def test_stages_that_do_not_fit_are_rejected_at_the_declaration(kind: str) -> None:
    vertex, text, line, name, words = LINKS[kind]
    compiled = linked(vertex, text)
    assert [verdict.ok for verdict in compiled.verdicts] == [False, False, False]
    error = compiled.verdicts[0].diagnostics[0]
    assert words in error.message
    assert (error.file, error.line, error.token) == ("wrong.frag", line, name)


def test_an_input_that_nobody_writes_is_rejected_by_what_links() -> None:
    text = HEAD + "in vec3 n;\n// in vec3 m;\nin vec3 m;\nvoid main() { c = vec4(n + m, 1.0); }\n"
    compiled = linked(VERTEX, text)
    assert [verdict.ok for verdict in compiled.verdicts] == [True, False, False]
    error = compiled.verdicts[1].diagnostics[0]
    assert (error.file, error.line, error.token) == ("wrong.frag", 5, "m")
    assert "the vertex stage never writes" in error.message
    assert linked(VERTEX, text.replace("n + m", "n")).ok, "an unused input is allowed"


def test_a_version_too_old_for_spirv_is_rejected_there_only(
    capfd: pytest.CaptureFixture[str],
) -> None:
    compiled = fragment("#version 120\nvoid main() { gl_FragColor = vec4(1.0); }\n")
    assert [verdict.ok for verdict in compiled.verdicts] == [True, False, False]
    assert compiled.interface is None
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


# What is wrong: files below the root, then the error's file, line, words and remedy.
FILES: dict[str, tuple[dict[str, bytes], str, int | None, str, str]] = {
    "no such shader": ({"attenuation.frag": b"x"}, "a.frag", None, "no shader 'a.frag'", ""),
    "a directory": ({"a.frag/b.frag": b"x"}, "a.frag", None, "is a directory", "name a file"),
    "an empty file": ({"a.frag": b""}, "a.frag", None, "is empty", ""),
    "only white space": ({"a.frag": b" \r\n\t\n"}, "a.frag", None, "is empty", ""),
    "not UTF-8": ({"a.frag": b"ok\n// \xe9t\xe9\n"}, "a.frag", 2, "byte 6 is 0xe9", "UTF-8"),
    "UTF-16": ({"a.frag": b"\xff\xfea\0"}, "a.frag", None, "looks like UTF-16", "UTF-8"),
    "a NUL": ({"a.frag": b"a\nb\0c\n"}, "a.frag", 2, "NUL character", "delete"),
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
        "a.frag:1",
        "",
    ),
    "an include of itself": (
        {"a.frag": b'#include "a.frag"\n'},
        "a.frag",
        1,
        "includes itself",
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
        "x.glsl:2",
        "break the cycle",
    ),
    "an include out of the root": (
        {"a.frag": b'#include "../secret.glsl"\n'},
        "a.frag",
        1,
        "leads out of the shader folders",
        "",
    ),
    "an absolute include": (
        {"a.frag": b'#include "/etc/passwd"\n'},
        "a.frag",
        1,
        "absolute path",
        "",
    ),
    "a backslash": ({"a.frag": b'#include "lib\\x.glsl"\n'}, "a.frag", 1, "backslash", ""),
    "an include of nothing": ({"a.frag": b'#include ""\n'}, "a.frag", 1, "is empty", ""),
    "an include without quotes": (
        {"a.frag": b"#include lib/x.glsl\n"},
        "a.frag",
        1,
        "malformed #include",
        'write #include "file.glsl"',
    ),
    "an include of a folder": (
        {"a.frag": b'#include "lib"\n', "lib/x.glsl": b"x"},
        "lib",
        None,
        "is a directory",
        "",
    ),
    "an included file that is empty": (
        {"a.frag": b'\n#include "x.glsl"\n', "x.glsl": b""},
        "x.glsl",
        None,
        "a.frag:2",
        "",
    ),
    "a stage nobody knows": (
        {"a.txt": b"x"},
        "a.txt",
        None,
        "can't tell the shader's stage",
        ".frag",
    ),
    "a pragma for no stage": (
        {"a.frag.txt": b"\n#pragma shader_stage(fragmet)\n"},
        "a.frag.txt",
        2,
        "names no stage",
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
    assert words in error.message
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
    with pytest.raises(ShaderError, match="more than 1000 times"):
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
