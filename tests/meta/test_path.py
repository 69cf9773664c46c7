"""The way through the course: every lesson once, nothing assumed before it comes, and Chinese."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab.engine.catalogue import chapter_title, place_of
from shaderlab.model import pictures
from shaderlab.report import html
from tests.catalogue import shipped
from tests.unit.test_report_samples import Page, outcome, record, run


@pytest.fixture(scope="module")
def course(repository: Path) -> dict[str, Any]:
    return tomllib.loads((repository / "cases" / "cases.toml").read_text(encoding="utf-8"))


def test_every_lesson_is_on_the_path_once(course: dict[str, Any]) -> None:
    path = [id for stage in course["path"] for id in stage["lessons"]]
    assert sorted(path) == sorted(shipped())


def test_what_a_lesson_assumes_comes_before_it(course: dict[str, Any]) -> None:
    before: set[str] = set()
    for stage in course["path"]:
        for id, lesson in stage["lessons"].items():
            assert set(lesson["assumes"]) <= before, id
            assert lesson["assumes"] or not before or id == "double-buffer", id
            before.add(id)


def test_a_reason_can_follow_because(course: dict[str, Any]) -> None:
    stages = course["path"]
    lessons = [lesson for stage in stages for lesson in stage["lessons"].values()]
    for because in (each["because"] for each in (*stages, *lessons)):
        assert not re.match(r"(and|or|but|which|in|because|[A-Z])\b", because), because
        assert 15 < len(because) <= 75 and because[-1] != ".", because


def test_every_title_is_there_in_chinese(course: dict[str, Any]) -> None:
    titles = [title for _, title in course["sections"].values()]
    titles += [stage["title_zh"] for stage in course["path"]]
    titles += [each["title_zh"] for stage in course["path"] for each in stage["lessons"].values()]
    latin = {title for title in titles if not re.search("[\u4e00-\u9fff]", title)}
    assert latin == {"Uniform", "GLM"}
    assert {case.section for case in shipped().values()} <= set(course["sections"])


def test_the_front_page_of_the_whole_course_is_light(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a learner loads it: 150 kB and 2,500 elements at most."""
    image = "images/case--default--picture.png"
    (tmp_path / "images").mkdir()
    pictures.save_png(tmp_path / image, np.zeros((4, 4, 3), np.uint8))
    lessons = [
        record(
            case.id, title=case.title, section=case.section, lesson=case.lesson,
            chapter=chapter_title(case.file, case.section),
            place=place_of(case.file, case.id, case.section),
            expectations=tuple(outcome(name=each.name) for each in case.expect),
            images={"picture": image},
        )
        for case in shipped().values()
    ]  # fmt: skip
    monkeypatch.setattr(html, "_with_neighbours", lambda page: ())  # no pages of cases
    front = html.write(run(*lessons), tmp_path)
    assert len(lessons) >= 113 and front.stat().st_size <= 150_000
    assert 1000 < len(Page(front).tags) <= 2500
