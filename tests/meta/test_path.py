"""The way through the course: every lesson once, nothing assumed before it comes, and Chinese."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from tests.catalogue import shipped


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
