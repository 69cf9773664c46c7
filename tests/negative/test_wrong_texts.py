"""Every way in which the text of one shader can be wrong, and all that the lab says of it."""

# Messages stand here as the compiler words them, in one piece.
# ruff: noqa: E501

from itertools import pairwise

import pytest

from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program
from shaderlab.errors import ShaderError

HEAD = "#version 330 core\nout vec4 c;\n"
MAIN = "void main() { c = vec4(1.0); }\n"
OPERATORS = "has a statement of more than 5000 operators, which overflows the compiler's stack"
NESTING = "nests deeper than 200 levels, which overflows the compiler's stack"

# What is wrong: the stage, the text, and each message with its line.
TEXTS: dict[str, tuple[str, str, list[tuple[int | None, str]]]] = {
    "a name nobody declared": (
        "fragment",
        HEAD + "void main() { c = vec4(x); }\n",
        [(3, "'x' : undeclared identifier")],
    ),
    "a missing semicolon": (
        "fragment",
        HEAD + "void main() {\n c = vec4(1.0)\n}\n",
        [(5, "syntax error, unexpected RIGHT_BRACE, expecting COMMA or SEMICOLON")],
    ),
    "a missing brace": (
        "fragment",
        HEAD + "void main() {\n c = vec4(1.0);\n",
        [(5, "syntax error, unexpected end of file")],
    ),
    "a type that does not convert": (
        "fragment",
        HEAD + "void main() { int i = 1.0; }\n",
        [(3, "'=' : cannot convert from ' const float' to ' temp int'")],
    ),
    "too few components": (
        "fragment",
        HEAD + "void main() { c = vec4(vec2(1.0)); }\n",
        [
            (3, "'constructor' : not enough data provided for construction"),
            (
                3,
                "'assign' : cannot convert from ' const float' to ' out 4-component vector of float'",
            ),
        ],
    ),
    "a swizzle out of range": (
        "fragment",
        HEAD + "void main() { c = vec2(1).xyzz; }\n",
        [
            (3, "'xyzz' : vector swizzle selection out of range"),
            (
                3,
                "'assign' : cannot convert from ' const 2-component vector of float' to ' out 4-component vector of float'",
            ),
        ],
    ),
    "an unknown function": (
        "fragment",
        HEAD + "void main() { c = vec4(sinn(1.0)); }\n",
        [(3, "'sinn' : no matching overloaded function found")],
    ),
    "a wrong argument": (
        "fragment",
        HEAD + "void main() { c = cross(c, c); }\n",
        [
            (3, "'cross' : no matching overloaded function found"),
            (
                3,
                "'assign' : cannot convert from ' const float' to ' out 4-component vector of float'",
            ),
        ],
    ),
    "writing a uniform": (
        "fragment",
        HEAD + "uniform vec4 u;\nvoid main() { u = c; }\n",
        [(4, "'assign' : l-value required \"u\" (can't modify a uniform)")],
    ),
    "writing an input": (
        "fragment",
        HEAD + "in vec4 i;\nvoid main() { i = c; }\n",
        [(4, "'assign' : l-value required \"i\" (can't modify shader input)")],
    ),
    "a reserved word": (
        "fragment",
        HEAD + "vec4 output;\n" + MAIN,
        [(3, "'output' : Reserved word.")],
    ),
    "a double definition": (
        "fragment",
        HEAD + "float a;\nfloat a;\n" + MAIN,
        [(4, "'a' : redefinition")],
    ),
    "a uniform of two types": (
        "fragment",
        HEAD + "uniform vec3 a;\nuniform vec4 a;\n" + MAIN,
        [(4, "'a' : redefinition")],
    ),
    "no main": (
        "fragment",
        HEAD + "void mane() { c = vec4(1.0); }\n",
        [
            (
                None,
                "Linking fragment stage: Missing entry point: Each stage requires one entry point",
            )
        ],
    ),
    "a function without body": (
        "fragment",
        HEAD + "float f();\nvoid main() { c = vec4(f()); }\n",
        [(3, "Linking fragment stage: No function definition (body) found: \n    f(")],
    ),
    "recursion": (
        "fragment",
        HEAD + "float f() { return f(); }\nvoid main() { c = vec4(f()); }\n",
        [(3, "Linking fragment stage: Recursion detected:\n    f( calling f(")],
    ),
    "a wrong profile": (
        "fragment",
        "#version 330_core\nout vec4 c;\n" + MAIN,
        [
            (1, "'#version' : bad profile name; use es, core, or compatibility"),
            (1, "'#version' : bad tokens following profile -- expected newline"),
        ],
    ),
    "a version that is not": (
        "fragment",
        "#version 999\nout vec4 c;\n" + MAIN,
        [(1, "version not supported")],
    ),
    "words after the version": (
        "fragment",
        "#version 330 core 0\nout vec4 c;\n" + MAIN,
        [(1, "'#version' : bad tokens following profile -- expected newline")],
    ),
    "a version too late": (
        "fragment",
        "\nfloat a;\n#version 330 core\n" + MAIN,
        [
            (3, "'#version' : must occur first in shader"),
            (3, "'#version' : bad profile name; use es, core, or compatibility"),
            (3, "'#version' : bad tokens following profile -- expected newline"),
        ],
    ),
    "#error": (
        "fragment",
        HEAD + "#error not like this\n" + MAIN,
        [(3, "'#error' : not like this")],
    ),
    "an extension that is not": (
        "fragment",
        HEAD + "#extension GL_no : require\n" + MAIN,
        [
            (3, "'#extension' : extension not supported: GL_no"),
            (3, "'#extension' : extra tokens -- expected newline"),
        ],
    ),
    "#if without #endif": (
        "fragment",
        HEAD + "void main() { c = vec4(1.0); }\n#if 1\n",
        [(5, "missing #endif")],
    ),
    "a letter GLSL lacks": (
        "fragment",
        HEAD + "float é;\n" + MAIN,
        [
            (3, "'é' : unexpected character"),
            (3, "type parameter must be a constant integer expression"),
        ],
    ),
    "an int attribute not flat": (
        "fragment",
        HEAD + "in int i;\n" + MAIN,
        [(3, "'int' : must be qualified as flat in")],
    ),
    "double in 330": (
        "fragment",
        HEAD + "dvec3 d;\n" + MAIN,
        [
            (3, "'dvec3' : Reserved word."),
            (3, "'double vector' : not supported for this version or the enabled extensions"),
        ],
    ),
    "two outputs in one place": (
        "fragment",
        HEAD + "layout(location=0) out vec4 d;\nlayout(location=0) out vec4 e;\n" + MAIN,
        [(4, "'location' : overlapping use of location 0")],
    ),
    "a sampler indexed by a variable": (
        "fragment",
        HEAD + "uniform sampler2D t[2]; uniform int i;\nvoid main() { c = texture(t[i], c.xy); }\n",
        [
            (
                4,
                "'variable indexing sampler array' : not supported for this version or the enabled extensions",
            )
        ],
    ),
    "a block's member named as a built-in": (
        "fragment",
        HEAD + "uniform S {\n float gl_InstanceID; };\n" + MAIN,
        [(4, "'gl_InstanceID' : identifiers starting with \"gl_\" are reserved")],
    ),
    "a block's name taken by an array": (
        "fragment",
        HEAD + "uniform S { float m; };\nconst float S[2] = float[2](1.0, 1.0);\n" + MAIN,
        [(4, "'S' : redefinition")],
    ),
    "ES without es": (
        "fragment",
        "#version 300\nvoid main() {}\n",
        [(1, "versions 300, 310, and 320 require specifying the 'es' profile")],
    ),
    "no precision in ES": (
        "fragment",
        "#version 310 es\nin float x;\nout vec4 c;\nvoid main() {}\n",
        [(2, "'float' : type requires declaration of default precision qualifier")],
    ),
    "desktop GLSL in ES": (
        "fragment",
        "#version 310 es\nprecision mediump float;\nout vec4 c;\nvoid main() { c = vec4(1); double d; }\n",
        [(4, "'double' : Reserved word."), (4, "'double' : not supported with this profile: es")],
    ),
    "an image before 420": (
        "fragment",
        HEAD + "layout (rgba8) uniform image2D i;\n" + MAIN,
        [(3, "'image load store' : not supported for this version or the enabled extensions")],
    ),
    "a function of a later version": (
        "fragment",
        HEAD + "void main() { c = vec4(fma(1.0, 2.0, 3.0)); }\n",
        [(3, "'fma' : no matching overloaded function found")],
    ),
    "a fragment's variable in a vertex stage": (
        "vertex",
        "#version 330 core\nvoid main() { gl_Position = gl_FragCoord; }\n",
        [
            (2, "'gl_FragCoord' : undeclared identifier"),
            (
                2,
                "'assign' : cannot convert from ' temp float' to ' gl_Position 4-component vector of float Position'",
            ),
        ],
    ),
    "discard in a vertex stage": (
        "vertex",
        "#version 330 core\nvoid main() { discard; }\n",
        [(2, "'discard' : not supported in this stage: vertex")],
    ),
    "a vertex's output in a fragment stage": (
        "fragment",
        HEAD + "void main() { gl_Position = c; }\n",
        [(3, "'gl_Position' : undeclared identifier")],
    ),
    "a geometry stage without layouts": (
        "geometry",
        "#version 330 core\nvoid main() { EmitVertex(); }\n",
        [
            (
                None,
                "Linking geometry stage: At least one shader must specify an input layout primitive",
            ),
            (
                None,
                "Linking geometry stage: At least one shader must specify an output layout primitive",
            ),
            (
                None,
                "Linking geometry stage: At least one shader must specify a layout(max_vertices = value)",
            ),
        ],
    ),
    "writing a constant": (
        "fragment",
        HEAD + "const float k = 1.0;\nvoid main() { k = 2.0; }\n",
        [(4, "'assign' : l-value required (can't modify a const)")],
    ),
    "writing gl_FragCoord": (
        "fragment",
        HEAD + "void main() { gl_FragCoord = c; }\n",
        [(3, "'assign' : l-value required \"gl_FragCoord\" (can't modify gl_FragCoord)")],
    ),
    "no such field": (
        "fragment",
        HEAD + "struct S { float f; };\nuniform S s;\nvoid main() { c = vec4(s.g); }\n",
        [(5, "'g' : no such field in structure 's'")],
    ),
    "an index out of range": (
        "fragment",
        HEAD + "float a[2];\nvoid main() { c = vec4(a[2]); }\n",
        [(4, "'[' : array index out of range '2'")],
    ),
    "an array size that is not constant": (
        "fragment",
        HEAD + "uniform int n;\nfloat a[n];\n" + MAIN,
        [(4, "array size must be a constant integer expression")],
    ),
    "break outside a loop": (
        "fragment",
        HEAD + "void main() { break; }\n",
        [(3, "break statement only allowed in switch and loops")],
    ),
    "a value returned from void": (
        "fragment",
        HEAD + "void main() { return 1.0; }\n",
        [(3, "'return' : void function cannot return a value")],
    ),
    "nothing returned": (
        "fragment",
        HEAD + "float f() { return; }\n" + MAIN,
        [(3, "'return' : non-void function must return a value")],
    ),
    "a sampler that is no uniform": (
        "fragment",
        HEAD + "void main() { sampler2D s; }\n",
        [
            (
                3,
                "'sampler2D' : sampler/image types can only be used in uniform variables or function parameters: s",
            )
        ],
    ),
    "a uniform in a function": (
        "fragment",
        HEAD + "void main() { uniform float u; }\n",
        [(3, "'uniform' : not allowed in nested scope")],
    ),
    "a case twice": (
        "fragment",
        HEAD + "uniform int i;\nvoid main() { switch (i) { case 1: break; case 1: break; } }\n",
        [(4, "'case' : duplicated value")],
    ),
    "#else twice": (
        "fragment",
        HEAD + "#if 1\n#else\n#else\n#endif\n" + MAIN,
        [(5, "'#else' : #else after #else"), (5, "missing #endif")],
    ),
    "a macro defined anew": (
        "fragment",
        HEAD + "#define A 1\n#define A 2\n" + MAIN,
        [(4, "'#define' : Macro redefined; different substitutions: A")],
    ),
    "too few arguments of a macro": (
        "fragment",
        HEAD + "#define A(x, y) x\nfloat f = A(1);\n" + MAIN,
        [(4, "'macro expansion' : Too few args in Macro A")],
    ),
    "a layout nobody knows": (
        "fragment",
        HEAD + "layout (place = 1) in vec4 i;\n" + MAIN,
        [
            (
                3,
                "'place' : there is no such layout identifier for this stage taking an assigned value",
            )
        ],
    ),
    "a condition that is no bool": (
        "fragment",
        HEAD + "void main() { if (1) c = vec4(1.0); }\n",
        [(3, "boolean expression expected")],
    ),
    "int for bool": (
        "fragment",
        HEAD + "void main() { bool b = 1; }\n",
        [(3, "'=' : cannot convert from ' const int' to ' temp bool'")],
    ),
    "matrices that do not multiply": (
        "fragment",
        HEAD + "void main() { mat2x3 m = mat2x3(1.0); c = vec4(m * vec3(1.0), 1.0, 1.0); }\n",
        [
            (
                3,
                "'*' : wrong operand types: no operation '*' exists that takes a left-hand operand of type ' temp 2X3 matrix of float' and a right operand of type ' const 3-component vector of float' (or there is no acceptable conversion)",
            )
        ],
    ),
    "a function defined twice": (
        "fragment",
        HEAD + "float f() { return 1.0; }\nfloat f() { return 2.0; }\n" + MAIN,
        [(4, "'f' : function already has a body")],
    ),
    "a return type that differs": (
        "fragment",
        HEAD + "float f();\nint f() { return 1; }\n" + MAIN,
        [(4, "'f' : overloaded functions must have the same return type")],
    ),
    "an unterminated comment": (
        "fragment",
        HEAD + "void main() { c = vec4(1.0); }\n/* and so on\n",
        [(4, "'comment' : End of input in comment")],
    ),
    "a bool varying": (
        "fragment",
        HEAD + "flat in bool b;\n" + MAIN,
        [(3, "'in' : cannot be bool")],
    ),
    "a subroutine before 400": (
        "fragment",
        HEAD + "subroutine float law();\n" + MAIN,
        [(3, "syntax error, unexpected IDENTIFIER")],
    ),
    "atomics before 420": (
        "fragment",
        HEAD + "layout (binding = 0) uniform atomic_uint a;\n" + MAIN,
        [(3, "'binding' : not supported for this version or the enabled extensions")],
    ),
    "a compute stage too old": (
        "compute",
        "#version 330 core\nlayout (local_size_x = 1) in;\nvoid main() {}\n",
        [
            (
                1,
                "compute shaders require es profile with version 310 or above, or non-es profile with version 420 or above",
            ),
        ],
    ),
    "a sum that overflows the stack": (
        "fragment",
        HEAD + "uniform float x;\nvoid main() { c = vec4(" + "+".join(["x"] * 100_000) + "); }\n",
        [(4, OPERATORS)],
    ),
    "macros that unfold to such a sum": (
        "fragment",
        HEAD
        + "#define A 1.0\n"
        + "".join(f"#define {b} {a}+{a}\n" for a, b in pairwise("ABCDEFGHIJKLMNO"))
        + "void main() { c = vec4(O); }\n",
        [(18, OPERATORS)],
    ),
    "branches too deep": (
        "fragment",
        HEAD + "uniform float x;\nvoid main() {\n" + "if (x > 0.0) {\n" * 1000 + "}" * 1001 + "\n",
        [(203, NESTING)],
    ),
    "a chain of branches too long": (
        "fragment",
        HEAD + "uniform float x;\nvoid main() {" + "if (x > 0.0) {} else " * 400 + "{} }\n",
        [(4, NESTING)],
    ),
}


@pytest.mark.parametrize("kind", TEXTS)
def test_a_wrong_text_is_rejected_with_its_whole_message_at_its_line(kind: str) -> None:
    stage, text, messages = TEXTS[kind]
    compiled = compile_program([Shaders([]).from_text(text, stage, "wrong")])
    for verdict in compiled.verdicts:
        assert not verdict.ok
        assert verdict.spirv_bytes == 0
        assert [(d.line, d.message) for d in verdict.diagnostics] == messages
        assert {(d.file, d.severity) for d in verdict.diagnostics} == {("wrong", "error")}
    assert compiled.interface is None
    assert compiled.spirv == {}
    with pytest.raises(ShaderError) as raised:
        compiled.require()
    assert messages[0][1] in raised.value.message
    assert (raised.value.file, raised.value.line) == ("wrong", messages[0][0])


def test_there_are_many_kinds() -> None:
    assert len(TEXTS) >= 60
    assert len({text for _, text, _ in TEXTS.values()}) == len(TEXTS)
