"""Names to files, files to text, and every line back to its author."""

import os
from pathlib import Path

import pytest

from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.sources import LineMap
from shaderlab.errors import ShaderError

FRAGMENT = "#version 330 core\nout vec4 color;\nvoid main() { color = vec4(1.0); }\n"


def write(root: Path, **files: str | bytes) -> Path:
    """Writes files into a root; `__` in a keyword stands for a folder, `_` before the suffix."""
    for key, content in files.items():
        stem, _, suffix = key.replace("__", "/").rpartition("_")
        path = root / f"{stem}.{suffix}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return root


@pytest.mark.parametrize(
    ("name", "stage"),
    [
        ("a.vert", "vertex"),
        ("a.vs", "vertex"),
        ("a.frag", "fragment"),
        ("a.fs", "fragment"),
        ("a.geom", "geometry"),
        ("a.gs", "geometry"),
        ("a.tesc", "tess_control"),
        ("a.tese", "tess_evaluation"),
        ("a.comp", "compute"),
        ("a.cs", "compute"),
        ("a.frag.glsl", "fragment"),
    ],
)
def test_the_extension_names_the_stage(tmp_path: Path, name: str, stage: str) -> None:
    (tmp_path / name).write_text(FRAGMENT)
    assert Shaders([tmp_path]).load(name).stage == stage


