"""Which lines and branches of a program its invocations came to."""

from __future__ import annotations

from collections.abc import Iterator, Set

from shaderlab.compiler.spirv import Op
from shaderlab.model.records import LineCoverage

from .interpreter import Program


def cover_lines(program: Program, taken: Set[tuple[int, int]]) -> Iterator[LineCoverage]:
    """The lines with code of a program's files, also of functions that were not called; `taken` as
    of `Interpreted`."""
    ran = {label for _, label in taken}
    lines: dict[int, tuple[bool, list[bool]]] = {}
    for function in program.functions.values():
        for label, block in function.blocks.items():
            for at in block:
                was_run, ways = lines.get(at.line, (False, []))
                lines[at.line] = was_run or label in ran, ways
                if at.op == Op.BranchConditional:
                    ways.extend((label, target) in taken for target in at.operands[1:3])
                elif at.op == Op.Switch:
                    ways.extend((label, target) in taken for target in at.operands[1::2])
    lines.pop(0, None)  # what has no line, as a variable's declaration
    for number, (was_run, ways) in sorted(lines.items()):
        file, line = program.place(number)
        if file:
            yield LineCoverage(file=file, line=line, was_run=was_run, branches=tuple(ways))


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
