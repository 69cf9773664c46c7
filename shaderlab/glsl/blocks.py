"""Uniform and storage blocks out of a module: members with offsets, sizes and strides."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from shaderlab.glsl.interface import Block, Member
from shaderlab.glsl.module import Decoration, Module, Storage
from shaderlab.glsl.types import component_count, is_struct, type_name, unwrap
from shaderlab.glsl.uses import used_paths
from shaderlab.glsl.variables import own_variables


def blocks(module: Module) -> Iterator[Block]:
    """The uniform and storage blocks of a module."""
    paths = used_paths(module)
    for storage in (Storage.UNIFORM, Storage.STORAGE_BUFFER, Storage.PUSH_CONSTANT):
        for id_ in own_variables(module, storage):
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
    name = type_name(module, element)
    width = 8 if name.startswith("d") else 4
    if matrix_stride:
        columns = module.types[element].words[1]
        rows = component_count(module, element) // columns
        return matrix_stride * (rows if row_major else columns)
    return width * component_count(module, element)
