"""What running costs, side by side with a hand-written script, pytest, and piglit.

    python -m benchmarks.running [--programs 50] [--size 256] [--tests 500] [--most 500]

Every way runs the same small programs and looks at every pixel (piglit probes three of them).
Each is a process of its own, run three times: the first warms the driver's shader cache, the better
of the others counts. The lab's own cache is switched off but where programs are said to be compiled
before.
The cost of a further program is the difference between many and few, by their number; so what a
process costs once is left out of it. CPU seconds are those of the process and all its children:
on a machine that does other things as well, trust them more than the clock. The lab has as many
workers as it takes by default, but where one is asked for (-j 1).
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from benchmarks import running_piglit, running_programs

HERE = Path(__file__).resolve().parent
FEW = 5


@dataclass(frozen=True)
class Cost:
    """Seconds by the clock and of the processors."""

    wall: float
    cpu: float

    def per(self, other: Cost, count: int) -> Cost:
        """What each of `count` more programs cost than `other`, in seconds."""
        return Cost((self.wall - other.wall) / count, (self.cpu - other.cpu) / count)


def measure(work: Callable[[], object]) -> Cost:
    """The better of two times, after one that does not count."""
    work()
    times = [_measured(work) for _ in range(2)]
    return Cost(min(one.wall for one in times), min(one.cpu for one in times))


def _measured(work: Callable[[], object]) -> Cost:
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    work()
    wall, after = time.perf_counter() - started, resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Cost(wall, used)


def call(*command: str | Path, kept: Path | None = None) -> None:
    """Run a process that must end well; `kept` is where the lab keeps compiled programs."""
    environment = {**os.environ, "PYTHONPATH": str(HERE.parent), "EGL_PLATFORM": "surfaceless"}
    environment["SHADERLAB_CACHE_DIR"] = str(kept or "")
    environment |= {"LIBGL_ALWAYS_SOFTWARE": "1", "GALLIUM_DRIVER": "llvmpipe"}
    done = subprocess.run(
        [str(part) for part in command], env=environment, capture_output=True, text=True
    )
    if done.returncode:
        raise SystemExit(f"{command}: {done.stdout[-2000:]}{done.stderr[-2000:]}")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", type=int, default=50, help="to judge, 0 for none")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--tests", type=int, default=500, help="for piglit, 0 for none")
    parser.add_argument("--most", type=int, default=0, help="also run this many in one command")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if asked.programs:
            further(folder, asked.programs, asked.size)
            fixed(folder)
        if asked.tests:
            piglit(folder, asked.tests, asked.size)
        if asked.most:
            growth(folder, asked.most)


def further(folder: Path, many: int, size: int) -> None:
    """What each further program costs, in each way."""
    ways: dict[str, list[str | Path]] = {
        "by hand, one tolerance": [HERE / "running_by_hand.py"],
        "by hand, same references and bands": [HERE / "running_by_hand.py", "--bands"],
    }
    costs: dict[str, Cost] = {}
    places = {}
    for count in (FEW, many):
        places[count] = folder / f"programs-{count}"
        running_programs.write(places[count], count, size)
    for title, script in ways.items():
        costs[title] = step(
            lambda n, script=script: call(sys.executable, *script, places[n], str(n), str(size)),
            many,
        )
    pytest = (sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider")
    for note, kept in (("", None), (", compiled before", folder / "kept")):
        for title, options in (
            ("shaderlab run", ()),
            ("… --no-pictures", ("--no-pictures",)),
            ("… --no-pictures -j 1", ("--no-pictures", "-j", "1")),
        ):
            costs[title + note] = step(
                lambda n, options=options, kept=kept: lab(
                    places[n], folder / "run", *options, kept=kept
                ),
                many,
            )
        if kept is None:
            shares = phases(folder / "run")
        for title, options in (("pytest", ()), ("pytest, one worker", ("-o", "shaderlab_jobs=1"))):
            costs[title + note] = step(
                lambda n, options=options, kept=kept: call(*pytest, *options, places[n], kept=kept),
                many,
            )
    print(f"each further program of {size}², every pixel judged:")
    fair = list(costs.values())[1]
    for title, cost in costs.items():
        spent = f"{cost.cpu * 1e3:7.1f} ms CPU {cost.cpu / fair.cpu:5.2f}×"
        print(f"  {spent} {cost.wall * 1e3:7.1f} ms {cost.wall / fair.wall:5.2f}×  {title}")
    print(
        "  phases of --no-pictures -j 1:",
        ", ".join(f"{name} {share:.0%}" for name, share in shares.items()),
    )


def step(run: Callable[[int], object], many: int) -> Cost:
    """What one more program costs, of `many`."""
    few, lot = measure(lambda: run(FEW)), measure(lambda: run(many))
    return lot.per(few, many - FEW)


def lab(cases: Path, report: Path, *options: str, kept: Path | None = None) -> None:
    """One command with the report."""
    command = (sys.executable, "-m", "shaderlab", "run", f"{cases}/", "--report", report)
    call(*command, *options, kept=kept)


def phases(report: Path) -> dict[str, float]:
    """The share of each phase in the records' time."""
    records = json.loads((report / "run.json").read_text())["records"]
    total = sum(record["seconds"] for record in records)
    spent: dict[str, float] = {"compile": 0.0, "picture": 0.0}
    for record in records:
        for phase, used in record["timings"].items():
            spent[phase] = spent.get(phase, 0.0) + used / total
    return spent


