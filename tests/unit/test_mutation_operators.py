"""Each kind of mistake on a small shader: exactly these, at exactly these lines."""

from __future__ import annotations

import runpy
from pathlib import Path
from textwrap import dedent

import pytest

from shaderlab.compiler.sources import LineMap, Source
from shaderlab.mutation.names import Operator
from shaderlab.mutation.operators import OPERATORS, OUTPUT_OPERATORS, change_constant
from shaderlab.mutation.shader_mutants import ShaderMutant, mutate_stage

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


def made(
    body: str, kind: str | None = None, operators: tuple[Operator, ...] = ()
) -> list[tuple[str, str, str]]:
    found = mutants(LAW.replace("BODY", body), operators=operators)
    return [(m.operator, m.before, m.after) for m in found if kind is None or m.operator == kind]


def mutants(
    text: str, *, stage: str = "fragment", operators: tuple[Operator, ...] = ()
) -> list[ShaderMutant]:
    """The mutants of a text by some kinds of mistakes; by all but those in outputs by default."""
    source = Source("law.frag", "/lab/law.frag", stage, text, LineMap(), ())
    chosen = operators or tuple(o for o in OPERATORS if o not in OUTPUT_OPERATORS)
    return mutate_stage(source, ("law.vert", "law.frag"), chosen)


def test_an_edit_makes_a_mutants_text() -> None:
    text = LAW.replace("BODY", "/* ½ */ x = d + 1.5; // ½\n    if (a && d < 2.)\n        x = -d;")
    found = mutants(text)
    assert len(found) > 10
    for mutant in found:
        assert mutant.text_edit is not None
        file, line, column, before, after = mutant.text_edit
        at = sum(map(len, text.splitlines(keepends=True)[: line - 1])) + column
        assert (file, text[at : at + len(before)]) == ("law.frag", before)
        assert text[:at] + after + text[at + len(before) :] == mutant.text


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
    def constants(body: str) -> list[str]:
        return [after for _, _, after in made(body, operators=(change_constant,))]

    assert made("f(0.5);", operators=(change_constant,)) == [
        ("constant + 1 %", "f(0.5)", "f(0.505)"),
        ("constant − 1 %", "f(0.5)", "f(0.495)"),
    ]
    assert constants("f(0.0);") == ["f(1.0)", "f(0.01)"]
    assert constants("f(1.0);") == ["f(1.01)", "f(0.99)", "f(0.0)"]
    assert constants("f(3);") == ["f(4)", "f(2)"]
    assert constants("f(100.f);") == ["f(101.0f)", "f(99.0f)"]


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
    assert str(found["operator"]).endswith("  in law.vert + law.frag")
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


def test_functions_that_main_does_not_reach_are_left_alone() -> None:
    text = """\
float inner(float x) { return -x; }
float used(float x) { return inner(x); }
float unused(float x) { return -x; }
void main() { color = used(1.0); }
"""
    assert {m.line for m in mutants(text)} == {1, 2, 4}


def test_code_between_directives_is_code_and_directives_are_none() -> None:
    text = """\
#ifndef GUARD
#define GUARD
float used(float x) { return -x; }
#endif
#if defined(GUARD) && 1 < 2
void main() { color = used(d); }
#endif
"""
    assert {m.line for m in mutants(text)} == {3, 6}


def test_a_place_in_an_included_file_is_named_by_that_file() -> None:
    text = "float law(float x) { return -x; }\nvoid main() { color = law(d); }\n"
    lines = LineMap.of([("/lab/lib/law.glsl", 7, 1), ("/lab/law.frag", 2, 1)])
    source = Source("law.frag", "/lab/law.frag", "fragment", text, lines, ())
    found = {m.operator: m for m in mutate_stage(source, ("law.vert", "law.frag"))}
    dropped = found["minus dropped"]
    assert (dropped.file, dropped.line) == ("/lab/lib/law.glsl", 7)
    assert str(dropped) == "/lab/lib/law.glsl:7  minus dropped: -x → x  in law.vert + law.frag"


