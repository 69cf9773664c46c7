"""A SPIR-V module's declarations: names, decorations, types, constants, variables.

Layout and numbers: Khronos, SPIR-V Specification 1.6, sections 2.3 and 3.
"""

from __future__ import annotations

import functools
import math
import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

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


OPAQUE = (Op.TYPE_IMAGE, Op.TYPE_SAMPLER, Op.TYPE_SAMPLED_IMAGE)
# The image formats of SPIR-V 1.6, 3.11, by their numbers from 0 on, as GLSL spells them.
_FORMATS = (
    "", "rgba32f", "rgba16f", "r32f", "rgba8", "rgba8_snorm", "rg32f", "rg16f", "r11f_g11f_b10f",
    "r16f", "rgba16", "rgb10_a2", "rg16", "rg8", "r16", "r8", "rgba16_snorm", "rg16_snorm",
    "rg8_snorm", "r16_snorm", "r8_snorm", "rgba32i", "rgba16i", "rgba8i", "r32i", "rg32i", "rg16i",
    "rg8i", "r16i", "r8i", "rgba32ui", "rgba16ui", "rgba8ui", "r32ui", "rgb10_a2ui", "rg32ui",
    "rg16ui", "rg8ui", "r16ui", "r8ui", "r64ui", "r64i",
)  # fmt: skip
_DIMENSIONS = {0: "1D", 1: "2D", 2: "3D", 3: "Cube", 4: "2DRect", 5: "Buffer"}


def type_name(module: Module, id_: int) -> str:
    """The GLSL name of a type: "vec3", "mat4x3", "sampler2DShadow", a struct's own name.

    Arrays give their element's name; see `unwrap`.
    """
    _, element = unwrap(module, id_)
    instruction = module.types[element]
    op, words = instruction.op, instruction.words
    if op == Op.TYPE_STRUCT:
        return module.names.get(element, "")
    if op == Op.TYPE_VECTOR:
        return f"{_prefix(module, words[0])}vec{words[1]}"
    if op == Op.TYPE_MATRIX:
        column = module.types[words[0]].words
        letter = _prefix(module, column[0])
        shape = f"{words[1]}" if words[1] == column[1] else f"{words[1]}x{column[1]}"
        return f"{letter}mat{shape}"
    if op == Op.TYPE_SAMPLED_IMAGE:
        return _image(module, words[0], "sampler")
    if op == Op.TYPE_IMAGE:
        return _image(module, element, "image")
    if op == Op.TYPE_SAMPLER:
        return "sampler"
    return _scalar(module, element)


def unwrap(module: Module, id_: int) -> tuple[tuple[int, ...], int]:
    """An array type's lengths, outermost first (0 if known at run time only), and its element."""
    lengths = []
    while module.types[id_].op in (Op.TYPE_ARRAY, Op.TYPE_RUNTIME_ARRAY):
        instruction = module.types[id_]
        known = instruction.op == Op.TYPE_ARRAY
        lengths.append(module.constants.get(instruction.words[1], 0) if known else 0)
        id_ = instruction.words[0]
    return tuple(lengths), id_


def component_count(module: Module, id_: int) -> int:
    """The numbers in one element of the type; 0 for structs and opaque types."""
    _, element = unwrap(module, id_)
    op, words = module.types[element].op, module.types[element].words
    if op in (Op.TYPE_BOOL, Op.TYPE_INT, Op.TYPE_FLOAT):
        return 1
    if op == Op.TYPE_VECTOR:
        return words[1]
    if op == Op.TYPE_MATRIX:
        return words[1] * component_count(module, words[0])
    return 0


def slots(module: Module, id_: int) -> int:
    """The locations that a varying of the type takes between shader stages."""
    lengths, element = unwrap(module, id_)
    op, words = module.types[element].op, module.types[element].words
    if op == Op.TYPE_STRUCT:
        one = sum(slots(module, member) for member in words)
    elif op == Op.TYPE_MATRIX:
        one = words[1] * slots(module, words[0])
    elif op == Op.TYPE_VECTOR:
        one = 2 if _scalar(module, words[0]) == "double" and words[1] > 2 else 1
    else:
        one = 1
    return one * elements_of(lengths)


def leaves_count(module: Module, id_: int) -> int:
    """The locations that a uniform of the type takes: one for each number, vector or matrix."""
    lengths, element = unwrap(module, id_)
    count = 1
    if module.types[element].op == Op.TYPE_STRUCT:
        count = sum(leaves_count(module, member) for member in module.types[element].words)
    return count * elements_of(lengths)


def elements_of(lengths: Iterable[int]) -> int:
    """The elements of an array of arrays; a length known at run time only counts as one."""
    return math.prod(max(length, 1) for length in lengths)


def image_format(module: Module, id_: int) -> str:
    """The format that an image's layout names, "" for none and for what is no image."""
    instruction = module.types[unwrap(module, id_)[1]]
    return _FORMATS[instruction.words[6]] if instruction.op == Op.TYPE_IMAGE else ""


def _scalar(module: Module, id_: int) -> str:
    op, words = module.types[id_].op, module.types[id_].words
    if op == Op.TYPE_BOOL:
        return "bool"
    if op == Op.TYPE_INT:
        return {(32, 1): "int", (32, 0): "uint"}.get((words[0], words[1]), f"int{words[0]}")
    if op == Op.TYPE_FLOAT:
        return {32: "float", 64: "double"}.get(words[0], f"float{words[0]}")
    return "void"


def _prefix(module: Module, id_: int) -> str:
    return {"float": "", "int": "i", "uint": "u", "bool": "b", "double": "d"}.get(
        _scalar(module, id_), ""
    )


