"""SPIR-V modules as a whole: validation and disassembly by SPIRV-Tools, and their size."""

from __future__ import annotations

import ctypes as c
import functools
import struct
import sys
from collections.abc import Iterator, Mapping, Sequence

from shaderlab.errors import ShaderError, UnsupportedError, nearest

from .library import SpirvDiagnostic, SpirvText, spirv_tools
from .reflection import leaves, own_variables
from .spirv import Capability, Decoration, ExecutionMode, Module, Op, StorageClass, parse, unwrap

# spv_target_env.
_ENVIRONMENTS: Mapping[str, int] = {
    "spv1.0": 0,
    "vulkan1.0": 1,
    "opengl4.5": 9,
    "vulkan1.1": 18,
    "vulkan1.2": 23,
    "vulkan1.3": 25,
}
_NO_HEADER, _INDENT, _FRIENDLY_NAMES = 1 << 5, 1 << 3, 1 << 6


def validate(module: bytes, env: str) -> str | None:
    """SPIRV-Tools' message about an invalid module, or None if it is valid.

    Args:
        module: SPIR-V as bytes, four a word.
        env: "opengl4.5", "vulkan1.0" … "vulkan1.3" or "spv1.0".

    Raises:
        ShaderError: no such environment, or the library is missing.
    """
    if env not in _ENVIRONMENTS:
        raise ShaderError(
            f"no such SPIR-V environment: {env!r}", remedy=nearest(env, _ENVIRONMENTS)
        )
    tools = spirv_tools()
    message = c.POINTER(SpirvDiagnostic)()
    words = len(module) // 4
    status = tools.spvValidateBinary(_context(env), module, words, c.byref(message))
    try:
        if status == 0:
            return None
        return message.contents.error.decode() if message else f"invalid ({status})"
    finally:
        tools.spvDiagnosticDestroy(message)


def disassemble(module: bytes) -> str:
    """The module as SPIR-V assembly with readable names.

    Raises:
        ShaderError: the bytes are not a SPIR-V module, or the library is missing.
    """
    if len(module) % 4:
        raise ShaderError(f"not a SPIR-V module: {len(module)} bytes are no whole words")
    tools = spirv_tools()
    text, message = c.POINTER(SpirvText)(), c.POINTER(SpirvDiagnostic)()
    options = _NO_HEADER | _INDENT | _FRIENDLY_NAMES
    context, words = _context("spv1.0"), len(module) // 4
    status = tools.spvBinaryToText(context, module, words, options, c.byref(text), c.byref(message))
    try:
        if status != 0:
            why = message.contents.error.decode() if message else f"status {status}"
            raise ShaderError(f"not a SPIR-V module: {why}")
        return c.string_at(text.contents.text, text.contents.length).decode()
    finally:
        tools.spvTextDestroy(text)
        tools.spvDiagnosticDestroy(message)


def instruction_count(module: bytes) -> int:
    """The number of a module's instructions.

    Raises:
        ShaderError: the bytes are not a SPIR-V module.
    """
    if len(module) < 20 or len(module) % 4:
        raise ShaderError(f"not a SPIR-V module: {len(module)} bytes")
    # An instruction's first word has its length in the upper half; a list is read fastest.
    upper = 1 if sys.byteorder == "little" else 0
    lengths = memoryview(module).cast("H")[upper::2].tolist()
    at, end = 5, len(lengths)
    for count in range(end):
        if at >= end:
            return count
        at += lengths[at]
    # An instruction of length 0: the loop did not advance.
    raise ShaderError(f"not a SPIR-V module: broken instruction at word {at}")


@functools.cache
def _context(env: str) -> int:
    """A context for the environment. It is never written to, so all calls and threads share it."""
    context: int = spirv_tools().spvContextCreate(_ENVIRONMENTS[env])
    return context


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
        for kind, value in (
            (Decoration.XfbBuffer, 0),
            (Decoration.XfbStride, at),
            (Decoration.Offset, offset),
        )
        for word in _decorated(target, kind, value)
    ]
    return _inserted(module, added)


def _outputs(module: Module) -> Iterator[tuple[Target, tuple[str, ...]]]:
    """Each output variable, or member of a block of outputs, with the names of its parts."""
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


def _decorated(target: Target, kind: int, value: int) -> Sequence[int]:
    id_, member = target
    if member is None:
        return (4 << 16 | Op.Decorate, id_, kind, value)
    return (5 << 16 | Op.MemberDecorate, id_, member, kind, value)


def _inserted(module: Module, decorations: Sequence[int]) -> bytes:
    """The module with a capability, an execution mode and decorations, each in its section."""
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
