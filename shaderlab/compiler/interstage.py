"""Agreement between stages: one location or binding for each name, and no input left unwritten.

glslang numbers the varyings and uniforms of each stage on its own, in the order of their use,
even if it links the stages together. The lab makes stages agree by name, as GLSL does.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from shaderlab.compiler.diagnostics import declaration
from shaderlab.compiler.module import Decoration, Module, Op, Storage, parse
from shaderlab.compiler.sources import Source
from shaderlab.compiler.text import STAGES
from shaderlab.compiler.types import OPAQUE, elements_of, leaves_count, slots, unwrap
from shaderlab.compiler.variables import stage_variables
from shaderlab.model.records import Diagnostic

_NUMBERED = (Storage.UNIFORM_CONSTANT, Storage.UNIFORM, Storage.STORAGE_BUFFER)
_Words = Mapping[str, list[int]]
"""The modules' words by stage."""


@dataclass(frozen=True)
class _Use:
    """A stage's numbers for a name: the index of the first one's word, how many there are, and the
    author's qualifier for them, "location" or "binding"."""

    stage: str
    word: int
    count: int
    qualifier: str

    def numbers(self, words: _Words) -> range:
        start = words[self.stage][self.word]
        return range(start, start + self.count)


def match_locations(modules: Mapping[str, bytes], sources: Sequence[Source]) -> dict[str, bytes]:
    """The modules with numbers that agree between stages.

    Each input gets the location of the previous stage's output of that name, and each uniform,
    sampler and block gets one location and one binding in all stages. Numbers that the author
    wrote stay. Modules that agree already are not changed.
    """
    if len(modules) == 1:
        return dict(modules)
    parsed = {stage: parse(data) for stage, data in modules.items()}
    words = {stage: list(module.words) for stage, module in parsed.items()}
    for writer, reader in pairwise(stage for stage in STAGES if stage in parsed):
        _move_inputs(parsed[writer], parsed[reader], words[writer], words[reader])
    for uses_by_name in _namespaces(parsed):
        _renumber(uses_by_name, words, sources)
    return {
        stage: data
        if tuple(words[stage]) == parsed[stage].words
        else struct.pack(f"{len(words[stage])}I", *words[stage])
        for stage, data in modules.items()
    }


def unwritten_inputs(
    sources: Sequence[Source], modules: Mapping[str, bytes]
) -> tuple[Diagnostic, ...]:
    """An error for each input that a stage uses and the previous stage does not declare, or
    declares with another type at the location that the author gave to both."""
    found = []
    by_stage = {source.stage: source for source in sources}
    for writer, reader in pairwise(stage for stage in STAGES if stage in modules):
        outputs = list(stage_variables(parse(modules[writer]), Storage.OUTPUT))
        written = {_without_indices(v.name) for v in outputs}
        at = {v.location: v for v in outputs if v.location is not None}
        source = by_stage[reader]
        inputs = stage_variables(parse(modules[reader]), Storage.INPUT)
        for name, variable in {_without_indices(v.name): v for v in inputs if v.used}.items():
            if name in written:
                continue
            declared = declaration(source, name.rpartition(".")[2], "in")
            message = f"'{name}' : input of the {reader} stage that the {writer} stage never writes"
            if declared is not None and "location" in declared[1]:
                other = None if variable.location is None else at.get(variable.location)
                if other is None or other.type == variable.type:
                    continue
                message = (
                    f"'{name}' : {variable.type} at location {variable.location}, where the "
                    f"{writer} stage writes the {other.type} '{other.name}'"
                )
            at_line = declared[0] if declared else None
            found.append(source.diagnostic(message, at_line, token=name))
    return tuple(found)


def interface_name(module: Module, id_: int) -> str:
    """The name that a variable has in all stages: its block's, or its own."""
    element = unwrap(module, module.variables[id_][0])[1]
    blocks = (Decoration.BLOCK, Decoration.BUFFER_BLOCK)
    is_block = any(module.decorated(element, block) is not None for block in blocks)
    return module.names.get(element if is_block else id_, "")


def _without_indices(name: str) -> str:
    """A name without array indices, which geometry and tessellation stages add by vertex."""
    return "".join(part.partition("]")[2] if i else part for i, part in enumerate(name.split("[")))


def _located(module: Module, storage: int) -> dict[str, tuple[int, int]]:
    """A storage class's variables that have a location, by interface name: the index of the
    location's word, and how many locations the variable takes."""
    return {
        interface_name(module, id_): (
            module.decoration_words[id_, Decoration.LOCATION],
            slots(module, pointee),
        )
        for id_, (pointee, its_storage) in module.variables.items()
        if its_storage == storage and module.number(id_, Decoration.LOCATION) is not None
    }


