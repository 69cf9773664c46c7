"""`audit` and `diff` of files of functions, which have neither a stage nor a `main`."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

LIBRARY = """\
#include "shared.glsl"
struct Light { vec3 at; float reach; bool on; };
const float radius = 2.0;
uniform float time;
float fade(Light light, vec3 p)
{
    float part = distance(light.at, p) / light.reach;
    return light.on ? max(1.0 - part, 0.0) : 0.0;
}
mat2 turned(float radius) { return mat2(cos(radius), sin(radius), -sin(radius), cos(radius)); }
bvec2 above(ivec2 n, bool strict) { return strict ? greaterThan(n, ivec2(1)) : bvec2(true); }
void split(float x, out float whole, inout vec2 rest) { whole = floor(x); rest *= x - whole; }
float result(float x) { return sqrt(x) + time + bent(radius); }
vec4 sampled(sampler2D image, vec2 uv) { return texture(image, uv) * 0.5; }
float weighed(float weights[3], int n) { return weights[n & 1] * 2.0; }
uint mixed(uint n) { return bitfieldReverse(n) ^ (n >> 3u); }
"""
NAMES = ["fade", "turned", "above", "split", "result", "sampled", "weighed", "mixed"]


def run(folder: Path, monkeypatch: pytest.MonkeyPatch, *words: str) -> tuple[int, str]:
    monkeypatch.chdir(folder)
    result = CliRunner().invoke(cli, [*words, "-j", "0"])
    return result.exit_code, result.output


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "shared.glsl").write_text("float bent(float x) { return 1.0 / x; }\n")
    (tmp_path / "law.glsl").write_text(LIBRARY)
    return tmp_path


def test_each_function_is_audited_at_its_line(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    status, output = run(folder, monkeypatch, "audit", "law.glsl", "--range", "x=-1:1")
    assert status == 1
    assert "law.glsl:7: division by 0" in output and "light_reach = 0, light_on = 1" in output
    assert "law.glsl:13: sqrt of a negative number" in output
    assert "undetermined" not in output and "law.glsl: 2 hazards" in output
    # Not what is only included: its caller gives 2.0.
    assert "shared.glsl" not in output
    assert "  fade: light_reach: " in output and "turned" not in output


def test_ranges_go_to_the_functions_that_take_them(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "law.glsl").write_text(
        "float root(float x) { return sqrt(x - 0.5); }\nfloat y(int n) { return 1.0; }\n"
    )
    assert run(folder, monkeypatch, "audit", "law.glsl")[0] == 1
    assert run(folder, monkeypatch, "audit", "law.glsl", "--range", "x=1:9")[0] == 0
    output = run(folder, monkeypatch, "audit", "law.glsl", "--precision")[1]
    assert "root: result: conforming devices" in output and "y: result at mediump: " in output
    status, output = run(folder, monkeypatch, "audit", "law.glsl", "--range", "xx=0:9")
    assert status == 2 and "no function takes 'xx'" in output and "x" in output


def test_a_file_keeps_the_version_that_it_says(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = "#version 310 es\nprecision highp float;\nhighp float root(highp float x)"
    (folder / "law.glsl").write_text(f"{text} {{ return sqrt(x - 0.5); }}\n")
    status, output = run(folder, monkeypatch, "audit", "law.glsl", "--range", "x=0:1")
    assert status == 1 and "law.glsl:3: sqrt of a negative number" in output


CHANGES = {
    "fade": ("light.on ?", "!light.on ?"),
    "turned": ("-sin(radius)", "sin(radius)"),
    "above": ("ivec2(1)", "ivec2(2)"),
    "split": ("rest *= x", "rest += x"),
    "result": ("time + bent", "2.0 * time + bent"),
    "sampled": ("* 0.5", "* 0.25"),
    "weighed": ("n & 1", "n & 2"),
    "mixed": ("Reverse(n)", "Reverse(n + 1u)"),
}


@pytest.mark.parametrize("names", [NAMES[::2], NAMES[1::2]])
def test_the_functions_that_differ_are_named(
    names: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = LIBRARY
    for name in names:
        assert CHANGES[name][0] in text
        text = text.replace(*CHANGES[name])
    (folder / "other.glsl").write_text(text)
    status, output = run(folder, monkeypatch, "diff", "law.glsl", "other.glsl")
    assert status == 1
    differing = {line.split(":")[0] for line in output.splitlines() if ": different" in line}
    assert differing == {*names}


def test_the_same_functions_are_the_same(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "other.glsl").write_text(
        LIBRARY.replace("* 2.0", "+ weights[n & 1]") + "int more() { return 1; }\n"
    )
    status, output = run(folder, monkeypatch, "diff", "law.glsl", "other.glsl")
    assert status == 0
    lines = [line for line in output.splitlines() if not line.startswith((" ", "only"))]
    assert {line.split(":")[0] for line in lines} == set(NAMES)
    assert "only other.glsl has int more()" in output
    status, output = run(folder, monkeypatch, "diff", "other.glsl", "law.glsl")
    assert status == 1 and "int more(): only one of the two" in output


def test_members_of_structures_have_ranges(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = "audit", "law.glsl", "--range", "light_reach=1:2"
    assert run(folder, monkeypatch, *words)[0] == 0
    status, output = run(folder, monkeypatch, *words, "--range", "x=1:0")
    assert status == 2 and "is no range" in output and "undetermined" not in output


def test_a_function_that_is_not_interpreted_leaves_the_others_their_answers(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts = [
        "float deep(sampler2DMSArray solid, vec4 p) { return texelFetch(solid, ivec3(p), 0).r; }\n"
        f"float half_of(float x) {{ return {x} * x; }}\n"
        for x in ("0.5", "0.25")
    ]
    for name, text in zip(("law.glsl", "other.glsl"), texts, strict=True):
        (folder / name).write_text(text)
    status, output = run(folder, monkeypatch, "diff", "law.glsl", "other.glsl")
    assert status == 1 and "half_of: different" in output
    assert "undetermined for deep: " in output and "sampler2DMSArray" in output
    (folder / "other.glsl").write_text(texts[0])
    assert run(folder, monkeypatch, "diff", "law.glsl", "other.glsl")[0] == 2


def test_a_file_without_functions_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "law.glsl").write_text("const float x = 1.0;\n")
    status, output = run(folder, monkeypatch, "audit", "law.glsl")
    assert status == 2 and "law.glsl: there is no function in it" in output
