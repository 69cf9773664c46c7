"""The parts of running many scenes: journal, distances, phases, failed jobs."""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path

import numpy as np
import pytest

from shaderlab.cli.compare_drivers import pixel_distances
from shaderlab.cli.options import FILE_NAME
from shaderlab.cli.recorded_run import Journal, RunPlan, read_journal
from shaderlab.engine.jobs import Job, ProcessExecutor, make_failed_record
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.model import store
from shaderlab.model.options import RunOptions
from shaderlab.model.phases import PhaseTimer, phase
from shaderlab.model.records import Record

JOB = Job(file="cases/lamp.py", id="lamp", variant="near", title="A lamp", section="5.1")
PLAN = RunPlan(
    started="2026-01-01",
    options=RunOptions(size=32, folder=Path("out"), shaders={"a.frag": Path("b.frag")}),
    jobs=(JOB,),
)


def test_a_journal_gives_back_what_was_added(tmp_path: Path, failing: Record) -> None:
    with Journal(tmp_path, PLAN) as journal:
        journal.add(failing)
        assert read_journal(tmp_path) == (PLAN, [failing], [])  # while it is still open
    with Journal(tmp_path, None) as journal:
        journal.add(make_failed_record(JOB, "crash", "gone"))
    plan, records, _ = read_journal(tmp_path)
    assert plan == PLAN
    assert [record.status for record in records] == ["fail", "crash"]


def test_a_line_that_was_cut_short_is_dropped(tmp_path: Path, passing: Record) -> None:
    with Journal(tmp_path, PLAN) as journal:
        journal.add(passing)
    with open(tmp_path / FILE_NAME, "ab") as file:
        file.write(b'{"id":"la')
    assert read_journal(tmp_path)[1] == [passing]
    with Journal(tmp_path, None) as journal:
        journal.add(passing)
    assert read_journal(tmp_path)[1] == [passing, passing]


def test_a_damaged_line_costs_its_own_record(tmp_path: Path, passing: Record) -> None:
    with Journal(tmp_path, PLAN) as journal:
        journal.add(passing)
    with open(tmp_path / FILE_NAME, "ab") as file:
        file.write(b'{"id": "cut\n[]\n\xff\n')
    with Journal(tmp_path, None) as journal:
        journal.add(passing)
    assert read_journal(tmp_path) == (PLAN, [passing, passing], [3, 4, 5])
    (tmp_path / FILE_NAME).write_text("{" + (tmp_path / FILE_NAME).read_text("latin-1"))
    with pytest.raises(UsageError, match=r"records.jsonl:1: the first line, which holds"):
        read_journal(tmp_path)


def test_a_journal_is_a_regular_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / FILE_NAME)
    for attempt in (lambda: Journal(tmp_path, PLAN), lambda: read_journal(tmp_path)):
        with pytest.raises(UsageError, match="this is no regular file"):
            attempt()


def test_only_one_run_writes_to_a_journal(tmp_path: Path) -> None:
    pytest.importorskip("fcntl")
    with Journal(tmp_path, PLAN):
        with pytest.raises(UsageError, match="another run"):
            Journal(tmp_path, PLAN)
        assert read_journal(tmp_path)[0] == PLAN
    Journal(tmp_path, PLAN).__exit__(None, None, None)


def test_what_is_no_journal_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no run to resume"):
        read_journal(tmp_path)
    (tmp_path / FILE_NAME).write_text('{"started"')
    with pytest.raises(UsageError, match="this run never began"):
        read_journal(tmp_path)
    (tmp_path / FILE_NAME).write_text(json.dumps({"other": 1}) + "\n")
    with pytest.raises(ShaderlabError, match="not a run of this version"):
        read_journal(tmp_path)


def test_a_failed_job_says_how_far_it_came() -> None:
    record = make_failed_record(JOB, "timeout", "took too long", step="draw 0", driver="softpipe")
    assert (record.id, record.variant, record.status) == ("lamp", "near", "timeout")
    assert record.message == "took too long\nlast step: draw 0\ndriver: softpipe"


