"""What somebody tries in the first hour, and what the lab says then: a sentence that goes on."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from shaderlab import glsl
from shaderlab.analysis.inputs import Input, InputDomain, domains_of
from shaderlab.cli import cli
from shaderlab.engine.jobs import ProcessExecutor
from shaderlab.errors import (
    ArgumentsError,
    CallError,
    FormulaError,
    NoFunctionError,
    ShaderError,
    UsageError,
)

LIBRARY = """\
uniform float exposure;
uniform Camera { mat4 view; float near; };
float fade(float d, float reach) { return max(1.0 - d / reach, 0.0); }
float shown(float x) { return x * exposure; }
float closest(float x) { return max(x, near); }
void nothing(float x) { }
vec3 squares(vec3 c) { return c * c; }
"""
SHADER = "#version 330 core\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n"
TESTS = 'from shaderlab import glsl\nlib = glsl.load("lib.glsl")\ndef test_it(): lib.fade(0, 1)\n'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SHADERLAB_JOBS", "0")
    Path("lib.glsl").write_text(LIBRARY)
    return tmp_path


@pytest.fixture
def library(folder: Path) -> glsl.Library:
    return glsl.load(str(folder / "lib.glsl"))


def call(*words: str) -> Result:
    return CliRunner().invoke(cli, words)


@pytest.mark.parametrize("name", ["a.hlsl", "a.wgsl", "a.metal", "a.slang", "a.gdshader"])
@pytest.mark.parametrize("command", ["compile", "audit", "explain", "diff", "run", "watch", "load"])
def test_another_language_is_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch, name: str, command: str
) -> None:
    monkeypatch.setenv("PATH", "/usr/bin:/bin")
    Path(name).write_text("float4 main() { return 1; }\n")
    if command == "load":
        with pytest.raises(ShaderError, match="the lab reads GLSL and SPIR-V"):
            _ = glsl.load(name).main
        return
    words = [name, name] if command == "diff" else [name]
    if command == "watch":  # which needs workers, and never starts one here
        words += ["-j", "1"]
    result = call(command, *words)
    assert result.exit_code in (1, 2)
    translated = command in ("audit", "explain", "diff") and name in ("a.hlsl", "a.slang", "a.wgsl")
    said = "which is not installed" if translated else "the lab reads GLSL and SPIR-V"
    assert said in result.output and "Traceback" not in result.output


def test_a_library_of_functions_is_judged_in_its_folder_and_by_name(folder: Path) -> None:
    for words in (["."], ["lib.glsl"]):
        assert "glsl                   1         0" in call("compile", *words).output
        assert "lib.glsl: 1 hazard" in call("audit", *words).output
    Path("lib.glsl").write_text(LIBRARY.replace("max(x, near)", "maxx(x, near)"))
    assert "lib.glsl:5: error" in call("compile", ".").output


def test_what_a_shader_of_the_folder_includes_is_compiled_with_it_alone(folder: Path) -> None:
    Path("part.glsl").write_text("float twice(float x) { return FACTOR * x; }\n")
    Path("a.frag").write_text(
        SHADER.replace("out", '#define FACTOR 2.0\n#include "part.glsl"\nout')
    )
    result = call("compile", ".")
    assert result.exit_code == 0 and "glsl                   2         0" in result.output


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["run", "lib.glsl"], "compile, explain, audit and diff take shaders"),
        (["run", "lib"], "did you mean lib.py"),
        (["run", "."], "it has tests of functions: pytest ."),
        (["run", "test_lib.py"], "tests of functions are run by pytest"),
        (["explain", "lib.glsl"], "this file has no main to explain"),
    ],
)
def test_what_is_no_case_is_told_with_the_command_for_it(
    folder: Path, words: list[str], said: str
) -> None:
    Path("test_lib.py").write_text(TESTS)
    if words[-1] == "lib":
        Path("lib.py").touch()
    result = call(*words)
    assert result.exit_code in (1, 2) and said in result.output


def test_a_folder_with_both_names_the_tests_that_are_not_run(folder: Path) -> None:
    Path("test_lib.py").write_text(TESTS)
    Path("a.frag").write_text(SHADER)
    Path("a.py").write_text(
        "from shaderlab import Case, constant, fullscreen\n"
        'case = Case(title="x", passes=fullscreen("a.frag"), expect=[])\n'
    )
    assert "pytest runs the tests of functions: test_lib.py" in call("run", ".").output


def test_names_of_a_library_are_those_of_a_mapping_and_of_a_module(library: glsl.Library) -> None:
    assert "fade" in library and "nope" not in library and not hasattr(library, "nope")
    with pytest.raises(KeyError, match="did you mean shown"):
        library["show"]
    with pytest.raises(NoFunctionError):
        library.show  # noqa: B018


def test_wrong_arguments_are_type_errors(library: glsl.Library) -> None:
    for arguments, named in (((1.0,), {}), ((1.0, 2.0, 3.0), {}), ((1.0,), {"rech": 1.0})):
        with pytest.raises(TypeError) as caught:
            library.fade(*arguments, **named)
        assert isinstance(caught.value, CallError)


def test_an_unknown_global_is_refused_as_it_is_given(library: glsl.Library) -> None:
    with pytest.raises(ArgumentsError, match="did you mean exposure"):
        glsl.load("lib.glsl", exposur=1.5)
    assert glsl.load("lib.glsl", exposure=1.5).shown(2.0) == 3.0


def test_members_of_a_block_that_nothing_reads_need_no_value(library: glsl.Library) -> None:
    assert library.closest(0.0, near=0.5) == 0.5


def test_a_function_that_returns_nothing_gives_none(library: glsl.Library) -> None:
    assert library.nothing(1.0) is None


def test_a_vector_rises_by_component(library: glsl.Library) -> None:
    colours = np.random.default_rng(0).uniform(0, 3, (50, 3))
    library.squares.check(glsl.monotone(over="c"), colours)
    with pytest.raises(AssertionError):
        library.squares.check(glsl.monotone(over="c"), colours - 1.0)


@pytest.mark.parametrize(
    ("reference", "hint"),
    [
        (lambda d, reach: max(1.0 - d / reach, 0.0), "glslmath has max, min, any and all"),
        (lambda d, reach: round(d), "write glslmath.round"),
        (lambda d, reach: float(d), "in place of math's, float"),
        (lambda d, reach: d**2, "write x \\* x, or glslmath.pow"),
    ],
)
def test_pythons_own_functions_in_a_reference_get_a_hint(
    library: glsl.Library, reference: object, hint: str
) -> None:
    with pytest.raises(FormulaError, match=hint):
        library.fade.check(reference, np.linspace(0, 1, 8), 1.0)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["N", "light.L", "V", "normals", "lightDirections[1]"])
def test_directions_are_known_by_their_letters_and_in_plural(name: str) -> None:
    assert domains_of({name: Input(name, "vec3", True)}, (), {})[name].kind == "unit"


@pytest.mark.parametrize("name", ["lightColors[0]", "F0", "material.f0", "lights[1].colours"])
def test_shares_of_light_are_known_in_plural_and_at_normal_incidence(name: str) -> None:
    assert domains_of({name: Input(name, "vec3", True)}, (), {})[name] == InputDomain("number")


@pytest.mark.parametrize(("name", "low", "high"), [("uIor", 1.0, 3.0), ("rimPower", 1.0, 128.0)])
def test_numbers_are_known_by_the_last_word(name: str, low: float, high: float) -> None:
    assert domains_of({name: Input(name, "float", True)}, (), {})[name] == InputDomain(
        "number", low, high
    )


def test_modf_frexp_and_the_length_of_a_buffer_are_interpreted(folder: Path) -> None:
    Path("a.frag").write_text(
        "#version 430 core\nlayout(std430) buffer B { float data[]; };\nin float x;\nout vec4 c;\n"
        "void main() { float i; int e; float f = modf(x, i); float s = frexp(x, e);\n"
        "  float sum = 0.0; for (int k = 0; k < data.length(); k++) sum += data[k];\n"
        "  c = vec4(f + i - x, ldexp(s, e) - x, sum, 1.0); }\n"
    )
    plain = Path("a.frag").read_text().replace("modf(x, i)", "x - trunc(x); i = trunc(x)")
    Path("b.frag").write_text(plain.replace("s = frexp(x, e)", "s = x; e = 0"))
    assert call("audit", "a.frag").exit_code == 0
    result = call("diff", "a.frag", "b.frag")
    assert result.exit_code == 0, result.output
    Path("b.frag").write_text(plain.replace("s = frexp(x, e)", "s = x; e = 1"))
    assert call("diff", "a.frag", "b.frag").exit_code == 1


def test_another_system_gets_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.platform", "win32")
    for name in ("fcntl", "resource"):
        monkeypatch.setitem(sys.modules, name, None)
    for module in ("options", "doctor", "run"):  # as if nothing had imported them yet
        monkeypatch.delitem(sys.modules, f"shaderlab.cli.{module}", raising=False)
    for command in ("doctor", "run", "list"):
        result = call(command)
        assert result.exit_code == 2 and "needs Linux" in result.output, result.output
    with pytest.raises(UsageError, match="needs Linux"):
        ProcessExecutor()
