"""Tests of GLSL functions inside a worker: mistakes in the functions, and which tests notice."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli, selecting
from shaderlab.compiler.sources import Shaders
from shaderlab.engine.worker import Worker
from shaderlab.errors import CaseError
from shaderlab.mutation import MutationPlan
from shaderlab.mutation.function_tests import (
    FunctionMutant,
    JudgeFunctionMutant,
    RunTestFile,
    TestFileTarget,
    compare_texts,
)

GLSL = """\
float fade(float d, float reach) { return max(1.0 - d / reach, 0.0); }
float twice(float x) { return 2.0 * x; }
float same(float x) { return clamp(x, 0.0, 1.0) * 1.0; }
float unused(float x) { return 3.0 * x; }
"""
TESTS = """\
import numpy as np
from shaderlab import glsl
import helper

light = glsl.load("light.glsl")
X = np.linspace(0, 4, 41)

def test_fade():
    light.fade.check(lambda d: np.maximum(1.0 - d / 2.0, 0.0) if False else helper.fade(d), X, 2.0)

def test_twice():
    assert light.twice(0.0) == 0.0

@glsl.given(light.same, x=glsl.floats(0, 1))
def test_same(x, y):
    return y == x
"""
HELPER = """\
from shaderlab.glslmath import max
def fade(d):
    return max(1.0 - d / 2.0, 0.0)
"""
INLINE = """\
from shaderlab import glsl
law = glsl.load("float law(float x) { return x + 1.0; }")
AT_2 = law.law(2.0)
def test_import():
    assert AT_2 == 3.0
def test_law():
    assert law.law(-1.0) == 0.0
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "light.glsl").write_text(GLSL)
    (tmp_path / "helper.py").write_text(HELPER)
    (tmp_path / "test_light.py").write_text(TESTS)
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


@pytest.fixture(scope="module")
def worker() -> Worker:
    return Worker()


def made(worker: Worker, file: Path) -> dict[tuple[str, str], FunctionMutant]:
    """The mutants by what they make of what."""
    found = {}
    for mutant in TestFileTarget(file, "", MutationPlan()).perform(worker):
        assert isinstance(mutant, FunctionMutant)
        found[mutant.before, mutant.after] = mutant
    return found


def test_a_file_of_tests_is_run_anew_each_time(worker: Worker, folder: Path) -> None:
    file = folder / "test_light.py"
    first = RunTestFile(file).perform(worker)
    assert [(r.variant, r.status) for r in first.records] == [
        ("test_fade", "pass"), ("test_twice", "pass"), ("test_same", "pass"),
    ]  # fmt: skip
    assert [sorted(names) for names in first.loads.used.values()] == [["fade", "same", "twice"]]
    (folder / "light.glsl").write_text(GLSL.replace("2.0 * x", "2.0 * x + 1.0"))
    again = RunTestFile(file).perform(worker)
    assert [r.status for r in again.records] == ["pass", "fail", "pass"]
    (folder / "light.glsl").write_text(GLSL)
    (folder / "helper.py").write_text(HELPER.replace("2.0", "20.0"))
    assert [r.status for r in RunTestFile(file).perform(worker).records] == ["fail", "pass", "pass"]
    file.write_text(TESTS.replace("import helper", "import helper as"))
    (broken,) = RunTestFile(file).perform(worker).records
    assert broken.status == "error" and "SyntaxError" in broken.message


def test_mutants_are_of_functions_that_tests_ask_for(worker: Worker, folder: Path) -> None:
    file = folder / "test_light.py"
    mutants = made(worker, file)
    assert not any("3.0" in before for before, _ in mutants)  # nobody asks for it

    def fate(before: str, after: str, **changes: str) -> tuple[str, str]:
        mutant = replace(mutants[before, after], **changes)
        found = JudgeFunctionMutant(file, mutant).perform(worker)
        return found.status, found.by

    assert fate("1.0 - d / reach", "1.0 + d / reach") == ("killed", "test_fade")
    assert fate("max(1.0 - d / reach, 0.0)", "(1.0 - d / reach)") == ("killed", "test_fade")
    # 2 x is only looked at where x is 0.
    survived = ("survived", "twice gives other values elsewhere")
    assert fate("2.0 * x", "2.02 * x") == survived
    whole = "clamp(x, 0.0, 1.0) * 1.0"
    assert fate(whole, "clamp(x, 0.0, 1.0) / 1.0")[0] == "no difference"
    assert fate(whole, "clamp(x, 0.0, 1.0) * 1.01") == ("killed", "test_same")
    # What no compiler takes is no mistake that a test has to notice.
    wrong = GLSL.replace("2.0 * x", "2.0 * nothing")
    assert fate("2.0 * x", "2.02 * x", text=wrong)[0] == "invalid"


