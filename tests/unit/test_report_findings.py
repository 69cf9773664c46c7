"""Findings at their file and line, as SARIF."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest
from click.testing import CliRunner

from shaderlab import Case, fullscreen
from shaderlab.cli import cli
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.expectations.driver_answers import coverage
from shaderlab.errors import Diagnostic, Verdict
from shaderlab.model.records import (
    DriverResult,
    Explanation,
    Outcome,
    ProgramRecord,
    Record,
    Run,
    SourceText,
)
from shaderlab.report.findings import WORKSPACE, Finding, collect_findings
from shaderlab.report.formats import sarif

CASE = "\n\ncase = ...\n\nfactor()\n"
# What each object of SARIF 2.1.0 that is written here may have, and must have (OASIS, section 3).
KEYS = {
    "log": ("$schema! version! runs!", "3.13"),
    "run": (
        "tool! automationDetails originalUriBaseIds invocations columnKind results", "3.14",
    ),
    "driver": ("name! rules", "3.19"),
    "rule": ("id! shortDescription!", "3.49"),
    "result": (
        "ruleId ruleIndex level message! partialFingerprints locations relatedLocations", "3.27",
    ),
    "place": ("artifactLocation! region", "3.29"),
    "artifact": ("uri! uriBaseId", "3.4"),
}  # fmt: skip


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(WORKSPACE, raising=False)
    (tmp_path / "lamp.py").write_text(CASE)
    (tmp_path / "lamp.frag").write_text("a\nb = 1;\n")
    return tmp_path


def outcome(**changes: Any) -> Outcome:
    given = {"name": "factor", "kind": "formula", "status": "fail", "message": "off", "line": 5}
    return Outcome(**(given | changes))


def record(*outcomes: Outcome, **changes: Any) -> Record:
    given: dict[str, Any] = {
        "id": "lamp", "variant": "default", "title": "Lamp", "section": "", "lesson": "",
        "formula": "", "file": "lamp.py", "status": "fail", "expectations": outcomes,
    }  # fmt: skip
    return Record(**(given | changes))


def run(*records: Record, **changes: Any) -> Run:
    return Run(driver={}, versions={}, started="", seconds=1.0, records=records, **changes)


def program(*verdicts: Verdict) -> ProgramRecord:
    return ProgramRecord(files=("lamp.frag",), sources=(), verdicts=verdicts)


def places(*records: Record, **changes: Any) -> list[tuple[str, str, int]]:
    return [(f.rule, f.file, f.line) for f in collect_findings(run(*records, **changes))]


def check(log: str) -> dict[str, Any]:
    """The only run of a log that has nothing but what the standard knows."""
    whole = json.loads(log)

    def has(kind: str, value: dict[str, Any]) -> None:
        words = KEYS[kind][0].split()
        assert set(value) <= {word.rstrip("!") for word in words}, kind
        assert {word[:-1] for word in words if word.endswith("!")} <= set(value), kind

    has("log", whole)
    assert whole["version"] == "2.1.0"
    (only,) = whole["runs"]
    has("run", only)
    has("driver", only["tool"]["driver"])
    rules = only["tool"]["driver"]["rules"]
    for rule in rules:
        has("rule", rule)
    for base in only["originalUriBaseIds"].values():
        assert base["uri"].endswith("/")
    for result in only["results"]:
        has("result", result)
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
        assert result["level"] in ("error", "warning", "note")
        related = result.get("relatedLocations", [])
        assert len({json.dumps(one, sort_keys=True) for one in related}) == len(related)
        for location in [*result.get("locations", []), *related]:
            place = location["physicalLocation"]
            has("place", place)
            has("artifact", place["artifactLocation"])
            assert place.get("region", {"startLine": 1})["startLine"] >= 1
    found: dict[str, Any] = only
    return found


def test_a_failing_formula_is_at_the_line_that_explains_it_or_where_it_stands() -> None:
    explained = Explanation(pixel=(0, 0), steps=(), verdict="off", file="lamp.frag", line=2)
    assert places(record(outcome(explanation=explained))) == [("formula", "lamp.frag", 2)]
    assert places(record(outcome())) == [("formula", "lamp.py", 5)]
    assert places(record(outcome(line=0))) == [("formula", "lamp.py", 3)]
    (found,) = collect_findings(run(record(outcome(explanation=explained))))
    assert found.related == (("lamp.py", 5),)


def test_what_passes_or_is_unsupported_is_no_finding() -> None:
    wrong = Diagnostic(file="lamp.frag", line=1, severity="error", message="no")
    refused = program(Verdict(target="driver", ok=False, diagnostics=(wrong,)))
    passed = outcome(status="pass")
    assert places(record(passed, status="pass")) == []
    assert places(record(status="unsupported", programs=(refused,))) == []
    assert places(record(passed, outcome(), passed)) == [("formula", "lamp.py", 5)]


def test_a_compilers_message_is_one_finding_whatever_targets_and_variants_have_it() -> None:
    wrong = Diagnostic(file="lamp.frag", line=2, severity="error", message="no 'x'")
    warned = Diagnostic(file="lamp.frag", line=1, severity="warning", message="hm")
    both = [Verdict(target=t, ok=False, diagnostics=(warned, wrong)) for t in ("glsl", "vulkan")]
    records = [record(variant=v, programs=(program(*both),), status="error") for v in "ab"]
    found = collect_findings(run(*records))
    assert [(f.rule, f.line, f.severity) for f in found] == [
        ("compile-warning", 1, "warning"),
        ("compile-error", 2, "error"),
    ]
    assert found[1].message == "no 'x' [glsl, vulkan]\nalso in b"


def test_what_came_to_no_verdict_is_at_the_place_in_its_message_or_at_the_case() -> None:
    assert places(record(status="error", message="lamp.frag:2: no\n→ mend")) == [
        ("error", "lamp.frag", 2)
    ]
    assert places(record(status="error", message="x.frag:2: gone")) == [("error", "lamp.py", 3)]
    assert places(record(status="timeout", message="30 s")) == [("timeout", "lamp.py", 3)]
    assert places(record(status="crash", file="gone.py")) == [("crash", "gone.py", 1)]


def test_an_interrupted_run_and_another_driver_are_findings() -> None:
    apart = DriverResult(driver="b", renderer="", id="lamp", variant="default", status="fail")
    passed = record(status="pass")
    assert places(passed, drivers=(apart,), missing=2) == [
        ("driver", "lamp.py", 3),
        ("interrupted", "", 0),
    ]
    log = check(sarif.render(run(passed, missing=2)))
    assert log["invocations"] == [{"executionSuccessful": False}]


def test_paths_are_those_of_the_repository(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    subprocess.run(["git", "init", "-q"], check=True)
    (here / "sub folder").mkdir()
    monkeypatch.chdir("sub folder")
    Path("é.frag").write_text("x\n")
    some = [
        Finding(rule="r", file=str(here / "sub folder" / "é.frag"), line=1, message="m"),
        Finding(rule="r", file="é.frag", line=1, message="m"),
        Finding(rule="r", file="/usr/a b.frag", line=1, message="m"),
    ]
    results = check(sarif.render_findings(some, "run"))["results"]
    where = [r["locations"][0]["physicalLocation"]["artifactLocation"] for r in results]
    assert [unquote(one["uri"]) for one in where] == [
        "sub folder/é.frag", "sub folder/é.frag", "file:///usr/a b.frag",
    ]  # fmt: skip
    assert all(" " not in one["uri"] and one["uri"].isascii() for one in where)
    assert [one.get("uriBaseId") for one in where] == ["SRCROOT", "SRCROOT", None]
    monkeypatch.setenv(WORKSPACE, str(here / "sub folder"))
    first = check(sarif.render_findings(some, "run"))["results"][0]["locations"][0]
    assert unquote(first["physicalLocation"]["artifactLocation"]["uri"]) == "é.frag"


def test_fingerprints_stay_where_lines_move_and_figures_change(here: Path) -> None:
    def prints(line: int, *messages: str) -> list[str]:
        some = [Finding(rule="r", file="a.frag", line=line, message=m) for m in messages]
        results = check(sarif.render_findings(some, "run"))["results"]
        return [result["partialFingerprints"]["shaderlab/v1"] for result in results]

    (here / "a.frag").write_text("b = 1;\n")
    before = prints(1, "1 of 4", "the same once more")
    (here / "a.frag").write_text("\n\n    b = 1;\n")
    assert prints(3, "2 of 4", "the same once more") == before
    assert len(set(before)) == 2
    (here / "a.frag").write_text("\n\n    b = 2;\n")
    assert not set(prints(3, "2 of 4")) & set(before)


def test_an_expectation_knows_its_line_whoever_makes_it(here: Path) -> None:
    (here / "helper.py").write_text(
        "from shaderlab import coverage\n\ndef checks():\n    return [coverage(4)]\n"
    )
    (here / "line_case.py").write_text(
        "from shaderlab import Case, coverage, fullscreen\n"
        "from helper import checks\n"
        "case = Case(\n"
        "    title='t',\n"
        "    passes=fullscreen('a.frag'),\n"
        "    expect=[\n"
        "        coverage(\n"
        "            3),\n"
        "        *checks(),\n"
        "    ],\n"
        ")\n"
    )
    case = load_case(here / "line_case.py")
    assert [one.line_in(str(here / "line_case.py")) for one in case.expect] == [7, 9]
    assert case.expect[0].line_in("line_case.py") == 7
    made = coverage(1)
    assert made.line_in(__file__) > 0 and made.line_in("line_case.py") == 0
    assert made == coverage(1)
    assert Case(title="t", passes=fullscreen("a.frag"), expect=[made]).expect[0] is made


def test_compile_writes_sarif(here: Path) -> None:
    (here / "bad.frag").write_text("#version 330 core\nout vec4 c;\nvoid main() { c = vec4(x); }\n")
    command = ["compile", "bad.frag", "--sarif", "out.sarif", "-j", "0"]
    result = CliRunner().invoke(cli, command, catch_exceptions=False)
    assert result.exit_code == 1
    assert "bad.frag:3: error:" in result.output
    log = check((here / "out.sarif").read_text())
    assert [result["ruleId"] for result in log["results"]] == ["compile-error"]
    assert log["automationDetails"] == {"id": "shaderlab/compile/"}


def test_shaders_that_compile_are_no_findings(here: Path) -> None:
    (here / "good.frag").write_text("#version 330 core\nout vec4 c;\nvoid main() { c = vec4(1); }")
    command = ["compile", "good.frag", "--sarif", "-", "-j", "0"]
    result = CliRunner().invoke(cli, command, catch_exceptions=False)
    assert result.exit_code == 0
    assert check(result.stdout)["results"] == []


def test_a_formula_of_a_function_is_related_to_its_sources() -> None:
    source = SourceText(file="lamp.frag", line=2, language="glsl", text="b")
    (found,) = collect_findings(run(record(outcome(sources=(source, source)))))
    assert found.related == (("lamp.frag", 2),)
