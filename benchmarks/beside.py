"""What a run costs beside its workers: `python -m benchmarks.beside [--programs N] [--rounds N]`.

Each round runs a few small programs and many, each time in a new command with two workers. Shown is
the processor time of the command alone, in milliseconds, for each program more: in all, and of that
what is written when the last worker is done (the page, run.json). Here one process writes the whole
page. Median, and least, of the rounds.

`python -m benchmarks.beside --page FOLDER` makes the page of a run once more, and shows the
processor time of that.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks import running_programs

REPOSITORY = Path(__file__).resolve().parent.parent
FEW = 5
RUN = """
import json, sys, time
from shaderlab.cli import main, recorded_run
write_report, written = recorded_run.write_report, []
def timed(*asked):
    began = time.process_time()
    try:
        return write_report(*asked)
    finally:
        written.append(time.process_time() - began)
recorded_run.write_report = timed
goal = sys.argv.pop(1)
try:
    main()
finally:
    with open(goal, "w") as file:
        json.dump([time.process_time(), sum(written)], file)
"""
PAGE = """
import json, sys, time
from shaderlab.report import html
from shaderlab.model.store import load
run = load(sys.argv[2])
html.write(run, sys.argv[2])
began = time.process_time()
html.write(run, sys.argv[2])
with open(sys.argv[1], "w") as file:
    json.dump([time.process_time() - began], file)
"""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    if asked.programs <= FEW:
        parser.error(f"--programs: more than {FEW}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if asked.page is not None:
            pages = [measured(PAGE, folder, [str(asked.page)]) for _ in range(asked.rounds)]
            show("the page", [1000 * seconds for (seconds,) in pages])
            return
        for count in (FEW, asked.programs):
            running_programs.write(folder / str(count), count, 64)
            ran(folder, count)  # what programs are compiled to is kept from here on
        rounds = [each(folder, asked.programs) for _ in range(asked.rounds)]
    for what, found in zip(
        ("in all", "written at the end"), zip(*rounds, strict=True), strict=True
    ):
        show(what, found)


def each(folder: Path, programs: int) -> list[float]:
    """Milliseconds for each program more: in all, and of writing."""
    few, many = ran(folder, FEW), ran(folder, programs)
    return [1000 * (b - a) / (programs - FEW) for a, b in zip(few, many, strict=True)]


def ran(folder: Path, count: int) -> list[float]:
    """The command's own seconds over so many programs: in all, and of writing."""
    report = str(folder / f"report-{count}")
    options = ["--no-pictures", "-j", "2", "--report", report]
    return measured(RUN, folder, ["run", str(folder / str(count)), *options])


def measured(code: str, folder: Path, arguments: Sequence[str]) -> list[float]:
    """What `code` writes into the file that is its first argument."""
    goal = folder / "measured.json"
    subprocess.run(
        [sys.executable, "-c", code, str(goal), *arguments],
        env={
            **os.environ,
            "PYTHONPATH": str(REPOSITORY),
            "SHADERLAB_CACHE_DIR": str(folder / "kept"),
        },
        stdout=subprocess.DEVNULL,
        check=True,
    )
    found: list[float] = json.loads(goal.read_text())
    return found


def show(what: str, found: Sequence[float]) -> None:
    """A line of the table."""
    print(f"{what:<20}{statistics.median(found):8.2f} ms  (least {min(found):.2f})", flush=True)


if __name__ == "__main__":
    main()
