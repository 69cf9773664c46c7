"""Right rewrites are the same, wrong ones are not, and the answer says where and under what."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from shaderlab.analysis.answer import Answer
from shaderlab.analysis.batches import InputBatch, merge_batches
from shaderlab.analysis.comparison import Plan, compare_programs
from shaderlab.analysis.inputs import (
    domains_of,
    inputs_of,
    learn_domains,
    sample_inputs,
    vary_inputs,
)
from shaderlab.analysis.interpreter import Program, load
from shaderlab.analysis.noise import PerturbedFloat, run
from shaderlab.cli.diff import command
from shaderlab.compiler import Shaders
from shaderlab.errors import NotInterpretedError, ShaderlabError, UsageError
from shaderlab.model.frame import Bindings

LAMP = """#version 330 core
struct Light { vec3 position; vec3 color; float cutOff; float outerCutOff; };
in vec3 Normal;
in vec3 FragPos;
uniform vec3 viewPos;
uniform vec3 axis; // range: unit
uniform float shininess; // range: 1..64
uniform Light lights[2];
uniform sampler2D map;
out vec4 FragColor;

float curve(float x)
{
    return x <= 0.04 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

void main()
{
    vec3 normal = normalize(Normal);
    vec3 viewDir = normalize(viewPos - FragPos);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 2; ++i) {
        vec3 lightDir = normalize(lights[i].position - FragPos);
        float diff = max(dot(normal, lightDir), 0.0);
        vec3 reflectDir = reflect(-lightDir, normal);
        float theta = dot(lightDir, axis);
        float span = lights[i].cutOff - lights[i].outerCutOff + 0.01;
        float beam = clamp((theta - lights[i].outerCutOff) / span, 0.0, 1.0);
        float cosine = max(dot(viewDir, reflectDir), 0.0);
        sum += beam * lights[i].color * (diff + pow(cosine, shininess));
    }
    vec4 texel = texture(map, FragPos.xy);
    float alpha = curve(texel.a);
    if (alpha < 0.1) {
        discard;
    }
    FragColor = vec4(sum * texel.rgb, alpha);
}
"""
RIGHT = (
    ("reflect(-lightDir, normal)", "2.0 * dot(normal, lightDir) * normal - lightDir"),
    ("max(dot(normal, lightDir), 0.0)", "clamp(dot(lightDir, normal), 0.0, 2.0)"),
    ("normalize(viewPos - FragPos)", "(viewPos - FragPos) / length(FragPos - viewPos)"),
    ("pow((x + 0.055) / 1.055, 2.4)", "exp2(2.4 * log2((0.055 + x) / 1.055))"),
    ("x <= 0.04 ? x / 12.92", "x <= 0.04 ? x * (1.0 / 12.92)"),
    ("(int i = 0; i < 2; ++i)", "(int i = 1; i >= 0; --i)"),
    ("clamp((theta - lights[i].outerCutOff) / span, 0.0, 1.0)",
     "min(max((theta - lights[i].outerCutOff) / span, 0.0), 1.0)"),
    ("if (alpha < 0.1) {\n        discard;", "if (!(alpha >= 0.1)) {\n        discard;"),
    ("pow(cosine, shininess)", "(cosine > 0.0 ? exp2(shininess * log2(cosine)) : 0.0)"),
    ("beam * lights[i].color * (diff", "lights[i].color * beam * (diff"),
    ("normalize(lights[i].position - FragPos)", "-normalize(FragPos - lights[i].position)"),
    ("sum * texel.rgb,", "vec3(texel.r * sum.r, texel.g * sum.g, texel.b * sum.b),"),
)  # fmt: skip
WRONG = (
    ("reflect(-lightDir, normal)", "reflect(lightDir, normal)"),
    ("max(dot(normal, lightDir), 0.0)", "abs(dot(normal, lightDir))"),
    ("normalize(viewPos - FragPos)", "normalize(viewPos + FragPos)"),
    ("x <= 0.04", "x <= 0.4"),
    ("(x + 0.055) / 1.055", "(x + 0.055) / 1.056"),
    ("int i = 0", "int i = 1"),
    ("0.0, 1.0);\n        float cosine", "-1.0, 1.0);\n        float cosine"),
    ("if (alpha < 0.1)", "if (alpha < 0.101)"),
    ("pow(cosine, shininess)", "pow(cosine, shininess + 0.05)"),
    ("lights[i].color * (diff", "lights[0].color * (diff"),
    ("FragPos.xy)", "FragPos.yx)"),
    ("sum * texel.rgb, alpha", "sum * texel.rgb, 1.0"),
)
SMALL = Plan(rounds=1, count=512, accuracy=False)


@functools.cache
def program(text: str, name: str = "new.frag") -> Program:
    text = text if text.startswith("#version") else f"#version 330 core\n{text}"
    return load(Shaders([]).from_text(text, "fragment", name))


def compared(old: str, new: str, **plan: Any) -> Answer:
    return compare_programs(program(old), program(new), Plan(rounds=1, count=512, **plan))


@pytest.mark.parametrize("some", [RIGHT[0::2], RIGHT[1::2], RIGHT[:1]])
def test_right_rewrites_are_the_same(some: tuple[tuple[str, str], ...]) -> None:
    text = LAMP
    for piece, other in some:
        assert piece in text
        text = text.replace(piece, other)
    answer = compare_programs(program(LAMP), program(text), SMALL)
    assert answer.same is True, list(answer.lines())
    assert answer.outputs[0].judged > 400


@pytest.mark.parametrize(("piece", "other"), WRONG)
def test_wrong_rewrites_are_not_and_their_line_is_found(piece: str, other: str) -> None:
    before = LAMP.partition(piece)[0]
    line = before.count("\n") + 1 + piece.endswith("0.1)")  # the discard is on the next one
    answer = compare_programs(program(LAMP), program(LAMP.replace(piece, other)), SMALL)
    assert answer.same is False
    (found,) = answer.outputs
    assert 0 < found.different <= found.judged and found.apart > 0.0
    assert found.place == f"new.frag:{line}", str(found)
    assert len(found.example["Normal"]) == 3 and len(found.gives[0]) in (0, 4)


LOOP = """in float x;
out float o;
void main() {
    o = x;
    for (int i = 0; i < 200; ++i) {
        if (i == 0)
            o += 1.0;
        if (i == 180)
            o += 2.0;
    }
}
"""


@pytest.mark.parametrize(("piece", "line"), [("1.0", 8), ("2.0", 10)])
def test_the_line_of_a_loop_is_found_early_or_late(piece: str, line: int) -> None:
    new = program(LOOP.replace(piece, "3.0"))
    (found,) = compare_programs(program(LOOP), new, SMALL).outputs
    assert found.place == f"new.frag:{line}"


@pytest.mark.parametrize(
    ("old", "new", "condition"),
    [
        ("n ^ (n >> 16)", "n ^ (n >> 17)", "0 <= n <= 4"),
        ("bitfieldReverse(n) & 15", "0", "0 <= n <= 4"),
        ("(n & 255) | (n & ~255)", "n", ""),
        ("min(n & 65535, 9)", "n > 65535 ? min(n & 65535, 9) : clamp(n & 65535, 0, 9)", ""),
    ],
)
@pytest.mark.parametrize("kind", ["int", "uint"])
def test_numbers_of_which_bits_are_taken_are_large_ones_too(
    kind: str, old: str, new: str, condition: str
) -> None:
    text = f"#version 450 core\nflat in {kind} n; out {kind} o; void main() {{ o = {kind}(%s); }}"
    if kind == "uint":
        old, new = (re.sub(r"\b\d+\b", r"\g<0>u", line) for line in (old, new))
    (output,) = compared(text % old, text % new).outputs
    assert output.same is True and output.conditions == ((condition,) if condition else ())


def test_a_loop_as_long_as_an_input_says_ends() -> None:
    text = "uniform int n; out int o; void main() { for (int i = 0; i < n; ++i) o ^= i << %d; }"
    assert compared(text % 1, text % 1).outputs[0].same is True
    assert compared(text % 1, text % 2).outputs[0].same is False


def test_an_assumption_that_matters_is_said() -> None:
    old = "uniform vec3 direction; uniform float x; out float o; void main() { o = x * %s; }"
    new = old % "dot(direction, direction)"
    answer = compared(old % "1.0", new)
    assert answer.same is True and answer.outputs[0].conditions == ("|direction| = 1",)
    assert answer.conditional and ", only if |direction| = 1" in str(answer.outputs[0])
    shown = answer.outputs[0]  # at inputs that refute it
    assert abs(np.linalg.norm(shown.example["direction"]) - 1.0) > 0.01
    assert abs(shown.gives[0][0] - shown.gives[1][0]) > 0.001
    told = compared(old.replace("direction;", "direction; // range: -1..1\n") % "1.0", new)
    assert told.same is False
    given = compared(old % "1.0", new, ranges={"direction": "-1:1"})
    assert given.same is False and given.inputs["direction"] == "-1..1 (given)"
    assert compared(old % "1.0", new, ranges={"direction": "unit"}).outputs[0].conditions == ()


@pytest.mark.parametrize(
    ("test", "wrong"),
    [("id == 12345", "id == 12346"), ("id == 3 || id == -77", "id == 3"), ("x == 0.375", "false")],
)
def test_numbers_that_the_shader_names_are_tried(test: str, wrong: str) -> None:
    text = "uniform int id; uniform float x; out float o; void main() { o = %s ? 2.0 : x; }"
    assert compared(text % test, text % test).same is True
    assert compared(text % test, text % wrong).same is False


def test_numbers_of_any_sign_bit_are_tried() -> None:
    text = "uniform %s id; out float o; void main() { o = %s ? 2.0 : 1.0; }"
    for type_, test in (("uint", "id == 0xdeadbeefu"), ("int", "uint(id) == 0xdeadbeefu")):
        answer = compared(text % (type_, test), text % (type_, "false"))
        (given,) = answer.outputs[0].example["id"]
        assert answer.same is False and given == 0xDEADBEEF - (2**32 if type_ == "int" else 0)


def test_the_cases_of_a_switch_are_tried() -> None:
    text = "uniform int id; out int o; void main() { switch (id) { case %d: o = 1; } }"
    assert compared(text % 4200, text % 4300).same is False


@pytest.mark.parametrize(
    ("turns", "most"),
    [("steps", 2e7), ("int(400.0 * abs(x))", 5e7)],
)
def test_what_runs_long_is_compared_on_fewer_inputs(
    turns: str, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A number such as 900 is tried as the end of a loop, too: the others do not run that long."""
    text = f"""uniform int steps; in float x; out float o;
    void main() {{
        o = steps == 900 ? %s : 0.0;
        for (int i = 0; i < {turns}; ++i) o = x - o;
    }}"""
    lanes = []

    def counted(*given: Any) -> Any:
        ran = run(*given)
        lanes.append(ran.blocks * ran.discarded.size)
        return ran

    monkeypatch.setattr("shaderlab.analysis.comparison.run", counted)
    plan = Plan(accuracy=False, count=2048)
    assert compare_programs(program(text % "1.0"), program(text % "1.0"), plan).same is True
    assert sum(lanes) < most
    if turns == "steps":
        assert compare_programs(program(text % "1.0"), program(text % "2.0"), plan).same is False


