"""What stages say to each other: locations that agree, and inputs that nobody writes.

glslang numbers the varyings and uniforms of each stage on its own, in the order of their use,
even where it links the stages together. The lab makes stages agree by name, as GLSL does.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from itertools import pairwise

from shaderlab.glsl.diagnostics import declaration
from shaderlab.glsl.interface import Variable
from shaderlab.glsl.module import MAGIC, Decoration, Module, Storage, parse
from shaderlab.glsl.numbering import interface_name, numbers, share
from shaderlab.glsl.sources import Source
from shaderlab.glsl.text import STAGES
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
    """An error for each input that a stage uses and the stage before it does not declare, or
    declares as another type at the location that the author gave to both."""
    found = []
    by_stage = {source.stage: source for source in sources}
    order = [stage for stage in STAGES if stage in modules]
    for giver, taker in pairwise(order):
        outputs = list(stage_variables(parse(modules[giver]), Storage.OUTPUT))
        given = {_plain(v.name) for v in outputs}
        at = {v.location: v for v in outputs if v.location is not None}
        source = by_stage[taker]
        for name, variable in _wanted(parse(modules[taker])).items():
            if name in given:
                continue
            declared = declaration(source, name.rpartition(".")[2], "in")
            message = f"'{name}' : input of the {taker} stage that the {giver} stage never writes"
            if declared is not None and "location" in declared[1]:
                other = None if variable.location is None else at.get(variable.location)
                if other is None or other.type == variable.type:
                    continue
                message = (
                    f"'{name}' : {variable.type} at location {variable.location}, where the "
                    f"{giver} stage writes the {other.type} '{other.name}'"
                )
            file, line = source.place(declared[0]) if declared else (source.path, None)
            found.append(
                Diagnostic(file=file, line=line, severity="error", message=message, token=name)
            )
    return tuple(found)


def _wanted(module: Module) -> Mapping[str, Variable]:
    """The inputs that a stage uses, by name."""
    inputs = stage_variables(module, Storage.INPUT)
    return {_plain(variable.name): variable for variable in inputs if variable.used}


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
