"""How fast shaders compile, side by side: `python -m benchmarks.compile [FILES]`.

`--growth` shows instead how time and memory grow from 100 to 10,000 files.
"""

from __future__ import annotations

import argparse
import itertools
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from shaderlab.compiler.harness import WORK
from shaderlab.workers.pool import WorkerPool
from tests.compiling import compile_glsl

sys.path.insert(0, str(Path(__file__).resolve().parent))
from bare import compile_all
from commands import FLAGS, environment, glslang_command
from trees import write_tree

REPOSITORY = Path(__file__).resolve().parent.parent
TARGETS = ("glsl", "opengl", "vulkan")
SHADERLAB = [sys.executable, "-m", "shaderlab", "compile"]


def seconds(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def spent(call: Callable[[], object]) -> tuple[float, float]:
    """The clock's seconds, and processor seconds of all processes started and ended meanwhile."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    clock = seconds(call)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return clock, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def one_process_each(paths: Sequence[Path], folder: Path) -> None:
    """What a script does that knows the command: one process per file and target."""
    glslang, env = glslang_command(), environment()
    for path, target in itertools.product(paths, TARGETS):
        flags = ["-d"] if target == "glsl" else FLAGS[target]
        done = subprocess.run(
            [glslang, *flags, path], cwd=folder, env=env, capture_output=True, check=False
        )
        assert done.returncode == 0, done.stdout


def whole_command(paths: Sequence[Path], *more: str) -> int:
    """`shaderlab compile` on the folder, start-up included; peak memory in KiB of any process."""
    tree = str(paths[0].parent.parent)
    process = subprocess.Popen([*SHADERLAB, tree, *more], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    assert status == 0, "a shader was refused"
    return usage.ru_maxrss


def bare(paths: Sequence[Path]) -> None:
    good = compile_all([(path.suffix[1:], path.read_bytes()) for path in paths])
    # A struct that holds a sampler is invalid for Vulkan; only the lab lifts it out.
    assert good > 2.9 * len(paths)


def lab(paths: Sequence[Path], pool: WorkerPool | None = None) -> None:
    results = compile_glsl([paths[0].parent.parent], workers=pool)
    assert sum(result.ok for result in results) == len(paths)


def compare(count: int, rounds: int, *, inside_only: bool) -> None:
    with tempfile.TemporaryDirectory() as folder:
        paths = write_tree(Path(folder) / "tree", REPOSITORY, count)
        if not inside_only:
            compare_commands(paths, rounds, Path(folder))
        compare_inside(paths, rounds)


def compare_commands(paths: Sequence[Path], rounds: int, folder: Path) -> None:
    print(f"{len(paths)} shaders, {len(TARGETS)} targets, {rounds} rounds; seconds of a round:")
    print(f"{'':<52} {'clock':>8} {'':>9} {'processor':>10}")
    names = ["one glslangValidator process per file and target"]
    names += ["shaderlab compile, start-up included", "the same with --jobs 1"]
    totals = [[0.0, 0.0] for _ in names]
    for turn in range(rounds):
        # A share of the processes in each round, so that other load falls on all alike.
        share = paths[turn::rounds]
        for total, call in zip(
            totals,
            (
                lambda share=share: one_process_each(share, folder),
                lambda: whole_command(paths),
                lambda: whole_command(paths, "--jobs", "1"),
            ),
            strict=True,
        ):
            clock, processor = spent(call)
            total[0] += clock
            total[1] += processor
    each = totals[0]
    for name, (clock, processor) in zip(names, totals, strict=True):
        per = 1 if name == names[0] else rounds
        row = f"  {name:<50} {clock / per:>8.2f} {per * each[0] / clock:>8.1f}x"
        print(f"{row} {processor / per:>9.2f} {per * each[1] / processor:>8.1f}x", flush=True)


def compare_inside(paths: Sequence[Path], rounds: int) -> None:
    with WorkerPool(WORK) as pool:
        ways: dict[str, Callable[[], None]] = {
            "bare loop over the compilers": lambda: bare(paths),
            "compile_glsl in this process": lambda: lab(paths),
            "compile_glsl in one worker": lambda: lab(paths, pool),
        }
        for call in ways.values():
            call()  # libraries loaded, worker started
        wall: dict[str, list[float]] = {name: [] for name in ways}
        processor: dict[str, list[float]] = {name: [] for name in ways}
        for name in list(ways) * (rounds + 2):
            start = time.process_time()
            wall[name].append(seconds(ways[name]))
            processor[name].append(time.process_time() - start)
    print("  inside the process: the clock's seconds, and this process's processor seconds")
    floor = [min(times["bare loop over the compilers"]) for times in (wall, processor)]
    for name in ways:
        clock, used = min(wall[name]), min(processor[name])
        row = f"  {name:<50} {clock:7.3f}   {clock / floor[0]:.2f} x"
        own = f"   {used:7.3f}   {used / floor[1]:.2f} x the bare loop"
        print(row + ("" if "worker" in name else own))


def growth() -> None:
    print(f"{'files':>6} {'seconds':>9} {'ms a file':>10} {'peak MiB':>9}")
    for count in (100, 300, 1000, 3000, 10_000):
        with tempfile.TemporaryDirectory() as folder:
            paths = write_tree(Path(folder) / "tree", REPOSITORY, count)
            start = time.perf_counter()
            peak = whole_command(paths, "--jobs", "1")
            taken = time.perf_counter() - start
        print(f"{count:>6} {taken:>9.2f} {1000 * taken / count:>10.2f} {peak / 1024:>9.0f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="?", type=int, default=300)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--growth", action="store_true")
    parser.add_argument("--inside", action="store_true", help="leave out the whole commands")
    given = parser.parse_args()
    if given.growth:
        growth()
    else:
        compare(given.files, given.rounds, inside_only=given.inside)


if __name__ == "__main__":
    main()
