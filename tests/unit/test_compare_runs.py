"""The comparison of two runs: records but for times, pictures to the byte."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.compare_runs import main

RECORD: dict[str, Any] = {
    "id": "lamp",
    "variant": "near",
    "status": "pass",
    "seconds": 1.5,
    "timings": {"draw": 0.5},
    "expectations": [
        {"name": "colour", "kind": "formula", "judged": 64, "worst": {"ulp": 0.5}},
        {
            "name": "cost",
            "kind": "cost",
            "values": [
                {
                    "measured": "3 draw calls, 0.27 ms",
                    "note": "1.53 × the fastest: 0.77 at 1, 1.8 at 16",
                }
            ],
        },
    ],
}


@pytest.fixture
def runs(tmp_path: Path) -> Any:
    """Writes two runs' records, and runs the command with some options."""

    def compared(before: list[Any], after: list[Any], *options: str) -> int:
        for name, cases in (("before", before), ("after", after)):
            (tmp_path / f"{name}.json").write_text(json.dumps({"cases": cases}), encoding="utf-8")
        return main([str(tmp_path / "before.json"), str(tmp_path / "after.json"), *options])

    return compared


def changed(*path: Any, to: Any) -> dict[str, Any]:
    """The record with one field changed."""
    record = copy.deepcopy(RECORD)
    *parents, last = path
    inner: Any = record
    for step in parents:
        inner = inner[step]
    inner[last] = to
    return record


@pytest.mark.parametrize(
    "same",
    [
        RECORD,
        changed("seconds", to=9.0),
        changed("timings", "draw", to=9.0),
        changed("expectations", 1, "values", 0, "measured", to="3 draw calls, 12.1 ms"),
        changed(
            "expectations", 1, "values", 0, "note", to="1.00 × the fastest: 0.79 at 1, 2.1 at 16"
        ),
    ],
)
def test_times_do_not_count(runs: Any, same: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert runs([RECORD], [same]) == 0
    assert capsys.readouterr().out == "1 records: equal\n"


@pytest.mark.parametrize(
    ("other", "line"),
    [
        (changed("status", to="fail"), 'lamp near: status: "pass" → "fail"'),
        (
            changed("expectations", 0, "worst", "ulp", to=0.75),
            "lamp near: expectations: [0] worst: ulp: 0.5 → 0.75",
        ),
        (
            changed("expectations", 1, "values", 0, "measured", to="4 draw calls, 0.27 ms"),
            'lamp near: expectations: [1] values: [0] measured: "3 draw calls, …" → '
            '"4 draw calls, …"',
        ),
        (changed("note", to="new"), "lamp near: note: only in the second run"),
        (changed("variant", to="far"), "lamp far: only in the second run"),
    ],
)
def test_all_else_does(
    runs: Any, other: Any, line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert runs([RECORD], [other]) == 1
    assert capsys.readouterr().out.splitlines()[0] == line


def test_named_fields_are_ignored(runs: Any) -> None:
    assert runs([RECORD], [changed("status", to="fail")], "--ignore", "status") == 0


def test_a_run_of_some_cases_is_compared_with_one_of_all(runs: Any) -> None:
    both = [RECORD, changed("id", to="moon")]
    assert runs(both, [RECORD]) == 1
    assert runs(both, [RECORD], "--some") == 0


def test_pictures_are_compared_to_the_byte(
    runs: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for report in ("old", "new"):
        (tmp_path / report / "images").mkdir(parents=True)
        (tmp_path / report / "images" / "lamp--near--picture.png").write_bytes(b"\x89PNG")
    (tmp_path / "old" / "images" / "moon--near--picture.png").write_bytes(b"\x89PNG")
    folders = ["--pictures", str(tmp_path / "old"), str(tmp_path / "new")]
    assert runs([RECORD], [RECORD], *folders) == 1
    assert "moon--near--picture.png: only in the first report" in capsys.readouterr().out
    assert runs([RECORD], [RECORD], *folders, "--some") == 0
    assert capsys.readouterr().out == "1 records, 1 pictures: equal\n"
    (tmp_path / "new" / "images" / "lamp--near--picture.png").write_bytes(b"\x89PNX")
    assert runs([RECORD], [RECORD], *folders, "--some") == 1
    assert "lamp--near--picture.png: differs" in capsys.readouterr().out