OUTPUTS = """\
layout (location = 0) out float light;
layout (location = 1) out vec4 color;
out ivec2 cell;
out vec3 many[2];
in vec2 at;
void main()
{
    color.rgb = vec3(at, 0.0);
    color.a = 1.0;
    light = at.x;
    cell = ivec2(at);
    if (at.x > 2.0) { light = 0.0; }
}
"""


def output_mistakes(text: str, stage: str = "fragment") -> list[tuple[str, int, str]]:
    found = mutants(text, stage=stage, operators=OUTPUT_OPERATORS)
    return [(m.operator, m.line, m.after) for m in found]


def test_mistakes_in_what_is_written_at_all() -> None:
    assert output_mistakes(OUTPUTS) == [
        (
            "every second pixel discarded", 13,
            "if ((int(gl_FragCoord.x) + int(gl_FragCoord.y)) % 2 == 1) discard; }",
        ),
        ("bright pixels discarded", 13, "if (light > 0.25) discard; }"),
        ("bright pixels discarded", 13, "if (color.x > 0.25) discard; }"),
        ("early return", 7, "{ return;"),
        ("output halved", 13, "light *= 0.5; }"),
        ("output halved", 13, "color *= 0.5; }"),
        ("output halved", 13, "cell /= 2; }"),
        # One assignment alone is a statement removed, which another kind makes.
        ("output never written", 7, "{ float light;"),
        ("output never written", 7, "{ vec4 color;"),
    ]  # fmt: skip


def test_a_vertex_stage_discards_nothing_and_a_geometry_stage_is_left_out() -> None:
    text = "in vec3 aPos; out vec3 place; void main() { place = aPos; gl_PointSize = 2.0; }"
    assert output_mistakes(text, "vertex") == [
        ("early return", 1, "{ return;"),
        ("output halved", 1, "place *= 0.5; }"),
        ("output halved", 1, "gl_PointSize *= 0.5; }"),
    ]
    assert output_mistakes(text, "geometry") == []


def test_a_return_before_a_last_statement_that_can_t_be_removed() -> None:
    text = "out vec4 c; void main() { c = vec4(1.0); { c.x = 0.0; } }"
    returns = [after for kind, _, after in output_mistakes(text) if kind == "early return"]
    assert returns == ["{ return;", "return; { c.x = 0.0; }"]
    assert output_mistakes("void main() {}") == [
        (
            "every second pixel discarded", 1,
            "if ((int(gl_FragCoord.x) + int(gl_FragCoord.y)) % 2 == 1) discard; }",
        )
    ]  # fmt: skip


def test_an_output_that_a_function_writes_too_is_not_shadowed() -> None:
    text = "out vec4 c; void more() { c.x = 0.0; } void main() { c = vec4(1.0); more(); c.y = 0.; }"
    assert "output never written" not in [kind for kind, _, _ in output_mistakes(text)]


def test_a_new_kind_is_a_file_and_a_line(repository: Path, tmp_path: Path) -> None:
    """CONTRIBUTING's recipe, as it stands there."""
    page = (repository / "CONTRIBUTING.md").read_text(encoding="utf-8")
    recipe = page[page.index("## Add a mutation operator") :]
    block = recipe[recipe.index("```python") : recipe.index("## Add a reference")].split("```")[1]
    file = tmp_path / "negation.py"
    file.write_text(dedent(block.removeprefix("python")), encoding="utf-8")
    negate_number = runpy.run_path(str(file))["negate_number"]
    text = LAW.replace("BODY", "f(d + 1.5);")
    usual = mutants(text, operators=OPERATORS)
    (new,) = set(mutants(text, operators=(*OPERATORS, negate_number))) - set(usual)
    assert (new.operator, new.after) == ("constant negated", "(-1.5)")


def test_a_broken_text_is_no_obstacle() -> None:
    assert mutants("void main() { float x = ; ) 1.0 + }") is not None


def test_long_lines_are_cut_but_not_at_the_change() -> None:
    body = "x = " + " + ".join(f"longName{i}" for i in range(20)) + " - 1.5;"
    after = [a for _, _, a in made(body, "constant + 1 %")]
    assert after[0].endswith("- 1.515") and after[0].startswith("…") and len(after[0]) < 80
