"""What `audit --prove` says of small functions: `python -m benchmarks.proving [--samples N]`.

Of each safe function of `proving.toml` every hazard should be proved absent, of each planted one
none must be. Then so many inputs of each proved function are run in float32 and on the driver: what
is no finite number there has been proved wrongly.
"""

from __future__ import annotations

import argparse
import time
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shaderlab.analysis.audit import Audit, Plan, audit_program
from shaderlab.analysis.batches import run_batch
from shaderlab.analysis.inputs import domains_of, inputs_of, sample_inputs
from shaderlab.analysis.interpreter import Program, load
from shaderlab.analysis.proof import are_finite
from shaderlab.analysis.requests import assume
from shaderlab.compiler import Shaders
from shaderlab.engine.worker import Worker
from shaderlab.functions.evaluation import use_worker
from shaderlab.functions.interpreting import find_entry_points
from shaderlab.functions.library import load as load_library

DATA = Path(__file__).with_suffix(".toml")


@dataclass(frozen=True)
class Case:
    """A function `f`, the ranges of its parameters, and a condition in GLSL or ""."""

    name: str
    planted: bool
    code: str
    ranges: dict[str, str]
    assume: str = ""

    def program(self, worker: Worker) -> Program:
        """A fragment stage that calls the function."""
        source = Shaders([]).from_text(self.code, "fragment", f"{self.name}.glsl")
        ((_, stage),) = find_entry_points(source, worker)
        return load(assume(stage, [self.assume] if self.assume else []))

    def audit(self, worker: Worker) -> Audit:
        """What is said of it."""
        return audit_program(self.program(worker), Plan(ranges=self.ranges, prove=True))


def cases() -> Iterator[Case]:
    """All of them."""
    for kind, entries in tomllib.loads(DATA.read_text(encoding="utf-8")).items():
        for name, entry in entries.items():
            code, condition = entry.pop("code"), entry.pop("assume", "")
            yield Case(name, kind == "planted", code, entry, condition)


def find_escapes(case: Case, worker: Worker, count: int, seed: int = 0) -> int:
    """How many of so many inputs give no finite number, in float32 or on the driver."""
    program = case.program(worker)
    inputs = inputs_of(program)
    batch = sample_inputs(inputs, domains_of(inputs, [program], case.ranges), count, seed)
    result = run_batch(program, batch)
    gone = np.broadcast_to(result.discarded.all_true, (count,))
    wrong = np.zeros(count, np.bool_)
    for holds in are_finite(result.outputs, batch).values():
        wrong |= ~np.asarray(holds).all(axis=-1)
    scalar = {name for name, one in inputs.items() if one.type in ("float", "int")}
    given = {n: batch.each[n][:, 0] if n in scalar else batch.each[n] for n in inputs}
    with use_worker(worker):
        values = np.asarray(load_library(case.code)["f"](**given)).reshape(count, -1)
    return int(((wrong | ~np.isfinite(values).all(axis=-1)) & ~gone).sum())


def main() -> None:
    """Print what is said of each, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=100_000, help="of each proved function")
    samples = parser.parse_args().samples
    worker, proved, safe, missed, escapes = Worker(), 0, 0, 0, 0
    for case in cases():
        start = time.process_time()
        audit = case.audit(worker)
        seconds = time.process_time() - start
        said = {False: "refuted", None: "open", True: "proved"}[audit.clean]
        said = "refuted" if audit.hazards else said
        kind = "planted" if case.planted else "safe"
        print(f"{kind} {case.name}: {said}, {seconds:.2f} s")
        if case.planted:
            missed += said == "proved"
            continue
        safe, proved = safe + 1, proved + (said == "proved")
        for claim in audit.claims:
            if claim.status == "open":
                print(f"    {claim}")
        if said == "proved":
            escapes += find_escapes(case, worker, samples)
    print(f"{proved} of {safe} safe functions proved; {missed} planted hazards proved absent")
    print(f"{samples * proved:,} inputs of proved functions: {escapes} escape")


if __name__ == "__main__":
    main()