def test_a_long_program_is_compared_on_fewer_inputs() -> None:
    """All values of a program are kept until it ends."""
    lines = "a = a * 0.99 + b.yzx;\n" * 900
    text = f"in vec3 a0, b; out vec3 o; void main() {{ vec3 a = a0;\n{lines} o = a %s; }}"
    plan = Plan(accuracy=False, rounds=1)
    answer = compare_programs(program(text % "+ b"), program(text % "+ 1.0 * b"), plan)
    assert answer.same is True and answer.outputs[0].judged < 4 * 2048


def test_what_lies_between_two_numbers_that_are_nearly_the_same_is_tried() -> None:
    text = "uniform float x; out float o; void main() { o = x < %s ? 1.0 : 0.0; }"
    assert compared(text % "0.0031308", text % "0.00313").same is False


@pytest.mark.parametrize(
    ("old", "wrong", "right"),
    [
        ("v.x < 0.1", "v.x <= 0.1", "step(0.1, v.x) == 0.0"),
        ("v.x - v.y > v.z", "v.x - v.y >= v.z", "!(v.x <= v.z + v.y)"),
        ("length(v.xy) > 1.0", "length(v.xy) >= 1.0", "dot(v.xy, v.xy) > 1.0"),
        ("fract(v.x * 4.0) >= 0.5", "fract(v.x * 4.0) > 0.5", "mod(4.0 * v.x, 1.0) >= 0.5"),
        ("dot(v, normal) > limit", "dot(v, normal) >= limit", "!(dot(normal, v) <= limit)"),
        ("abs(v.x) >= abs(v.y)", "abs(v.x) > abs(v.y)", "v.x * v.x >= v.y * v.y"),
        ("v.x < 0.7", "v.x < 0.70001", "v.x < 0.0 || v.x * v.x < 0.49"),
        ("v.x < 0.3", "0.3 >= v.x", "10.0 * v.x < 3.0"),
        ("int(v.x * 4.0) < 3", "int(ceil(v.x * 4.0)) < 3", "int(trunc(v.x * 4.0)) <= 2"),
    ],
)
def test_what_is_compared_meets_its_bounds(old: str, wrong: str, right: str) -> None:
    text = "in vec3 v; in vec3 normal; uniform float limit; out float o; // range: 0..1\n"
    text += "void main() { o = %s ? 1.0 : limit; }"
    assert_told_apart(text, old, wrong, right)


