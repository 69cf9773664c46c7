"""`run --scheduler` on a real Dask cluster of two worker processes, one of which gets killed."""

from __future__ import annotations

import contextlib
import csv
import json
import os
import shutil
import signal
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner, Result

from shaderlab.cli import cli, cluster, cluster_worker
from shaderlab.cli.cluster import DaskExecutor
from shaderlab.engine import jobs
from shaderlab.engine.jobs import Job
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.model import store
from shaderlab.model.options import Limits, RunOptions
from tests.gpu import faulty

distributed = pytest.importorskip("distributed")

WAITING = """\
import time
from pathlib import Path
from shaderlab import Case, Variant, formula, fullscreen
from neighbour import scaled

def factor(reach):
    time.sleep(0.1)
    return scaled(reach)

case = Case(
    title="Takes its time",
    passes=fullscreen("slow.frag", uniforms={"reach": 1.0}),
    variants=[Variant(f"{n}", {"reach": float(n)}) for n in range(6)],
    expect=[formula("factor", factor)],
)
"""
SLOW = """#version 330 core
in vec2 TexCoords; uniform float reach; out float factor;
void main() { factor = reach * 0.5; }
"""


@pytest.fixture(scope="module")
def dask() -> Iterator[Any]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0"
    ) as made:
        yield made


@pytest.fixture
def slow(tmp_path: Path) -> Path:
    folder = tmp_path / "slow_cases"
    folder.mkdir()
    (folder / "slow.py").write_text(WAITING)
    (folder / "neighbour.py").write_text("def scaled(x):\n    return x * 0.5\n")
    (folder / "slow.frag").write_text(SLOW)
    return folder / "slow.py"


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Result]:
    monkeypatch.chdir(tmp_path)
    return lambda *args: CliRunner().invoke(cli, ["run", *map(str, args)], catch_exceptions=False)


def jobs_of(file: Path) -> list[Job]:
    return [Job(file=str(file), id="slow", variant=str(n)) for n in range(6)]


def timeless(value: Any) -> Any:
    """JSON without what no two runs have in common."""
    if isinstance(value, dict):
        return {k: timeless(v) for k, v in value.items() if k not in ("seconds", "timings")}
    return [timeless(v) for v in value] if isinstance(value, list) else value


def test_records_and_pictures_are_those_of_a_local_run(
    dask: Any, call: Callable[..., Result], case_folder: Path
) -> None:
    faulty.write(case_folder, "deadly", before=faulty.in_draw("deadly", "os.kill(os.getpid(), 9)"))
    mine = case_folder / "mine.frag"
    mine.write_text((case_folder / "lamp.frag").read_text().replace("0.25", "0.26"))
    shared = ("./my_cases", "--shader", f"lamp.frag={mine}", "orange-triangle")
    there = call(*shared, "--scheduler", dask.scheduler_address, "--report", "there")
    here = call(*shared, "--report", "here")
    assert (there.exit_code, here.exit_code) == (1, 1)
    assert "1 passed, 2 failed, 1 crashed" in there.output
    runs = [json.loads(Path(name, "run.json").read_text()) for name in ("there", "here")]
    records = [timeless(run["records"]) for run in runs]
    assert records[0] == records[1]
    assert [record["status"] for record in records[0]] == ["crash", "fail", "fail", "pass"]
    files = [
        {
            p.relative_to(name): p.read_bytes()
            for p in Path(name).rglob("*")
            # What a killed process was writing, on whichever of two attempts.
            if p.is_file() and not p.name.startswith(".") and "deadly" not in p.name
        }
        for name in ("there", "here")
    ]
    assert set(files[0]) == set(files[1])
    pictures = [path for path in files[0] if path.parts[0] in ("images", "spirv")]
    assert len(pictures) > 10
    assert all(files[0][path] == files[1][path] for path in pictures)


def test_a_worker_that_is_lost_costs_no_record_and_none_comes_twice(
    slow: Path, tmp_path: Path
) -> None:
    """On a cluster of its own: the others' workers stay as they are."""
    found = []
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0"
        ) as dask,
        contextlib.closing(
            DaskExecutor(dask.scheduler_address, limits=Limits(seconds=120.0))
        ) as executor,
    ):
        (facts,) = executor.load([slow])
        assert facts.variants == ("0", "1", "2", "3", "4", "5")
        # All that workers need has been sent by now.
        shutil.rmtree(slow.parent)
        options = RunOptions(folder=tmp_path, pictures=False)
        for job, record in executor.run(jobs_of(slow), options):
            if not found:
                os.kill(next(iter(dask.workers.values())).pid, signal.SIGKILL)
            assert record.variant == job.variant
            found.append((job.variant, record.status))
    assert sorted(found) == [(variant, "pass") for variant in "012345"]


