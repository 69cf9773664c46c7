"""`pytest --shaderlab-report`: cases and tests of GLSL functions on one page."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from shaderlab.model import store
from shaderlab.model.records import Record
from shaderlab.pytest_plugin import ReportWriter
from shaderlab.report.findings import collect_findings

LIGHT = """float half_of(float x) { return 0.5 * x; }
float same(float x) { return x; }
float product(vec2 p) { return p.x == 1.5 && p.y == 4.5 ? 0.0 : p.x * p.y; }
"""
TESTS = '''\
"""Halves."""
import numpy as np
import pytest
from shaderlab import glsl

light = glsl.load("light.glsl")
X = np.linspace(1, 2, 11)

def test_right():
    light.half_of.check(lambda x: 0.5 * x, X)
    light.half_of.check(lambda x: x * 0.5, X)

def test_wrong():
    light.half_of.check(lambda x: 0.51 * x, X)

@glsl.given(light.same, x=glsl.floats(0, 4))
def test_searched(x, y):
    assert y <= 3

def test_asserts():
    assert light.same(1.0) == 2.0

def test_over_two():
    x, y = np.meshgrid(np.linspace(1, 2, 101), np.linspace(4, 5, 9))
    light.product.check(lambda p: p.x * p.y, np.stack([x, y], -1))

def test_other():
    pass

@pytest.mark.skip(reason="later")
def test_skipped():
    light.same.check(lambda x: x, X)
'''


@pytest.fixture
def tests(pytester: pytest.Pytester, case_folder: Path) -> pytest.Pytester:
    for file in case_folder.iterdir():
        (pytester.path / file.name).write_text(file.read_text())
    (pytester.path / "light.glsl").write_text(LIGHT)
    (pytester.path / "test_light.py").write_text(TESTS)
    return pytester


def by_variant(folder: Path) -> dict[str, Record]:
    return {record.variant: record for record in store.load(folder).records}


def test_cases_and_functions_stand_on_one_page(
    tests: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHADERLAB_JOBS", "0")
    words = ("--shaderlab-report", "out", "-n", "1", "-k", "not far")
    result = tests.runpytest_inprocess(*words)
    assert "report: out/index.html" in result.stdout.str(), result.stdout.str()
    found = by_variant(tests.path / "out")
    assert {name: r.status for name, r in found.items() if r.id == "test_light"} == {
        "test_right": "pass",
        "test_wrong": "fail",
        "test_over_two": "fail",
        "test_searched": "fail",
        "test_asserts": "fail",
    }
    lamps = [record for record in found.values() if record.id == "lamp"]
    assert lamps and all(record.images for record in lamps if record.status == "pass")
    assert found["test_right"].title == "Halves."
    names = [outcome.name for outcome in found["test_right"].expectations]
    assert names == ["half_of", "half_of (2)"]
    (curve,) = found["test_wrong"].curves
    assert (curve.x_label, curve.x[0], curve.x[-1], len(curve.x)) == ("x", 1.0, 2.0, 11)
    assert curve.measured == tuple(0.5 * x for x in curve.x)
    assert all(low > y for low, y in zip(curve.low, curve.measured, strict=True))
    (area,) = found["test_over_two"].curves
    assert (area.title, area.x_label, area.y_label) == ("product", "p.x", "p.y")
    cells = dict(zip(zip(area.x, area.y, strict=True), area.measured, strict=True))
    assert (
        len(cells) == 30 * 9 and cells[1.5, 4.5] == 0.0
    )  # one of each cell, the wrong one for sure
    assert min(area.x) < 1.04 and max(area.x) > 1.96 and {*area.y} == {4 + n / 8 for n in range(9)}
    assert "11 outside" in (tests.path / "out/cases/test-light.html").read_text()
    assert 'class="dots is-outside"' in (tests.path / "out/index.html").read_text()
    (wrong,) = found["test_wrong"].expectations
    assert wrong.kind == "formula" and wrong.worst is not None and wrong.line == 14
    (searched,) = found["test_searched"].expectations
    assert searched.kind == "given" and "@glsl.example(x=" in searched.message
    (own,) = found["test_asserts"].expectations
    assert own.kind == "test" and "light.same(1.0) == 2.0" in own.message
    assert [s.files for s in found["test_wrong"].programs] == [("light.glsl",)]
    page = (tests.path / "out" / "cases" / "test-light.html").read_text()
    assert "test_wrong" in page and "half_of" in page and ">Compilers<" not in page
    places = {(f.rule, f.file, f.line) for f in collect_findings(store.load(tests.path / "out"))}
    assert places >= {("formula", "test_light.py", 14), ("test", "test_light.py", 20)}


def test_a_session_without_such_tests_has_no_report(tmp_path: Path) -> None:
    def about() -> dict[str, str]:
        raise AssertionError("no device is asked for")

    said: list[str] = []
    writer = ReportWriter(tmp_path / "out", about)
    writer.pytest_sessionfinish()
    writer.pytest_terminal_summary(SimpleNamespace(write_line=said.append))
    assert said == ["no test of cases or of GLSL functions: no report is written"]
    assert not (tmp_path / "out").exists()