def test_a_fifo_is_no_shader_and_nobody_waits_for_it(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.frag")
    with pytest.raises(ShaderError, match="can't read the shader: this is no regular file"):
        Shaders([tmp_path]).load("a.frag")


def test_a_pragma_names_the_stage_unless_it_is_a_comment(tmp_path: Path) -> None:
    write(
        tmp_path,
        a_glsl="// #pragma shader_stage(vertex)\n#pragma shader_stage(tesscontrol)\n",
        b_glsl="/* #pragma shader_stage(vertex) */\n",
    )
    shaders = Shaders([tmp_path])
    assert shaders.load("a.glsl").stage == "tess_control"
    assert shaders.load("b.glsl", "compute").stage == "compute"
    with pytest.raises(ShaderError, match="can't tell the shader's stage"):
        shaders.load("b.glsl")


def test_an_include_is_expanded_and_every_line_keeps_its_origin(tmp_path: Path) -> None:
    write(
        tmp_path,
        ch__main_frag='#version 330 core\n#include "lib/a.glsl"\nout vec4 c;\n',
        lib__a_glsl='float a;\n#include "b.glsl"\nfloat aa;\n',
        lib__b_glsl="float b;\n",
    )
    source = Shaders([tmp_path]).load("ch/main.frag")
    assert source.text == "#version 330 core\nfloat a;\nfloat b;\nfloat aa;\nout vec4 c;\n"
    main, a, b = (str(tmp_path / name) for name in ("ch/main.frag", "lib/a.glsl", "lib/b.glsl"))
    assert tuple(source.lines) == ((main, 1), (a, 1), (b, 1), (a, 3), (main, 3), (main, 4))
    assert len(source.lines) == len(source.text.split("\n"))
    assert [path for path, _ in source.parts] == [main, a, b]
    assert dict(source.parts)[b] == "float b;\n"
    assert source.place(3) == (b, 1)


def test_an_error_in_an_included_file_names_that_file(tmp_path: Path) -> None:
    write(
        tmp_path,
        main_frag='#version 330 core\n#include "lib/a.glsl"\n'
        "out vec4 c;\nvoid main() { c = v(); }\n",
        lib__a_glsl="\n\nvec4 v() { return wrong; }\n",
    )
    compiled = compile_program([Shaders([tmp_path]).load("main.frag")])
    first = compiled.verdicts[0].diagnostics[0]
    assert (first.file, first.line) == (str(tmp_path / "lib/a.glsl"), 3)
    assert first.token == "wrong"


def test_the_including_files_folder_comes_before_the_roots(tmp_path: Path) -> None:
    write(tmp_path, ch__m_frag='#include "x.glsl"\n', ch__x_glsl="near\n", x_glsl="far\n")
    write(tmp_path, ch__n_frag="#include <x.glsl>\n", ch__o_frag='#include "../x.glsl"\n')
    shaders = Shaders([tmp_path])
    assert shaders.load("ch/m.frag").text == "near\n"
    assert shaders.load("ch/n.frag").text == "far\n"
    assert shaders.load("ch/o.frag").text == "far\n"


@pytest.mark.parametrize(
    ("version", "continued"), [("330", False), ("420", True), ("300 es", True)]
)
def test_a_backslash_continues_a_comment_where_lines_can_be(
    tmp_path: Path, version: str, continued: bool
) -> None:
    (tmp_path / "a.frag").write_text(f"#version {version}\n// a \\\nfloat x;\n")
    assert ("float x" not in Shaders([tmp_path]).load("a.frag").code) is continued


def test_a_backslash_in_a_comment_continues_no_line(tmp_path: Path) -> None:
    comments = "// a \\\n/* b \\\n c \\\n */\n"
    write(
        tmp_path, a_frag=f"#version 330\n{comments}out vec4 c; void main() {{ c = vec4(1.0); }}\n"
    )
    source = Shaders([tmp_path]).load("a.frag")
    assert compile_program([source], targets=("glsl",)).ok
    assert source.place(6) == (str(tmp_path / "a.frag"), 6)


def test_an_include_may_leave_out_glsl(tmp_path: Path) -> None:
    (tmp_path / "common.glsl").write_text("const float k = 2.0;\n")
    (tmp_path / "a.frag").write_text("#version 330\n#include <common>\n")
    assert "const float k" in Shaders([tmp_path]).load("a.frag").text


def test_chunks_in_scripts_keep_their_lines(tmp_path: Path) -> None:
    (tmp_path / "common.glsl.js").write_text("export default /* glsl */`\nfloat k;\n`;\n")
    (tmp_path / "a.frag").write_text("#version 330\n#include <common>\n")
    source = Shaders([tmp_path]).load("a.frag")
    (line,) = [n for n, row in enumerate(source.text.split("\n"), 1) if row == "float k;"]
    assert source.place(line) == (str(tmp_path / "common.glsl.js"), 2)
    assert "export" not in source.text and "`" not in source.text


def test_modules_of_glslify_keep_their_names_to_themselves(tmp_path: Path) -> None:
    modules = tmp_path / "node_modules"
    for name, text in {
        "noise/2d.glsl": "const float K = 0.5;\nfloat hash(float x) { return fract(x * K); }\n"
        "float noise(vec2 p) { return hash(p.x) + hash(p.y); }\n"
        "#pragma glslify: export(noise)\n",
        "fade/index.glsl": "#pragma glslify: hash = require('./hash')\n"
        "float K(float x) { return hash(x) * scale; }\n#pragma glslify: export(K)\n",
        "fade/hash.glsl": "float other(float x) { return x; }\n#pragma glslify: export(other)\n",
    }.items():
        (modules / name).parent.mkdir(parents=True, exist_ok=True)
        (modules / name).write_text(text)
    write(
        tmp_path,
        a_frag="precision mediump float;\nvarying vec2 uv;\nuniform float size;\n"
        "#pragma glslify: hash = require('noise/2d')\n"
        "#pragma glslify: fade = require(fade, scale=size)\n"
        "void main() { gl_FragColor = vec4(hash(uv), fade(uv.x), 0.0, wrong); }\n",
    )
    source = Shaders([tmp_path]).load("a.frag")
    first = compile_program([source]).verdicts[0].diagnostics[0]
    assert (first.file, first.line, first.token) == (str(tmp_path / "a.frag"), 6, "wrong")
    right = Shaders([tmp_path], overrides={"a.frag": source.parts[0][1].replace("wrong", "1.0")})
    assert compile_program([right.load("a.frag")]).ok
    assert dict(source.parts)[str(modules / "noise/2d.glsl")].startswith("const float K"), (
        "as written"
    )


def test_a_module_of_glslify_that_is_missing_is_named(tmp_path: Path) -> None:
    write(tmp_path, a_frag="precision mediump float;\n#pragma glslify: luma = require(glsl-luma)\n")
    with pytest.raises(
        ShaderError, match=r"no file to #include: 'node_modules/glsl-luma'"
    ) as caught:
        Shaders([tmp_path]).load("a.frag")
    assert caught.value.line == 2


def test_roots_are_searched_in_order(tmp_path: Path) -> None:
    one, two = write(tmp_path / "1", a_frag="one\n"), write(tmp_path / "2", a_frag="two\n")
    write(two, b_frag='#include "a.frag"\n')
    assert Shaders([one, two]).load("a.frag").text == "one\n"
    assert Shaders([one, two]).load("b.frag").text == "one\n"
    assert Shaders([two, one]).load("a.frag").text == "two\n"
    assert Shaders([one, two]).names() == ("a.frag", "b.frag")


@pytest.mark.parametrize(
    "text",
    [
        '// #include "nowhere.glsl"\n',
        '/* text\n#include "nowhere.glsl"\n*/\n',
        '#version 450\n// continued \\\n#include "nowhere.glsl"\n',
        '/* "unbalanced */ /*\n#include "nowhere.glsl"\n*/\n',
    ],
)
def test_an_include_in_a_comment_is_left_alone(tmp_path: Path, text: str) -> None:
    write(tmp_path, a_frag=text)
    assert Shaders([tmp_path]).load("a.frag").text == text


def test_a_path_with_slashes_is_no_comment(tmp_path: Path) -> None:
    write(tmp_path, a_frag='#include "lib//a.glsl" // really\n', lib__a_glsl="yes\n")
    assert Shaders([tmp_path]).load("a.frag").text == "yes\n"


def test_a_file_is_included_twice_without_pragma_once(tmp_path: Path) -> None:
    body = "float f() { return 1.0; }\n"
    main = '#version 330 core\n#include "x.glsl"\n#include "lib/../x.glsl"\n' + FRAGMENT[18:]
    write(tmp_path, main_frag=main, x_glsl=body, lib__y_glsl="\n")
    twice = compile_program([Shaders([tmp_path]).load("main.frag")])
    assert "already has a body" in twice.verdicts[0].diagnostics[0].message
    assert twice.verdicts[0].diagnostics[0].file == str(tmp_path / "x.glsl")
    write(tmp_path, x_glsl="#pragma once\n" + body)
    assert compile_program([Shaders([tmp_path]).load("main.frag")]).ok


def test_pragma_once_works_if_the_first_include_is_inactive(tmp_path: Path) -> None:
    write(
        tmp_path,
        main_frag='#version 330 core\n#if 0\n#include "x.glsl"\n#endif\n#include "x.glsl"\n'
        "out vec4 c;\nvoid main() { c = vec4(f()); }\n",
        x_glsl="#pragma once\nfloat f() { return 1.0; }\n",
    )
    assert compile_program([Shaders([tmp_path]).load("main.frag")]).ok


def test_files_with_pragma_once_can_include_each_other(tmp_path: Path) -> None:
    write(
        tmp_path,
        main_frag='#version 330 core\n#include "x.glsl"\n' + FRAGMENT[18:],
        x_glsl='#pragma once\n#include "y.glsl"\nfloat x() { return 1.0; }\n',
        y_glsl='#pragma once\n#include "x.glsl"\nfloat y() { return 1.0; }\n',
    )
    assert compile_program([Shaders([tmp_path]).load("main.frag")]).ok


def test_include_extensions_are_removed_for_drivers_without_them(tmp_path: Path) -> None:
    write(
        tmp_path,
        a_frag="#version 330 core\n#extension GL_GOOGLE_include_directive : require\n"
        '#extension GL_ARB_shading_language_include : enable\n#include "x.glsl"\n' + FRAGMENT[18:],
        x_glsl="float x;\n",
    )
    source = Shaders([tmp_path]).load("a.frag")
    assert "extension" not in source.text
    assert source.lines[4] == (str(tmp_path / "a.frag"), 5)
    compile_program([source]).require()


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_and_a_byte_order_mark_change_no_line_number(tmp_path: Path, end: str) -> None:
    text = f"#version 330 core{end}{end}out vec4 c;{end}void main() {{ c = vec4(wrong); }}{end}"
    write(tmp_path, a_frag=b"\xef\xbb\xbf" + text.encode())
    compiled = compile_program([Shaders([tmp_path]).load("a.frag")])
    assert [d.line for d in compiled.verdicts[0].diagnostics] == [4]
    assert compiled.verdicts[0].diagnostics[0].token == "wrong"


def test_messages_respect_the_authors_line_directive(tmp_path: Path) -> None:
    write(
        tmp_path,
        a_frag='#version 330 core\n#line 100\nfloat a = x;\n#line 7 "gen.py"\nfloat b = y;\n',
        b_frag="#version 120\n#line 100\nfloat a = x;\n",
    )
    source = Shaders([tmp_path]).load("a.frag")
    assert source.lines[2] == (str(tmp_path / "a.frag"), 100)
    assert source.lines[4] == ("gen.py", 7)
    # Up to GLSL 1.50 the directive numbered its own line.
    assert Shaders([tmp_path]).load("b.frag").lines[2] == (str(tmp_path / "b.frag"), 101)


def test_overrides_replace_shaders_and_included_files(tmp_path: Path) -> None:
    write(tmp_path, a_frag='#include "x.glsl"\n', x_glsl="old\n", other_glsl="other\n")
    with_text = Shaders([tmp_path], overrides={"x.glsl": "new\r\nlines\n"})
    assert with_text.load("a.frag").text == "new\nlines\n"
    assert with_text.load("a.frag").lines[0] == ("x.glsl", 1)
    with_file = Shaders([tmp_path], overrides={"a.frag": tmp_path / "other.glsl"})
    assert with_file.load("a.frag").text == "other\n"
    assert with_file.load("a.frag").path == str(tmp_path / "other.glsl")
    assert Shaders([], overrides={"no/file.vert": "text"}).load("no/file.vert").stage == "vertex"


def test_defines_follow_the_version_and_shift_no_line(tmp_path: Path) -> None:
    text = "// first\n#version 330 core\nout vec4 c;\nvoid main() { c = vec4(N) + x; }\n"
    write(tmp_path, a_frag=text)
    source = Shaders([tmp_path], defines={"N": "4.0", "ON": ""}).load("a.frag")
    assert source.text.split("\n")[1:4] == ["#version 330 core", "#define N 4.0", "#define ON"]
    errors = compile_program([source]).verdicts[0].diagnostics
    assert [(d.line, d.token) for d in errors] == [(4, "x")]


def test_text_that_is_not_a_file_can_include(tmp_path: Path) -> None:
    write(tmp_path, lib__x_glsl="float x;\n")
    source = Shaders([tmp_path]).from_text('#include "lib/x.glsl"\n', "vertex", "<generated>")
    assert source.text == "float x;\n"
    assert (source.path, source.stage) == ("<generated>", "vertex")


def test_a_line_map_joins_runs_and_refuses_other_lines():
    lines = LineMap.of([("a", 1, 2), ("a", 3, 1), ("b", 9, 2)])
    assert lines.spans == (("a", 1, 3), ("b", 9, 2))
    assert list(lines) == [("a", 1), ("a", 2), ("a", 3), ("b", 9), ("b", 10)]
    for index in (5, -1):
        with pytest.raises(IndexError, match=f"no line {index}"):
            lines[index]


@pytest.mark.parametrize(
    ("main", "text", "lines"),
    [
        ("#version 330\nout vec4 c;", "#version 330\n#define N 4\nout vec4 c;", [1, 1, 2]),
        ("// first\nout vec4 c;", "#define N 4\n// first\nout vec4 c;", [1, 1, 2]),
        ("#version 330", "#version 330\n#define N 4", [1, 1]),
        ('#include "v.glsl"\nint i;', "#version 410\n#define N 4\nint i;", [1, 1, 2]),
        ('#version 330\n#include "i.glsl"', "#version 330\n#define N 4\nint j;", [1, 1, 1]),
    ],
)
def test_defines_follow_the_version_line(tmp_path, main, text, lines):
    write(tmp_path, main_frag=main, v_glsl="#version 410\n", i_glsl="int j;\n")
    source = Shaders([tmp_path], defines={"N": "4"}).load("main.frag")
    assert source.text == source.code.replace(" " * 8, "// first") == text
    assert [line for _, line in source.lines] == lines