@pytest.mark.parametrize(
    ("old", "wrong", "right"),
    [
        ("near.r < z", "near.r <= z", "!(near.r >= z)"),
        ("sign(near.r) * z > 0.5", "z > 0.5", "(near.r > 0.0 ? z : 0.0) > 0.5"),
    ],
)
def test_texels_are_equal_to_others_and_to_zero(old: str, wrong: str, right: str) -> None:
    text = "uniform sampler2D map; in vec2 uv; in float z; out float o; // range: 0..1\n"
    text += "void main() { vec4 near = texture(map, uv); o = %s ? 1.0 : 0.5; }"
    assert_told_apart(text, old, wrong, right)


def assert_told_apart(text: str, old: str, wrong: str, right: str) -> None:
    """The wrong one differs; the right one is the same, whatever is assumed."""
    assert compared(text % old, text % wrong, accuracy=False).same is False
    (output,) = compared(text % old, text % right, accuracy=False).outputs
    assert output.same is True and output.conditions == ()


def test_matrices_and_lengths_meet_their_bounds() -> None:
    text = "uniform mat4 view; in vec3 place; uniform vec3 lamp; uniform float end; out float o;"
    text += "void main() { float far = -(view * vec4(place, 1.0)).z, away = length(lamp - place);"
    text += " o = %s ? end : 2.0; }"
    assert_told_apart(text, "far >= end", "far > end", "!(end > far)")
    assert_told_apart(text, "away < end", "away <= end", "end > distance(place, lamp)")


