"""Changes to SPIR-V modules: locations and bindings that agree between a program's stages, and
transform feedback."""

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from shaderlab.errors import Diagnostic, UnsupportedError

from .diagnostics import find_declaration
from .reflection import leaves, own_variables, stage_variables
from .shader_files import STAGES
from .sources import Source
from .spirv import (
    OPAQUE,
    Capability,
    Decoration,
    ExecutionMode,
    Module,
    Op,
    StorageClass,
    elements_of,
    interface_name,
    leaves_count,
    parse,
    slots,
    unwrap,
)

_NUMBERED = (StorageClass.UniformConstant, StorageClass.Uniform, StorageClass.StorageBuffer)
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


def drop_repeated(module: bytes) -> bytes:
    """Return the module without decorations that it has already."""
    words = struct.unpack(f"{len(module) // 4}I", module)
    kept, seen, at = list(words[:5]), set[tuple[int, ...]](), 5
    while at < len(words):
        one = words[at : at + max(words[at] >> 16, 1)]
        if one[0] & 0xFFFF != Op.Decorate or one not in seen:
            kept += one
        seen.add(one)
        at += len(one)
    return struct.pack(f"{len(kept)}I", *kept)


def match_locations(modules: Mapping[str, bytes], sources: Sequence[Source]) -> dict[str, bytes]:
    """Return the modules with numbers that agree between stages: each input gets the location of
    the previous stage's output of that name, and each uniform, sampler and block one location and
    one binding in all stages. Numbers that the author wrote stay. Modules that agree already are
    not changed."""
    parsed = {stage: parse(data) for stage, data in modules.items()}
    words = {stage: list(module.words) for stage, module in parsed.items()}
    for writer, reader in pairwise(stage for stage in STAGES if stage in parsed):
        _move_inputs(parsed, words, writer, reader)
    for uses_by_name in _namespaces(parsed):
        _renumber(uses_by_name, words, sources)
    return {stage: struct.pack(f"{len(own)}I", *own) for stage, own in words.items()}


def find_unwritten_inputs(
    sources: Sequence[Source], modules: Mapping[str, bytes]
) -> tuple[Diagnostic, ...]:
    """Return an error for each input that a stage uses and the previous stage does not declare, or
    declares with another type at the location that the author gave to both."""
    found = []
    by_stage = {source.stage: source for source in sources}
    for writer, reader in pairwise(stage for stage in STAGES if stage in modules):
        outputs = list(stage_variables(parse(modules[writer]), StorageClass.Output))
        written = {_strip_indices(v.name) for v in outputs}
        at = {v.location: v for v in outputs if v.location is not None}
        source = by_stage[reader]
        inputs = stage_variables(parse(modules[reader]), StorageClass.Input)
        for name, variable in {_strip_indices(v.name): v for v in inputs if v.used}.items():
            if name in written:
                continue
            declared = find_declaration(source, name.rpartition(".")[2], "in")
            message = f"'{name}' : input of the {reader} stage that the {writer} stage never writes"
            if declared is not None and "location" in declared.qualifiers:
                other = None if variable.location is None else at.get(variable.location)
                if other is None or other.type == variable.type:
                    continue
                message = (
                    f"'{name}' : {variable.type} at location {variable.location}, where the "
                    f"{writer} stage writes the {other.type} '{other.name}'"
                )
            at_line = declared.line if declared else None
            found.append(source.diagnostic(message, at_line, token=name))
    return tuple(found)


def _strip_indices(name: str) -> str:
    """Return a name without array indices, which geometry and tessellation stages add by vertex."""
    return "".join(part.partition("]")[2] if i else part for i, part in enumerate(name.split("[")))


def _move_inputs(parsed: Mapping[str, Module], words: _Words, writer: str, reader: str) -> None:
    """Move the reader's inputs to the locations of their outputs, and others out of their way."""
    outputs = _find_locations(parsed, writer, StorageClass.Output)
    inputs = _find_locations(parsed, reader, StorageClass.Input)
    occupied: set[int] = set()
    for name, use in inputs.items():
        if name in outputs:
            numbers = outputs[name].numbers(words)
            words[reader][use.word] = numbers.start
            occupied.update(numbers)
    for name, use in inputs.items():
        if name not in outputs:
            if occupied.intersection(use.numbers(words)):
                words[reader][use.word] = max(occupied) + 1
            occupied.update(use.numbers(words))


def _find_locations(parsed: Mapping[str, Module], stage: str, storage: int) -> dict[str, _Use]:
    """Return a stage's inputs or outputs that have a location, by interface name."""
    module = parsed[stage]
    return {
        interface_name(module, id_): _Use(
            stage,
            module.decoration_words[id_, Decoration.Location],
            slots(module, pointee),
            "location",
        )
        for id_, (pointee, its_storage) in module.variables.items()
        if its_storage == storage and module.number(id_, Decoration.Location) is not None
    }


def _namespaces(parsed: Mapping[str, Module]) -> Iterator[Mapping[str, Sequence[_Use]]]:
    """For each range of numbers that a program's stages share, its uses by name. OpenGL numbers
    uniform locations, texture units, image units, uniform and storage blocks separately; Vulkan has
    one range of bindings for each descriptor set."""
    found: dict[object, dict[str, list[_Use]]] = {}
    for stage, module in parsed.items():
        for id_, (_, storage) in module.variables.items():
            for namespace, qualifier, count in _numbers(module, id_, storage):
                kind = Decoration.Location if qualifier == "location" else Decoration.Binding
                use = _Use(stage, module.decoration_words[id_, kind], count, qualifier)
                names = found.setdefault(namespace, {})
                names.setdefault(interface_name(module, id_), []).append(use)
    yield from found.values()


