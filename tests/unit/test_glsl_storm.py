"""Mutated and random sources: none is lost, none takes the lab down (20,000 of them:
`python -m benchmarks.storm`)."""

from __future__ import annotations

from pathlib import Path

from benchmarks.trees import storm
from shaderlab.compiler.harness import WORK
from shaderlab.workers.pool import WorkerPool
from tests.compiling import compile_glsl

COUNT = 300


def test_every_source_of_a_storm_gets_verdicts(tmp_path: Path, repository: Path) -> None:
    names = []
    for name, data in storm(repository, COUNT, seed=2):
        (tmp_path / name).write_bytes(data)
        names.append(name)
    with WorkerPool(WORK) as pool:
        results = list(compile_glsl([tmp_path], workers=pool))
    assert [Path(result.path).name for result in results] == names
    accepted = sum(result.ok for result in results)
    assert COUNT // 20 < accepted < COUNT // 2
    for result in results:
        assert len(result.verdicts) == 3
        for verdict in result.verdicts:
            errors = [d for d in verdict.diagnostics if d.severity == "error"]
            assert verdict.ok is (not errors)
            assert all(d.file for d in verdict.diagnostics)