@pytest.mark.parametrize(
    ("guarded", "bare"),
    [
        ("max(length(v), 0.0001)", "length(v)"),
        ("max(distance(v, w), 0.0001)", "distance(v, w)"),
        ("max(texture(map, v.xy).a, 0.0001)", "texture(map, v.xy).a"),
        ("max(textureLod(map, v.xy, 2.0).r, 0.0001)", "textureLod(map, v.xy, 2.0).r"),
        ("(v.x == w.x ? 1.0 : v.x - w.x)", "(v.x - w.x)"),
        ("max(light - around, 0.01)", "(light - around)"),
    ],
)
def test_a_divisor_without_its_guard_is_found(guarded: str, bare: str) -> None:
    text = "uniform sampler2D map; in vec3 v; uniform vec3 w; out float o; void main() {"
    text += " ivec2 here = ivec2(gl_FragCoord.xy); float light = texelFetch(map, here, 0).r;"
    text += " float around = texelFetch(map, max(here - 1, ivec2(0)), 0).r; o = w.y / %s; }"
    for old, new in ((guarded, bare), (bare, guarded)):
        (output,) = compared(text % old, text % new, accuracy=False).outputs
        assert output.same is False and output.example
    for same in (guarded, bare):
        assert_told_apart(text, same, "1.1", f"(2.0 * {same} * 0.5)")


def test_a_vec4_that_has_to_turn_is_a_condition() -> None:
    text = "uniform vec4 q, tint; in vec3 v; out vec3 o; void main() { vec3 u = q.xyz; o = %s; }"
    turned = "v + 2.0 * cross(u, cross(u, v) + q.w * v) + tint.rgb"
    longer = (
        "2.0 * dot(u, v) * u + (q.w * q.w - dot(u, u)) * v + 2.0 * q.w * cross(u, v) + tint.rgb"
    )
    answer = compared(text % turned, text % longer)
    (output,) = answer.outputs
    assert output.same is True and output.conditions == ("|q| = 1",)
    assert abs(np.linalg.norm(output.example["q"]) - 1.0) > 0.01
    assert compared(text % turned, text % longer.replace("- dot", "+ dot")).same is False
    assert compared(text % turned, text % turned.replace("tint.rgb", "tint.gbr")).same is False
    seen = "in vec4 seen; out float o; void main() { o = seen.z / seen.w %s 1.0 ? 1.0 : 0.5; }"
    assert compared(seen % ">", seen % ">=").same is False  # at few inputs: nothing that turns


def test_a_step_of_0_that_a_case_does_not_give_is_left_out() -> None:
    text = "uniform float dt; in float x; out float o; void main() { float t = x;"
    text += " while (t >= dt) t -= dt; o = %s; }"
    given = {"dt": np.full((64, 1), 0.25), "x": np.linspace(0.5, 2.0, 64)[:, None]}
    batch = InputBatch({n: v.astype(np.float32) for n, v in given.items()}, Bindings(), 64)
    for new, same in (("t + 0.0", True), ("1.1 * t", False)):
        programs = program(text % "t"), program(text % new)
        assert compare_programs(*programs, SMALL, [batch]).same is same


def test_a_texture_may_be_larger_than_another() -> None:
    text = "uniform sampler2D map, atlas; out float o; void main() { "
    text += "o = texelFetch(atlas, textureSize(map, 0) * %d, 0).r; }"
    plan = Plan(count=64, accuracy=False)
    assert compare_programs(program(text % 1), program(text % 2), plan).same is False