def _numbers(module: Module, id_: int, storage: int) -> Iterator[tuple[object, str, int]]:
    """Yield a variable's numbers: their range's key, the author's qualifier, how many."""
    if storage not in _NUMBERED:
        return
    pointee = module.variables[id_][0]
    lengths, element = unwrap(module, pointee)
    if module.number(id_, Decoration.Location) is not None:
        yield "location", "location", leaves_count(module, pointee)
    if module.number(id_, Decoration.Binding) is None:
        return
    descriptor_set = module.number(id_, Decoration.DescriptorSet)
    if descriptor_set is not None:
        yield ("set", descriptor_set), "binding", 1
    elif storage != StorageClass.UniformConstant:
        stored = module.decorated(element, Decoration.BufferBlock) is not None
        yield "storage" if stored else "uniform", "binding", elements_of(lengths)
    elif module.types[element].op in OPAQUE:
        image = module.types[element].op == Op.TypeImage
        yield "image" if image else "unit", "binding", elements_of(lengths)


def _renumber(
    uses_by_name: Mapping[str, Sequence[_Use]], words: _Words, sources: Sequence[Source]
) -> None:
    """Renumber the names of a range unless each has one number in all stages, and of its own."""
    owner: dict[int, str] = {}
    if all(
        len({words[use.stage][use.word] for use in uses}) == 1
        and all(owner.setdefault(n, name) == name for use in uses for n in use.numbers(words))
        for name, uses in uses_by_name.items()
    ):
        return
    fixed = {name for name, uses in uses_by_name.items() if _is_authors(name, uses, sources)}
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


def _is_authors(name: str, uses: Sequence[_Use], sources: Sequence[Source]) -> bool:
    """Return whether the author wrote the name's number in one of the stages that use it."""
    stages, qualifier = {use.stage for use in uses}, uses[0].qualifier
    may = [s for s in sources if s.stage in stages and name and qualifier in s.code]
    return any(
        found and qualifier in found.qualifiers
        for found in (find_declaration(s, name) for s in may)
    )


# BuiltIn numbers of what `gl_PerVertex` has.
_BUILT_IN = {0: "gl_Position", 1: "gl_PointSize"}
_CAPTURED = (Decoration.XfbBuffer, Decoration.XfbStride, Decoration.Offset)

Target = tuple[int, int | None]
"""A variable's id, or a struct's with one of its members."""


def add_feedback(data: bytes, sizes: Mapping[str, int]) -> bytes:
    """Return a module of the last stage before rasterisation, decorated so that it captures.
    `sizes` are the components of each output by name, in the order in which they are captured:
    elements of an array and members of a struct follow one another. Raises UnsupportedError: only a
    part of an array or a struct is named, or there is no such output."""
    module = parse(data)
    offsets: dict[Target, int] = {}
    owners = {name: target for target, names in _outputs(module) for name in names}
    at = 0
    for name, size in sizes.items():
        if name not in owners:
            raise UnsupportedError(f"capturing {name!r}: the SPIR-V module has no such output")
        offsets.setdefault(owners[name], at)
        at += 4 * size
    for target, names in _outputs(module):
        if target in offsets and [n for n in sizes if owners[n] == target] != list(names):
            raise UnsupportedError(
                f"capturing {names[0]!r}: a SPIR-V module captures a variable as a whole",
                remedy="pass on fewer or smaller arrays",
            )
    added = [
        word
        for (id_, member), offset in offsets.items()
        for kind, value in zip(_CAPTURED, (0, at, offset), strict=True)
        for word in (
            (4 << 16 | Op.Decorate, id_, kind, value)
            if member is None
            else (5 << 16 | Op.MemberDecorate, id_, member, kind, value)
        )
    ]
    return _insert(module, added)


def _outputs(module: Module) -> Iterator[tuple[Target, tuple[str, ...]]]:
    """Yield each output variable, or member of a block of outputs, with the names of its parts."""
    for pointee, storage in module.variables.values():
        element = unwrap(module, pointee)[1]
        if storage == StorageClass.Output and Decoration.BuiltIn in module.member(element, 0):
            for index in range(len(module.types[element].words)):
                kind = module.member(element, index)[Decoration.BuiltIn][0]
                yield (element, index), (_BUILT_IN.get(kind, ""),)
    for id_ in own_variables(module, StorageClass.Output):
        pointee, _ = module.variables[id_]
        _, element = unwrap(module, pointee)
        name = module.names.get(id_, "")
        if module.decorated(element, Decoration.Block) is None:
            yield (id_, None), tuple(leaf.name for leaf in leaves(module, pointee, name))
            continue
        owner = module.names.get(element, "") if name else ""
        members: dict[int, list[str]] = {}
        for leaf in leaves(module, pointee, owner):
            members.setdefault(leaf.path[0], []).append(leaf.name)
        for index, names in members.items():
            yield (element, index), tuple(names)


def _insert(module: Module, decorations: Sequence[int]) -> bytes:
    """Return the module with what transform feedback takes, each in its section."""
    words = list(module.words)
    mode_at = decorate_at = 0
    at = 5
    while at < len(words):
        op = words[at] & 0xFFFF
        if op == Op.EntryPoint:
            mode_at = at + (words[at] >> 16)
        if op in (Op.Decorate, Op.MemberDecorate) or Op.TypeVoid <= op <= Op.TypePointer:
            decorate_at = at
            break
        at += words[at] >> 16
    words[decorate_at:decorate_at] = decorations
    words[mode_at:mode_at] = [3 << 16 | Op.ExecutionMode, module.entry, ExecutionMode.Xfb]
    words[5:5] = [2 << 16 | Op.Capability, Capability.TransformFeedback]
    return struct.pack(f"{len(words)}I", *words)