def test_of_a_task_that_lost_its_workers_only_the_job_to_blame_is_a_crash(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from distributed.scheduler import KilledWorker

    class Task:
        def __init__(self, remote: Any) -> None:
            self.jobs, self.key = remote, "+".join(job.variant for job in remote)

        def add_done_callback(self, done: Callable[[Task], None]) -> None:
            done(self)

        def result(self, timeout: float) -> Any:
            if "4" in self.key:
                raise KilledWorker(self.key, None, 3)
            records = {
                n: jobs.make_failed_record(job, "pass", "") for n, job in enumerate(self.jobs)
            }
            plain = {number: store.to_plain(record) for number, record in records.items()}
            return cluster_worker.RemoteResult(records=plain, files={}, frames={})

        def release(self) -> None:
            asked.append(self.key)

    asked: list[str] = []
    executor = object.__new__(DaskExecutor)
    monkeypatch.setattr(executor, "about", lambda: None, raising=False)
    monkeypatch.setattr(executor, "_submit", lambda *given, **_: Task(given[2]))
    monkeypatch.setattr(executor, "_remote", lambda some, options: [some])
    monkeypatch.setattr(
        executor, "_together", lambda all_of_them: [all_of_them[:3], all_of_them[3:]]
    )
    ran = executor.run(jobs_of(Path("slow.py")), RunOptions())
    found = {job.variant: (record.status, record.message) for job, record in ran}
    assert asked == ["0+1+2", "3+4+5", "3", "4", "5"]
    assert found.pop("4") == ("crash", "every Dask worker that ran it was lost")
    assert found == dict.fromkeys("01235", ("pass", ""))


def test_many_jobs_share_a_task_and_each_thread_gets_several() -> None:
    executor = object.__new__(DaskExecutor)
    executor._client = SimpleNamespace(nthreads=lambda: {"one": 1, "two": 1})
    many = [Job(file="slow.py", id="slow", variant=f"{n}") for n in range(1000)]
    tasks = list(executor._together([*many, replace(many[0], driver="softpipe")]))
    assert [job.variant for some in tasks for job in some] == [f"{n}" for n in range(1000)] + ["0"]
    assert {len(some) for some in tasks[:-2]} == {cluster.TOGETHER} and len(tasks[-1]) == 1
    assert {len(some) for some in executor._together(many[:40])} == {1}


def test_what_a_cluster_compiled_once_it_knows_again(
    case_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = tmp_path / "cache"
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", str(cache))  # the workers inherit it
    near = Job(file=str(case_folder / "lamp.py"), id="lamp", variant="near")
    options = RunOptions(folder=tmp_path / "run", pictures=False)
    kept: list[set[Path]] = []
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, dashboard_address=":0"
    ) as cluster:
        for _ in range(2):
            executor = DaskExecutor(cluster.scheduler_address)
            try:
                assert [record.status for _, record in executor.run([near], options)] == ["pass"]
            finally:
                executor.close()
            kept.append({path for path in cache.rglob("*") if path.is_file()})
    assert kept[0] and kept[0] == kept[1]


def test_a_wrong_file_and_a_hang_are_known_by_their_own_names(
    dask: Any, call: Callable[..., Result], case_folder: Path
) -> None:
    (case_folder / "wrong.py").write_text((case_folder / "lamp.py").read_text() + "\nx = 1 / 0\n")
    faulty.write(case_folder, "endless", before=faulty.in_draw("endless", faulty.HANG))
    result = call("./my_cases", "--timeout", "60", "--no-pictures", "--report", "out",
                  "--scheduler", dask.scheduler_address)  # fmt: skip
    assert "2 passed, 1 in error, 1 timeout" in result.output, result.output
    assert "line 13: ZeroDivisionError" in result.output, result.output
    records = {record["id"]: record for record in faulty.kept(Path("out"))}
    assert records["wrong"]["file"] == "my_cases/wrong.py"
    assert "last step: draw 0" in records["endless"]["message"]
    assert "/shaderlab-" not in result.output


def test_a_run_that_was_cut_short_goes_on_elsewhere(
    dask: Any, call: Callable[..., Result], case_folder: Path
) -> None:
    assert call("./my_cases", "--no-pictures", "--report", "out").exit_code == 0
    journal = Path("out/records.jsonl")
    journal.write_text("".join(journal.read_text().splitlines(keepends=True)[:2]))
    done = call("--resume", "out", "--scheduler", dask.scheduler_address)
    assert done.exit_code == 0 and "2 passed" in done.output
    assert [record["variant"] for record in faulty.kept(Path("out"))] == ["near", "far"]


def test_drivers_are_compared_there_as_they_are_here(
    dask: Any, call: Callable[..., Result], tmp_path: Path
) -> None:
    faulty.write_wave(tmp_path / "waves", "wave")
    shared = ("./waves", "--drivers", "llvmpipe,softpipe", "--size", "16", "--no-pictures")
    there = call(*shared, "--scheduler", dask.scheduler_address, "--json", "there.json")
    here = call(*shared, "--json", "here.json")
    assert (there.exit_code, here.exit_code) == (0, 0), there.output + here.output
    runs = [json.loads(Path(f"{name}.json").read_text()) for name in ("there", "here")]
    found = [(r["driver"], r["driver"] in r["renderer"], r["status"]) for r in runs[0]["drivers"]]
    assert found == [("llvmpipe", True, "pass"), ("softpipe", True, "pass")]
    rows = {row["output"]: row["differing"] for row in runs[0]["disagreements"]}
    assert rows["main.FragColor"] == 0 < rows["main.wave"]
    for key in ("drivers", "disagreements"):
        assert timeless(runs[0][key]) == timeless(runs[1][key])


def test_a_sweep_there_gives_the_table_of_one_here(
    dask: Any, tmp_path: Path, slow: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shared = ["sweep", str(slow), "--param", "reach=0.5,2.0", "--param", "size=8,16", "--report"]
    tables = []
    for name, where in (("there", ["--scheduler", dask.scheduler_address]), ("here", [])):
        done = CliRunner().invoke(cli, [*shared, name, *where], catch_exceptions=False)
        assert done.exit_code == 0, done.output
        with open(Path(name, "sweep.csv"), newline="") as file:
            tables.append(list(csv.DictReader(file)))
    timed = {"seconds", "compile", "link", "draw", "read", "reference", "judge", "picture"}
    values = [[{k: v for k, v in row.items() if k not in timed} for row in t] for t in tables]
    assert values[0] == values[1] and timed < set(tables[0][0])
    assert [(row["reach"], row["size"], row["judged"]) for row in values[0]] == [
        ("0.5", "8", "64"), ("0.5", "16", "256"), ("2.0", "8", "64"), ("2.0", "16", "256"),
    ]  # fmt: skip


def test_other_versions_there_are_refused(dask: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    other = {**cluster.identity(), "numpy": "1.0"}
    monkeypatch.setattr(cluster, "identity", lambda: other)
    with pytest.raises(UsageError, match=r"numpy \d.*here 1\.0") as raised:
        DaskExecutor(dask.scheduler_address)
    assert "same versions" in str(raised.value)


def test_without_a_scheduler_workers_or_dask_it_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 0.3)
    with pytest.raises(UsageError, match="no Dask scheduler answers") as raised:
        DaskExecutor("tcp://127.0.0.1:9")
    assert "dask scheduler" in str(raised.value)
    with pytest.raises(UsageError, match="no scheduler's address"):
        DaskExecutor("nonsense://127.0.0.1:1")
    with (
        distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=":0") as idle,
        pytest.raises(UsageError, match="has no workers"),
    ):
        DaskExecutor(idle.scheduler_address)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match="needs Dask") as missing:
        DaskExecutor("tcp://127.0.0.1:9")
    assert "shaderlab[cluster]" in str(missing.value)


