"""What judging by bands costs: each formula's band, and comparing a frame with one.

`python -m benchmarks.bands` prints

- the time to evaluate the band of every formula of every shipped case, once for each variant, at
  64 × 64 or the size that a scene has of its own (best of `--repeats`), and their sums; formulas of
  one output and one reference are judged over all of the case's variants, and `--variants` lists
  them all; also with one formula a case, the first and the slowest, at 64 × 64 values at most;
- comparing 1024 × 1024 float32 values with a band that is there already, against `np.allclose`
  of the same tolerance, and whether the verdicts are equal on right and wrong frames;
- the memory that judging the largest formula takes at 512 × 512.

`--operations` prints what single operations take instead.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import tracemalloc
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.shipped import load_cases
from shaderlab import glslmath
from shaderlab.bands import Band, Rules
from shaderlab.bands.bounds import contains
from shaderlab.engine.expectations.formula import Formula
from shaderlab.engine.expectations.needs import subject_of
from shaderlab.engine.judging.references import Inputs, evaluate
from shaderlab.engine.run import SceneRunner
from shaderlab.model.case import Scene
from shaderlab.model.frame import Frame
from shaderlab.model.options import RunOptions
from shaderlab.workers.pool import ENVIRONMENT

SIDE = 64
LARGE = 512


@dataclass(frozen=True)
class Job:
    """One formula of one variant, with the inputs that its shader got."""

    case: str
    variant: str
    check: Formula
    inputs: Inputs
    scene: Scene
    frame: Frame


def main(words: list[str] | None = None) -> int:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("cases", nargs="*", help="ids of cases; all by default")
    options.add_argument("--repeats", type=int, default=5)
    options.add_argument("--variants", action="store_true", help="list every variant")
    options.add_argument("--operations", action="store_true", help="single operations alone")
    given = options.parse_args(words)
    if not ENVIRONMENT.items() <= os.environ.items():  # compute as workers do
        os.execve(sys.executable, sys.orig_argv, os.environ | ENVIRONMENT)
    if given.operations:
        operations()
        return 0
    slowest = evaluation(given.repeats, given.variants, given.cases)
    comparison(given.repeats)
    memory(slowest)
    return 0


def evaluation(repeats: int, every: bool, cases: Collection[str] = ()) -> Job:
    """Print the cost of each formula's band; the slowest formula."""
    print(f"bands at {SIDE} × {SIDE}, best of {repeats}")
    total, first, slowest = 0.0, 0.0, (0.0, None)
    seen: set[tuple[str, str]] = set()
    of_case: dict[str, list[float]] = {}
    for job in jobs(SIDE, cases):
        took = best(repeats, lambda job=job: band_of(job))
        total += took
        some = replace(job, inputs=job.inputs.part(slice(0, SIDE * SIDE)))
        of_case.setdefault(job.case, []).append(best(repeats, lambda some=some: band_of(some)))
        name = (job.case, job.check.name)
        if name not in seen:
            first += took
        if every or name not in seen:
            print(f"  {took * 1e3:8.2f} ms  {job.case}  {job.variant}  {job.check.name}")
        seen.add(name)
        if took > slowest[0]:
            slowest = (took, job)
    print(f"  {first * 1e3:8.1f} ms  all {len(seen)} formulas, one variant each")
    print(f"  {total * 1e3:8.1f} ms  with all variants")
    one = f"of each of {len(of_case)} cases, {SIDE * SIDE} values at most"
    print(f"  {sum(times[0] for times in of_case.values()) * 1e3:8.1f} ms  the first formula {one}")
    print(f"  {sum(map(max, of_case.values())) * 1e3:8.1f} ms  the slowest formula {one}")
    assert slowest[1] is not None
    return slowest[1]


