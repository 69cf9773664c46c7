"""The front page knows earlier runs: what changed, and how headroom and time went."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from shaderlab.model.records import Record, Run
from shaderlab.report import html
from shaderlab.report.comparison import (
    LONGEST_HISTORY,
    SUMMARY_NAME,
    compare_with_past,
    save_summary,
)
from tests.unit.test_report_samples import HOSTILE, INF, Page, outcome, record, run, worst


def judged(id: str, widths: float = 0.25, *, variant: str = "default", **changes: object) -> Record:
    found = outcome(worst=replace(worst(0.49991), widths=widths, ulp=3.0))
    return record(id, variant, expectations=(found,), size=64, **changes)


def at(day: int, *records: Record, **changes: object) -> Run:
    return run(*records, started=f"2026-11-{day:02}T10:00:00+00:00", **changes)


def kept(folder: Path, day: int, *records: Record, **changes: object) -> None:
    made = folder / f"run-{day}"
    made.mkdir(parents=True)
    save_summary(at(day, *records, **changes), made)


def test_what_changed_is_told_against_the_last_run_of_each_variant(tmp_path: Path) -> None:
    kept(tmp_path, 1, judged("a"), judged("b"), judged("c", 0.5))
    kept(tmp_path, 2, judged("a"))
    now = at(3, judged("a"), judged("b", INF, status="fail"), judged("c", 0.75), judged("new"))
    past = compare_with_past(now, tmp_path / "run-3", {})
    assert (
        past is not None and past.known == 3 and [r.name for r in past.runs] == ["run-2", "run-1"]
    )
    found = [(c.id, c.verdict_changed, c.before.widths, c.after.widths) for c in past.changes]
    assert found == [("b", True, 0.25, INF), ("c", False, 0.5, 0.75)]
    assert {change.when.name for change in past.changes} == {"run-1"}


def test_headroom_and_time_are_those_of_the_whole_case(tmp_path: Path) -> None:
    def case(*widths: float, seconds: float = 1.0) -> list[Record]:
        return [judged("a", w, variant=f"v{n}", seconds=seconds) for n, w in enumerate(widths)]

    kept(tmp_path, 1, *case(0.25, 0.5, seconds=2.0))
    kept(tmp_path, 2, *case(0.25))  # one of its variants alone is no point
    past = compare_with_past(at(3, *case(0.75, 2.0)), tmp_path / "run-3", {})
    assert past is not None
    trend = past.trends["a"]
    assert trend.headroom == (0.5, 0.0) and trend.seconds == (4.0, 2.0)
    assert trend.path("headroom", 60, 14) == "M0.0 7.0L60.0 14.0"
    assert trend.path("seconds", 60, 14) == "M0.0 0.0L60.0 7.0"


@pytest.mark.parametrize(
    "other",
    [
        {"driver": {"renderer": "another"}},
        {"replaced": {"a.frag": "mine.frag"}},
        {"started": "2026-11-04T10:00:00+00:00"},  # later than this one
    ],
)
def test_runs_that_are_not_alike_are_not_compared(tmp_path: Path, other: dict[str, object]) -> None:
    (tmp_path / "other").mkdir()
    save_summary(replace(at(1, judged("a", 0.5)), **other), tmp_path / "other")  # type: ignore[arg-type]
    now = at(3, judged("a"))
    assert compare_with_past(now, tmp_path / "run-3", {}) is None
    save_summary(at(1, replace(judged("a", 0.5), size=32)), tmp_path / "other")
    assert compare_with_past(now, tmp_path / "run-3", {}) is None
    save_summary(at(1, judged("a", 0.5)), tmp_path / "other")
    assert compare_with_past(now, tmp_path / "run-3", {}) is not None


@pytest.mark.parametrize("text", ["", "[]", "{", "null", '{"cases": 1}', '{"cases": {"a": [1]}}'])
def test_what_is_no_summary_is_passed_over(tmp_path: Path, text: str) -> None:
    kept(tmp_path, 1, judged("a"))
    (tmp_path / "damaged").mkdir()
    good = json.loads((tmp_path / "run-1" / SUMMARY_NAME).read_text())
    (tmp_path / "damaged" / SUMMARY_NAME).write_text(text)
    past = compare_with_past(at(3, judged("a")), tmp_path / "run-3", {})
    assert past is not None and len(past.runs) == 1
    wrong = good | {"cases": {"a": {"default": ["<b>", 0.1, 1, 64]}}}
    (tmp_path / "damaged" / SUMMARY_NAME).write_text(json.dumps(wrong))
    past = compare_with_past(at(3, judged("a")), tmp_path / "run-3", {})
    assert past is not None and len(past.runs) == 1


def test_the_pages_show_it_and_only_a_few_runs(tmp_path: Path) -> None:
    for day in range(1, 25):
        kept(tmp_path, day, judged("a", 0.5))
    front = html.write(at(25, judged("a", 0.125)), tmp_path / "run-25")
    page = Page(front)
    words = page.words()
    assert "1 of 1 variant from earlier runs has a different verdict or distance" in words
    assert "0.5 0.125" in words and f"{LONGEST_HISTORY - 1} earlier runs" in words
    assert words.count("headroom 88 %") == 1
    assert "headroom 88 %" in Page(front.parent / "cases" / "a.html").words()
    again = Page(html.write(at(26, judged("a", 0.125)), tmp_path / "run-26"))
    assert "no verdict or distance has changed" in again.words()
    assert "Since the last run" not in Page(html.write(run(judged("b")), tmp_path / "x")).words()


def test_names_of_folders_stay_text(tmp_path: Path) -> None:
    folder = tmp_path / HOSTILE.replace("/", "").replace("\x00", "").replace("\udc80", "")
    folder.mkdir()
    save_summary(at(1, judged(HOSTILE, 0.5)), folder)
    page = Page(html.write(at(2, judged(HOSTILE)), tmp_path / "run"))
    assert "onerror=alert(1)" in page.words()
    assert not [tag for tag, attrs in page.tags if "onerror" in attrs]
