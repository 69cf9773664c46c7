"""A program's interface, read from its SPIR-V modules."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import replace

from shaderlab.compiler.interface import Block, Interface, Member, SpecConstant, Variable
from shaderlab.compiler.module import Decoration, Module, Op, Storage, parse
from shaderlab.compiler.types import component_count, type_name, unwrap
from shaderlab.compiler.variables import (
    Leaf,
    leaves,
    own_variables,
    stage_variables,
    uniform_variables,
    used_paths,
)

_LOCAL_SIZE, _OUTPUT_VERTICES = 17, 26  # execution modes
_FORMATS = {"int": "<i", "uint": "<I", "float": "<f", "double": "<d"}


def reflect(modules: Mapping[str, bytes]) -> Interface:
    """A program's interface.

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
    size = parsed["compute"].modes.get(_LOCAL_SIZE) if "compute" in parsed else None
    return Interface(
        attributes={v.name: v for v in stage_variables(vertex, Storage.INPUT)},
        varyings={v.name: v for v in stage_variables(fragment, Storage.INPUT)},
        vertex_outputs={v.name: v for v in stage_variables(last, Storage.OUTPUT)},
        evaluation_inputs={v.name: v for v in stage_variables(evaluation, Storage.INPUT)},
        patch_vertices=control.modes.get(_OUTPUT_VERTICES, (0,))[0],
        outputs={v.name: v for v in stage_variables(fragment, Storage.OUTPUT)},
        uniforms=uniforms,
        blocks=blocks,
        constants={c.name: c for module in parsed.values() for c in _spec_constants(module)},
        local_size=(size[0], size[1], size[2]) if size else None,
    )


def _blocks(module: Module) -> Iterator[Block]:
    """The module's uniform and storage blocks."""
    paths = used_paths(module)
    for storage in (Storage.UNIFORM, Storage.STORAGE_BUFFER, Storage.PUSH_CONSTANT):
        for id_ in own_variables(module, storage):
            pointee, _ = module.variables[id_]
            lengths, element = unwrap(module, pointee)
            buffer = module.decorated(element, Decoration.BUFFER_BLOCK) is not None
            stored = buffer or storage == Storage.STORAGE_BUFFER
            whole = module.decorated(id_, Decoration.NON_WRITABLE) is not None
            found = (_member(module, element, leaf, whole) for leaf in leaves(module, element, ""))
            members = {member.name: member for member in found}
            end = max((m.offset + m.size for m in members.values()), default=0)
            yield Block(
                name=module.names.get(element, ""),
                kind="storage" if stored else "uniform",
                members=members,
                size=end if stored else -(-end // 16) * 16,
                binding=module.number(id_, Decoration.BINDING),
                array=lengths[0] if lengths else None,
                instance=module.names.get(id_, ""),
                used=bool(paths.get(id_)),
            )


def _member(module: Module, struct: int, leaf: Leaf, readonly: bool) -> Member:
    offset, type_, own, record_stride = 0, struct, module.member(struct, 0), 0
    for index in leaf.path:
        instruction = module.types[type_]
        if instruction.op == Op.TYPE_STRUCT:
            own = module.member(type_, index)
            offset += own.get(Decoration.OFFSET, (0,))[0]
            readonly = readonly or Decoration.NON_WRITABLE in own
            type_ = instruction.words[index]
        else:
            stride = module.number(type_, Decoration.ARRAY_STRIDE) or 0
            offset += index * stride
            if instruction.op == Op.TYPE_RUNTIME_ARRAY:
                record_stride = stride
            type_ = instruction.words[0]
    lengths, element = unwrap(module, type_)
    stride = module.number(type_, Decoration.ARRAY_STRIDE) or 0
    matrix_stride = own.get(Decoration.MATRIX_STRIDE, (0,))[0]
    row_major = Decoration.ROW_MAJOR in own
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


def _spec_constants(module: Module) -> Iterator[SpecConstant]:
    """Specialisation constants, such as `layout (constant_id = 3) const int N = 4;`."""
    for id_, instruction in module.specials.items():
        number = module.number(id_, Decoration.SPEC_ID)
        if number is None:
            continue  # computed from others
        type_, _, *words = instruction.words
        name = type_name(module, type_)
        default: int | float | bool = instruction.op == Op.SPEC_CONSTANT_TRUE
        if instruction.op == Op.SPEC_CONSTANT:
            data = struct.pack(f"<{len(words)}I", *words)
            default = struct.unpack(_FORMATS[name], data)[0]
        yield SpecConstant(
            name=module.names.get(id_, ""), type=name, constant_id=number, default=default
        )
