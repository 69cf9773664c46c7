"""How runs grow: `python -m benchmarks.scale [COUNT …]`.

Runs folders of so many small cases (500 and 2,000 by default; 10,000 take minutes), each a shader
of its own with 16 × 16 judged pixels, or as `--size` says: records a second, milliseconds of the
processors for each, the largest process, and the page, made once more.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from benchmarks import running_programs

REPOSITORY = Path(__file__).resolve().parent.parent
HEAD = (
    f"{'cases':>7} {'clock, s':>9} {'records/s':>10} {'processors, ms each':>20} "
    f"{'largest, MiB':>13} {'page, s':>8} {'front page, kB':>15} {'run.json, MB':>13}"
)


class Taken(NamedTuple):
    """Seconds by the clock and of the processors, and MiB of the largest process."""

    clock: float
    processors: float
    largest: float


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("counts", type=int, nargs="*", metavar="COUNT")
    parser.add_argument("--size", type=int, default=16, metavar="PIXELS")
    asked = parser.parse_args()
    counts = asked.counts or [500, 2000]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if counts:
            print(HEAD, flush=True)
        for count in counts:
            grown(folder, count, asked.size)


def grown(folder: Path, count: int, size: int) -> None:
    """A folder of `count` cases, run with their page and without pictures."""
    cases, report = folder / f"cases-{count}", folder / f"report-{count}"
    running_programs.write(cases, count, size)
    taken = lab(folder, "run", str(cases), "--no-pictures", "--report", str(report))
    page = lab(folder, "report", str(report)).processors
    front, run = ((report / file).stat().st_size for file in ("index.html", "run.json"))
    print(
        f"{count:>7} {taken.clock:>9.1f} {count / taken.clock:>10.1f} "
        f"{1000 * taken.processors / count:>20.1f} {taken.largest:>13.0f} {page:>8.2f} "
        f"{front / 1e3:>15.0f} {run / 1e6:>13.1f}",
        flush=True,
    )


def lab(folder: Path, *arguments: str) -> Taken:
    """What a command of the lab takes, with all processes that it starts."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(REPOSITORY),
        "SHADERLAB_CACHE_DIR": str(folder / "kept"),
    }
    began = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "shaderlab", *arguments],
        cwd=folder,
        env=environment,
        stdout=subprocess.DEVNULL,
    )
    _, status, usage = os.wait4(process.pid, 0)
    clock = time.perf_counter() - began
    if status:
        sys.exit(f"shaderlab {' '.join(arguments[:2])} did not pass")
    return Taken(clock, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


if __name__ == "__main__":
    main()