def comparison(repeats: int) -> None:
    """Print how a frame is compared, and whether verdicts agree with np.allclose."""
    rng = np.random.default_rng(1)
    shape = (1024, 1024, 1)
    tolerance = 2.0**-20
    # Multiples of 2^-23 below 2, so that reference ± tolerance is exact in float32.
    reference = rng.integers(2**22, 2**23, shape) * 2.0**-23
    low, high = reference - tolerance, reference + tolerance
    right = reference + rng.integers(-8, 9, shape) * 2.0**-23
    frames = {"right": right}
    for label, by in (("one step outside", 9), ("far outside", 4096)):
        wrong = right.copy()
        wrong[517, 93, 0] = reference[517, 93, 0] + by * 2.0**-23
        frames[label] = wrong
    for label, value in (("NaN", np.nan), ("infinity", np.inf)):
        wrong = right.copy()
        wrong[0, 0, 0] = value
        frames[label] = wrong
    equal = []
    for label, values in frames.items():
        got = values.astype(np.float32)
        by_band = bool(contains(low, high, np.False_, got).all())
        by_tolerance = bool(np.allclose(got, reference, rtol=0.0, atol=tolerance))
        equal.append(by_band == by_tolerance == (label == "right"))
    got = right.astype(np.float32)
    narrow = reference.astype(np.float32)
    # As a frame is judged: a band's bounds are float32 numbers, and are kept so.
    low, high = low.astype(np.float32), high.astype(np.float32)
    equal += [
        bool(contains(low, high, np.False_, v.astype(np.float32)).all()) == (label == "right")
        for label, v in frames.items()
    ]
    ours = best(4 * repeats, lambda: bool(contains(low, high, np.False_, got).all()))
    theirs = best(4 * repeats, lambda: bool(np.allclose(got, reference, rtol=0.0, atol=tolerance)))
    single = best(4 * repeats, lambda: bool(np.allclose(got, narrow, rtol=0.0, atol=tolerance)))
    print(f"comparison of 1024 × 1024 values, best of {4 * repeats}")
    print(f"  {ours * 1e3:8.2f} ms  contains")
    print(f"  {theirs * 1e3:8.2f} ms  np.allclose, float64 reference: {theirs / ours:.1f} times")
    print(f"  {single * 1e3:8.2f} ms  np.allclose, float32 reference: {single / ours:.1f} times")
    print(f"  verdicts equal on {sum(equal)} of {len(equal)} frames, as float64 and as float32")


def memory(slowest: Job) -> None:
    """Print the most memory that judging the slowest formula takes at 512 × 512."""
    for job in jobs(LARGE, [slowest.case]):
        if (job.variant, job.check.name) != (slowest.variant, slowest.check.name):
            continue
        tracemalloc.start()
        started = time.process_time()
        outcome = job.check.judge(job.scene, job.frame).outcome
        took = time.process_time() - started
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        print(f"judging {job.case} {job.check.name} at {LARGE} × {LARGE}: {outcome.status}")
        print(f"  {peak / 2**20:8.0f} MiB at most, {took:.1f} s (while memory is traced)")


def operations() -> None:
    """Print the µs of single operations on so many values, or vectors of three."""
    rng = np.random.default_rng(1)
    matrix = Band.exact(rng.normal(size=(3, 3)))
    for count in (1, 4096, 49152):
        x, y, z, w = (Band.exact(rng.uniform(0.1, 1.0, (count, 1))) for _ in range(4))
        u, v = (Band.exact(rng.normal(size=(count, 3))) for _ in range(2))
        a, b, share = x + y, z + w, x * y
        repeats = 200 if count == 1 else 20
        runs: dict[str, Callable[[], Any]] = {
            "sum of two sums": lambda a=a, b=b: a + b,
            "product of two sums": lambda a=a, b=b: a * b,
            "quotient of two sums": lambda a=a, b=b: a / b,
            "root of a sum": lambda a=a: glslmath.sqrt(a),
            "mix of two sums": lambda a=a, b=b, share=share: glslmath.mix(a, b, share),
            "choice between two sums": lambda a=a, b=b: glslmath.where(a < 1.0, a, b),
            "dot of two vectors": lambda u=u, v=v: glslmath.dot(u, v),
            "difference's direction": lambda u=u, v=v: glslmath.normalize(u - v),
            "matrix and vector": lambda u=u, matrix=matrix: glslmath.mul(matrix, u),
        }
        for name, run in runs.items():
            print(f"{count:6} values  {name:24}{best(repeats, run) * 1e6:9.1f}")


def jobs(side: int, only: Collection[str] = ()) -> Iterator[Job]:
    """Every formula of the shipped cases, with what the driver gives its shader at this size."""
    with SceneRunner(RunOptions(size=side)) as lab:
        for case in load_cases().values():
            if only and case.id not in only:
                continue
            for scene in case.scenes():
                checks = [c for c in scene.expect if isinstance(c, Formula)]
                with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
                    for check in checks:
                        evaluation.gather(check)
                for check in checks:
                    inputs = subject_of(check, check.given, scene, evaluation.frame).inputs
                    yield Job(case.id, scene.variant, check, inputs, scene, evaluation.frame)


def band_of(job: Job) -> Any:
    return evaluate(
        job.check.reference, job.inputs, rules=job.check.rules or Rules(), decimal=False
    )


def best(repeats: int, run: Callable[[], Any]) -> float:
    """The shortest of some runs, in seconds of processor time: others may be using the machine."""
    times = []
    for _ in range(repeats):
        started = time.process_time_ns()
        run()
        times.append((time.process_time_ns() - started) / 1e9)
    return min(times)


if __name__ == "__main__":
    sys.exit(main())