def test_structures_and_textures_are_asked_for_other_values(worker: Worker) -> None:
    text = """
        struct Light { vec3 at; float reach; };
        struct Surface { sampler2D color; float gain; };
        float near(Light light, vec3 p) { return distance(light.at, p) / light.reach * 1.0; }
        vec4 shone(Surface surface, vec2 p) { return surface.gain * texture(surface.color, p); }
        vec4 texel(sampler2D image, ivec2 p) { return texelFetch(image, p & 3, 0) + 0.0; }
        float cube(samplerCube sky, vec3 p) { return texture(sky, p).r * 1.0; }
    """
    source = Shaders([]).from_text(text, "fragment", "text")
    for name, before, after, expected in [
        ("near", "light.reach *", "(light.reach + 0.01) *", "survived"),
        ("near", "light.reach * 1.0", "light.reach / 1.0", "no difference"),
        ("shone", "surface.gain *", "1.01 * surface.gain *", "survived"),
        ("texel", "p & 3", "p & 1", "survived"),
        ("texel", "0) + 0.0", "0) - 0.0", "no difference"),
        ("cube", ".r * 1.0", ".g * 1.0", "survived"),
    ]:
        changed = text.replace(before, after)
        assert changed != text
        found = compare_texts(worker, source, changed, [name])
        assert found.status == expected, (name, after, found.by)
    assert found.by == "cube is not called at other values"


def test_texts_and_values_of_the_import_are_mutated_too(worker: Worker, folder: Path) -> None:
    (folder / "test_inline.py").write_text(INLINE)
    file = folder / "test_inline.py"
    mutant = made(worker, file)["x + 1.0", "x - 1.0"]
    assert JudgeFunctionMutant(file, mutant).perform(worker).by == "test_import, test_law"


def test_a_test_that_fails_as_it_is_notices_nothing(worker: Worker, folder: Path) -> None:
    file = folder / "test_light.py"
    file.write_text(TESTS.replace("== 0.0", "== 1.0"))
    mutant = made(worker, file)["2.0 * x", "2.0 / x"]
    result = JudgeFunctionMutant(file, mutant).perform(worker)
    assert result.status == "survived"
    assert "test_twice (left out: it fails as it is)" in (result.noticed or {})


def test_what_can_not_be_measured_is_said(worker: Worker, folder: Path) -> None:
    file = folder / "test_light.py"
    file.write_text("def test_red(): assert 0\n")
    with pytest.raises(CaseError, match="fails as it is: test_red"):
        TestFileTarget(file, "", MutationPlan()).perform(worker)
    file.write_text("from shaderlab import glsl\ndef test_nothing(): pass\n")
    with pytest.raises(CaseError, match="asks for a function"):
        TestFileTarget(file, "", MutationPlan()).perform(worker)


def test_the_command_tells_which_tests_notice(folder: Path) -> None:
    (folder / "test_light.py").write_text(TESTS[: TESTS.index("@glsl")])
    command = ["mutate", "test_light.py", "-j", "0", "--json", "out.json", "--fail-under", "99"]
    command += ["--limit", "12"]
    result = CliRunner().invoke(cli, command, catch_exceptions=False)
    assert result.exit_code == 1
    assert "light.glsl:2" in result.output and "noticed in test_light, by test:" in result.output
    (case,) = json.loads((folder / "out.json").read_text())["cases"]
    assert case["id"] == "test_light" and set(case["noticed"]) == {"test_fade", "test_twice"}
    assert case["noticed"]["test_fade"] > 1 and case["survived"]


def test_files_of_tests_are_told_from_cases(folder: Path) -> None:
    (folder / "test_other.py").write_text("def test_nothing(): pass\n")
    tests, cases = selecting.split_targets([".", "spotlight"])
    assert [path.name for path in tests] == ["test_light.py"] and cases == ["spotlight"]
    (folder / "lamp.py").write_text("from shaderlab import Case\ncase = Case(title='', passes=())")
    assert selecting.split_targets(["."])[1] == ["."]
    result = CliRunner().invoke(cli, ["mutate", "test_light.py", "--api", "-j", "0"])
    assert result.exit_code == 2 and "--api is about cases" in result.output
