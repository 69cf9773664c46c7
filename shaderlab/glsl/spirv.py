"""What a program declares: attributes, varyings, uniforms, blocks, outputs, out of its modules.

Names are GLSL's own, as a driver reports them: "light.constant", "lights[0].position",
"weights" for a whole array, "Block.member" for members of a varying block with an instance name.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from shaderlab.glsl.module import Decoration, Module, Storage, parse
from shaderlab.glsl.types import (
    component_count,
    is_opaque,
    is_struct,
    slots,
    type_name,
    unwrap,
)
from shaderlab.glsl.uses import Path, is_used, used_paths

Interpolation = Literal["smooth", "flat", "noperspective"]

_LOCAL_SIZE = 17  # execution mode


@dataclass(frozen=True, kw_only=True)
class Variable:
    """One input, output or uniform.

    Attributes:
        name: GLSL's name of it.
        type: "float", "vec3", "mat4", "int", "uint", "bool", "sampler2D", "image2D", …
        location: as in the module. Where the author gives none, the compiler chooses one, and
            a driver that is given GLSL may choose another.
        array: how many elements, 0 for a run-time length, None where it is not an array.
        interpolation: of varyings.
        components: numbers in one element, 3 for vec3, 16 for mat4, 0 for samplers.
        used: whether a function that the program calls refers to it; a driver may still find
            that it changes nothing and remove it.
    """

    name: str
    type: str
    location: int | None = None
    array: int | None = None
    interpolation: Interpolation = "smooth"
    components: int = 0
    used: bool = False


@dataclass(frozen=True, kw_only=True)
class Member:
    """One member of a block; sizes, strides and `offset` in bytes, strides 0 where none apply.

    `size` covers all elements of an array; it is 0 for an array of run-time length.
    """

    name: str
    type: str
    offset: int
    size: int
    array: int | None = None
    array_stride: int = 0
    matrix_stride: int = 0
    row_major: bool = False


@dataclass(frozen=True, kw_only=True)
class Block:
    """A uniform or storage block: members by GLSL name less the block's own.

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
    """Everything a program declares, built-ins (`gl_…`) left out. All mappings are by name.

    Attributes:
        attributes: inputs of the vertex stage.
        varyings: inputs of the fragment stage.
        vertex_outputs: outputs of the last stage before rasterisation.
        outputs: outputs of the fragment stage.
        uniforms: uniforms outside blocks, samplers and images among them.
        blocks: uniform and storage blocks.
        local_size: of a compute stage, else None.
    """

    attributes: Mapping[str, Variable] = field(default_factory=dict)
    varyings: Mapping[str, Variable] = field(default_factory=dict)
    vertex_outputs: Mapping[str, Variable] = field(default_factory=dict)
    outputs: Mapping[str, Variable] = field(default_factory=dict)
    uniforms: Mapping[str, Variable] = field(default_factory=dict)
    blocks: Mapping[str, Block] = field(default_factory=dict)
    local_size: tuple[int, int, int] | None = None


@dataclass(frozen=True)
class Leaf:
    """A part of a variable that GLSL names on its own: its type, and the way to it."""

    name: str
    type: int
    path: Path


