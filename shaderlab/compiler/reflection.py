"""What a program declares, read from its SPIR-V modules: inputs, outputs, uniforms, blocks; and
changes to modules: numbers that agree between stages, and transform feedback."""

from __future__ import annotations

import functools
import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal

from shaderlab.errors import UnsupportedError
from shaderlab.model.records import Diagnostic

from .diagnostics import find_declaration
from .shader_files import STAGES
from .sources import Source
from .spirv import (
    OPAQUE,
    Capability,
    Decoration,
    ExecutionMode,
    Instruction,
    Module,
    Op,
    StorageClass,
    component_count,
    elements_of,
    image_format,
    interface_name,
    leaves_count,
    parse,
    slots,
    type_name,
    unwrap,
)

Path = tuple[int, ...]
"""Indices from a variable to a part of it; `ANY` if computed at run time."""

ANY = -1


@dataclass(frozen=True)
class Leaf:
    """A part of a variable that has a GLSL name: its type, and the path to it."""

    name: str
    type: int
    path: Path


def stage_variables(module: Module, storage: int) -> Iterator[Variable]:
    """Yield a stage's inputs or outputs, flattened, without built-ins."""
    paths = used_paths(module)
    for id_ in own_variables(module, storage):
        pointee, _ = module.variables[id_]
        lengths, element = unwrap(module, pointee)
        is_block = module.decorated(element, Decoration.Block) is not None
        name = module.names.get(id_, "")
        if is_block:
            name = module.names.get(element, "") if name else ""
        at = module.number(id_, Decoration.Location)
        for leaf in leaves(module, pointee, name):
            member = leaf.path[len(lengths)] if is_block else None
            own = {} if member is None else module.member(element, member)
            location = own[Decoration.Location][0] if Decoration.Location in own else at
            decorations = {**module.decorations.get(id_, {}), **own}
            yield _variable(module, leaf, location, paths.get(id_, ()), decorations)
            if at is not None and location is not None:
                at = location + slots(module, leaf.type)


def leaves(module: Module, type_: int, name: str, path: Path = ()) -> Iterator[Leaf]:
    """Yield the parts of a variable that have names, in declaration order."""
    lengths, element = unwrap(module, type_)
    is_struct = module.types[element].op == Op.TypeStruct
    if len(lengths) > 1 or (lengths and is_struct):
        inner = module.types[type_].words[0]
        for index in range(max(lengths[0], 1)):
            yield from leaves(module, inner, f"{name}[{index}]", (*path, index))
    elif is_struct:
        for index, member in enumerate(module.types[element].words):
            own = module.member_names.get((element, index), f"_{index}")
            full = f"{name}.{own}" if name else own
            yield from leaves(module, member, full, (*path, index))
    else:
        yield Leaf(name, type_, path)


def own_variables(module: Module, storage: int) -> Iterator[int]:
    """Yield the ids of a storage class's variables, without built-ins."""
    for id_, (pointee, its) in module.variables.items():
        if its != storage or module.decorated(id_, Decoration.BuiltIn) is not None:
            continue
        element = unwrap(module, pointee)[1]
        if Decoration.BuiltIn in module.member(element, 0):
            continue  # gl_PerVertex
        if not module.names.get(id_, "").startswith("gl_"):
            yield id_


def _variable(
    module: Module,
    leaf: Leaf,
    location: int | None,
    paths: Iterable[Path],
    decorations: Mapping[int, tuple[int, ...]],
) -> Variable:
    lengths, element = unwrap(module, leaf.type)
    interpolation: Interpolation = "smooth"
    if Decoration.Flat in decorations:
        interpolation = "flat"
    elif Decoration.NoPerspective in decorations:
        interpolation = "noperspective"
    return Variable(
        name=leaf.name,
        type=type_name(module, element),
        location=location,
        array=lengths[0] if lengths else None,
        interpolation=interpolation,
        components=component_count(module, element),
        used=is_used(paths, leaf.path),
        patch=Decoration.Patch in decorations,
    )


