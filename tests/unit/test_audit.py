"""Hazards are found at their lines, by inputs that show them; what is guarded is none."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.analysis.audit import Audit, Hazard, Plan, audit_program
from shaderlab.analysis.interpreter import load
from shaderlab.cli import cli
from shaderlab.cli.audit import command
from shaderlab.compiler import Shaders
from shaderlab.errors import NotInterpretedError, UsageError

_START = """#version 330 core
in vec2 uv; // range: 0..1
uniform float x; // range: -1..1
uniform float y; // range: 0..1
uniform vec3 v;
uniform vec3 lightPos;
uniform vec3 FragPos;
uniform int n; // range: 0..40
uniform sampler2D image;
out vec4 FragColor;
float ratio(float a, float b) { return a / b; }
void main()
{
"""
_PLANTED = {
    "division by 0": "1.0 / (uv.x - 0.3)",
    "sqrt of a negative number": "sqrt(x)",
    "log of 0 or less": "log(y)",
    "log2 of 0 or less": "log2(x + 0.5)",
    "inversesqrt of 0 or less": "inversesqrt(y * y)",
    "pow of a negative number": "pow(x, 2.2)",
    "pow of 0 to 0 or less": "pow(y, x)",
    "acos outside -1..1": "acos(x * 1.1)",
    "asin outside -1..1": "asin(y + 0.1)",
    "normalize of a zero vector": "normalize(v).x",
    "smoothstep with reversed edges": "smoothstep(y, uv.x, 0.5)",
    "clamp with reversed bounds": "clamp(0.5, y, uv.x)",
    "index out of range": "float[3](1.0, 2.0, 3.0)[n]",
    "integer division by 0": "float(100 / n)",
    "shift beyond 31 bits": "float(1 << n)",
    "overflow": "exp(100.0 * y)",
    "atan of (0, 0)": "atan(x, y)",
}
_GUARDED = (
    "uv.x != 0.3 ? 1.0 / (uv.x - 0.3) : 0.0",
    "x > 0.0 ? log(x) : 0.0",
    "sqrt(max(x, 0.0))",
    "acos(clamp(x * 1.1, -1.0, 1.0))",
    "pow(abs(x) + 0.001, 2.2)",
    "y / max(y, 0.001)",
    "n < 3 ? float[3](1.0, 2.0, 3.0)[n] : 0.0",
    "float(1 << (n & 31))",
    "exp(-100.0 * y)",
    "length(v) > 0.0 ? normalize(v).x : 0.0",
    "texture(image, uv).r / (texture(image, uv).a + 0.1)",
)


@functools.cache
def audit(body: str, ranges: tuple[tuple[str, str], ...] = (), count: int = 4096) -> Audit:
    """The audit of a fragment shader; an expression is what it draws, at line 14."""
    lines = body if ";" in body else f"    float value = {body};\n    FragColor = vec4(value);"
    shaders = Shaders([Path()], overrides={"a.frag": f"{_START}{lines}\n}}\n"})
    program = load(shaders.load("a.frag", "fragment"))
    return audit_program(program, Plan(ranges=dict(ranges), count=count))


def evident(found: Audit) -> list[Hazard]:
    return [hazard for hazard in found.hazards if hazard.evident]


@pytest.mark.parametrize("kind", _PLANTED)
def test_a_hazard_is_found_at_its_line(kind: str) -> None:
    hazards = evident(audit(_PLANTED[kind]))
    assert [(hazard.line, hazard.kind) for hazard in hazards] == [(14, kind)]
    assert hazards[0].inputs


@pytest.mark.parametrize("expression", _GUARDED)
def test_what_a_condition_keeps_out_is_no_hazard(expression: str) -> None:
    assert audit(expression).clean


def test_the_inputs_that_are_shown_do_it() -> None:
    (hazard,) = evident(audit("sqrt(uv.x - 0.999)"))
    assert hazard.inputs["uv"][0] < 0.999
    (exact,) = evident(audit("1.0 / (uv.x - 0.3)"))
    assert exact.inputs["uv"][0] == pytest.approx(0.3, abs=1e-6)


def test_a_loop_over_all_texels_ends() -> None:
    body = "    ivec2 size = textureSize(image, 0);\n    vec4 sum = vec4(0.0);\n"
    body += "    for (int y = 0; y < size.y; ++y)\n        for (int x = 0; x < size.x; ++x)\n"
    body += "            sum += texelFetch(image, ivec2(x, y), 0);\n    FragColor = sum;"
    assert audit(body, count=64).clean
    outside = body.replace("x = 0", "x = -1").replace("y < size.y", "y < 2")
    assert not audit(outside, count=64).clean


def test_the_inputs_that_matter_come_first() -> None:
    hazards = evident(audit("uv.y * lightPos.x / (FragPos.x > 0.0 ? v.x : y)"))
    assert {*list(hazards[0].inputs)[:2]} in ({"FragPos", "v"}, {"FragPos", "y"})


def test_a_result_that_nothing_depends_on_is_no_hazard() -> None:
    body = "    float bad = log(x);\n    FragColor = vec4(x > 0.0 ? bad : 0.0);"
    assert audit(body).clean
    assert not audit(body.replace("x > 0.0", "x > -0.5")).clean


@pytest.mark.parametrize(
    "bad", ["sqrt(x)", "1.0 / (x - 0.5)", "float(100 / int(9.0 * y))", "normalize(max(v, 0.0)).x"]
)
@pytest.mark.parametrize("rare", ["uv.y > 0.999", "n == 35"])
def test_an_output_may_depend_on_it_for_few_inputs(bad: str, rare: str) -> None:
    body = f"    float bad = {bad};\n    FragColor = vec4({rare} ? bad : 0.0);"
    assert [hazard.line for hazard in evident(audit(body))] == [14]


_NEAR = "texelFetch(image, ivec2(gl_FragCoord.xy) - 1, 0).r"
_SIZE = "textureSize(image, 0)"


@pytest.mark.parametrize(
    ("value", "kind"),
    [
        (_NEAR, "texel"),
        ("texelFetchOffset(image, ivec2(gl_FragCoord.xy), 0, ivec2(0, -1)).r", "texel"),
        (f"texelFetch(image, {_SIZE}, 0).r", "texel"),
        (f"texelFetch(image, ivec2(uv * vec2({_SIZE})), 0).r", "texel"),
        ("texelFetch(image, ivec2(0), n - 1).r", "level"),
        ("texelFetch(image, ivec2(gl_FragCoord.xy), 0).r", ""),  # its size may be the target's
        ("texelFetch(image, ivec2(gl_FragCoord.xy) >> (n & 3), n & 3).r", ""),
        (f"texelFetch(image, min(ivec2(uv * vec2({_SIZE})), {_SIZE} - 1), 0).r", ""),
        (f"texelFetch(image, (ivec2(gl_FragCoord.xy) + {_SIZE} - 1) % {_SIZE}, 0).r", ""),
        (f"all(greaterThan(gl_FragCoord.xy, vec2(1.0))) ? {_NEAR} : 0.0", ""),
    ],
)
def test_texels_outside_of_a_texture(value: str, kind: str) -> None:
    shown = [(hazard.line, hazard.kind) for hazard in evident(audit(value))]
    assert shown == ([(14, f"{kind} out of range")] if kind else [])


def test_levels_of_a_texture_decide_both_what_goes_wrong_and_what_depends_on_it() -> None:
    levels = "float a = textureLod(image, uv, y).r, b = textureLod(image, uv, 0.0).r;"
    body = f"{levels} float d = 1.0 / (a - b); FragColor = vec4(a == b ? 0.0 : d);"
    assert not audit(body).hazards
    assert audit(body.replace("a == b ? 0.0 : d", "d")).hazards


@pytest.mark.parametrize(
    ("condition", "output"), [("d > 3.0 && y < 0.5", "discard"), ("y < 0.5", "FragColor")]
)
def test_what_is_discarded_has_no_outputs(condition: str, output: str) -> None:
    body = f"float d = 1.0 / floor(x); FragColor = vec4(d);\nif ({condition}) discard;"
    (found,) = audit(f"{body}\ngl_FragDepth = d;").hazards
    assert found.kind == "division by 0" and output in found.outputs


def test_two_places_seldom_meet_and_two_vectors_do() -> None:
    (hazard,) = audit("normalize(lightPos - FragPos).x").hazards
    assert not hazard.evident
    assert "only if two inputs are equal" in hazard.message
    said = (("lightPos", "-1..1"), ("FragPos", "-1..1"))
    assert not audit("normalize(lightPos - FragPos).x", said).clean


def test_the_w_of_a_place_is_seldom_0() -> None:
    text = """#version 330 core
in vec4 NAME;
out vec4 FragColor;
void main()
{
    FragColor = vec4(NAME.xyz / NAME.w, 1.0);
}
"""
    for name, is_evident in (("FragPosLightSpace", False), ("ratios", True)):
        overrides = {"a.frag": text.replace("NAME", name)}
        program = load(Shaders([Path()], overrides=overrides).load("a.frag", "fragment"))
        (hazard,) = audit_program(program).hazards
        assert (hazard.kind, hazard.evident) == ("division by 0", is_evident)


def test_ranges_decide() -> None:
    assert not audit("sqrt(v.x)").clean
    assert audit("sqrt(v.x)", (("v", "0..3"),)).clean
    with pytest.raises(UsageError, match="does not read 'w'"):
        audit("sqrt(v.x)", (("w", "0..3"),))


def test_a_call_is_named() -> None:
    (hazard,) = evident(audit("ratio(1.0, y)"))
    assert (hazard.line, hazard.calls) == (11, (14,))


def test_what_nobody_wrote() -> None:
    body = "    float sum;\n    if (x > 0.5) sum = 1.0;\n    FragColor.rgb = vec3(sum);"
    found = [(hazard.line, hazard.kind) for hazard in evident(audit(body))]
    assert found == [(10, "output not written"), (16, "uninitialised read")]
    whole = body.replace("sum;\n", "sum = 0.0;\n", 1).replace(".rgb = vec3", " = vec4")
    assert audit(whole).clean


def test_derivatives_in_divergent_control_flow() -> None:
    body = "    float d = 0.0;\n    if (uv.x > 0.5) {\n        d = dFdx(uv.y);\n    }\n"
    body += "    FragColor = vec4(d);"
    assert [(h.line, h.kind) for h in evident(audit(body))] == [
        (16, "derivative in divergent control flow")
    ]
    assert audit(body.replace("uv.x > 0.5", "x > 0.5")).clean


def test_derivatives_after_others_of_the_quad_were_discarded() -> None:
    body = "    if (uv.x < 0.5) discard;\n    FragColor = vec4(dFdx(uv.x * uv.y));"
    assert [h.line for h in evident(audit(body))] == [15]
    assert audit(
        "    float d = dFdx(uv.y);\n    if (d < 0.5) discard;\n    FragColor = vec4(d);"
    ).clean


@pytest.mark.parametrize(
    ("value", "hazards"),
    [
        ("id == 12345 ? sqrt(-1.0 - y) : 0.0", 1),
        ("float(100 / (id - 777))", 1),
        ("(float[6](y, y, y, y, y, y))[id] * float(id / 16)", 0),  # 16 is no index
    ],
)  # fmt: skip
def test_numbers_that_the_shader_names_are_tried(value: str, hazards: int) -> None:
    text = (
        f"uniform int id;\nin float y; // range: 0..1\nout float o;\nvoid main() {{ o = {value}; }}"
    )
    source = Shaders([]).from_text(f"#version 330 core\n{text}", "fragment", "a.frag")
    assert len(evident(audit_program(load(source)))) == hazards


@pytest.mark.parametrize(
    ("body", "hazards"),
    [
        ("float v; if (id != 777) v = y; o = v;", 1),
        ("if (id != 777) o = y;", 1),
        ("o = id == 777 ? fract(sin(y * 91.7) * 43758.5) : 0.0;", 1),
        ("o = 0.0; if (id == 777 && y > 0.5) o = dFdx(y * y);", 1),
        ("o = id == 777 ? y : 0.0; for (int i = 0; i < id; ++i) o += y;", 0),
        ("o = id == 100000 ? y : 0.0; for (int i = 0; i < id; ++i) o += y;", 0),  # 100,000 times
    ],
)
def test_what_only_a_number_that_the_shader_names_shows(body: str, hazards: int) -> None:
    text = f"uniform int id;\nin float y; // range: 0..1\nout float o;\nvoid main() {{ {body} }}"
    source = Shaders([]).from_text(f"#version 330 core\n{text}", "fragment", "a.frag")
    assert len(evident(audit_program(load(source)))) == hazards


@pytest.mark.parametrize(
    ("declared", "value", "evident"),
    [
        ("in vec2 at; uniform sampler2D map;", "at.x > 0.5 ? texture(map, at).r : 0.0", [True]),
        (
            "in vec3 at; uniform sampler2DShadow map;",
            "at.x > 0.5 ? texture(map, at) : 0.0",
            [False],
        ),
        ("flat in vec2 at; uniform sampler2D map;", "at.x > 0.5 ? texture(map, at).r : 0.0", []),
        ("in vec2 at; uniform sampler2D map;", "at.x > 0.5 ? textureLod(map, at, 0.0).r : 0.0", []),
        (  # a level of detail, though made-up textures have one level
            "in vec2 at; uniform int k; uniform sampler2D map;",
            "textureLod(map, at, log2(float(abs(k)))).r",
            [True],
        ),
        ("in mat3 turn; uniform sampler2D map;", "texture(map, turn[0].xy).r", []),
        ("in vec2 at;", "log2(max(abs(at.x - 0.25), abs(at.y - 0.75)))", [True]),  # both at once
    ],
)
def test_what_a_texture_and_its_coordinates_may_be(
    declared: str, value: str, evident: list[bool]
) -> None:
    text = f"#version 330 core\n{declared}\nout float o;\nvoid main() {{ o = {value}; }}"
    found = audit_program(load(Shaders([]).from_text(text, "fragment", "a.frag"))).hazards
    assert [hazard.evident for hazard in found] == evident


def test_a_loop_that_never_ends_can_not_be_audited() -> None:
    with pytest.raises(NotInterpretedError, match="goes on after"):
        audit("    float s = 0.0;\n    while (y >= 0.0) s += y;\n    FragColor = vec4(s);")


def run(tmp_path: Path, expression: str, *options: str) -> tuple[int, str]:
    file = tmp_path / "a.frag"
    file.write_text(f"{_START}    FragColor = vec4({expression});\n}}\n")
    result = CliRunner().invoke(command, [str(file), "-j", "0", *options], standalone_mode=False)
    return result.return_value, result.output


def test_the_command_says_where_and_with_what(tmp_path: Path) -> None:
    status, output = run(tmp_path, "log(x)")
    assert status == 1
    assert "a.frag:14: log of 0 or less: log(" in output
    assert "    with x = " in output
    assert "1 hazard on " in output
    assert "  x: -1..1 (declared)" in output


def test_the_command_is_quiet_about_the_rest(tmp_path: Path) -> None:
    status, output = run(tmp_path, "normalize(lightPos - FragPos).x")
    assert status == 0
    answer, *ranges = output.splitlines()
    assert "no hazards, 1 possible" in answer and ranges
    assert all("(assumed)" in line for line in ranges)
    assert (
        "only if two inputs are equal (possible)"
        in run(tmp_path, "normalize(lightPos - FragPos).x", "--possible")[1]
    )


def test_the_command_writes_what_programs_read(tmp_path: Path) -> None:
    files = {name: tmp_path / name for name in ("json", "sarif")}
    status, _ = run(tmp_path, "1.0 / y", *(w for n, f in files.items() for w in (f"--{n}", str(f))))
    assert status == 1
    ((audited,),) = [json.loads(files["json"].read_text())]
    (hazard,) = audited["hazards"]
    assert (hazard["line"], hazard["kind"], hazard["evident"]) == (14, "division by 0", True)
    assert hazard["outputs"]["FragColor"][0] in ("inf", "-inf")
    (found,) = json.loads(files["sarif"].read_text())["runs"][0]["results"]
    assert (found["ruleId"], found["level"]) == ("hazard", "error")


def test_what_can_not_be_audited_is_status_2(tmp_path: Path) -> None:
    status, output = run(tmp_path, "undeclared")
    assert status == 2
    assert "undetermined: " in output and "undeclared" in output


def test_where_precision_is_lost_is_named() -> None:
    body = "    float big = 1000.0 + y;\n    float small = big - 1000.0;\n"
    body += "    FragColor = vec4(small);"
    source = f"{_START}{body}\n}}\n"
    program = load(Shaders([Path()], overrides={"a.frag": source}).load("a.frag", "fragment"))
    highp, mediump = audit_program(program, Plan(precision=True)).spreads
    assert (highp.precision, highp.line) == ("highp", 15)
    assert 0.01 < highp.codes < 1.0
    assert (mediump.precision, mediump.line) == ("mediump", 15)
    assert mediump.codes > 50.0  # 1000 + y has steps of a half there
    plain = audit("y", ()).spreads
    assert plain == ()


def test_what_is_declared_highp_stays_so() -> None:
    text = """#version 310 es
precision mediump float;
in PRECISION vec2 uv; // range: 0..1
out vec4 FragColor;
void main()
{
    highp float big = 1000.0 + uv.x;
    FragColor = vec4(big - 1000.0);
}
"""
    codes = []
    for word in ("highp", "mediump"):
        overrides = {"a.frag": text.replace("PRECISION", word)}
        program = load(Shaders([Path()], overrides=overrides).load("a.frag", "fragment"))
        (found,) = [
            s for s in audit_program(program, Plan(precision=True)).spreads
            if s.precision == "mediump"
        ]  # fmt: skip
        codes.append(found.codes)
    assert codes[0] < 5.0 and codes[1] > 50.0


def test_a_file_of_no_stage_is_told_what_to_do(tmp_path: Path) -> None:
    file = tmp_path / "law.glsl"
    file.write_text("#ifdef FRAGMENT\nvoid main() { gl_FragColor = vec4(1.0); }\n#else\n"
                    "void main() { gl_Position = vec4(1.0); }\n#endif\n")  # fmt: skip
    result = CliRunner().invoke(command, [str(file), "-j", "0"], standalone_mode=False)
    assert result.return_value == 2
    assert "can't tell the shader's stage" in result.output


HUGE = "more than 2,048 elements\n  → give its array a length that the shader needs"


@pytest.mark.parametrize("words", [("audit",), ("explain",), ("prove",), ("diff", "a.frag")])
@pytest.mark.parametrize(
    ("declared", "value", "said"),
    [
        (
            "uniform sampler2DMSArray solid;",
            "texelFetch(solid, ivec3(0), 0)",
            "sampler2DMSArray solid",
        ),
        ("uniform B { vec4 v[1 << 30]; }; uniform int n;", "v[n]", f"v has {HUGE}"),
        ("struct S { vec4 a; float b; }; uniform B { S v[1 << 28]; };", "v[7].a", f"v has {HUGE}"),
        ("uniform B { vec4 v[16][16][16]; }; uniform int n;", "v[n][n][n]", f"v has {HUGE}"),
    ],
)
def test_what_is_not_interpreted_names_its_file(
    words: tuple[str, ...], declared: str, value: str, said: str, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.frag").write_text(
        f"#version 430 core\n{declared}\nout vec4 color;\nvoid main() {{ color = {value}; }}\n"
    )
    result = CliRunner().invoke(cli, [*words, "a.frag", "-j", "0"])
    assert result.exit_code in (1, 2)
    assert f"a.frag: not interpreted: {said}" in result.output


@pytest.mark.parametrize("words", [("audit",), ("explain",), ("prove",), ("diff", "a.frag")])
def test_what_takes_too_long_says_how_to_allow_more(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.frag").write_text(
        "#version 330 core\nuniform int n;\nuniform vec4 v[1000];\nout vec4 color;\n"
        "void main() { for (int i = 0; i < 1000; i++) color += v[(n + i) % 1000]; }\n"
    )
    result = CliRunner().invoke(cli, [*words, "a.frag", "-j", "1", "--timeout", "1"])
    assert result.exit_code in (1, 2), result.output
    # On a busy machine a second is over while the shader is compiled.
    said = r"(compil|interpret)ing a\.frag: took longer than 1 s\n  → allow more time: --timeout S"
    assert re.search(said, result.output)


@pytest.mark.parametrize(
    ("body", "found"),
    [
        ("return fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.5453);", True),
        ("float s = sin(p.x * 91.7); s *= 4375.5; return fract(s);", True),
        ("vec2 s = sin(p * 91.7); return fract(s * 43758.5).x;", True),
        ("return fract(vec2(cos(p.x), sin(p.y)) * 4000.0).y;", True),
        ("float h = cos(p.x * 91.7) * 43758.5; return h - floor(h);", True),
        ("return mod(sin(p.x * 91.7) * 43758.5, 1.0);", True),
        ("return mod(sin(p.x * 91.7) * 43758.5, 43758.0);", False),
        ("float h = sin(p.x) * 43758.5; return h - floor(p.y);", False),
        ("return floor(sin(p.x) * 255.0) / 255.0;", False),
        ("return fract(sin(p.x) * 4.0 + p.y);", False),
        ("return sin(p.x) * 43758.5 + fract(p.y * 43758.5);", False),
    ],
)
def test_random_numbers_of_sines_are_hazards(body: str, found: bool) -> None:
    text = f"#version 330 core\nin vec2 p;\nout float c;\nfloat f()\n{{ {body} }}\n"
    source = Shaders([]).from_text(text + "void main() { c = f(); }", "fragment", "a.frag")
    hazards = audit_program(load(source)).hazards
    assert [(h.kind, h.line) for h in hazards] == ([("sine hash", 5)] if found else [])
