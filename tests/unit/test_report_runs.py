"""The page of all runs of a folder: one line each, and never in another page's place."""

from __future__ import annotations

import os
from pathlib import Path
from urllib.parse import unquote_to_bytes

import pytest

from shaderlab.model.records import DriverResult, Record, Run
from shaderlab.report import html
from shaderlab.report.comparison import SUMMARY_NAME
from tests.unit.test_report_samples import HOSTILE, Page, record, run


def made(folder: Path, name: str, *records: Record, **changes: object) -> Run:
    found = run(*records, **{"started": "2026-11-01T10:00:00+00:00", **changes})
    html.write(found, folder / name)
    return found


def rows(folder: Path) -> list[str]:
    html.write_run_list(folder)
    page = Page(folder / "index.html")
    links = [link for link in page.attributes("href") if not link.startswith("#")]
    assert all((folder / os.fsdecode(unquote_to_bytes(link))).is_file() for link in links)
    words = page.words()
    return [words, *links]


def test_each_run_has_a_line_the_last_one_first(tmp_path: Path) -> None:
    made(tmp_path, "early", record("a"))
    made(tmp_path, "late", record("a"), record("b", status="fail"),
         started="2026-11-02T10:00:00+00:00")  # fmt: skip
    (tmp_path / "latest").symlink_to("late")
    (tmp_path / "notes").mkdir()
    words, *links = rows(tmp_path)
    assert links == ["late/index.html", "early/index.html"]
    assert "2 cases: 1 passed, 1 failed in 1.5 s" in words and words.count("failed") == 2
    assert words.index("2 November 2026") < words.index("1 November 2026, 10:00")
    (tmp_path / "late" / "index.html").unlink()
    assert rows(tmp_path)[1:] == ["early/index.html"]


def test_an_interrupted_run_did_not_pass(tmp_path: Path) -> None:
    made(tmp_path, "half", record("a"), missing=3)
    words = rows(tmp_path)[0]
    assert "interrupted" in words and "1 passed, 3 not run" in words
    assert words.count("passed") == 1  # no verdict of its own


def test_one_drivers_failure_is_the_runs(tmp_path: Path) -> None:
    other = DriverResult(driver="softpipe", renderer="", id="a", variant="default", status="fail")
    made(tmp_path, "two", record("a"), drivers=(other,))
    assert "failed" in rows(tmp_path)[0]


@pytest.mark.parametrize("text", ["", "[]", "null", '{"started": 1}', '{"status": []}'])
def test_a_damaged_summary_takes_no_other_line(tmp_path: Path, text: str) -> None:
    made(tmp_path, "good", record("a"))
    made(tmp_path, "bad", record("a"))
    (tmp_path / "bad" / SUMMARY_NAME).write_text(text)
    assert rows(tmp_path)[1:] == ["good/index.html"]


def test_names_are_text_and_links_lead_to_them(tmp_path: Path) -> None:
    for name in ("a #1 %20<b>", os.fsdecode(b"b\xff")):
        made(tmp_path, name, record("a"), replaced={HOSTILE: HOSTILE})
    assert rows(tmp_path)[1:] == ["b%FF/index.html", "a%20%231%20%2520%3Cb%3E/index.html"]


def test_another_page_is_left_alone(tmp_path: Path) -> None:
    for words in ("mine", html.write(run(record("a")), tmp_path / "x").read_text()):
        (tmp_path / "index.html").write_text(words)
        html.write_run_list(tmp_path)
        assert (tmp_path / "index.html").read_text() == words
    (tmp_path / "index.html").unlink()
    assert len(rows(tmp_path)) == 2  # and its own is renewed
    assert len(rows(tmp_path)) == 2