def uniform_variables(module: Module) -> Iterator[Variable]:
    """Yield the uniforms outside blocks, flattened; includes atomic counters."""
    paths = used_paths(module)
    for storage in (StorageClass.UniformConstant, StorageClass.AtomicCounter):
        for id_ in own_variables(module, storage):
            pointee, _ = module.variables[id_]
            at = module.number(id_, Decoration.Location)
            for leaf in leaves(module, pointee, module.names.get(id_, "")):
                variable = _variable(module, leaf, at, paths.get(id_, ()), {})
                if "image" in variable.type:
                    fixed = module.decorated(id_, Decoration.NonWritable) is not None
                    word = image_format(module, leaf.type)
                    variable = replace(variable, format=word, readonly=fixed)
                if storage == StorageClass.AtomicCounter:
                    variable = replace(variable, type="atomic_uint", location=None)
                yield variable
                if at is not None:
                    at += max(unwrap(module, leaf.type)[0] or (1,))


@functools.lru_cache(maxsize=8)  # called once for each storage class
def used_paths(module: Module) -> Mapping[int, set[Path]]:
    """Return the paths by which a module's functions refer to each variable."""
    paths: dict[int, set[Path]] = {}
    chains: dict[int, tuple[int, Path]] = {}
    for instruction in module.body:
        if instruction.op in (Op.AccessChain, Op.InBoundsAccessChain):
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
    """Return whether a path leads to the part, into it, or to something that contains it."""
    return any(all(a in (ANY, b) for a, b in zip(path, part, strict=False)) for path in paths)


def _pointers(instruction: Instruction) -> tuple[int, ...]:
    """Return the operands that an instruction may read or write memory through."""
    op, words = instruction.op, instruction.words
    if op in (Op.Load, Op.ImageTexelPointer, Op.CopyObject, Op.ArrayLength):
        return words[2:3]
    if op in (Op.Store, Op.AtomicStore):
        return words[:1]
    if op == Op.CopyMemory:
        return words[:2]
    if op == Op.FunctionCall:
        return words[3:]
    if op == Op.ExtInst:
        return words[4:]
    if Op.AtomicLoad <= op <= Op.AtomicXor:
        return words[2:3]
    return ()


Interpolation = Literal["smooth", "flat", "noperspective"]


@dataclass(frozen=True, kw_only=True)
class Variable:
    """One input, output or uniform.

    Attributes:
        name: in GLSL.
        type: "float", "vec3", "mat4", "int", "uint", "bool", "sampler2D", "image2D", …
        location: in the module. Without the author's own, the compiler chooses one, and a driver
            that compiles GLSL may choose another.
        array: the number of elements, 0 if known at run time only, None if it is not an array.
        interpolation: of varyings.
        components: numbers in one element: 3 for vec3, 16 for mat4, 0 for samplers.
        used: whether the program's functions refer to it; a driver may still optimise it away.
        format: of an image, as its layout says ("rgba8"); "" for none.
        readonly: what GLSL says of an image.
        patch: of an evaluation stage's input, whether there is one for the whole patch.
    """

    name: str
    type: str
    location: int | None = None
    array: int | None = None
    interpolation: Interpolation = "smooth"
    components: int = 0
    used: bool = False
    format: str = ""
    readonly: bool = False
    patch: bool = False


@dataclass(frozen=True, kw_only=True)
class Member:
    """One member of a block. Sizes, strides and `offset` are in bytes; strides that don't apply
    are 0. `size` covers all elements of an array, and is 0 for an array of run-time length.

    `record_stride` is that of the array of structs of run-time length that the member lies in; it
    is described for the first of them ("particles[0].position"). `readonly` is what GLSL says of
    members of storage blocks.
    """

    name: str
    type: str
    offset: int
    size: int
    array: int | None = None
    array_stride: int = 0
    matrix_stride: int = 0
    row_major: bool = False
    record_stride: int = 0
    readonly: bool = False


@dataclass(frozen=True, kw_only=True)
class Block:
    """A uniform or storage block: members by their names without the block's.

    `size` is in bytes, rounded up to 16 for uniform blocks as std140 has it; for a storage
    block that ends in an array of run-time length it is the size without that array.
    """

    name: str
    kind: Literal["uniform", "storage"]
    members: Mapping[str, Member]
    size: int
    binding: int | None = None
    array: int | None = None
    instance: str = ""
    used: bool = False


