"""Mutated and random sources by the thousand: `python -m benchmarks.storm [COUNT] [--seed N]`.

Every one must come back with a verdict. Those on which a compiler crashed or hung are named and
kept in a folder; the exit status is 1 where a result is missing or the lab itself failed.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from shaderlab.compiler.harness import WORK
from shaderlab.model.options import Limits
from shaderlab.workers.pool import WorkerPool
from tests.compiling import compile_glsl

sys.path.insert(0, str(Path(__file__).resolve().parent))
from trees import storm

REPOSITORY = Path(__file__).resolve().parent.parent


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", nargs="?", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--jobs", type=int, default=min(os.cpu_count() or 1, 4))
    given = parser.parse_args()
    kinds: Counter[str] = Counter()
    missing = 0
    with tempfile.TemporaryDirectory() as folder:
        names = []
        for name, data in storm(REPOSITORY, given.count, given.seed):
            (Path(folder) / name).write_bytes(data)
            names.append(name)
        start = time.perf_counter()
        with WorkerPool(WORK, limits=Limits(seconds=given.seconds), jobs=given.jobs) as pool:
            results = compile_glsl([folder], workers=pool)
            for name, result in zip(names, results, strict=False):
                missing += Path(result.path).name != name or len(result.verdicts) != 3
                status = next((v.status for v in result.verdicts if v.status), "")
                kinds[status or ("accepted" if result.ok else "refused")] += 1
                if status:
                    keep(Path(folder) / name, result.verdicts[0].diagnostics[0].message)
        taken = time.perf_counter() - start
    missing += given.count - sum(kinds.values())
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    print(f"{given.count} sources, seed {given.seed}, {taken:.0f} s: {counts}; {missing} missing")
    return 1 if missing else 0


def keep(path: Path, message: str) -> None:
    offenders = Path(tempfile.gettempdir()) / "shaderlab-offenders"
    offenders.mkdir(exist_ok=True)
    (offenders / path.name).write_bytes(path.read_bytes())
    print(f"{offenders / path.name}: {message}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
