"""Each kind of mistake on a small shader: exactly these, at exactly these lines."""

from __future__ import annotations

import pytest

from shaderlab.mutation.mutants import ShaderMutant, mutants_of
from shaderlab.mutation.syntax import Syntax, reachable

LAW = """\
struct Light { vec3 position; float linear; float quadratic; };
uniform Light light;
uniform mat4 model;
in vec3 aPos;
in float d;
out vec4 color;
void main()
{
    BODY
}
"""


def made(body: str, kind: str | None = None) -> list[tuple[str, str, str]]:
    found = mutants(LAW.replace("BODY", body))
    return [(m.operator, m.before, m.after) for m in found if kind is None or m.operator == kind]


def mutants(text: str) -> list[ShaderMutant]:
    return mutants_of(Syntax(text), shader="law.frag", path="/lab/law.frag")


@pytest.mark.parametrize(
    ("body", "kind", "pairs"),
    [
        ("d + 1.5;", "operator", [("d + 1.5", "d - 1.5")]),
        ("d * 1.5;", "operator", [("d * 1.5", "d / 1.5")]),
        ("d % 2;", "operator", [("d % 2", "d * 2")]),
        ("x += d;", "operator", [("x += d", "x -= d")]),
        ("++i;", "operator", [("++i", "--i")]),
        ("a && b;", "operator", [("a && b", "a || b")]),
        ("d < 2.;", "comparison", [("d < 2.", "d <= 2."), ("d < 2.", "d > 2.")]),
        ("d == e;", "comparison", [("d == e", "d != e")]),
        ("-d;", "minus dropped", [("-d", "d")]),
        ("!a;", "negation dropped", [("!a", "a")]),
        ("d - (e + f);", "operands swapped", [("d - (e + f)", "(e + f) - d")]),
        ("e + f - d;", "operands swapped", [("e + f - d", "d - (e + f)")]),
        ("f(model * v);", "operands swapped", [("model * v", "v * model")]),
        ("d * e;", "operands swapped", []),
        ("max(d, 0.0);", "max dropped", [("max(d, 0.0)", "d"), ("max(d, 0.0)", "0.0")]),
        ("clamp(d + e, 0., 1.);", "clamp dropped", [("clamp(d + e, 0., 1.)", "(d + e)")]),
        ("normalize(-v);", "normalize dropped", [("normalize(-v)", "(-v)")]),
        ("abs(f(d));", "abs dropped", [("abs(f(d))", "f(d)")]),
        ("pow(d, 2.0);", "arguments swapped", [("pow(d, 2.0)", "pow(2.0, d)")]),
        ("dot(d, e);", "arguments swapped", []),
        ("sin(d);", "function", [("sin(d)", "cos(d)")]),
        ("aPos.xz;", "swizzle", [("aPos.xz", "aPos.yz"), ("aPos.xz", "aPos.xy"),
                                 ("aPos.xz", "aPos.zx")]),
        ("light.linear * d;", "member", [("light.linear * d", "light.quadratic * d")]),
        ("light.position;", "member", []),
        ("a ? d : e;", "branches swapped", [("a ? d : e", "a ? e : d")]),
        ("if (a) return;", "condition", [("(a)", "(true)"), ("(a)", "(false)")]),
        ("d = 1.5;", "statement removed", [("d = 1.5;", ";")]),
        ("if (a) x = 1; else x = 2;", "else removed",
         [("if (a) x = 1; else x = 2;", "if (a) x = 1;")]),
    ],
)  # fmt: skip
def test_a_kind_of_mistake(body: str, kind: str, pairs: list[tuple[str, str]]) -> None:
    assert [(before, after) for _, before, after in made(body, kind)] == pairs


def test_constants_are_off_by_one_per_cent() -> None:
    assert made("f(0.5);")[1:] == [
        ("constant + 1 %", "f(0.5)", "f(0.505)"),
        ("constant − 1 %", "f(0.5)", "f(0.495)"),
    ]
    assert [after for _, _, after in made("f(0.0);")][1:] == ["f(1.0)", "f(0.01)"]
    assert [after for _, _, after in made("f(1.0);")][1:] == ["f(1.01)", "f(0.99)", "f(0.0)"]
    assert [after for _, _, after in made("f(3);")][1:] == ["f(4)", "f(2)"]
    assert [after for _, _, after in made("f(100.f);")][1:] == ["f(101.0f)", "f(99.0f)"]


def test_variables_are_swapped_for_ones_of_the_same_type_in_scope() -> None:
    body = "float e = d; vec3 p = aPos; f(e); { float g = e; } f(p);"
    swapped = [(b, a) for _, b, a in made(body, "variable")]
    assert swapped == [("f(e)", "f(d)"), ("g = e", "g = d"), ("f(p)", "f(aPos)")]


def test_what_is_written_to_is_no_variable_to_read() -> None:
    text = "in vec4 a; out vec4 color; void main() { vec4 b = a; color = b; }"
    changed = [(m.before, m.after) for m in mutants(text) if m.operator == "variable"]
    assert changed == [("color = b", "color = a")]


def test_a_mutant_knows_the_author_s_line_and_the_whole_text() -> None:
    text = LAW.replace("BODY", "float x = d\n        + 1.5;\n    // d + 1.5")
    found = {m.operator: m for m in mutants(text)}
    assert (found["operator"].line, found["constant + 1 %"].line) == (10, 10)
    assert str(found["operator"]).startswith("/lab/law.frag:10  operator: ")
    assert found["operator"].text == text.replace("+ 1.5;", "- 1.5;")


def test_declarations_directives_and_comments_are_left_alone() -> None:
    text = (
        "#version 330 core\n#define TWO 2.0\nlayout (location = 3) in vec3 a;\n"
        "uniform float w[4];\nstruct S { float x[2]; };\n// 1.0 + 2.0\nvoid main() {}\n"
    )
    assert mutants(text) == []


def test_two_ways_to_one_text_count_once() -> None:
    texts = [m.text for m in mutants(LAW.replace("BODY", "d = max(d, 1.0) - d;"))]
    assert len(texts) == len(set(texts))


def test_functions_that_nothing_calls_are_left_alone() -> None:
    law = Syntax("float used(float x) { return -x; }\nfloat unused(float x) { return -x; }\n")
    main = Syntax("void main() { color = used(1.0); }")
    names = reachable([law, main])
    assert names == {"main", "used"}
    found = mutants_of(law, shader="l", path="l", functions=names)
    assert {m.line for m in found} == {1}


def test_a_broken_text_is_no_obstacle() -> None:
    assert mutants("void main() { float x = ; ) 1.0 + }") is not None


def test_long_lines_are_cut_but_not_at_the_change() -> None:
    body = "x = " + " + ".join(f"longName{i}" for i in range(20)) + " - 1.5;"
    after = [a for _, _, a in made(body, "constant + 1 %")]
    assert after[0].endswith("- 1.515") and after[0].startswith("…") and len(after[0]) < 80
