"""Transform feedback of a SPIR-V module: it names what is captured itself, by decorations.

Source: Khronos, SPIR-V Specification 1.6, sections 3.6 (Xfb), 3.20 (XfbBuffer, XfbStride, Offset)
and 3.31 (TransformFeedback).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence

from shaderlab.compiler.module import Decoration, Module, Op, Storage, parse
from shaderlab.compiler.types import unwrap
from shaderlab.compiler.variables import leaves, own_variables
from shaderlab.errors import UnsupportedError

_CAPABILITY, _TRANSFORM_FEEDBACK, _XFB = 17, 53, 11
_BUFFER, _STRIDE = 36, 37
_BUILT_IN = {0: "gl_Position", 1: "gl_PointSize"}

Target = tuple[int, int | None]
"""A variable's id, or a struct's with one of its members."""


def with_feedback(data: bytes, sizes: Mapping[str, int]) -> bytes:
    """A module of the last stage before rasterisation, decorated so that it captures.

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
        for kind, value in ((_BUFFER, 0), (_STRIDE, at), (Decoration.OFFSET, offset))
        for word in _decorated(target, kind, value)
    ]
    return _inserted(module, added)


def _outputs(module: Module) -> Iterator[tuple[Target, tuple[str, ...]]]:
    """Each output variable, or member of a block of outputs, with the names of its parts."""
    for pointee, storage in module.variables.values():
        element = unwrap(module, pointee)[1]
        if storage == Storage.OUTPUT and Decoration.BUILT_IN in module.member(element, 0):
            for index in range(len(module.types[element].words)):
                kind = module.member(element, index)[Decoration.BUILT_IN][0]
                yield (element, index), (_BUILT_IN.get(kind, ""),)
    for id_ in own_variables(module, Storage.OUTPUT):
        pointee, _ = module.variables[id_]
        _, element = unwrap(module, pointee)
        name = module.names.get(id_, "")
        if module.decorated(element, Decoration.BLOCK) is None:
            yield (id_, None), tuple(leaf.name for leaf in leaves(module, pointee, name))
            continue
        owner = module.names.get(element, "") if name else ""
        members: dict[int, list[str]] = {}
        for leaf in leaves(module, pointee, owner):
            members.setdefault(leaf.path[0], []).append(leaf.name)
        for index, names in members.items():
            yield (element, index), tuple(names)


def _decorated(target: Target, kind: int, value: int) -> Sequence[int]:
    id_, member = target
    if member is None:
        return (4 << 16 | Op.DECORATE, id_, kind, value)
    return (5 << 16 | Op.MEMBER_DECORATE, id_, member, kind, value)


def _inserted(module: Module, decorations: Sequence[int]) -> bytes:
    """The module with a capability, an execution mode and decorations, each in its section."""
    words = list(module.words)
    mode_at = decorate_at = 0
    at = 5
    while at < len(words):
        op = words[at] & 0xFFFF
        if op == Op.ENTRY_POINT:
            mode_at = at + (words[at] >> 16)
        if op in (Op.DECORATE, Op.MEMBER_DECORATE) or Op.TYPE_VOID <= op <= Op.TYPE_POINTER:
            decorate_at = at
            break
        at += words[at] >> 16
    words[decorate_at:decorate_at] = decorations
    words[mode_at:mode_at] = [3 << 16 | Op.EXECUTION_MODE, module.entry, _XFB]
    words[5:5] = [2 << 16 | _CAPABILITY, _TRANSFORM_FEEDBACK]
    return struct.pack(f"{len(words)}I", *words)
