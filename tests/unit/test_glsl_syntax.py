"""What a GLSL file declares at its top level is read with types, lengths, qualifiers and lines."""

import pytest

from shaderlab.compiler.syntax import GlslDeclaration, Syntax, TypeSpecifier, check_brackets
from shaderlab.errors import ShaderError

TEXT = """\
#version 330 core
precision highp float;
layout(points) in;
layout(location = 0, index = 1) flat in highp vec3 a, b[2];
struct Light { vec3 p, q[3]; float[2] k; sampler2D s; } light, lights[4];
in VS_OUT { vec3 P; flat int i[2]; } fs_in[];
const mediump float PI = 3.14, E[2] = float[2](1.0, 2.0);
invariant gl_Position;
float[3] f(const in vec3 x[2], inout float, out Light l);
vec3 g(void) { float Q = PI * f(b); return a.xyz; }
coherent volatile restrict buffer B { uint words[]; };
#if A
in vec3 h;
#else
in vec2 h;
#endif
"""


@pytest.fixture(scope="module")
def declarations() -> list[GlslDeclaration]:
    return list(Syntax(TEXT).declarations)


def test_each_declaration_has_a_kind_a_line_and_its_text(
    declarations: list[GlslDeclaration],
) -> None:
    kinds = [(declaration.kind, declaration.line) for declaration in declarations]
    assert kinds == [
        ("layout", 3), ("variables", 4), ("struct", 5), ("block", 6), ("variables", 7),
        ("other", 8), ("prototype", 9), ("function", 10), ("block", 11), ("variables", 13),
        ("variables", 15),
    ]  # fmt: skip
    for declaration in declarations:
        text = TEXT[declaration.start : declaration.end]
        assert text in TEXT.split("\n")


def test_variables_have_types_lengths_qualifiers_and_initialisers(
    declarations: list[GlslDeclaration],
) -> None:
    layout, inputs, *_ = declarations
    assert layout.qualifiers == {"layout", "points", "in"}
    assert inputs.prefix == "layout(location = 0, index = 1) flat in highp"
    assert inputs.qualifiers >= {"flat", "in", "highp", "location"}
    assert [(m.name, m.type) for m in inputs.members] == [
        ("a", TypeSpecifier("vec3")),
        ("b", TypeSpecifier("vec3", ("2",))),
    ]
    constants = declarations[4]
    assert "const" in constants.qualifiers
    assert [m.initialiser for m in constants.members] == ["3.14", "float[2](1.0, 2.0)"]


def test_structs_and_blocks_have_members_and_variables(
    declarations: list[GlslDeclaration],
) -> None:
    struct, block = declarations[2:4]
    assert [m.name for m in struct.members] == ["p", "q", "k", "s"]
    assert struct.members[2].type == TypeSpecifier("float", ("2",))
    assert [(v.name, v.type.lengths) for v in struct.variables] == [
        ("light", ()),
        ("lights", ("4",)),
    ]
    assert block.body == " vec3 P; flat int i[2]; "
    assert block.instance is not None
    assert block.instance.type == TypeSpecifier("VS_OUT", ("",))
    assert declarations[8].qualifiers == {"coherent", "volatile", "restrict", "buffer"}


def test_functions_have_parameters_results_and_names_that_they_use(
    declarations: list[GlslDeclaration],
) -> None:
    prototype, function = declarations[6:8]
    assert prototype.result == TypeSpecifier("float", ("3",))
    assert [(m.name, m.type.name) for m in prototype.members] == [
        ("x", "vec3"), ("", "float"), ("l", "Light"),
    ]  # fmt: skip
    assert function.members == ()
    assert function.uses >= {"PI", "f", "a", "b"}
    assert not function.uses & {"g", "Q", "xyz"}


def test_places_are_counted_in_characters() -> None:
    text = "// ∞ ≠ ö\nin vec3 a;"
    (declaration,) = Syntax(text).declarations
    assert text[declaration.start : declaration.end] == "in vec3 a;"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("\nfloat f() {", "2: '{' is never closed"),
        ("float f(];", "1: ']' closes nothing"),
        ("}", "1: '}' closes nothing"),
    ],
)
def test_brackets_that_do_not_match_are_an_error(text: str, message: str) -> None:
    line, _, words = message.partition(": ")
    with pytest.raises(ShaderError, match=words.replace("{", r"\{").replace("]", r"\]")) as caught:
        check_brackets(text)
    assert caught.value.line == int(line)
