"""What a program reads from outside, and what its author says about it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from shaderlab.compiler.reflection import Storage, is_used, leaves, type_name, unwrap, used_paths

from ..interpreter import Program
from ..interpreter.binding import called
from ..interpreter.program import INPUTS
from ..interpreter.workgroups import NUMBERS

_RANGE = re.compile(r"//.*?\brange:\s*(\S+)\s*\.\.\s*(\S+)")
_UNIT = re.compile(r"//.*?\brange:\s*unit\b")
_DECLARED = re.compile(r"([A-Za-z_]\w*)\s*(?:\[[^]]*\]\s*)?(?:=[^;]*)?[;,]")
_ENDLESS = 4  # elements of an array whose length is known at run time only


@dataclass(frozen=True)
class Input:
    """One number, vector, matrix or texture that a program may read.

    Attributes:
        name: as the interpreter takes it: "lights[0].color".
        type: GLSL's name of it: "vec3", "sampler2D".
        uniform: whether all invocations of a draw have the same.
        workgroup: of what numbers a compute stage's invocations, the size of their workgroup.
    """

    name: str
    type: str
    uniform: bool
    workgroup: tuple[int, int, int] | None = None

    @property
    def whole(self) -> bool:
        """Whether its numbers are integers."""
        return self.type.startswith(("int", "ivec", "uint", "uvec"))


def inputs_of(program: Program) -> dict[str, Input]:
    """What a program's functions read, by name, in the order of declaration."""
    module = program.module
    paths = used_paths(module)
    found = {}
    for id_, (pointee, storage) in module.variables.items():
        if storage not in INPUTS:
            continue
        name = called(program, id_)
        for leaf in leaves(module, pointee, name):
            if not is_used(paths.get(id_, ()), leaf.path):
                continue
            type_, uniform = type_name(module, leaf.type), storage != Storage.INPUT
            for each in _elements(unwrap(module, leaf.type)[0], leaf.name):
                size = program.workgroup if each in NUMBERS else None
                found[each] = Input(each, type_, uniform, size)
    return found


def _elements(lengths: tuple[int, ...], name: str) -> Iterator[str]:
    if not lengths:
        yield name
        return
    for i in range(lengths[0] or _ENDLESS):
        yield from _elements(lengths[1:], f"{name}[{i}]")


def declared_ranges(program: Program) -> dict[str, str]:
    """What `// range:` says of each name declared in its line: "0..50", "unit"."""
    found: dict[str, str] = {}
    text = "" if program.source is None else program.source.text
    for line in text.splitlines():
        if "range:" not in line:
            continue
        code, _, _ = line.partition("//")
        pair = _RANGE.search(line)
        says = "unit" if _UNIT.search(line) else f"{pair[1]}..{pair[2]}" if pair else ""
        if says:
            found.update((name, says) for name in _DECLARED.findall(code))
    return found
