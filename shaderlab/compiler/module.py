"""A SPIR-V module's declarations: names, decorations, types, constants, variables.

Layout and numbers: Khronos, SPIR-V Specification 1.6, sections 2.3 and 3.
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from shaderlab.errors import ShaderError

MAGIC = 0x07230203


class Op:
    """The opcodes of declarations and of their uses."""

    NAME, MEMBER_NAME, EXECUTION_MODE, CAPABILITY = 5, 6, 16, 17
    TYPE_VOID, TYPE_BOOL, TYPE_INT, TYPE_FLOAT, TYPE_VECTOR, TYPE_MATRIX = 19, 20, 21, 22, 23, 24
    TYPE_IMAGE, TYPE_SAMPLER, TYPE_SAMPLED_IMAGE = 25, 26, 27
    TYPE_ARRAY, TYPE_RUNTIME_ARRAY, TYPE_STRUCT, TYPE_POINTER = 28, 29, 30, 32
    UNDEFINED, LINE, ENTRY_POINT = 1, 8, 15
    CONSTANT_TRUE, CONSTANT, CONSTANT_LAST = 41, 43, 52
    SPEC_CONSTANT_TRUE, SPEC_CONSTANT_FALSE, SPEC_CONSTANT = 48, 49, 50
    EXTENDED, FUNCTION, FUNCTION_CALL = 12, 54, 57
    VARIABLE, TEXEL_POINTER, LOAD, STORE, COPY_MEMORY, COPY = 59, 60, 61, 62, 63, 83
    ACCESS_CHAIN, IN_BOUNDS_ACCESS_CHAIN, ARRAY_LENGTH = 65, 66, 68
    DECORATE, MEMBER_DECORATE = 71, 72
    ATOMIC_FIRST, ATOMIC_STORE, ATOMIC_LAST = 227, 228, 242


class Decoration:
    """The decorations that an interface depends on."""

    RELAXED_PRECISION, SPEC_ID = 0, 1
    BLOCK, BUFFER_BLOCK, ROW_MAJOR = 2, 3, 4
    ARRAY_STRIDE, MATRIX_STRIDE, BUILT_IN, NO_PERSPECTIVE, FLAT, PATCH = 6, 7, 11, 13, 14, 15
    LOCATION, BINDING, DESCRIPTOR_SET, OFFSET = 30, 33, 34, 35
    NON_WRITABLE = 24


class Storage:
    """The storage classes of global variables."""

    UNIFORM_CONSTANT, INPUT, UNIFORM, OUTPUT = 0, 1, 2, 3
    WORKGROUP, PRIVATE = 4, 6
    PUSH_CONSTANT, ATOMIC_COUNTER, STORAGE_BUFFER = 9, 10, 12


class Instruction(NamedTuple):
    """One instruction: its opcode, its operand words, the index of its first word."""

    op: int
    words: tuple[int, ...]
    at: int


@dataclass(eq=False)
class Module:
    """What a module declares, by id. Callers of `parse` share it and must not change it.

    Attributes:
        decorations: id → decoration → its literal words; `member_decorations` by (id, member).
        types: id → the OpType… instruction; operands as in the specification, less the id.
        variables: id → (pointed-to type, storage class).
        constants: the words of scalar ones; `values` has the instruction of every constant.
        specials: id of each specialisation constant → the instruction that declares it.
        initialisers: id of each variable that has one → the id of the constant.
        capabilities: the numbers of those that it takes.
        entry: the id of the function that is the stage's `main`.
        decoration_words: (id, decoration) → index of its first literal in the module's words.
        body: the instructions inside functions.
    """

    words: tuple[int, ...]
    names: dict[int, str] = field(default_factory=dict)
    member_names: dict[tuple[int, int], str] = field(default_factory=dict)
    decorations: dict[int, dict[int, tuple[int, ...]]] = field(default_factory=dict)
    member_decorations: dict[tuple[int, int], dict[int, tuple[int, ...]]] = field(
        default_factory=dict
    )
    decoration_words: dict[tuple[int, int], int] = field(default_factory=dict)
    types: dict[int, Instruction] = field(default_factory=dict)
    pointers: dict[int, tuple[int, int]] = field(default_factory=dict)
    constants: dict[int, int] = field(default_factory=dict)
    values: dict[int, Instruction] = field(default_factory=dict)
    specials: dict[int, Instruction] = field(default_factory=dict)
    variables: dict[int, tuple[int, int]] = field(default_factory=dict)
    initialisers: dict[int, int] = field(default_factory=dict)
    entry: int = 0
    capabilities: set[int] = field(default_factory=set)
    modes: dict[int, tuple[int, ...]] = field(default_factory=dict)
    body: list[Instruction] = field(default_factory=list)

    def decorated(self, id_: int, decoration: int) -> tuple[int, ...] | None:
        """A decoration's literals (empty if it has none), or None if it is absent."""
        return self.decorations.get(id_, {}).get(decoration)

    def number(self, id_: int, decoration: int) -> int | None:
        """A decoration's first literal, or None if it is absent."""
        literals = self.decorated(id_, decoration)
        return literals[0] if literals else None

    def member(self, id_: int, index: int) -> Mapping[int, tuple[int, ...]]:
        """The decorations of a struct's member."""
        return self.member_decorations.get((id_, index), {})


