"""What stages say to each other: locations that agree, and inputs that nobody writes.

glslang numbers the varyings and uniforms of each stage on its own, in the order of their use,
even where it links the stages together. The lab makes stages agree by name, as GLSL does.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from shaderlab.glsl.diagnostics import declaration
from shaderlab.glsl.module import MAGIC, Decoration, Module, Storage, parse
from shaderlab.glsl.numbering import interface_name, numbers, share
from shaderlab.glsl.sources import STAGES, Source
from shaderlab.glsl.types import slots
from shaderlab.glsl.variables import stage_variables
from shaderlab.records import Diagnostic


def match_locations(modules: Mapping[str, bytes], sources: Sequence[Source]) -> dict[str, bytes]:
    """The modules with numbers that agree between stages.

    Each input gets the location of the output of its name one stage before, and each uniform,
    sampler and block one location and one binding in all stages. Numbers that the author wrote
    stay; where all agree already, the modules are returned as they are.
    """
    if len(modules) == 1:
        return dict(modules)
    parsed = {stage: parse(data) for stage, data in modules.items()}
    words = {stage: list(module.words) for stage, module in parsed.items()}
    order = [stage for stage in STAGES if stage in parsed]
    for giver, taker in pairwise(order):
        _give(parsed[giver], parsed[taker], words[giver], words[taker])
    for places in numbers(parsed):
        share(places, words, sources)
    return {
        stage: data if tuple(words[stage]) == parsed[stage].words else _pack(words[stage], data)
        for stage, data in modules.items()
    }


def unwritten_inputs(
    sources: Sequence[Source], modules: Mapping[str, bytes]
) -> tuple[Diagnostic, ...]:
    """An error for each input that a stage uses and the stage before it does not declare."""
    found = []
    by_stage = {source.stage: source for source in sources}
    order = [stage for stage in STAGES if stage in modules]
    for giver, taker in pairwise(order):
        given = {_plain(v.name) for v in stage_variables(parse(modules[giver]), Storage.OUTPUT)}
        source = by_stage[taker]
        for name in _wanted(parse(modules[taker])):
            declared = declaration(source, name.rpartition(".")[2], "in")
            explicit = declared is not None and "location" in declared[1]
            if name in given or explicit:
                continue
            file, line = source.place(declared[0]) if declared else (source.path, None)
            message = f"'{name}' : input of the {taker} stage that the {giver} stage never writes"
            found.append(
                Diagnostic(file=file, line=line, severity="error", message=message, token=name)
            )
    return tuple(found)


def _wanted(module: Module) -> Iterator[str]:
    seen: dict[str, None] = {}
    for variable in stage_variables(module, Storage.INPUT):
        if variable.used:
            seen[_plain(variable.name)] = None
    yield from seen


def _plain(name: str) -> str:
    """A name less its array indices, which geometry and tessellation stages add by vertex."""
    return "".join(part.partition("]")[2] if i else part for i, part in enumerate(name.split("[")))


def _located(module: Module, storage: int) -> dict[str, int]:
    """The variables of a class that have a location, by interface name."""
    return {
        interface_name(module, id_): id_
        for id_, (_, its) in module.variables.items()
        if its == storage and module.number(id_, Decoration.LOCATION) is not None
    }


def _give(giver: Module, taker: Module, given: Sequence[int], taken: list[int]) -> None:
    """Moves the taker's inputs to their outputs' locations, and strangers out of their way."""
    outputs = _located(giver, Storage.OUTPUT)
    inputs = _located(taker, Storage.INPUT)
    occupied: set[int] = set()
    for name in inputs.keys() & outputs.keys():
        source = giver.decoration_words[outputs[name], Decoration.LOCATION]
        at = taker.decoration_words[inputs[name], Decoration.LOCATION]
        taken[at] = given[source]
        pointee = giver.variables[outputs[name]][0]
        occupied.update(range(taken[at], taken[at] + slots(giver, pointee)))
    for name in inputs.keys() - outputs.keys():
        at = taker.decoration_words[inputs[name], Decoration.LOCATION]
        span = range(taken[at], taken[at] + slots(taker, taker.variables[inputs[name]][0]))
        if occupied.intersection(span):
            taken[at] = max(occupied) + 1
            span = range(taken[at], taken[at] + len(span))
        occupied.update(span)


def _pack(words: Sequence[int], like: bytes) -> bytes:
    order = "<" if like[:4] == struct.pack("<I", MAGIC) else ">"
    return struct.pack(f"{order}{len(words)}I", *words)