@pytest.mark.parametrize("kind", ["2D map; in vec2", "Cube map; in vec3"])
def test_levels_of_detail_matter_where_a_texture_has_mipmaps(kind: str) -> None:
    text = f"uniform sampler{kind} uv; out vec4 o; void main() {{ o = %s; }}"
    plain, condition = "texture(map, uv)", "map has no mipmaps and no texel above 1"
    for other in ("texture(map, uv, 1.0)", "textureLod(map, uv, 0.0)", "texture(map, uv, -1.0)"):
        (output,) = compared(text % plain, text % other, accuracy=False).outputs
        assert output.same is True and output.conditions == (condition,)
    for other in ("texture(map, 0.5 * (uv + uv))", "textureGrad(map, uv, dFdx(uv), dFdy(uv))"):
        (output,) = compared(text % plain, text % other, accuracy=False).outputs
        assert output.same is True and output.conditions == ()
    old, new = (text % f"textureLod(map, uv, {lod})" for lod in (2.0, 1.0))
    assert compared(old, new, accuracy=False).outputs[0].conditions == (condition,)


def test_lines_that_no_input_came_to_are_said() -> None:
    text = "uniform float x;\nout float o;\nvoid main() {\no = x;\nif (x > %s)\no = 0.0;\n}"
    assert compared(text % 3.0, text % 3.0).notes == ("never run: new.frag:7",)
    assert compared(text % 0.5, text % 0.5).notes == ()


def test_numbers_that_nearly_agree_are_said() -> None:
    text = "uniform float x; out float o; void main() { o = x < %s ? 12.92 * x : 1.055 * "
    text += "pow(x, 1.0 / 2.4) - 0.055; }"
    (note,) = compared(text % "0.0031308", text % "0.00313", accuracy=False).notes
    assert note == "0.0031308 became 0.00313, which changes less than rounding may"
    assert compared(text % "0.0031308", text % "0.0031308", accuracy=False).notes == ()


def test_a_rotation_in_a_plane_is_no_reflection() -> None:
    text = "uniform mat2 turn; uniform vec2 uv; out vec2 o; void main() { o = %s; }"
    assert compared(text % "turn * uv", text % "uv * turn").same is False
    assert compared(text % "turn * uv", text % "uv * transpose(turn)").same is True


def test_a_range_is_read_behind_a_layout() -> None:
    text = "#version 410 core\nlayout (location = 0) in vec3 n; // range: unit\nout vec3 o;\n"
    text += "void main() { o = n; }"
    assert compared(text, text).inputs["n"] == "of length 1 (declared)"


@pytest.mark.parametrize(
    ("declared", "other", "words"),
    [
        ("layout (std140) uniform B { float a; vec4 b; };",
         "layout (std140) uniform B { vec4 b; float a; };", "Offset 16"),
        ("layout (std140) uniform B { mat4 m; float a; vec4 b; };",
         "layout (std140, row_major) uniform B { mat4 m; float a; vec4 b; };", "RowMajor"),
        ("uniform float a; noperspective in vec4 b;", "uniform float a; in vec4 b;", "NoPersp"),
        ("uniform float a; uniform vec4 b; layout (origin_upper_left) in vec4 gl_FragCoord;",
         "uniform float a; uniform vec4 b;", "pixels: OriginUpperLeft"),
        ("uniform float a; uniform vec4 b; layout (location = 1) out vec4 o;",
         "uniform float a; uniform vec4 b; layout (location = 2) out vec4 o;", "Location 1 became"),
        ("uniform B { float a; vec4 b; };", "uniform B { vec4 b; float a; };", ""),
        ("uniform float a; uniform vec4 b;", "uniform vec4 b; uniform float a;", ""),
    ],
)  # fmt: skip
def test_interfaces_are_compared(declared: str, other: str, words: str) -> None:
    rest = "void main() { o = a * b + gl_FragCoord; }"
    texts = (one if "out vec4 o" in one else f"{one} out vec4 o;" for one in (declared, other))
    answer = compared(*(f"#version 450 core\n{text} {rest}" for text in texts))
    found = "".join(str(one) for one in answer.outputs if one.why == "interface")
    assert answer.same is (not words) and words in found and bool(found) == bool(words)


def test_a_range_hides_what_lies_outside_of_it() -> None:
    old = "uniform float k; out float o; void main() { o = k; }"
    new = old.replace("o = k", "o = min(k, 3.0)")
    assert compared(old, new, ranges={"k": "0..3"}).same is True
    assert compared(old, new, ranges={"k": "0..4"}).same is False