@functools.lru_cache(maxsize=8)  # matching, checking and reflecting stages parse them in turn
def parse(data: bytes) -> Module:
    """The declarations of a module.

    Raises:
        ShaderError: the bytes are not a SPIR-V module in this machine's byte order.
    """
    if len(data) < 20 or len(data) % 4:
        raise ShaderError(f"not a SPIR-V module: {len(data)} bytes")
    words = struct.unpack(f"{len(data) // 4}I", data)
    if words[0] != MAGIC:
        raise ShaderError(f"not a SPIR-V module: it begins with 0x{words[0]:08x}")
    module = Module(words)
    at, in_function = 5, False
    while at < len(words):
        count, op = words[at] >> 16, words[at] & 0xFFFF
        if count == 0 or at + count > len(words):
            raise ShaderError(f"not a SPIR-V module: broken instruction at word {at}")
        instruction = Instruction(op, words[at + 1 : at + count], at)
        in_function = in_function or op == Op.FUNCTION
        if in_function:
            module.body.append(instruction)
        else:
            _declare(module, instruction)
        at += count
    return module


def _declare(module: Module, instruction: Instruction) -> None:
    op, words, at = instruction.op, instruction.words, instruction.at
    if op == Op.UNDEFINED or Op.CONSTANT_TRUE <= op <= Op.CONSTANT_LAST:
        module.values[words[1]] = instruction
    if op == Op.NAME:
        module.names[words[0]] = _string(words[1:])
    elif op == Op.MEMBER_NAME:
        module.member_names[words[0], words[1]] = _string(words[2:])
    elif op == Op.DECORATE:
        module.decorations.setdefault(words[0], {})[words[1]] = words[2:]
        module.decoration_words[words[0], words[1]] = at + 3
    elif op == Op.MEMBER_DECORATE:
        module.member_decorations.setdefault((words[0], words[1]), {})[words[2]] = words[3:]
    elif op == Op.CAPABILITY:
        module.capabilities.add(words[0])
    elif op == Op.ENTRY_POINT:
        module.entry = words[1]
    elif op == Op.EXECUTION_MODE:
        module.modes[words[1]] = words[2:]
    elif op == Op.TYPE_POINTER:
        module.pointers[words[0]] = (words[2], words[1])
    elif Op.TYPE_VOID <= op <= Op.TYPE_STRUCT:
        module.types[words[0]] = Instruction(op, words[1:], at)
    elif op in (Op.CONSTANT, Op.SPEC_CONSTANT):
        module.constants[words[1]] = words[2]
        if op == Op.SPEC_CONSTANT:
            module.specials[words[1]] = instruction
    elif op in (Op.SPEC_CONSTANT_TRUE, Op.SPEC_CONSTANT_FALSE):
        module.specials[words[1]] = instruction
    elif op == Op.VARIABLE:
        module.variables[words[1]] = module.pointers[words[0]]
        if len(words) > 3:
            module.initialisers[words[1]] = words[3]


def _string(words: tuple[int, ...]) -> str:
    return struct.pack(f"<{len(words)}I", *words).split(b"\0")[0].decode("utf-8", "replace")
