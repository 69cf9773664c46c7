"""One location and one binding for each uniform, sampler and block of a program."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from shaderlab.glsl.diagnostics import declaration
from shaderlab.glsl.module import Decoration, Module, Op, Storage
from shaderlab.glsl.sources import Source
from shaderlab.glsl.types import is_opaque, leaves_count, unwrap


@dataclass(frozen=True)
class Place:
    """Where a module says a number: the stage, the index of the word, how many numbers it takes,
    and whether the author's word for it is "location" or "binding"."""

    stage: str
    word: int
    count: int
    kind: str


Places = Mapping[str, Sequence[Place]]
"""The places of each name that share one range of numbers."""


def interface_name(module: Module, id_: int) -> str:
    """The name by which stages find each other's variable: a block's own, or the variable's."""
    element = unwrap(module, module.variables[id_][0])[1]
    if _is_block(module, element):
        return module.names.get(element, "")
    return module.names.get(id_, "")


def numbers(parsed: Mapping[str, Module]) -> Iterator[Places]:
    """Each range of numbers that a program's stages have in common.

    OpenGL numbers uniform locations, texture units, image units, uniform and storage blocks
    apart; Vulkan has one range of bindings for all of a descriptor set.
    """
    ranges: dict[tuple[object, ...], dict[str, list[Place]]] = {}
    for stage, module in parsed.items():
        for id_, (pointee, storage) in module.variables.items():
            if storage not in (
                Storage.UNIFORM_CONSTANT,
                Storage.UNIFORM,
                Storage.STORAGE_BUFFER,
            ):
                continue
            for kind, key, count in _ranges(module, id_, pointee, storage):
                word = module.decoration_words[
                    id_, Decoration.LOCATION if kind == "location" else Decoration.BINDING
                ]
                names = ranges.setdefault(key, {})
                place = Place(stage, word, count, kind)
                names.setdefault(interface_name(module, id_), []).append(place)
    yield from ranges.values()


def share(places: Places, words: Mapping[str, list[int]], sources: Sequence[Source]) -> None:
    """Numbers the names anew where two stages disagree; `words` are the modules' own, by stage."""
    if _agree(places, words):
        return
    taken: set[int] = set()
    fixed = {name for name in places if _by_author(name, places[name], sources)}
    for name in fixed:
        for place in places[name]:
            start = words[place.stage][place.word]
            taken.update(range(start, start + place.count))
    for name, uses in places.items():
        if name in fixed:
            continue
        count = max(place.count for place in uses)
        start = 0
        while taken.intersection(range(start, start + count)):
            start += 1
        taken.update(range(start, start + count))
        for place in uses:
            words[place.stage][place.word] = start


def _ranges(
    module: Module, id_: int, pointee: int, storage: int
) -> Iterator[tuple[str, tuple[object, ...], int]]:
    """The ranges that a variable takes numbers from: author's word, range's key, how many."""
    lengths, element = unwrap(module, pointee)
    descriptor_set = module.number(id_, Decoration.DESCRIPTOR_SET)
    has_binding = module.number(id_, Decoration.BINDING) is not None
    if module.number(id_, Decoration.LOCATION) is not None:
        yield "location", ("location",), leaves_count(module, pointee)
    if not has_binding:
        return
    if descriptor_set is not None:
        yield "binding", ("set", descriptor_set), 1
        return
    count = 1
    for length in lengths:
        count *= max(length, 1)
    if storage != Storage.UNIFORM_CONSTANT:
        stored = module.decorated(element, Decoration.BUFFER_BLOCK) is not None
        yield "binding", ("storage" if stored else "uniform",), count
    elif is_opaque(module, pointee):
        yield "binding", ("image" if module.types[element].op == Op.TYPE_IMAGE else "unit",), count


def _agree(places: Places, words: Mapping[str, list[int]]) -> bool:
    taken: dict[int, str] = {}
    for name, uses in places.items():
        if len({words[place.stage][place.word] for place in uses}) > 1:
            return False
        for place in uses:
            start = words[place.stage][place.word]
            for number in range(start, start + place.count):
                if taken.setdefault(number, name) != name:
                    return False
    return True


def _by_author(name: str, uses: Sequence[Place], sources: Sequence[Source]) -> bool:
    stages = {place.stage for place in uses}
    for source in sources:
        declared = declaration(source, name) if source.stage in stages and name else None
        if declared is not None and uses[0].kind in declared[1]:
            return True
    return False


def _is_block(module: Module, struct: int) -> bool:
    return any(
        module.decorated(struct, d) is not None for d in (Decoration.BLOCK, Decoration.BUFFER_BLOCK)
    )
