"""The same scene twice gives the same bytes: in one worker, in another one, after other scenes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from shaderlab.engine.jobs import Job, ProcessExecutor
from shaderlab.model import store
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

# Seeded noise as a texture, a domain with figures and curves, meshes with depth and stencil.
CASES = {
    "ch07_maps/light_map.py": "",
    "ch05_lighting/attenuation.py": "50",
    "ch06_tests/stencil_outline.py": "",
}


def timeless(record: Record) -> Any:
    plain = store.to_plain(replace(record, seconds=0.0, timings={}))
    assert plain["expectations"]
    return plain


def files_below(folder: Path) -> dict[str, bytes]:
    found = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}


def drawn(
    executor: ProcessExecutor, jobs: list[Job], folder: Path, size: int = 32
) -> tuple[dict[Any, Any], dict[str, bytes]]:
    places = {"folder": folder / "run", "frames": folder / "frames"}
    options = RunOptions(size=size, picture_size=64, **places)
    records = dict(executor.run(jobs, options)).values()
    return {(r.id, r.variant): timeless(r) for r in records}, files_below(folder)


@pytest.fixture(scope="module")
def runs(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Any]:
    folder = tmp_path_factory.mktemp("runs")
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("LP_NUM_THREADS", raising=False)  # the driver's threads take part
        first, other = ProcessExecutor(), ProcessExecutor()
    try:
        facts = first.load([repository / "cases" / name for name in CASES])
        jobs = [
            Job(file=f.file, id=f.id, variant=variant or f.variants[0])
            for f, variant in zip(facts, CASES.values(), strict=True)
        ]
        return {
            "jobs": jobs,
            "once": drawn(first, jobs, folder / "once"),
            "again": drawn(first, jobs, folder / "again"),
            "elsewhere": drawn(other, jobs[::-1], folder / "elsewhere"),
            "smaller": drawn(other, jobs[1:2], folder / "smaller", size=31),
        }
    finally:
        first.close()
        other.close()


@pytest.mark.parametrize("which", ["again", "elsewhere"])
def test_frames_pictures_and_records_are_the_same(runs: Mapping[str, Any], which: str) -> None:
    records, files = runs["once"]
    others, other_files = runs[which]
    assert others == records
    assert set(other_files) == set(files)
    assert [name for name in files if files[name] != other_files[name]] == []
    assert sum(name.startswith("frames/") for name in files) == len(CASES)
    assert sum(name.endswith(".png") for name in files) > len(CASES)


def test_a_record_says_what_its_values_depend_on(runs: Mapping[str, Any]) -> None:
    for record in runs["once"][0].values():
        renderer, version = record["driver"].split("; ")
        assert renderer and version[0].isdigit()
        assert (record["size"], record["picture_size"]) == (32, 64)


def test_another_size_would_be_noticed(runs: Mapping[str, Any]) -> None:
    (((key, record),), files) = runs["smaller"][0].items(), runs["smaller"][1]
    before, frames = runs["once"][0][key], runs["once"][1].values()
    assert record["size"] == 31 and record["expectations"] != before["expectations"]
    (frame,) = (data for name, data in files.items() if name.startswith("frames/"))
    assert frame not in frames
