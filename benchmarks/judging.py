"""What bands notice, beside fixed tolerances, on the same mistakes and the same values.

`python -m benchmarks.judging [CASE…]` makes every mutant of the cases' shaders (see `shaderlab
mutate`; those of fixed-function state left out) and judges each by four rules:

- the derived band;
- an 8-bit image comparison: both clamped to 0…1, no channel more than 2/255 apart;
- `np.allclose` with rtol 1e-3, and with 1e-5, NumPy's own atol.

All get the same measured values and the same float64 reference: everything that the cases'
`formula`, `value` and `sweep` expectations look at. `exact` and `coverage` need no tolerance and
count alike for all four. Mutants that do not count (equivalent, no difference, invalid) are left
out, and so are those that change only what no expectation reads. Then the cases' own, correct
shaders are judged by the same rules on each driver: how many cases are rejected?
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from importlib import import_module
from unittest.mock import patch

import numpy as np

from shaderlab.engine.catalogue import case_files, data_folder, load_case
from shaderlab.engine.judging.banded import Banded
from shaderlab.engine.run import SceneRunner
from shaderlab.model.case import Case
from shaderlab.mutation.judging import Judge
from shaderlab.mutation.mutants import Mutant
from shaderlab.mutation.shader_mutants import mutate_case

DRIVERS = ("llvmpipe", "softpipe")
Rule = Callable[[Banded], bool]


def in_band(seen: Banded) -> bool:
    return bool(seen.inside.all())


def eight_bits(seen: Banded) -> bool:
    """No channel of a picture is more than 2 codes off."""
    if seen.unit is not None:  # the attachment holds codes already
        return bool((np.abs(seen.measured - np.rint(seen.reference)) <= 2).all())
    with np.errstate(invalid="ignore"):
        one, other = (
            np.rint(np.nan_to_num(np.clip(v, 0.0, 1.0)) * 255.0)
            for v in (seen.measured.astype(np.float64), seen.reference)
        )
    return bool((np.abs(one - other) <= 2).all())


def relative(tolerance: float) -> Rule:
    def close(seen: Banded) -> bool:
        wanted = seen.reference if seen.unit is None else np.rint(seen.reference)
        return bool(np.allclose(seen.measured, wanted, rtol=tolerance, equal_nan=True))

    return close


RULES: Mapping[str, Rule] = {
    "band": in_band,
    "2/255": eight_bits,
    "rtol 1e-3": relative(1e-3),
    "rtol 1e-5": relative(1e-5),
}


@contextmanager
def recorded() -> Iterator[list[Banded]]:
    """Everything that is judged by a band meanwhile."""
    modules = [
        import_module(f"shaderlab.engine.expectations.{n}") for n in ("formula", "sweep", "value")
    ]
    original = modules[0].judge_band
    seen: list[Banded] = []

    def keep(*arguments: object, **named: object) -> Banded:
        seen.append(original(*arguments, **named))
        return seen[-1]

    with ExitStack() as stack:
        for module in modules:
            stack.enter_context(patch.object(module, "judge_band", keep))
        yield seen


def noticed(own: Judge, mutant: Mutant) -> set[str]:
    """The rules by which some expectation fails."""
    found: set[str] = set()
    for trial in own.trials(mutant):
        if not trial.expect or len(found) == len(RULES):
            continue
        with own.evaluation(trial) as (mutated, _):
            for expectation in mutated.scene.expect:
                with recorded() as seen:
                    status = mutated.judge(expectation).outcome.status
                for one in seen:
                    found |= {name for name, passes in RULES.items() if not passes(one)}
                if status != "pass" and (not seen or all(in_band(one) for one in seen)):
                    found |= set(RULES)  # no matter of tolerance: coverage, exact, nothing drawn
    return found


def mutation(cases: Sequence[Case]) -> dict[str, dict[str, int]]:
    """For each case, how many mutants there are and how many each rule notices."""
    rows = {}
    with SceneRunner() as lab:
        for case in cases:
            own = Judge(lab, case)
            counts = dict.fromkeys(("mutants", *RULES), 0)
            for mutant in mutate_case(case):
                fate = own.judge(mutant)
                if fate.status not in ("killed", "survived") or fate.unread:
                    continue
                try:
                    found = noticed(own, mutant)
                except Exception:
                    found = set(RULES)  # the case ends in an error, by whatever rule
                counts["mutants"] += 1
                for name in found:
                    counts[name] += 1
            rows[case.id] = counts
            print(f"{case.id:<20}" + "".join(f"{counts[n]:>11}" for n in counts), flush=True)
    return rows


def rejected(cases: Sequence[Case]) -> dict[str, list[str]]:
    """For each rule, the cases whose own shaders it rejects on this driver."""
    found: dict[str, list[str]] = {name: [] for name in RULES}
    with SceneRunner() as lab:
        for case in cases:
            with recorded() as seen:
                Judge(lab, case)
            for name, passes in RULES.items():
                if not all(passes(one) for one in seen):
                    found[name].append(case.id)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", help="ids; every case in cases/ by default")
    parser.add_argument("--correct", action="store_true", help="only the correct shaders, as JSON")
    options = parser.parse_args()
    files = [
        f for f in case_files(data_folder("cases")) if not options.cases or _id(f) in options.cases
    ]
    cases = [load_case(file) for file in files]
    if options.correct:
        print(json.dumps(rejected(cases)))
        return
    print(f"{'killed':<20}" + "".join(f"{n:>11}" for n in ("mutants", *RULES)))
    rows = mutation(cases)
    total = {n: sum(row[n] for row in rows.values()) for n in ("mutants", *RULES)}
    print(f"{'all':<20}" + "".join(f"{total[n]:>11}" for n in total))
    shares = (f"{100.0 * total[n] / max(total['mutants'], 1):>9.1f} %" for n in RULES)
    print(f"{'share':<31}" + "".join(shares))
    for driver in DRIVERS:
        command = [sys.executable, "-m", "benchmarks.judging", "--correct", *options.cases]
        run = subprocess.run(
            command,
            env={**os.environ, "SHADERLAB_DRIVER": driver},
            capture_output=True,
            text=True,
            check=False,
        )
        if run.returncode:
            print(f"{driver}: {run.stderr.strip().splitlines()[-1]}")
            continue
        wrong = json.loads(run.stdout.splitlines()[-1])
        print(f"\ncorrect cases rejected on {driver}, of {len(cases)}:")
        for name in RULES:
            print(f"  {name:<10}{len(wrong[name]):>3}  {', '.join(wrong[name])}")


def _id(file: object) -> str:
    return str(file).rsplit("/", 1)[-1].removesuffix(".py").replace("_", "-")


if __name__ == "__main__":
    main()
