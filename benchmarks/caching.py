"""What the compile cache saves: `python -m benchmarks.caching [--programs N] [--rounds N]`.

Each round prepares the same small programs three times, each time in a new process: without a
cache, with an empty cache, and with a full one. Shows the processor time of each process's first
program, which includes loading the compilers if they are needed, and of each further program:
median and minimum of the rounds, in milliseconds.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

from benchmarks import running_programs

REPOSITORY = Path(__file__).resolve().parent.parent
WAYS = ("no cache", "empty cache", "full cache")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", type=int, default=60)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--inside", type=Path, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.inside:
        print(json.dumps(prepared(asked.inside, asked.programs)))
        return
    times: dict[str, list[list[float]]] = {way: [] for way in WAYS}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        running_programs.write(folder / "programs", asked.programs, 64)
        for _ in range(asked.rounds):
            shutil.rmtree(folder / "cache", ignore_errors=True)
            for way in WAYS:
                cache = "" if way == "no cache" else str(folder / "cache")
                times[way].append(measured(folder / "programs", asked.programs, cache))
    show(times)


def measured(programs: Path, count: int, cache: str) -> list[float]:
    """Processor seconds of the first program and of each further one, in a new process."""
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "benchmarks.caching",
            "--inside",
            programs,
            "--programs",
            str(count),
        ],
        env={**os.environ, "PYTHONPATH": str(REPOSITORY), "SHADERLAB_CACHE_DIR": cache},
        cwd=REPOSITORY,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    found: list[float] = json.loads(done.stdout)
    return found


def prepared(folder: Path, count: int) -> list[float]:
    """The same in this process."""
    import shaderlab.engine.run  # noqa: F401  a run has imported it before it compiles
    from shaderlab import fullscreen
    from shaderlab.compiler import Shaders
    from shaderlab.compiler.compile_cache import cached_compiler
    from shaderlab.drivers.programs.prepare import Preparer

    uniforms = {"gain": running_programs.GAIN}
    names = [f"light_{index}.frag" for index in range(count)]
    draws = [fullscreen(name, uniforms=uniforms)[0].draws[0] for name in names]
    preparer = Preparer(Shaders([folder]), cached_compiler())
    times = [time.process_time()]
    for draw in draws:
        assert preparer.prepare(draw).interface.varyings
        times.append(time.process_time())
    return [times[1] - times[0], (times[-1] - times[1]) / (count - 1)]


def show(times: Mapping[str, list[list[float]]]) -> None:
    """A row for each way."""
    print(f"{'':<14} {'first program':>20} {'each further one':>20}   ms: median, minimum")
    for way, rounds in times.items():
        cells = ""
        for column in zip(*rounds, strict=True):
            middle, least = statistics.median(column) * 1e3, min(column) * 1e3
            cells += f" {middle:>11.2f} {least:>8.2f}"
        print(f"{way:<14}{cells}")


if __name__ == "__main__":
    main()
