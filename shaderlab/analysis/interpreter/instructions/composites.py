"""Vectors, matrices, structs and arrays: put together, taken apart, shuffled."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..memory import World, changed, fetch, known_index
from ..program import Instruction
from ..types import Type
from ..values import composed
from .handler import Handler, calling

if TYPE_CHECKING:
    from ..running import Run

_NOTHING = 0xFFFFFFFF


def _construct(run: Run, at: Instruction, world: World) -> Any:
    return composed(run.program.types[at.type], run.values(at.operands))


def _extract(run: Run, at: Instruction, world: World) -> Any:
    value = run.value(at.operands[0])
    for index in at.operands[1:]:
        value = run.part(value, index)
    return value


def _insert(run: Run, at: Instruction, world: World) -> Any:
    new, whole = run.values(at.operands[:2])
    return changed(whole, run.program.types[at.type], at.operands[2:], new, world.mask)


def _extract_dynamic(run: Run, at: Instruction, world: World) -> Any:
    vector, index = run.values(at.operands)
    return fetch(vector, [known_index(index)], world.mask)


def _insert_dynamic(run: Run, at: Instruction, world: World) -> Any:
    vector, new, index = run.values(at.operands)
    type_: Type = run.program.types[at.type]
    return changed(vector, type_, [known_index(index)], new, world.mask)


def _shuffle(run: Run, at: Instruction, world: World) -> Any:
    first, second = run.values(at.operands[:2])
    size = first.shape[-1]
    picks = [0 if i == _NOTHING else i for i in at.operands[2:]]
    if all(i < size for i in picks):
        return run.remembered(first, tuple(picks), lambda: first[..., picks])
    parts = [run.part(first, i) if i < size else run.part(second, i - size) for i in picks]
    return composed(run.program.types[at.type], parts)


COMPOSITES: Mapping[int, Handler] = {
    77: _extract_dynamic,
    78: _insert_dynamic,
    79: _shuffle,
    80: _construct,
    81: _extract,
    82: _insert,
    84: calling("transpose"),
}