def test_a_cluster_that_goes_away_ends_the_run_with_a_remedy(
    slow: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "LOOK_SECONDS", 0.2)
    found: list[str] = []
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0"
    ) as brief:
        limits = Limits(seconds=120.0)
        executor = DaskExecutor(brief.scheduler_address, limits=limits, patience=0.5)
        options = RunOptions(folder=tmp_path, pictures=False)
        try:
            with pytest.raises(ShaderlabError, match="no workers left") as raised:
                for job, _ in executor.run(jobs_of(slow), options):
                    found.append(job.variant)
                    brief.scale(0)
        finally:
            executor.close()
    assert "--resume" in str(raised.value) and 0 < len(found) < 6


def test_a_bundle_is_made_of_its_content_alone(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name / "reports").mkdir(parents=True)
        (tmp_path / name / "case.py").write_text("x = 1")
        (tmp_path / name / ".hidden").write_text(name)
        (tmp_path / name / "reports" / "index.html").write_text(name)
    first, second = (cluster.pack_folder(tmp_path / name) for name in ("a", "b"))
    assert first == second
    folder = first.unpack(tmp_path)
    assert [p.name for p in folder.iterdir()] == ["case.py"]
    assert replace(first, name="other").unpack(tmp_path) != folder


def test_a_folder_that_is_too_large_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "large").write_bytes(b"x" * 2000)
    monkeypatch.setattr(cluster, "MOST_BYTES", 1000)
    with pytest.raises(UsageError, match="folder of its own"):
        cluster.pack_folder(tmp_path)


def test_nothing_is_written_outside_the_run(tmp_path: Path) -> None:
    said = cluster.write_files({"../evil": b"x"}, tmp_path / "run")
    assert "outside" in said and not (tmp_path / "evil").exists()
