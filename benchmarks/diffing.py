"""How many right rewrites of the catalogue's shaders `diff` calls different, and how many wrong
ones it calls the same.

    python -m benchmarks.diffing [--only right|wrong] [--case ID] [--captured]

The rewrites are those of `rewrites.toml`, each compared on the inputs of its case's draws, and on
varied ones (with `--captured`, on captured ones alone). Seconds are of the processor, and of the
comparison alone: the old shader is drawn once for all of its rewrites.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.rewrites import Rewrite, rewrites
from benchmarks.shipped import load_cases
from shaderlab.analysis.answer import Answer
from shaderlab.analysis.comparison import Plan, compare_programs
from shaderlab.analysis.invocations import changed_stages, program_of
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderlabError
from shaderlab.model.case import Case
from shaderlab.model.options import RunOptions


def compared(
    lab: SceneRunner, case: Case, listed: Sequence[Rewrite], plan: Plan
) -> Iterator[tuple[Rewrite, list[Answer], float]]:
    """The answers on each stage that a rewrite changes, and the seconds that they took; no answer
    where one can't be had."""
    changes = [{rewrite.file: rewrite.text()} for rewrite in listed]
    for rewrite, pairs in zip(listed, changed_stages(lab, case, changes), strict=True):
        answers = []
        spent = 0.0
        try:
            for pair in pairs:
                old, new = program_of(pair.old), program_of(pair.new)
                started = time.process_time()
                answers.append(compare_programs(old, new, plan, pair.given))
                spent += time.process_time() - started
        except ShaderlabError as error:
            print(f"  {rewrite}: can't say: {error}", flush=True)
            answers = []
        yield rewrite, answers, spent


def main() -> None:
    """Compare, and print what is surprising."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=("right", "wrong"))
    parser.add_argument("--case")
    parser.add_argument("--captured", action="store_true", help="vary nothing")
    options = parser.parse_args()
    limit = 0.3 if options.captured else 1.5
    plan = Plan(rounds=0 if options.captured else 2, accuracy=False)
    kinds = ("right", "wrong") if options.only is None else (options.only,)
    listed = {kind: [r for r in rewrites(kind) if options.case in (None, r.case)] for kind in kinds}
    wanted = {rewrite: kind for kind in kinds for rewrite in listed[kind]}
    found = dict.fromkeys(kinds, 0)
    unsaid = dict.fromkeys(kinds, 0)
    conditional = 0
    seconds: dict[Rewrite, float] = {}
    with SceneRunner(RunOptions()) as lab:
        for id_, case in load_cases().items():
            of_case = [rewrite for rewrite in wanted if rewrite.case == id_]
            for rewrite, answers, spent in compared(lab, case, of_case, plan) if of_case else ():
                kind = wanted[rewrite]
                seconds[rewrite] = spent
                answers = [answer for answer in answers if answer.outputs]  # it got some inputs
                unsaid[kind] += not answers
                differs = any(answer.same is False for answer in answers)
                if kind == "wrong" and answers and not differs:
                    conditional += any(o.conditions for a in answers for o in a.outputs)
                if answers and differs == (kind == "right"):
                    found[kind] += 1
                    print(f"  {kind}: {rewrite}", flush=True)
                    for answer in answers:
                        print(*(f"      {line}" for line in answer.lines()), sep="\n", flush=True)
    for kind in kinds:
        verb = "called different" if kind == "right" else "called the same"
        print(
            f"{found[kind]} of {len(listed[kind])} {kind} ones {verb}, {unsaid[kind]} can't be said"
        )
    if conditional:
        print(
            f"{conditional} of the wrong ones called the same are so under a condition that is said"
        )
    if seconds:
        each = list(seconds.values())
        print(
            f"seconds a pair: median {np.median(each):.2f}, mean {np.mean(each):.2f}, "
            f"most {max(each):.2f}; {sum(s > limit for s in each)} above {limit}"
        )
        for rewrite in sorted(seconds, key=lambda r: -seconds[r])[:5]:
            print(f"  {seconds[rewrite]:.2f} {rewrite}")


if __name__ == "__main__":
    main()
