"""What reading shaders as arithmetic must reach, and what is measured, as one table.

    python -m benchmarks.interpreter_goals [--only explain|diff|audit]

Runs `interpreting`, `diffing` (on captured inputs, and on varied ones too) and `auditing`, each as
its own page in the docs has it, and prints the lines that a goal is about. The adversary's 10^8
values take a minute or two.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from dataclasses import dataclass


@dataclass(frozen=True)
class Goal:
    """What a benchmark must reach.

    Attributes:
        words: the goal.
        line: what the benchmark's line about it looks like.
    """

    words: str
    line: str


@dataclass(frozen=True)
class Part:
    """A benchmark, and the goals that it is asked about."""

    command: str
    words: tuple[str, ...]
    goals: tuple[Goal, ...]


PARTS = (
    Part("explain", ("interpreting", "--adversary", "12"), (
        Goal("at least 99 % of the catalogue's programs", r"programs are interpreted"),
        Goal("0 of all drawn values outside", r"values of the driver"),
        Goal("0 of 10^8 of an adversary outside", r"values of the adversary"),
        Goal("widths 1.00 in the median, 98 % at most 1.1, all at most 1.5", r"^widths of"),
        Goal("at most 1.5 of the hand-written bands' cost, 15 s in all", r"^cost:"),
    )),
    Part("diff", ("diffing", "--captured"), (
        Goal("at most 0.3 s a pair on captured inputs", r"^seconds a pair"),
    )),
    Part("diff", ("diffing",), (
        Goal("at most 1 of 60 right rewrites called different", r"right ones called"),
        Goal("at most 2 of 110 wrong ones missed", r"wrong ones called"),
        Goal("at most 1.5 s a pair", r"^seconds a pair"),
    )),
    Part("audit", ("auditing", "--all"), (
        Goal("at least 95 % of planted hazards at their lines", r"at their lines"),
        Goal("at most 1 alarm in 100 files", r"alarms in"),
    )),
)  # fmt: skip


def main(words: list[str] | None = None) -> int:
    """Print the table; 1 if a benchmark has no line about one of its goals."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=sorted({part.command for part in PARTS}))
    only = parser.parse_args(words).only
    missing = 0
    for part in PARTS:
        if only in (None, part.command):
            module, *options = part.words
            command = [sys.executable, "-m", f"benchmarks.{module}", *options]
            done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
            missing += table(part, done.stdout)
    return 1 if missing else 0


def table(part: Part, output: str) -> int:
    """Print each goal and the lines about it; how many goals have none."""
    missing = 0
    print(f"python -m benchmarks.{' '.join(part.words)}")
    for goal in part.goals:
        lines = [line for line in output.splitlines() if re.search(goal.line, line)]
        missing += not lines
        print(f"  {goal.words}")
        print(*(f"    {line.strip()}" for line in lines or ["nothing was measured"]), sep="\n")
    sys.stdout.flush()
    return missing


if __name__ == "__main__":
    sys.exit(main())