def test_what_only_one_discards_or_defines_or_writes_is_different() -> None:
    old = "in float x; out float o; void main() { o = x; }"
    discarding = compared(old, old.replace("o = x;", "if (x > 0.999) discard; o = x;"))
    assert discarding.outputs[0].why == "coverage"
    assert "where only one discards; first at new.frag:2" in str(discarding.outputs[0])
    undefined = compared(old, old.replace("o = x;", "o = x; if (x > 0.7) o = log(-x);"))
    assert undefined.outputs[0].why == "definedness"
    unwritten = compared(old, old.replace("o = x;", "if (x > 0.5) o = x;"))
    assert unwritten.same is False
    missing = compared(
        old, old.replace("out float o;", "out float o; out float p;").replace("o = x", "p = o = x")
    )
    assert missing.same is False and missing.outputs[1].why == "missing"
    both = old.replace("o = x", "o = log(-1.0 - x)")
    assert compared(both, both).same is None  # nothing is defined, so nothing can be said


def test_inputs_and_outputs_are_matched_by_name() -> None:
    old = "in float x; out float o; void main() { o = x; }"
    other = compared(old, "in float y; out float p; void main() { p = y; }")
    assert other.outputs[0].name == "o → p" and other.same is False
    assert other.notes == ("only OLD reads x", "only NEW reads y")
    with pytest.raises(UsageError, match="x is float in one, vec2 in the other"):
        compared(old, "in vec2 x; out float o; void main() { o = x.x; }")
    with pytest.raises(UsageError, match="does not read 'z'"):
        compared(old, old, ranges={"z": "0..1"})
    with pytest.raises(UsageError, match="'1' is no range"):
        compared(old, old, ranges={"x": "1"})


def test_the_accuracy_is_told_apart_from_the_mathematics() -> None:
    old = """in float x; // range: 0.01..1
out float o;
void main() {
    float s = x * x;
    o = s;
}"""
    lossy = compared(old, old.replace("s = x * x", "s = (1.0 + x * x) - 1.0"))
    numerics = lossy.outputs[0].numerics
    assert lossy.same is True and numerics is not None and not lossy.same_numerics
    assert numerics.worse > 100.0 and numerics.better == 0.0 and numerics.near["x"][0] < 0.1
    text = str(lossy.outputs[0])
    assert text.startswith("o: same mathematics on ") and "ULP less accurate near x = " in text
    (before, cost) = numerics.costs
    assert before is None and cost is not None and (cost.operation, cost.line) == ("-", 5)
    assert cost.ulp > numerics.worse and ": - at new.frag:5 costs " in text
    better = compared(old.replace("s = x * x", "s = (1.0 + x * x) - 1.0"), old)
    assert better.outputs[0].numerics is not None and better.outputs[0].numerics.better > 100.0
    same = compared(old, old.replace("x * x", "(x) * x"))
    assert same.same_numerics and same.outputs[0].numerics is not None


def test_strict_does_not_pass_where_accuracy_is_not_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a.frag"
    file.write_text("#version 330 core\nin float x; out float o; void main() { o = x * 2.0; }")
    words = [str(file), str(file), "--strict", "-j", "0"]
    assert CliRunner().invoke(command, words, standalone_mode=False).return_value == 0
    monkeypatch.setattr("shaderlab.analysis.comparison.bands_of", lambda *_, **__: None)
    found = CliRunner().invoke(command, words, standalone_mode=False)
    assert found.return_value == 2 and "o: accuracy not known" in found.output


def test_captured_inputs_are_varied_and_stay_what_they_are() -> None:
    rng = np.random.default_rng(3)
    normal = rng.normal(size=(64, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]], np.float32)
    move = np.eye(4, dtype=np.float32)
    move[:3, :3], move[:3, 3] = turn, (1.0, 2.0, 3.0)
    y, x = np.indices((8, 8)).reshape(2, 64) + 0.5
    given = InputBatch(
        {
            "normal": normal.astype(np.float32),
            "uv": rng.uniform(size=(64, 2)).astype(np.float32),
            "gl_FragCoord": np.stack([x, y, x, x], axis=1).astype(np.float32),
        },
        Bindings(
            uniforms={
                "model": move,
                "turn": turn,
                "stretch": turn * np.float32(2.0),
                "far": np.float32([1.0]),
                "near": np.float32([0.9]),
                "count": np.int32([3]),
            }
        ),
        64,
    )
    roles = learn_domains([given])
    assert {name: role.kind for name, role in roles.items()} == {
        "normal": "unit", "uv": "number", "model": "affine", "turn": "rotation",
        "stretch": "affine",
        "far": "number", "near": "number",
    }  # fmt: skip
    found = vary_inputs(given, roles, 1).each
    np.testing.assert_allclose(np.linalg.norm(found["normal"], axis=1), 1.0, rtol=1e-6)
    assert not np.allclose(found["normal"], normal)
    assert found["uv"].min() >= 0.0 and found["uv"].max() <= 1.0
    assert (found["model"][:, 3] == (0.0, 0.0, 0.0, 1.0)).all() and np.ptp(found["model"]) > 0.0
    square = found["turn"] @ np.swapaxes(found["turn"], 1, 2)
    np.testing.assert_allclose(square, np.broadcast_to(np.eye(3), square.shape), atol=1e-6)
    assert (found["near"] <= found["far"]).all() and "count" not in found
    quads = found["near"].reshape(4, 2, 4, 2)
    assert (quads == quads[:, :1, :, :1]).all() and len(np.unique(found["near"])) > 8


