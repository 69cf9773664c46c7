"""What a program declares, read from its SPIR-V modules: inputs, outputs, uniforms, blocks."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from .spirv import (
    Decoration,
    ExecutionMode,
    Instruction,
    Module,
    Op,
    StorageClass,
    component_count,
    image_format,
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
    """One input, output or uniform: its type ("float", "vec3", "mat4", "int", "uint", "bool",
    "sampler2D", "image2D", …), its location in the module (without the author's own, the compiler
    chooses one, and a driver that compiles GLSL may choose another), the number of elements of an
    array, 0 if known at run time only, None if it is none, and the numbers in one: 3 for vec3, 16
    for mat4, 0 for samplers. `used` says whether the program's functions refer to it; a driver may
    still optimise it away. An image has the format that its layout says ("rgba8"), and an
    evaluation stage's input may be there once for the whole patch."""

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
    """One member of a block. Sizes, strides and `offset` are in bytes; strides that don't apply are
    0. `size` covers all elements of an array, and is 0 for an array of run-time length.
    `record_stride` is that of the array of structs of run-time length that the member lies in; it
    is described for the first of them ("particles[0].position"). `readonly` is what GLSL says of
    members of storage blocks."""

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
    """A uniform or storage block: members by their names without the block's. `size` is in bytes,
    rounded up to 16 for uniform blocks as std140 has it; for a storage block that ends in an array
    of run-time length it is the size without that array."""

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
    """Everything that a program declares, by name, without built-ins (`gl_…`). Uniforms are those
    outside blocks, samplers and images among them; vertex outputs those of the last stage before
    rasterisation; evaluation inputs those of the tessellation evaluation stage, by a patch's
    vertices; the control stage makes patches of so many (0 without one)."""

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
    """Return a program's interface, read from its modules by stage, made for OpenGL. Raises
    ShaderError: bytes that are not a SPIR-V module."""
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