def _image(module: Module, id_: int, kind: str) -> str:
    """OpTypeImage's operands: sampled type, dimension, depth, arrayed, multisampled, …"""
    sampled, dimension, depth, arrayed, multisampled, *_ = module.types[id_].words
    if dimension == 6:
        return "subpassInput"
    return (
        _prefix(module, sampled)
        + kind
        + _DIMENSIONS.get(dimension, "")
        + ("MS" if multisampled else "")
        + ("Array" if arrayed else "")
        + ("Shadow" if depth == 1 and kind == "sampler" else "")
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
    """A stage's inputs or outputs, flattened, without built-ins."""
    paths = used_paths(module)
    for id_ in own_variables(module, storage):
        pointee, _ = module.variables[id_]
        lengths, element = unwrap(module, pointee)
        is_block = module.decorated(element, Decoration.BLOCK) is not None
        name = module.names.get(id_, "")
        if is_block:
            name = module.names.get(element, "") if name else ""
        at = module.number(id_, Decoration.LOCATION)
        for leaf in leaves(module, pointee, name):
            member = leaf.path[len(lengths)] if is_block else None
            own = {} if member is None else module.member(element, member)
            location = own[Decoration.LOCATION][0] if Decoration.LOCATION in own else at
            decorations = {**module.decorations.get(id_, {}), **own}
            yield _variable(module, leaf, location, paths.get(id_, ()), decorations)
            if at is not None and location is not None:
                at = location + slots(module, leaf.type)


def leaves(module: Module, type_: int, name: str, path: Path = ()) -> Iterator[Leaf]:
    """The parts of a variable that have names, in declaration order."""
    lengths, element = unwrap(module, type_)
    is_struct = module.types[element].op == Op.TYPE_STRUCT
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
    """The ids of a storage class's variables, without built-ins."""
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
    location: int | None,
    paths: Iterable[Path],
    decorations: Mapping[int, tuple[int, ...]],
) -> Variable:
    lengths, element = unwrap(module, leaf.type)
    interpolation: Interpolation = "smooth"
    if Decoration.FLAT in decorations:
        interpolation = "flat"
    elif Decoration.NO_PERSPECTIVE in decorations:
        interpolation = "noperspective"
    return Variable(
        name=leaf.name,
        type=type_name(module, element),
        location=location,
        array=lengths[0] if lengths else None,
        interpolation=interpolation,
        components=component_count(module, element),
        used=is_used(paths, leaf.path),
        patch=Decoration.PATCH in decorations,
    )


def uniform_variables(module: Module) -> Iterator[Variable]:
    """The uniforms outside blocks, flattened; includes atomic counters."""
    paths = used_paths(module)
    for storage in (Storage.UNIFORM_CONSTANT, Storage.ATOMIC_COUNTER):
        for id_ in own_variables(module, storage):
            pointee, _ = module.variables[id_]
            at = module.number(id_, Decoration.LOCATION)
            for leaf in leaves(module, pointee, module.names.get(id_, "")):
                variable = _variable(module, leaf, at, paths.get(id_, ()), {})
                if "image" in variable.type:
                    fixed = module.decorated(id_, Decoration.NON_WRITABLE) is not None
                    word = image_format(module, leaf.type)
                    variable = replace(variable, format=word, readonly=fixed)
                if storage == Storage.ATOMIC_COUNTER:
                    variable = replace(variable, type="atomic_uint", location=None)
                yield variable
                if at is not None:
                    at += max(unwrap(module, leaf.type)[0] or (1,))


@functools.lru_cache(maxsize=8)  # called once for each storage class
def used_paths(module: Module) -> Mapping[int, set[Path]]:
    """The paths by which a module's functions refer to each variable."""
    paths: dict[int, set[Path]] = {}
    chains: dict[int, tuple[int, Path]] = {}
    for instruction in module.body:
        if instruction.op in (Op.ACCESS_CHAIN, Op.IN_BOUNDS_ACCESS_CHAIN):
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
    """Whether one of the paths leads to the part, into it, or to something that contains it."""
    return any(all(a in (ANY, b) for a, b in zip(path, part, strict=False)) for path in paths)


def _pointers(instruction: Instruction) -> tuple[int, ...]:
    """The operands that an instruction may read or write memory through."""
    op, words = instruction.op, instruction.words
    if op in (Op.LOAD, Op.TEXEL_POINTER, Op.COPY, Op.ARRAY_LENGTH):
        return words[2:3]
    if op in (Op.STORE, Op.ATOMIC_STORE):
        return words[:1]
    if op == Op.COPY_MEMORY:
        return words[:2]
    if op == Op.FUNCTION_CALL:
        return words[3:]
    if op == Op.EXTENDED:
        return words[4:]
    if Op.ATOMIC_FIRST <= op <= Op.ATOMIC_LAST:
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
class SpecConstant:
    """A specialisation constant: GLSL's name and type, its `constant_id`, its default value."""

    name: str
    type: str
    constant_id: int
    default: int | float | bool


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
        constants: specialisation constants.
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
    constants: Mapping[str, SpecConstant] = field(default_factory=dict)
    local_size: tuple[int, int, int] | None = None


_LOCAL_SIZE, _OUTPUT_VERTICES = 17, 26  # execution modes
_FORMATS_reflection = {"int": "<i", "uint": "<I", "float": "<f", "double": "<d"}


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
            default = struct.unpack(_FORMATS_reflection[name], data)[0]
        yield SpecConstant(
            name=module.names.get(id_, ""), type=name, constant_id=number, default=default
        )