def test_draws_are_compared_together_where_pixels_do_not_depend_on_each_other() -> None:
    draws = [
        InputBatch(
            {"x": np.full((count, 1), count, np.float32)},
            Bindings(uniforms={"u": np.float32([count]), **more}),
            count,
        )
        for count, more in ((3, {"model": np.eye(4)}), (2, {}))
    ]
    text = "in float x; uniform float u; out float o; void main() { o = x * u; }"
    (one,) = merge_batches(draws, program(text), 64)
    assert one.count == 5 and set(one.each) == {"x", "u"}
    assert one.each["u"].ravel().tolist() == [3.0, 3.0, 3.0, 2.0, 2.0]
    assert len(merge_batches(draws, program(text.replace("x *", "dFdx(x) *")), 64)) == 2


def test_a_loop_that_does_not_end_is_not_interpreted() -> None:
    ending = "a loop that goes on after 4096 iterations at line 3\n.* ranges .* of x: --range"
    with pytest.raises(NotInterpretedError, match=ending):
        compared(
            "in float x; out float o;\nvoid main() { o = x; while (o < 9.0) o -= 1.0; }",
            "in float x; out float o; void main() { o = x; }",
        )


def test_an_endless_loop_beyond_what_is_assumed_is_no_condition() -> None:
    text = "uniform float dt; out float o; void main() { o = 0.5; while (o > 0.0) o -= dt;"
    text += " o *= %s; }"
    answer = compared(text % "2.0", text % "(4.0 * 0.5)")
    assert answer.outputs[0].same is True and "dt" not in str(answer.outputs[0].conditions)


def test_where_a_loop_ends_shaders_are_compared_however_many_do_not() -> None:
    """Without what is assumed of dt the loop does not end for some; of n it is known, still."""
    text = "uniform float dt; in vec3 normal; out float o; void main() {"
    text += " float s = 0.0; for (float t = 0.0; t < 1.0; t += dt) s += t;"
    text += " vec3 n = %s; o = s * n.z; }"
    answer = compared(text % "normalize(normal)", text % "normal")
    assert answer.outputs[0].conditions == ("|normal| = 1",)
    right = compared(text % "normal", text % "1.0 * normal")
    assert right.same is True and not right.conditional
    assert any(n.startswith("not compared: ") and "goes on for too" in n for n in right.notes)


def test_what_is_not_interpreted_beyond_what_is_assumed_is_not_called_the_same() -> None:
    """Only a loop that goes on is left out; above 1.5, more than light's name says, not all read
    one sampler."""
    text = "#version 430 core\n"
    text += "uniform float light; uniform sampler2D maps[2]; in vec3 normal; out float o;"
    text += " void main() { vec3 n = %s;"
    text += " o = n.z * textureLod(maps[int(light > 1.5)], vec2(0.0), 0.0).r; }"
    with pytest.raises(NotInterpretedError, match="a choice between samplers"):
        compared(text % "normalize(normal)", text % "normal")


def test_what_the_old_one_leaves_undefined_beyond_what_is_assumed_is_no_condition() -> None:
    """With levels of -2 it divides by 0, which the new one need not."""
    text = "uniform int levels; in float d; out float o; void main() { float n = float(levels + 2);"
    text += " o = %s; }"
    guarded = text % "n == 0.0 ? 0.0 : d / n"
    found = compared(text % "d / n", guarded)
    assert found.same is True and not found.conditional
    assert compared(guarded, text % "d / n").outputs[0].conditions == ("0 <= levels <= 4",)


def test_a_sum_that_a_small_number_is_lost_in_is_rounded() -> None:
    """1 - exp(-40) is 1 in float64, too."""
    text = "in float d; in float c; out float o; void main() { float k = exp(-60.0 * d); o = %s; }"
    assert compared(text % "mix(c, 0.0, 1.0 - k)", text % "mix(0.0, c, k)").same is True
    assert compared(text % "mix(c, 0.0, 1.0 - k)", text % "1e-6 + mix(0.0, c, k)").same is False


def test_textures_that_are_made_up_have_dark_places_with_contrast() -> None:
    one = program(
        "uniform sampler2D map; in vec2 uv; out vec4 o; void main() { o = texture(map, uv); }"
    )
    inputs = inputs_of(one)
    made = sample_inputs(inputs, domains_of(inputs, [one], {}), 64, 0).bindings.textures["map"]
    dark = made.values[:, -1]
    assert 0.0 < dark.min() < dark.max() / 8.0 and dark.max() < 1.0 / 64.0


