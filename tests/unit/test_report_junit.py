"""JUnit XML: counts that CI systems add up, and text that any XML reader takes."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from shaderlab.model.records import Outcome, Record, Row, Run, Worst
from shaderlab.report.formats.junit import render

HOSTILE = "]]></failure>&<\x00\x1b\udc80\ufffe\u202e"


def outcome(status: str = "pass", **changes: object) -> Outcome:
    fields: dict[str, object] = {"name": "factor", "kind": "formula", "status": status}
    return Outcome(**(fields | changes))  # type: ignore[arg-type]


def record(id: str, status: str, *outcomes: Outcome, **changes: object) -> Record:
    fields: dict[str, object] = {
        "id": id,
        "variant": "default",
        "title": id,
        "section": "5.1",
        "lesson": "",
        "formula": "",
        "file": f"cases/{id}.py",
        "status": status,
        "seconds": 0.5,
        "expectations": outcomes,
    }
    return Record(**(fields | changes))  # type: ignore[arg-type]


def junit(*records: Record, seconds: float = 2.0) -> ET.Element:
    run = Run(driver={}, versions={}, started="", seconds=seconds, records=records)
    return ET.fromstring(render(run))


def counts(element: ET.Element) -> dict[str, int]:
    names = ("tests", "failures", "errors", *(["skipped"] if element.tag == "testsuite" else []))
    return {k: int(element.attrib[k]) for k in names}


def test_an_interrupted_run_is_an_error() -> None:
    run = Run(
        driver={}, versions={}, started="", seconds=1.0, missing=2,
        records=(record("a", "pass", outcome()),),
    )  # fmt: skip
    root = ET.fromstring(render(run))
    assert counts(root) == {"tests": 2, "failures": 0, "errors": 1}
    (error,) = root.findall(".//error")
    assert error.attrib["message"] == "the run was interrupted: 2 variants not run"


def test_counts_add_up() -> None:
    root = junit(
        record("a", "pass", outcome(), outcome(name="n")),
        record("b", "fail", outcome(), outcome("fail", message="off"), variant="x"),
        record("b", "error", outcome("error"), variant="y"),
        record("c", "crash", message="signal 11"),
        record("d", "timeout", outcome()),
        record("e", "unsupported", message="no 8 samples"),
    )
    assert counts(root) == {"tests": 9, "failures": 1, "errors": 3}
    suites = {suite.attrib["name"]: counts(suite) for suite in root}
    assert suites["b"] == {"tests": 3, "failures": 1, "errors": 1, "skipped": 0}
    assert suites["d"] == {"tests": 2, "failures": 0, "errors": 1, "skipped": 0}
    for name in ("tests", "failures", "errors"):
        assert counts(root)[name] == sum(counts(suite)[name] for suite in root)
    assert len(root.findall(".//testcase")) == 9
    assert len(root.findall(".//failure")) == 1 and len(root.findall(".//error")) == 3
    total = sum(float(test.attrib["time"]) for test in root.findall(".//testcase"))
    assert abs(total - 3.0) < 1e-3


def test_no_two_tests_have_one_name() -> None:
    root = junit(
        record("a", "pass", outcome(), outcome(), outcome(name="factor (2)"), outcome()),
        record("a", "crash", outcome(name="run"), variant="b"),
        record("a", "pass", outcome(name="x: y"), variant="b"),
        record("a", "pass", outcome(name="y"), variant="b: x"),
    )
    names = [(t.attrib["classname"], t.attrib["name"]) for t in root.iter("testcase")]
    assert len(names) == len(set(names)) == 8
    assert names[:2] == [("a", "default: factor"), ("a", "default: factor (2)")]


def test_a_failure_that_no_expectation_explains_is_a_test_of_its_own() -> None:
    root = junit(record("a", "fail", outcome(), message="refused by glslang\nline 3"))
    test = next(t for t in root.iter("testcase") if t.find("failure") is not None)
    failure = test.find("failure")
    assert test.attrib["name"] == "default: run" and failure is not None
    assert failure.attrib["message"] == "refused by glslang" and "line 3" in (failure.text or "")


def test_a_case_without_expectations_counts_as_one_test() -> None:
    assert counts(junit(record("a", "pass")))["tests"] == 1


def test_details_help_without_the_report() -> None:
    worst = Worst(
        pixel=(3, 4),
        component=0,
        measured=(0.75,),
        reference=(0.5,),
        low=(float("-inf"),),
        high=(0.6,),
        ulp=9.0,
        widths=float("nan"),
        inputs={"distance": (2.0,)},
    )
    row = Row(label="F(7)", expected=".01", measured=".02", ok=False)
    bad = outcome("fail", judged=10, outside=2, worst=worst, rows=(row,))
    text = junit(record("a", "fail", bad)).findtext(".//failure") or ""
    for seen in ("2 of 10", "(3, 4)", "0.75", "distance = 2", "F(7): expected .01, measured .02"):
        assert seen in text, seen


def test_any_string_makes_a_file_that_parses() -> None:
    bad = outcome("fail", name=HOSTILE, message=HOSTILE)
    hostile = record(
        HOSTILE, "crash", bad, message=HOSTILE, variant=HOSTILE, file=HOSTILE, seconds=float("nan")
    )
    root = junit(hostile, seconds=float("inf"))
    assert counts(root) == {"tests": 2, "failures": 1, "errors": 1}
    assert "]]></failure>&<" in (root.findtext(".//failure") or "")
