"""Wrong shaders that no case may miss: fragments kept out, and outputs of half their size.

`python -m benchmarks.wrong_shaders [CASE…]` makes these mistakes at the end of `main` in every
program of the shipped cases, as `shaderlab mutate` does:

- every second pixel is discarded, as on a chess board;
- pixels where an output is above a quarter are discarded;
- one output is halve_outputs.

Each is judged by all expectations of all variants. It prints what goes unnoticed, and the sums.
What changes nothing that the case draws, such as half of 0, and what changes only what no
expectation reads is counted by itself. The exit status is 1 where anything else goes unnoticed.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter

from benchmarks.shipped import load_cases
from shaderlab.engine.run import SceneRunner
from shaderlab.mutation import mutate_case
from shaderlab.mutation.judging import Judge
from shaderlab.mutation.operators import discard_pixels, halve_outputs


def main(words: list[str] | None = None) -> int:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("cases", nargs="*", help="ids of cases; all by default")
    given = options.parse_args(words)
    counts: dict[str, Counter[str]] = {}
    catalogue = load_cases()
    with SceneRunner() as lab:
        for case in [catalogue[name] for name in given.cases] or catalogue.values():
            judge = Judge(lab, case)
            for mutant in mutate_case(case, operators=(discard_pixels, halve_outputs)):
                fate = judge.judge(mutant)
                how = fate.status if fate.status != "survived" else "unnoticed"
                if fate.unread:
                    how = "unread"
                elif fate.by.startswith("only on other inputs"):
                    how = "without any effect"
                elif how == "unnoticed":
                    print(f"{case.id}: {mutant}: {fate.by}", flush=True)
                counts.setdefault(mutant.operator, Counter())[how] += 1
    for operator, found in counts.items():
        print(f"{operator}: " + ", ".join(f"{count} {how}" for how, count in found.items()))
    return 1 if any(found["unnoticed"] for found in counts.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