def reflect(modules: Mapping[str, bytes]) -> Interface:
    """The interface of a program, from one module a stage (made for OpenGL).

    Raises:
        ShaderError: bytes that are not a SPIR-V module.
    """
    parsed = {stage: parse(data) for stage, data in modules.items()}
    none = Module(())
    vertex, fragment = parsed.get("vertex", none), parsed.get("fragment", none)
    last = next((parsed[s] for s in ("geometry", "tess_evaluation", "vertex") if s in parsed), none)
    uniforms: dict[str, Variable] = {}
    blocks: dict[str, Block] = {}
    for module in parsed.values():
        for uniform in _uniforms(module):
            before = uniforms.setdefault(uniform.name, uniform)
            uniforms[uniform.name] = replace(before, used=before.used or uniform.used)
        for block in _blocks(module):
            known = blocks.setdefault(block.name, block)
            blocks[block.name] = replace(known, used=known.used or block.used)
    size = parsed["compute"].modes.get(_LOCAL_SIZE) if "compute" in parsed else None
    return Interface(
        attributes={v.name: v for v in stage_variables(vertex, Storage.INPUT)},
        varyings={v.name: v for v in stage_variables(fragment, Storage.INPUT)},
        vertex_outputs={v.name: v for v in stage_variables(last, Storage.OUTPUT)},
        outputs={v.name: v for v in stage_variables(fragment, Storage.OUTPUT)},
        uniforms=uniforms,
        blocks=blocks,
        local_size=(size[0], size[1], size[2]) if size else None,
    )


def stage_variables(module: Module, storage: int) -> Iterator[Variable]:
    """The inputs or outputs of a stage, flattened, built-ins left out."""
    paths = used_paths(module)
    for id_ in _of_class(module, storage):
        pointee, _ = module.variables[id_]
        element = unwrap(module, pointee)[1]
        is_block = module.decorated(element, Decoration.BLOCK) is not None
        name = module.names.get(id_, "")
        if is_block:
            name = module.names.get(element, "") if name else ""
        at = module.number(id_, Decoration.LOCATION)
        for leaf in leaves(module, pointee, name):
            member = leaf.path[-1] if is_block and leaf.path else None
            own = {} if member is None else module.member(element, member)
            location = own[Decoration.LOCATION][0] if Decoration.LOCATION in own else at
            yield _variable(
                module,
                leaf,
                location=location,
                interpolation=_interpolation({**module.decorations.get(id_, {}), **own}),
                used=is_used(paths.get(id_, ()), leaf.path),
            )
            at = None if at is None else location_after(location, slots(module, leaf.type))


def leaves(module: Module, type_: int, name: str, path: Path = ()) -> Iterator[Leaf]:
    """The parts of a variable that have names of their own, in declaration order."""
    lengths, element = unwrap(module, type_)
    if is_struct(module, type_):
        if lengths:
            for index in range(max(lengths[0], 1)):
                inner = module.types[type_].words[0]
                yield from leaves(module, inner, f"{name}[{index}]", (*path, index))
        else:
            for index, member in enumerate(module.types[element].words):
                own = module.member_names.get((element, index), f"_{index}")
                full = f"{name}.{own}" if name else own
                yield from leaves(module, member, full, (*path, index))
    elif len(lengths) > 1:
        for index in range(max(lengths[0], 1)):
            inner = module.types[type_].words[0]
            yield from leaves(module, inner, f"{name}[{index}]", (*path, index))
    else:
        yield Leaf(name, type_, path)


def location_after(location: int | None, count: int) -> int | None:
    """The location that follows `count` locations from this one."""
    return None if location is None else location + count


def _of_class(module: Module, storage: int) -> Iterator[int]:
    """The variables of a storage class that are the author's own."""
    for id_, (pointee, its) in module.variables.items():
        if its != storage or module.decorated(id_, Decoration.BUILT_IN) is not None:
            continue
        element = unwrap(module, pointee)[1]
        if Decoration.BUILT_IN in module.member(element, 0):
            continue  # gl_PerVertex
        if not module.names.get(id_, "").startswith("gl_"):
            yield id_


def _variable(
    module: Module,
    leaf: Leaf,
    *,
    location: int | None,
    interpolation: Interpolation = "smooth",
    used: bool,
) -> Variable:
    lengths, element = unwrap(module, leaf.type)
    return Variable(
        name=leaf.name,
        type=type_name(module, element),
        location=location,
        array=lengths[0] if lengths else None,
        interpolation=interpolation,
        components=component_count(module, element),
        used=used,
    )