@dataclass(frozen=True, kw_only=True)
class Interface:
    """Everything that a program declares, by name, without built-ins (`gl_…`).

    Attributes:
        attributes: inputs of the vertex stage.
        varyings: inputs of the fragment stage.
        vertex_outputs: outputs of the last stage before rasterisation.
        evaluation_inputs: inputs of the tessellation evaluation stage, by a patch's vertices.
        patch_vertices: of the patches that the tessellation control stage makes; 0 without one.
        outputs: outputs of the fragment stage.
        uniforms: uniforms outside blocks, samplers and images among them.
        blocks: uniform and storage blocks.
        local_size: of a compute stage, or None.
    """

    attributes: Mapping[str, Variable] = field(default_factory=dict)
    varyings: Mapping[str, Variable] = field(default_factory=dict)
    vertex_outputs: Mapping[str, Variable] = field(default_factory=dict)
    evaluation_inputs: Mapping[str, Variable] = field(default_factory=dict)
    patch_vertices: int = 0
    outputs: Mapping[str, Variable] = field(default_factory=dict)
    uniforms: Mapping[str, Variable] = field(default_factory=dict)
    blocks: Mapping[str, Block] = field(default_factory=dict)
    local_size: tuple[int, int, int] | None = None


def reflect(modules: Mapping[str, bytes]) -> Interface:
    """Return a program's interface.

    Args:
        modules: by stage, made for OpenGL.

    Raises:
        ShaderError: bytes that are not a SPIR-V module.
    """
    parsed = {stage: parse(data) for stage, data in modules.items()}
    none = Module(())
    vertex, fragment = parsed.get("vertex", none), parsed.get("fragment", none)
    control, evaluation = parsed.get("tess_control", none), parsed.get("tess_evaluation", none)
    last = next((parsed[s] for s in ("geometry", "tess_evaluation", "vertex") if s in parsed), none)
    uniforms: dict[str, Variable] = {}
    blocks: dict[str, Block] = {}
    for module in parsed.values():
        for uniform in uniform_variables(module):
            before = uniforms.setdefault(uniform.name, uniform)
            uniforms[uniform.name] = replace(before, used=before.used or uniform.used)
        for block in _blocks(module):
            known = blocks.setdefault(block.name, block)
            blocks[block.name] = replace(known, used=known.used or block.used)
    size = parsed["compute"].modes.get(ExecutionMode.LocalSize) if "compute" in parsed else None
    return Interface(
        attributes={v.name: v for v in stage_variables(vertex, StorageClass.Input)},
        varyings={v.name: v for v in stage_variables(fragment, StorageClass.Input)},
        vertex_outputs={v.name: v for v in stage_variables(last, StorageClass.Output)},
        evaluation_inputs={v.name: v for v in stage_variables(evaluation, StorageClass.Input)},
        patch_vertices=control.modes.get(ExecutionMode.OutputVertices, (0,))[0],
        outputs={v.name: v for v in stage_variables(fragment, StorageClass.Output)},
        uniforms=uniforms,
        blocks=blocks,
        local_size=(size[0], size[1], size[2]) if size else None,
    )


