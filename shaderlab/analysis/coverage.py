"""Which lines and branches of a program its invocations came to."""

from __future__ import annotations

from collections.abc import Set
from itertools import zip_longest

from shaderlab.compiler.spirv import Op
from shaderlab.model.records import LineCoverage

from .interpreter import Program

Lines = dict[tuple[str, int], tuple[bool, list[bool]]]
"""By file and number, whether a line was run, and each way of its branches taken."""


def add_coverage(lines: Lines, program: Program, taken: Set[tuple[int, int]]) -> None:
    """Add what a run of a program came to: lines with code, of functions that were not called too;
    `taken` as of `Interpreted`."""
    own: Lines = {}
    ran = {label for _, label in taken}
    for function in program.functions.values():
        for label, block in function.blocks.items():
            for at in block:
                if not at.line:  # as that of a variable's declaration
                    continue
                was_run, ways = own.setdefault(program.place(at.line), (False, []))
                own[program.place(at.line)] = was_run or label in ran, ways
                if at.op == Op.BranchConditional:
                    ways.extend((label, target) in taken for target in at.operands[1:3])
                elif at.op == Op.Switch:
                    ways.extend((label, target) in taken for target in at.operands[1::2])
    for place, (was_run, ways) in own.items():
        before, known = lines.get(place, (False, []))
        either = [a or b for a, b in zip_longest(known, ways, fillvalue=False)]
        lines[place] = before or was_run, either


def record_lines(lines: Lines) -> tuple[LineCoverage, ...]:
    """The lines for a record, but for those of no file."""
    return tuple(
        LineCoverage(file=file, line=line, was_run=was_run, branches=tuple(ways))
        for (file, line), (was_run, ways) in sorted(lines.items())
        if file and line
    )


def lines_not_run(program: Program, ran: Set[int]) -> list[int]:
    """The first lines of blocks that were not run, of functions that were; ends of blocks, where
    nothing is done, don't count."""
    return sorted(
        {
            block[0].line
            for function in program.functions.values()
            for label, block in function.blocks.items()
            if label not in ran and len(block) > 1 and not ran.isdisjoint(function.blocks)
        }
    )