def _move_inputs(
    writer: Module, reader: Module, writer_words: Sequence[int], reader_words: list[int]
) -> None:
    """Moves the reader's inputs to the locations of their outputs, and others out of their way."""
    outputs, inputs = _located(writer, Storage.OUTPUT), _located(reader, Storage.INPUT)
    occupied: set[int] = set()
    for name, (at, _) in inputs.items():
        if name in outputs:
            word, count = outputs[name]
            reader_words[at] = writer_words[word]
            occupied.update(range(reader_words[at], reader_words[at] + count))
    for name, (at, count) in inputs.items():
        if name not in outputs:
            if occupied.intersection(range(reader_words[at], reader_words[at] + count)):
                reader_words[at] = max(occupied) + 1
            occupied.update(range(reader_words[at], reader_words[at] + count))


def _namespaces(parsed: Mapping[str, Module]) -> Iterator[Mapping[str, Sequence[_Use]]]:
    """For each range of numbers that a program's stages share, its uses by name.

    OpenGL numbers uniform locations, texture units, image units, uniform and storage blocks
    separately; Vulkan has one range of bindings for each descriptor set.
    """
    found: dict[object, dict[str, list[_Use]]] = {}
    for stage, module in parsed.items():
        for id_, (_, storage) in module.variables.items():
            for namespace, qualifier, count in _numbers(module, id_, storage):
                kind = Decoration.LOCATION if qualifier == "location" else Decoration.BINDING
                use = _Use(stage, module.decoration_words[id_, kind], count, qualifier)
                names = found.setdefault(namespace, {})
                names.setdefault(interface_name(module, id_), []).append(use)
    yield from found.values()


def _numbers(module: Module, id_: int, storage: int) -> Iterator[tuple[object, str, int]]:
    """The numbers that a variable takes: their range's key, the author's qualifier, how many."""
    if storage not in _NUMBERED:
        return
    pointee = module.variables[id_][0]
    lengths, element = unwrap(module, pointee)
    if module.number(id_, Decoration.LOCATION) is not None:
        yield "location", "location", leaves_count(module, pointee)
    if module.number(id_, Decoration.BINDING) is None:
        return
    descriptor_set = module.number(id_, Decoration.DESCRIPTOR_SET)
    if descriptor_set is not None:
        yield ("set", descriptor_set), "binding", 1
    elif storage != Storage.UNIFORM_CONSTANT:
        stored = module.decorated(element, Decoration.BUFFER_BLOCK) is not None
        yield "storage" if stored else "uniform", "binding", elements_of(lengths)
    elif module.types[element].op in OPAQUE:
        image = module.types[element].op == Op.TYPE_IMAGE
        yield "image" if image else "unit", "binding", elements_of(lengths)


def _renumber(
    uses_by_name: Mapping[str, Sequence[_Use]], words: _Words, sources: Sequence[Source]
) -> None:
    """Renumbers the names of a range if two stages disagree about them."""
    if _agree(uses_by_name, words):
        return
    fixed = {name for name, uses in uses_by_name.items() if _by_author(name, uses, sources)}
    taken = {n for name in fixed for use in uses_by_name[name] for n in use.numbers(words)}
    for name, uses in uses_by_name.items():
        if name in fixed:
            continue
        count = max(use.count for use in uses)
        start = 0
        while taken.intersection(range(start, start + count)):
            start += 1
        taken.update(range(start, start + count))
        for use in uses:
            words[use.stage][use.word] = start


def _agree(uses_by_name: Mapping[str, Sequence[_Use]], words: _Words) -> bool:
    """Whether each name has one number in all stages, and each number one name."""
    owner: dict[int, str] = {}
    return all(
        len({words[use.stage][use.word] for use in uses}) == 1
        and all(owner.setdefault(n, name) == name for use in uses for n in use.numbers(words))
        for name, uses in uses_by_name.items()
    )


def _by_author(name: str, uses: Sequence[_Use], sources: Sequence[Source]) -> bool:
    """Whether the author wrote the name's number in one of the stages that use it."""
    stages, qualifier = {use.stage for use in uses}, uses[0].qualifier
    may = [s for s in sources if s.stage in stages and name and qualifier in s.code]
    return any(found and qualifier in found[1] for found in (declaration(s, name) for s in may))