def test_the_ends_of_fields_in_words_are_tried() -> None:
    """Of 16 bits with a sign -32768 alone is below -1."""
    text = "flat in uint word; out float o; void main() {"
    text += " float x = float(int(word << 16) >> 16) / 32767.0; o = %s; }"
    (output,) = compared(text % "max(x, -1.0)", text % "x").outputs
    assert output.conditions == ("0 <= word <= 4",) and output.gives[0] == (-1.0,)


def test_noise_errs_by_what_rounding_may() -> None:
    rough, plain = PerturbedFloat(count=3, copies=2), PerturbedFloat()
    x = np.float32([[0.1], [0.5], [3.0]] * 3)
    given = (rough.exact(x) / plain.exact(x) - 1.0).reshape(3, 3)
    assert (given[0] == 0.0).all() and (given[:, 1:] == 0.0).all()
    assert ((abs(given[1:, 0]) > 2.0**-26) & (abs(given[1:, 0]) <= 2.0**-24)).all()
    assert given[1, 0] != given[2, 0]
    assert rough.literal(0.5) == 0.5
    tenth = rough.literal(0.1)
    assert (tenth[:3] == np.float32(0.1)).all() and (tenth[3:] != 0.1).all() and len(tenth) == 9
    third = rough.call("divide", np.ones((1, 1)), np.full((1, 1), 3.0))
    assert (third[:3] == 1.0 / 3.0).all() and (third[3:] != 1.0 / 3.0).all()
    assert (abs(third * 3.0 - 1.0) <= 2.0**-51).all()
    assert rough.call("add", np.ones((1, 1)), np.ones((1, 1))) == 2.0
    assert np.isnan(plain.call("pow", np.full((1, 1), -2.0), np.full((1, 1), 2.0)))


def test_the_command_answers_by_its_status(tmp_path: Path) -> None:
    texts = {
        "old": "o = x;",
        "same": "o = 1.0 * x;",
        "wrong": "o = x + 0.001;",
        "lossy": "o = (x + 3.0) - 3.0;",
        "clamped": "o = clamp(x, 0.0, 1.0);",
        "broken": "o = y;",
        "endless": "o = x; for (int i = 0; i < 4000; ++i) o += sin(o);",
    }
    for name, body in texts.items():
        text = f"#version 330 core\nin float x;\nout float o;\nvoid main() {{ {body} }}\n"
        (tmp_path / f"{name}.frag").write_text(text)

    def diff(name: str, *more: str) -> tuple[Any, str]:
        words = [str(tmp_path / "old.frag"), str(tmp_path / f"{name}.frag"), "-j", "0", *more]
        result = CliRunner().invoke(command, words, standalone_mode=False)
        return result.exception or result.return_value, result.output

    status, text = diff("same", "--json", str(tmp_path / "a.json"))
    assert status == 0 and text.startswith("o: same on ")
    assert json.loads((tmp_path / "a.json").read_text())[0]["same"] is True
    status, text = diff("wrong", "--range", "x=2:3")
    assert status == 1 and "different at 100 %" in text and "x: 2..3 (given)" in text
    assert diff("lossy")[0] == 0 and diff("lossy", "--strict")[0] == 1
    assert diff("same", "--strict")[0] == 0
    status, text = diff("clamped")
    assert status == 3 and ", only if 0 <= x <= 1" in text and " became " in text
    assert diff("clamped", "--assume")[0] == 0
    status, text = diff("endless", "--timeout", "0.1", "-j", "1")
    assert status == 2 and "timeout" in text and "--range NAME=A:B" in text
    status, text = diff("broken")
    assert status == 2 and text.startswith("undetermined: ") and "undeclared" in text
    for words in (["--range", "x"], ["--range", "x=5..1"], ["--range", "y=0:1"]):
        assert isinstance(diff("same", *words)[0], UsageError)
    assert isinstance(diff("nowhere")[0], ShaderlabError)


def test_elements_of_an_array_are_listed_once(tmp_path: Path) -> None:
    file = tmp_path / "sum.frag"
    text = "#version 330 core\nuniform float w[7]; flat in int n; out float o;"
    file.write_text(f"{text} void main() {{ o = w[n]; }}")
    words = [str(file), str(file), "-j", "0", "--inputs", "--range", "w[1]=2:3"]
    text = CliRunner().invoke(command, words, standalone_mode=False).output
    said = ["  w[]: 0..1 (assumed)", "  w[1]: 2..3 (given)", "  n: 0..4 (assumed)"]
    assert text.splitlines()[1:] == said