def _blocks(module: Module) -> Iterator[Block]:
    """Yield the module's uniform and storage blocks."""
    paths = used_paths(module)
    for storage in (StorageClass.Uniform, StorageClass.StorageBuffer, StorageClass.PushConstant):
        for id_ in own_variables(module, storage):
            pointee, _ = module.variables[id_]
            lengths, element = unwrap(module, pointee)
            buffer = module.decorated(element, Decoration.BufferBlock) is not None
            stored = buffer or storage == StorageClass.StorageBuffer
            whole = module.decorated(id_, Decoration.NonWritable) is not None
            found = (_member(module, element, leaf, whole) for leaf in leaves(module, element, ""))
            members = {member.name: member for member in found}
            end = max((m.offset + m.size for m in members.values()), default=0)
            yield Block(
                name=module.names.get(element, ""),
                kind="storage" if stored else "uniform",
                members=members,
                size=end if stored else -(-end // 16) * 16,
                binding=module.number(id_, Decoration.Binding),
                array=lengths[0] if lengths else None,
                instance=module.names.get(id_, ""),
                used=bool(paths.get(id_)),
            )


def _member(module: Module, struct: int, leaf: Leaf, readonly: bool) -> Member:
    offset, type_, own, record_stride = 0, struct, module.member(struct, 0), 0
    for index in leaf.path:
        instruction = module.types[type_]
        if instruction.op == Op.TypeStruct:
            own = module.member(type_, index)
            offset += own.get(Decoration.Offset, (0,))[0]
            readonly = readonly or Decoration.NonWritable in own
            type_ = instruction.words[index]
        else:
            stride = module.number(type_, Decoration.ArrayStride) or 0
            offset += index * stride
            if instruction.op == Op.TypeRuntimeArray:
                record_stride = stride
            type_ = instruction.words[0]
    lengths, element = unwrap(module, type_)
    stride = module.number(type_, Decoration.ArrayStride) or 0
    matrix_stride = own.get(Decoration.MatrixStride, (0,))[0]
    row_major = Decoration.RowMajor in own
    size = _bytes(module, element, matrix_stride, row_major)
    return Member(
        name=leaf.name,
        type=type_name(module, element),
        offset=offset,
        size=stride * lengths[0] if lengths else size,
        array=lengths[0] if lengths else None,
        array_stride=stride,
        matrix_stride=matrix_stride,
        row_major=row_major,
        record_stride=record_stride,
        readonly=readonly,
    )


def _bytes(module: Module, element: int, matrix_stride: int, row_major: bool) -> int:
    name = type_name(module, element)
    width = 8 if name.startswith("d") else 4
    if matrix_stride:
        columns = module.types[element].words[1]
        rows = component_count(module, element) // columns
        return matrix_stride * (rows if row_major else columns)
    return width * component_count(module, element)


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


def match_locations(modules: Mapping[str, bytes], sources: Sequence[Source]) -> dict[str, bytes]:
    """Return the modules with numbers that agree between stages.

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


def _find_locations(module: Module, storage: int) -> dict[str, tuple[int, int]]:
    """Return variables with a location by interface name: its word's index, and how many."""
    return {
        interface_name(module, id_): (
            module.decoration_words[id_, Decoration.Location],
            slots(module, pointee),
        )
        for id_, (pointee, its_storage) in module.variables.items()
        if its_storage == storage and module.number(id_, Decoration.Location) is not None
    }


def _move_inputs(
    writer: Module, reader: Module, writer_words: Sequence[int], reader_words: list[int]
) -> None:
    """Move the reader's inputs to the locations of their outputs, and others out of their way."""
    outputs = _find_locations(writer, StorageClass.Output)
    inputs = _find_locations(reader, StorageClass.Input)
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
    """Renumber the names of a range if two stages disagree about them."""
    if _agree(uses_by_name, words):
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


def _agree(uses_by_name: Mapping[str, Sequence[_Use]], words: _Words) -> bool:
    """Return whether each name has one number in all stages, and each number one name."""
    owner: dict[int, str] = {}
    return all(
        len({words[use.stage][use.word] for use in uses}) == 1
        and all(owner.setdefault(n, name) == name for use in uses for n in use.numbers(words))
        for name, uses in uses_by_name.items()
    )


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

Target = tuple[int, int | None]
"""A variable's id, or a struct's with one of its members."""


def add_feedback(data: bytes, sizes: Mapping[str, int]) -> bytes:
    """Return a module of the last stage before rasterisation, decorated so that it captures.

    Args:
        data: the module.
        sizes: the components of each output, by name, in the order in which they are captured:
            elements of an array and members of a struct follow one another.

    Raises:
        UnsupportedError: only a part of an array or a struct is named, or there is no such output.
    """
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
        for target, offset in offsets.items()
        for kind, value in (
            (Decoration.XfbBuffer, 0),
            (Decoration.XfbStride, at),
            (Decoration.Offset, offset),
        )
        for word in _decorate(target, kind, value)
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


def _decorate(target: Target, kind: int, value: int) -> Sequence[int]:
    id_, member = target
    if member is None:
        return (4 << 16 | Op.Decorate, id_, kind, value)
    return (5 << 16 | Op.MemberDecorate, id_, member, kind, value)


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