def _interpolation(decorations: Mapping[int, tuple[int, ...]]) -> Interpolation:
    if Decoration.FLAT in decorations:
        return "flat"
    return "noperspective" if Decoration.NO_PERSPECTIVE in decorations else "smooth"


def _uniforms(module: Module) -> Iterator[Variable]:
    paths = used_paths(module)
    for storage in (Storage.UNIFORM_CONSTANT, Storage.ATOMIC_COUNTER):
        for id_ in _of_class(module, storage):
            pointee, _ = module.variables[id_]
            at = module.number(id_, Decoration.LOCATION)
            for leaf in leaves(module, pointee, module.names.get(id_, "")):
                used = is_used(paths.get(id_, ()), leaf.path)
                variable = _variable(module, leaf, location=at, used=used)
                if storage == Storage.ATOMIC_COUNTER:
                    variable = replace(variable, type="atomic_uint", location=None)
                yield variable
                at = location_after(at, max(unwrap(module, leaf.type)[0] or (1,)))


def _blocks(module: Module) -> Iterator[Block]:
    paths = used_paths(module)
    for storage in (Storage.UNIFORM, Storage.STORAGE_BUFFER, Storage.PUSH_CONSTANT):
        for id_ in _of_class(module, storage):
            pointee, _ = module.variables[id_]
            lengths, struct = unwrap(module, pointee)
            buffer = module.decorated(struct, Decoration.BUFFER_BLOCK) is not None
            stored = buffer or storage == Storage.STORAGE_BUFFER
            members = {m.name: m for m in _members(module, struct, "", 0)}
            end = max((m.offset + m.size for m in members.values()), default=0)
            yield Block(
                name=module.names.get(struct, ""),
                kind="storage" if stored else "uniform",
                members=members,
                size=end if stored else -(-end // 16) * 16,
                binding=module.number(id_, Decoration.BINDING),
                array=lengths[0] if lengths else None,
                instance=module.names.get(id_, ""),
                used=bool(paths.get(id_)),
            )


def _members(module: Module, struct: int, name: str, base: int) -> Iterator[Member]:
    for index, type_ in enumerate(module.types[struct].words):
        own = module.member(struct, index)
        word = module.member_names.get((struct, index), f"_{index}")
        offset = base + (own.get(Decoration.OFFSET) or (0,))[0]
        full = f"{name}.{word}" if name else word
        yield from _member(module, type_, full, offset, own)


def _member(
    module: Module, type_: int, name: str, offset: int, own: Mapping[int, tuple[int, ...]]
) -> Iterator[Member]:
    lengths, element = unwrap(module, type_)
    stride = module.number(type_, Decoration.ARRAY_STRIDE) or 0
    if lengths and (is_struct(module, type_) or len(lengths) > 1):
        inner = module.types[type_].words[0]
        for index in range(max(lengths[0], 1)):
            yield from _member(module, inner, f"{name}[{index}]", offset + index * stride, own)
        return
    if is_struct(module, type_):
        yield from _members(module, element, name, offset)
        return
    matrix_stride = (own.get(Decoration.MATRIX_STRIDE) or (0,))[0]
    row_major = Decoration.ROW_MAJOR in own
    size = _bytes(module, element, matrix_stride, row_major)
    yield Member(
        name=name,
        type=type_name(module, element),
        offset=offset,
        size=stride * lengths[0] if lengths else size,
        array=lengths[0] if lengths else None,
        array_stride=stride,
        matrix_stride=matrix_stride,
        row_major=row_major,
    )


def _bytes(module: Module, element: int, matrix_stride: int, row_major: bool) -> int:
    if is_opaque(module, element):
        return 8
    name = type_name(module, element)
    width = 8 if name.startswith("d") else 4
    if matrix_stride:
        columns = module.types[element].words[1]
        rows = component_count(module, element) // columns
        return matrix_stride * (rows if row_major else columns)
    return width * component_count(module, element)