def test_while_debugging_errors_of_workers_carry_their_traceback(
    case_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = case_folder / "lamp.py"
    file.write_text(file.read_text() + "\n1 / 0\n")
    for debugging in ("", "1"):
        monkeypatch.setenv("SHADERLAB_DEBUG", debugging)
        with contextlib.closing(ProcessExecutor(early=False)) as executor:
            (facts,) = executor.load([file])
        assert facts.error is not None and facts.error.line == 13
        notes = "".join(getattr(facts.error, "__notes__", ()))
        assert ("Traceback" in notes and "ZeroDivisionError" in notes) is bool(debugging)


def floats(*values: float) -> np.ndarray:
    return np.array(values, np.float32).reshape(1, -1, 1)


NEXT = float(np.nextafter(np.float32(1), np.float32(2)))
TINY = float(np.finfo(np.float32).smallest_subnormal)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        (floats(1.0, 2.0), floats(1.0, 2.0), (0, 0.0)),
        (floats(1.0, 2.0), floats(NEXT, 2.0), (1, 1.0)),
        (floats(0.0), floats(-0.0), (0, 0.0)),
        (floats(TINY), floats(-TINY), (1, 2.0)),
        (floats(np.nan), floats(np.nan), (0, 0.0)),
        (floats(np.nan, 1.0), floats(1.0, 1.0), (1, np.inf)),
        (np.array([[[1, 2]]]), np.array([[[4, 2]]]), (1, 3.0)),
        (np.array([[[255]]], np.uint8), np.array([[[0]]], np.uint8), (1, 255.0)),
    ],
)
def test_distance_of_two_drivers(a: np.ndarray, b: np.ndarray, expected: tuple[int, float]) -> None:
    steps = pixel_distances(a, b)
    assert (int((steps > 0).sum()), float(steps.max())) == expected


def test_each_moment_counts_for_one_phase(monkeypatch: pytest.MonkeyPatch) -> None:
    steps: list[str] = []
    ticks = iter([0.0, 2.0, 7.0, 10.0, 20.0, 21.0])  # draw, link in it, link's end, draw's end, …
    monkeypatch.setattr("shaderlab.model.phases.time.perf_counter", lambda: next(ticks))
    with PhaseTimer(steps.append) as timer:
        with phase("draw", "outside"), phase("link", "inside"):
            pass
        with phase("link"):
            pass
    assert list(timer.timings().items()) == [("link", 6.0), ("draw", 5.0)]
    assert steps == ["outside", "inside"]


def test_without_anyone_watching_nothing_is_counted() -> None:
    with phase("draw", "unheard"):
        pass
    assert PhaseTimer().timings() == {}


def test_a_run_that_begins_leaves_no_page_of_an_earlier_one(tmp_path: Path) -> None:
    for name in ("index.html", "run.json"):
        (tmp_path / name).write_text("1 passed")
    with Journal(tmp_path, PLAN):
        assert [path.name for path in tmp_path.iterdir()] == [FILE_NAME]


def test_a_power_cut_costs_the_last_second(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[int] = []
    monkeypatch.setattr("os.fsync", lambda _: synced.append((tmp_path / FILE_NAME).stat().st_size))
    clock = iter(range(100))
    monkeypatch.setattr("time.monotonic", lambda: next(clock) * 0.7)
    with Journal(tmp_path, PLAN) as journal:
        for _ in range(4):
            journal.add(PLAN)
        assert len(synced) >= 2
    assert synced[-1] == (tmp_path / FILE_NAME).stat().st_size


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a":' * 100_000, "[" * 9999 + "]" * 9999])
def test_deep_json_is_damage_by_its_name(tmp_path: Path, text: str) -> None:
    (tmp_path / FILE_NAME).write_text(text + "\n")
    (tmp_path / "run.json").write_text(text)
    for read in (read_journal, store.load):
        with pytest.raises(ShaderlabError) as raised:
            read(tmp_path)
        assert str(tmp_path) in str(raised.value) and raised.value.remedy
