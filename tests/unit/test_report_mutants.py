"""The results of mutation testing on the page."""

import json
from pathlib import Path

import pytest

from shaderlab.errors import ShaderlabError
from shaderlab.model.records import ProgramRecord, SourceText
from shaderlab.report.page import (
    MUTATION_NAME,
    combine_mutants,
    load_mutants,
    merge_mutants,
)
from tests.unit.test_report_samples import record, run, write

SURVIVOR = {
    "file": "lamp.frag", "line": 3, "operator": "constant", "before": "1.0", "after": "<b>1.01",
    "program": ["post.vert", "lamp.frag"],
}  # fmt: skip


def case(name: str, killed: int, *survived: dict[str, object]) -> dict[str, object]:
    return {"id": name, "killed": killed, "survived": list(survived), "score": None}


def put(folder: Path, *cases: dict[str, object]) -> None:
    folder.mkdir(exist_ok=True)
    (folder / MUTATION_NAME).write_text(json.dumps({"cases": cases}))


def test_a_run_without_results_has_none(tmp_path: Path) -> None:
    assert load_mutants(tmp_path) == {}
    assert combine_mutants([]) is None
    page = write(run(record("lamp", "default")), tmp_path).read_text(encoding="utf-8")
    assert "Mutants killed" not in page


def test_results_are_counted_together_and_survivors_shown_at_their_lines(tmp_path: Path) -> None:
    text = "#version 330 core\nuniform float a;\nFragColor = a;\n"
    source = SourceText(file="lamp.frag", line=1, language="glsl", text=text)
    program = ProgramRecord(files=("lamp.frag",), sources=(source,), verdicts=())
    put(tmp_path, case("lamp", 45, SURVIVOR), case("gone", 7), case("blend", 4))
    both = run(record("lamp", "default", programs=(program,)), record("blend", "default"))
    page = write(both, tmp_path).read_text(encoding="utf-8")
    assert "of 50 planted mistakes in 2 cases" in page and "98 %" in page.replace("\u202f", " ")
    assert "<b>45</b> of 46 mistakes" in page and "1 mistake that no check detects" in page
    assert "&lt;b&gt;1.01" in page and "<b>1.01" not in page
    row = page[page.index("lamp.frag:3") - 200 :][:260]
    assert 'href="#' in row and "-L3" in row and "<td>post.vert + lamp.frag</td>" in row


def test_of_a_case_in_two_campaigns_the_later_stands() -> None:
    old = {"cases": [case("a", 1), case("b", 2)]}
    new = {"cases": [case("b", 3), case("c", 4)]}
    kept = merge_mutants(old, new)["cases"]
    assert [(c["id"], c["killed"]) for c in kept] == [("a", 1), ("b", 3), ("c", 4)]


@pytest.mark.parametrize("text", ["", "[]", '{"cases": [{"id": "a"}]}', '{"cases": 3}'])
def test_a_damaged_file_is_named(tmp_path: Path, text: str) -> None:
    (tmp_path / MUTATION_NAME).write_text(text)
    with pytest.raises(ShaderlabError, match="no results of shaderlab mutate") as refused:
        load_mutants(tmp_path)
    assert MUTATION_NAME in str(refused.value)
