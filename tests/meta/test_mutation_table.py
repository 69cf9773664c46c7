"""The page of mutation scores is what its data give, and its explanations are about real lines."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import mutation_table as made
from tests.catalogue import shipped

SURVIVOR = {
    "file": "/x/shaders/ch13_skybox/skybox.vert",
    "line": made.line_number(
        "skybox.vert", "gl_Position = (projection * turned * vec4(aPos, 1.0)).xyww;"
    ),
    "operator": "constant + 1 %",
    "before": "vec4(aPos, 1.0)",
    "after": "1.01",
}


def test_the_page_is_what_the_data_give() -> None:
    text = made.PAGE.read_text(encoding="utf-8")
    found = made.page(text, made.load_scores(), made.load_api_scores())
    assert text == found, "run `python -m benchmarks.mutation_table`"


def test_explanations_are_about_lines_that_shaders_have() -> None:
    places = [place for entry in made.load_survivors() for place in made.lines_of(entry)]
    assert len(places) > 50 and all(made.line_number(*place) for place in places)


def test_every_case_has_a_row() -> None:
    assert set(made.load_scores()) == set(shipped())


def test_cases_about_the_api_notice_mistakes_in_its_calls() -> None:
    chapters = ("ch02", "ch08", "ch09", "ch10", "ch11")
    about = {c for c, case in shipped().items() if Path(case.file).parent.name[:4] in chapters}
    rows = made.load_api_scores()
    assert set(rows) == about
    too_low = {c for c, row in rows.items() if row["killed"] < 19 * len(row["survived"])}
    assert not too_low, "less than 95 % of the mistakes in calls are noticed"


def test_counts_of_mistakes_in_calls_become_a_row() -> None:
    case = {"killed": 19, "survived": [SURVIVOR], "equivalent": 2, "no_difference": [SURVIVOR] * 8}
    row = made.api_row_of(case, 3)
    assert row["survived"] == ["vec4(aPos, 1.0) → 1.01"]
    drawn = ["a[0] glDrawArrays(GL_POINTS, 0, 7) → first = 1", "b glDrawArrays(0) → first = 1"]
    table = made.call_table(
        {"a": row, "b": {**row, "survived": drawn}, "c": {**row, "survived": []}}
    )
    assert "Noticed in 3 cases: 95.0 % of 60 mistakes." in table
    assert "| `vec4(aPos, 1.0)` | `1.01` | a |" in table
    assert "| `glDrawArrays` | `first = 1` | b (2) |" in table


def test_counts_of_a_file_become_a_row() -> None:
    unread = SURVIVOR | {"unread": True}
    case = {"killed": 7, "survived": [SURVIVOR, unread, SURVIVOR | {"operator": "state"}],
            "killed_in_state": 3, "equivalent": 0, "no_difference": [SURVIVOR],
            "invalid": 0}  # fmt: skip
    row = {"killed": 4, "survived": 2, "unread": 1, "killed in state": 3, "survived in state": 1}
    assert made.row_of(case, 0, 0) == row
    assert made.row_of(case, 11, 3) == row | {"sample": 11, "seed": 3}
    assert made.row_of(case, 12, 3) == row


def test_the_table_has_the_cases_with_survivors_and_the_sums() -> None:
    row = {"killed": 3, "survived": 1, "unread": 1}
    state = {"killed in state": 2, "survived in state": 1}
    noticed = {"killed": 8, "survived": 0, "unread": 0}
    sampled = row | state | {"sample": 4, "seed": 7}
    table = made.score_table({"a": row, "b": sampled, "c": noticed})
    assert "(of state): a 1/4, b 1/4 (1/3)." in table
    assert "c 0/8" not in table
    assert "all 3 cases: 87.5 % of 16 mistakes in shaders, 66.7 % of 3 mistakes in state" in table
    assert "2 change only what no expectation reads" in table
    assert "1 × `--limit 4 --seed 7`" in table


def test_a_survivor_finds_its_explanation_and_no_other() -> None:
    def about(case: str, survivor: dict[str, object]) -> list[str]:
        known = made.load_survivors()
        return [e["why"] for e in known if made.is_about(e, case, survivor)]

    assert len(about("skybox", SURVIVOR)) == 1
    assert not about("skybox", SURVIVOR | {"line": 1})
    state = {"operator": "state", "before": "scene[0] depth.func='less'", "after": "'lequal'"}
    assert len(about("shadow-map", SURVIVOR | state)) == 1
    assert not about("shadow-map", SURVIVOR | state | {"after": "'greater'"})
    assert not about("cubemap", SURVIVOR | {"operator": "state"})


def test_a_line_that_is_gone_is_named(tmp_path: Path) -> None:
    with pytest.raises(LookupError, match=r"skybox\.vert"):
        made.line_number("skybox.vert", "no such line")