def fixed(folder: Path) -> None:
    """What a command with one small case costs, and a worker more."""
    running_programs.write(folder / "one", 1, 16)
    for title, kept in (("nothing kept", None), ("compiled before", folder / "kept")):
        cost = measure(lambda kept=kept: lab(folder / "one", folder / "one-run", kept=kept))
        print(f"one small case, {title}: {cost.wall:.2f} s, {cost.cpu:.2f} s CPU")
    running_programs.write(folder / "eight", 8, 16)
    alone, beside = (
        measure(
            lambda j=j: lab(folder / "eight", folder / "eight-run", "-j", j, kept=folder / "kept")
        )
        for j in "12"
    )
    print(f"a second worker: {beside.cpu - alone.cpu:.2f} s CPU")


def piglit(folder: Path, count: int, size: int) -> None:
    """Tests a second of piglit's shader_runner, where there is one."""
    runner = running_piglit.find()
    if runner is None:
        print("piglit is not installed (Debian: apt-get install piglit): not compared")
        return
    files = running_piglit.write(folder / "piglit", count, size)
    running_programs.write(folder / "small", count, 64)
    out = folder / "small-run"
    for title, at_once in (("one process a test", False), ("one process", True)):
        cost = measure(lambda at_once=at_once: running_piglit.run(runner, files, at_once))
        print(f"piglit, {title}: {count / cost.wall:.0f} tests/s, {count / cost.cpu:.0f} per CPU s")
    for title, kept in (("nothing kept", None), ("compiled before", folder / "kept")):
        cost = measure(lambda kept=kept: lab(folder / "small", out, "--no-pictures", kept=kept))
        rate = f"{count / cost.wall:.0f} tests/s, {count / cost.cpu:.0f} per CPU s"
        print(f"shaderlab run --no-pictures at 64², {title}: {rate}")


def growth(folder: Path, most: int) -> None:
    """Time and the parent's memory as the number of cases grows."""
    environment = {**os.environ, "PYTHONPATH": str(HERE.parent), "SHADERLAB_CACHE_DIR": ""}
    for count in (most // 10, most):
        running_programs.write(folder / f"grow-{count}", count, 16)
        started = time.perf_counter()
        done = subprocess.run(
            ["/usr/bin/env", "time", "-f", "%M", sys.executable, "-m", "shaderlab", "run",
             str(folder / f"grow-{count}"), "--report", str(folder / "grow-run")],
            capture_output=True, text=True, env=environment,
        )  # fmt: skip
        spent = time.perf_counter() - started
        peak = done.stderr.strip().splitlines()[-1]
        print(
            f"{count} cases of 16²: {spent:.1f} s, at most {int(peak) / 1024:.0f} MB in one process"
        )


if __name__ == "__main__":
    main()
