"""What is proved of the shipped cases' fragment shaders: `python -m benchmarks.proving_catalogue`.

Each shader is drawn by its case; then its hazards are proved between the least and the greatest of
what its draws give it, as `audit --prove CASE` does. Prints the share of hazard sites (a kind in a
line) and of outputs that are proved, and the seconds of the proofs.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter

from benchmarks.shipped import load_cases
from shaderlab.analysis.audit import prove_between_draws
from shaderlab.analysis.inputs import inputs_of
from shaderlab.analysis.interpreter import load
from shaderlab.analysis.invocations import case_stages
from shaderlab.engine.worker import Worker
from shaderlab.errors import ShaderlabError
from shaderlab.model.options import RunOptions


def main() -> None:
    """Print what is open, by shader, and the shares."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("ids", nargs="*", help="of cases, by default all")
    ids = parser.parse_args().ids
    lab = Worker().lab(RunOptions())
    seen, counts, seconds = set(), Counter[tuple[bool, str]](), 0.0
    for case in load_cases().values():
        if ids and case.id not in ids:
            continue
        for source, given in case_stages(lab, case):
            if source.stage != "fragment" or not given or source.text in seen:
                continue
            seen.add(source.text)
            start = time.process_time()
            try:
                program = load(source)
                proof = prove_between_draws(program, inputs_of(program), given)
                claims = [*proof.claims(), *proof.refuted_claims()]
            except ShaderlabError as error:
                print(f"{case.id}: {source.name}: not run: {error.message}")
                counts[False, "not run"] += 1
                continue
            taken = time.process_time() - start
            seconds += taken
            if taken > 1.0:
                print(f"{case.id}: {source.name}: {taken:.1f} s", flush=True)
            for claim in claims:
                counts[claim.line > 0, claim.status] += 1
                if claim.status == "open":
                    print(f"{case.id}: {claim}", flush=True)
    for is_site, words in ((True, "hazard sites"), (False, "outputs")):
        proved, opened = counts[is_site, "proved"], counts[is_site, "open"]
        share = proved / max(proved + opened, 1)
        print(f"{proved} of {proved + opened} {words} proved, {share:.1%}")
    unrun = counts[False, "not run"]
    print(f"{len(seen)} shaders, {unrun} not run; {seconds:.1f} s of processor time")


if __name__ == "__main__":
    main()
