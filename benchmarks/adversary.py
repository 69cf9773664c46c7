"""How many results that the rules allow lie outside their band? There should be none.

Random expression trees are evaluated by a device that errs in every operation as much as the
precision rules allow (adversary_device.py), on many inputs each, and each result is held against
the bands:

- as written, against the bands of `precise` code and against the default ones;
- trees of sums and products rearranged as an optimiser would, rounded to nearest and towards
  zero, against the default bands.

Run it with `python -m benchmarks.adversary --samples 1e8` (a sample is one result held against
one band; the exit status is 1 if one lies outside). The same `--seed` gives the same run. A tree
that fails is printed with its seed.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.adversary_device import BINARY, UNARY, Device, Tree, on_bands, on_device, rearranged
from shaderlab.bands import Band, Rules

AS_WRITTEN, WIDENED = Rules(rearrange=False), Rules()
SUMS = ("add", "sub", "mul", "add")
CONSTANTS = (0.5, 2.0, 0.25, 1.0, 3.0, 0.75)
MAX_DEPTH = 5


@dataclass
class Tally:
    """What was counted so far."""

    samples: int = 0
    trees: int = 0
    outside: int = 0


def main(words: list[str] | None = None) -> int:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--samples", type=float, default=1e8, help="results to judge")
    options.add_argument("--inputs", type=int, default=4096, help="inputs for each tree")
    options.add_argument("--seed", type=int, default=0)
    given = options.parse_args(words)
    tally, started, shown = Tally(), time.perf_counter(), 0.0
    while tally.samples < given.samples:
        check_one(given.seed + tally.trees, given.inputs, tally)
        elapsed = time.perf_counter() - started
        if elapsed - shown > (0.5 if sys.stderr.isatty() else 30.0):
            shown = elapsed
            print(f"\r{progress(tally, given.samples, elapsed)}", end="", file=sys.stderr)
    elapsed = time.perf_counter() - started
    print(f"\r{progress(tally, given.samples, elapsed)}", file=sys.stderr)
    print(f"{tally.outside} of {tally.samples:,} samples outside ({tally.trees:,} trees)")
    return 1 if tally.outside else 0


def progress(tally: Tally, goal: float, elapsed: float) -> str:
    """One line: how far, how fast, how long still."""
    share = tally.samples / goal
    left = elapsed * (1.0 - share) / share if share else 0.0
    return (
        f"{min(share, 1.0):6.1%}  {tally.samples / 1e6:8.2f} M samples  {tally.trees} trees  "
        f"{tally.outside} outside  {elapsed:.0f} s, {max(left, 0.0):.0f} s left   "
    )


def check_one(seed: int, count: int, tally: Tally) -> None:
    """Judge one random tree of each kind."""
    rng = np.random.default_rng(seed)
    tally.trees += 2
    with np.errstate(all="ignore"):
        for tree, measured, rules in runs(rng, count):
            for chosen in rules:
                band = on_bands(tree, [Band.exact(value, chosen) for value in measured.inputs])
                outside = ~band.contains(measured.values)
                tally.samples += outside.size
                if outside.any():
                    tally.outside += int(outside.sum())
                    print(f"\nseed {seed}: {int(outside.sum())} outside of {chosen}: {tree}")


@dataclass(frozen=True)
class Measured:
    """A device's results for one tree and the inputs that it got."""

    inputs: list[np.ndarray]
    values: np.ndarray


def runs(
    rng: np.random.Generator, count: int
) -> Iterator[tuple[Tree, Measured, tuple[Rules, ...]]]:
    """Trees, what a device makes of them, and the rules whose bands must hold it."""
    inputs = input_values(rng, count)
    tree = random_tree(rng, BINARY, (*UNARY, "dot", "mix"))
    device = Device(int(rng.integers(2**63)), "either")
    yield tree, Measured(inputs, on_device(tree, inputs, device)), (AS_WRITTEN, WIDENED)
    tree = random_tree(rng, SUMS, ())
    run = rearranged(rearranged(tree, rng), rng)
    for mode in ("nearest", "zero"):
        device = Device(int(rng.integers(2**63)), mode)
        yield tree, Measured(inputs, on_device(run, inputs, device)), (WIDENED,)


def random_tree(
    rng: np.random.Generator, binary: tuple[str, ...], unary: tuple[str, ...], depth: int = 0
) -> Tree:
    """A random tree; never a bare leaf."""
    if depth and (depth == MAX_DEPTH or rng.random() < 0.3):
        if rng.random() < 0.7:
            return ("input", int(rng.integers(3)))
        return ("constant", CONSTANTS[int(rng.integers(len(CONSTANTS)))])
    name = str(rng.choice((*binary, *unary)))
    branches = 2 if name in binary or name in ("dot", "mix") else 1
    return (name, *(random_tree(rng, binary, unary, depth + 1) for _ in range(branches)))


def input_values(rng: np.random.Generator, count: int) -> list[np.ndarray]:
    """Two scalars and a vec3 for each input: many sizes, and some that are easy to get wrong."""
    scales = np.exp2(rng.integers(-6, 7, (2, count, 1)))
    values = [rng.uniform(-1.0, 1.0, (count, 1)) * scale for scale in scales]
    values.append(rng.uniform(-2.0, 2.0, (count, 3)))
    odd = np.array([0.0, 1.0, -1.0, 2.0**-130, -(2.0**-140), 0.5, 1.0 - 2.0**-24, 1.0 + 2.0**-23])
    for value in values:
        some = rng.random(value.shape) < 0.1
        value[some] = rng.choice(odd, int(some.sum()))
    return [value.astype(np.float32).astype(np.float64) for value in values]


if __name__ == "__main__":
    sys.exit(main())
