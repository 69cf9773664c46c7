"""The page of gaps in coverage is what its data give, and its explanations are about real lines."""

from __future__ import annotations

import pytest

from benchmarks import coverage_table as made
from tests.catalogue import shipped

ENTRY = {
    "cases": ["skybox"],
    "file": "ch13_skybox/skybox.vert",
    "text": "vec4(aPos, 1.0)",
    "what": "is always 1",
    "why": "an example",
}
GAP = {
    "file": "/x/shaders/ch13_skybox/skybox.vert",
    "line": 13,
    "text": "vec4(aPos, 1.0)",
    "what": "is always 1",
}


def measured(*gaps: dict[str, object], message: str = "") -> list[dict[str, object]]:
    return [{"id": "skybox", "items": 7, "gaps": list(gaps), "message": message}]


def test_the_page_is_what_the_data_give() -> None:
    text, entries = made.PAGE.read_text(encoding="utf-8"), made.load_entries()
    assert text == made.page(text, entries), "run `python -m benchmarks.coverage_table`"
    assert {case for entry in entries for case in entry["cases"]} <= set(shipped())
    missed = sum(len(entry["cases"]) for entry in entries)
    assert f"; {missed} gaps." in text, "run `python -m benchmarks.coverage_table RUN.json`"


def test_what_is_not_explained_is_named() -> None:
    assert made.unexplained(measured(GAP), [ENTRY]) == []
    other = GAP | {"what": "is always 0"}
    assert made.unexplained(measured(GAP, other), [ENTRY]) == [
        "not in coverage-gaps.toml: skybox: ch13_skybox/skybox.vert: vec4(aPos, 1.0): is always 0"
    ]


def test_an_explanation_without_a_gap_is_named() -> None:
    gone = ["no gap: skybox: ch13_skybox/skybox.vert: vec4(aPos, 1.0): is always 1"]
    assert made.unexplained(measured(), [ENTRY]) == gone
    assert made.unexplained(measured(message="no driver"), [ENTRY]) == []


def test_totals() -> None:
    assert made.totals(measured(GAP)) == "6 of 7 items in 1 cases; 1 gaps."
    assert made.totals(measured(message="no driver")).endswith("Not measured: skybox.")


def test_an_expression_that_is_gone_is_named() -> None:
    assert made.line_number(ENTRY["file"], ENTRY["text"]) > 1
    with pytest.raises(LookupError, match=r"skybox\.vert"):
        made.line_number(ENTRY["file"], "no such expression")
