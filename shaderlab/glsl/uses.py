"""Which variables, and which parts of them, the functions of a module refer to."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping

from shaderlab.glsl.module import Instruction, Module, Op

Path = tuple[int, ...]
"""Indices from a variable to a part of it; `ANY` for one that is computed at run time."""

ANY = -1

_EXTENDED, _TEXEL_POINTER, _LOAD, _STORE, _COPY_MEMORY, _COPY = 12, 60, 61, 62, 63, 83
_ATOMIC_FIRST, _ATOMIC_STORE, _ATOMIC_LAST = 227, 228, 242


@functools.lru_cache(maxsize=8)  # asked for once for each class of variables
def used_paths(module: Module) -> Mapping[int, set[Path]]:
    """For each variable that is referred to, the paths by which it is."""
    paths: dict[int, set[Path]] = {}
    chains: dict[int, tuple[int, Path]] = {}
    for instruction in module.body:
        if instruction.op in (Op.ACCESS_CHAIN, Op.IN_BOUNDS_ACCESS_CHAIN):
            _, result, base, *indices = instruction.words
            variable, start = chains.get(base, (base, ()))
            steps = tuple(module.constants.get(index, ANY) for index in indices)
            chains[result] = (variable, (*start, *steps))
            continue
        for pointer in _pointers(instruction):
            variable, path = chains.get(pointer, (pointer, ()))
            if variable in module.variables:
                paths.setdefault(variable, set()).add(path)
    return paths


def is_used(paths: Iterable[Path], part: Path) -> bool:
    """Whether one of the paths leads to the part, into it, or to something around it."""
    return any(all(a in (ANY, b) for a, b in zip(path, part, strict=False)) for path in paths)


def _pointers(instruction: Instruction) -> tuple[int, ...]:
    """The operands that an instruction may read or write memory through."""
    op, words = instruction.op, instruction.words
    if op in (_LOAD, _TEXEL_POINTER, _COPY, Op.ARRAY_LENGTH):
        return words[2:3]
    if op in (_STORE, _ATOMIC_STORE):
        return words[:1]
    if op == _COPY_MEMORY:
        return words[:2]
    if op == Op.FUNCTION_CALL:
        return words[3:]
    if op == _EXTENDED:
        return words[4:]
    if _ATOMIC_FIRST <= op <= _ATOMIC_LAST:
        return words[2:3]
    return ()
