"""SPIR-V by name: its numbers, and a module's declarations, types and constants.

Layout and numbers: Khronos, SPIR-V Specification 1.6, sections 2.3 and 3, and the extended
instruction set GLSL.std.450. A row of names has consecutive numbers.
"""

import functools
import math
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import NamedTuple

from shaderlab.errors import ShaderError

from .shader_files import OWN

MAGIC = 0x07230203


class Op(IntEnum):
    """The opcodes that GLSL is compiled to."""

    Undef = 1
    Name, MemberName = 5, 6
    Line = 8
    ExtInstImport, ExtInst = 11, 12
    EntryPoint, ExecutionMode, Capability = 15, 16, 17
    TypeVoid, TypeBool, TypeInt, TypeFloat, TypeVector, TypeMatrix = range(19, 25)
    TypeImage, TypeSampler, TypeSampledImage = range(25, 28)
    TypeArray, TypeRuntimeArray, TypeStruct, TypeOpaque, TypePointer = range(28, 33)
    ConstantTrue, ConstantFalse, Constant, ConstantComposite = range(41, 45)
    ConstantNull = 46
    SpecConstantTrue, SpecConstantFalse, SpecConstant = range(48, 51)
    SpecConstantComposite, SpecConstantOp = 51, 52
    Function, FunctionParameter, FunctionEnd, FunctionCall = range(54, 58)
    Variable, ImageTexelPointer, Load, Store, CopyMemory = range(59, 64)
    AccessChain, InBoundsAccessChain = 65, 66
    ArrayLength = 68
    Decorate, MemberDecorate = 71, 72
    VectorExtractDynamic, VectorInsertDynamic, VectorShuffle = range(77, 80)
    CompositeConstruct, CompositeExtract, CompositeInsert, CopyObject, Transpose = range(80, 85)
    SampledImage, ImageSampleImplicitLod, ImageSampleExplicitLod = range(86, 89)
    ImageSampleDrefImplicitLod, ImageSampleDrefExplicitLod = 89, 90
    ImageSampleProjImplicitLod, ImageSampleProjExplicitLod = 91, 92
    ImageSampleProjDrefImplicitLod, ImageSampleProjDrefExplicitLod = 93, 94
    ImageFetch, ImageGather, ImageDrefGather, ImageRead, ImageWrite, Image = range(95, 101)
    ImageQuerySizeLod, ImageQuerySize, ImageQueryLod = range(103, 106)
    ImageQueryLevels, ImageQuerySamples = 106, 107
    ConvertFToU, ConvertFToS, ConvertSToF, ConvertUToF = range(109, 113)
    FConvert = 115
    Bitcast = 124
    SNegate, FNegate, IAdd, FAdd, ISub, FSub, IMul, FMul = range(126, 134)
    UDiv, SDiv, FDiv, UMod, SRem, SMod, FRem, FMod = range(134, 142)
    VectorTimesScalar, MatrixTimesScalar, VectorTimesMatrix = range(142, 145)
    MatrixTimesVector, MatrixTimesMatrix, OuterProduct, Dot = range(145, 149)
    IAddCarry, ISubBorrow, UMulExtended, SMulExtended = range(149, 153)
    Any, All, IsNan, IsInf = range(154, 158)
    LogicalEqual, LogicalNotEqual, LogicalOr, LogicalAnd, LogicalNot = range(164, 169)
    Select, IEqual, INotEqual = range(169, 172)
    UGreaterThan, SGreaterThan, UGreaterThanEqual, SGreaterThanEqual = range(172, 176)
    ULessThan, SLessThan, ULessThanEqual, SLessThanEqual = range(176, 180)
    FOrdEqual, FUnordEqual, FOrdNotEqual, FUnordNotEqual = range(180, 184)
    FOrdLessThan, FUnordLessThan, FOrdGreaterThan, FUnordGreaterThan = range(184, 188)
    FOrdLessThanEqual, FUnordLessThanEqual = 188, 189
    FOrdGreaterThanEqual, FUnordGreaterThanEqual = 190, 191
    ShiftRightLogical, ShiftRightArithmetic, ShiftLeftLogical = range(194, 197)
    BitwiseOr, BitwiseXor, BitwiseAnd, Not = range(197, 201)
    BitFieldInsert, BitFieldSExtract, BitFieldUExtract, BitReverse, BitCount = range(201, 206)
    DPdx, DPdy, Fwidth, DPdxFine, DPdyFine, FwidthFine = range(207, 213)
    DPdxCoarse, DPdyCoarse, FwidthCoarse = range(213, 216)
    EmitVertex, EndPrimitive, EmitStreamVertex, EndStreamPrimitive = range(218, 222)
    ControlBarrier, MemoryBarrier = 224, 225
    AtomicLoad, AtomicStore, AtomicExchange, AtomicCompareExchange = range(227, 231)
    AtomicCompareExchangeWeak, AtomicIIncrement, AtomicIDecrement = range(231, 234)
    AtomicIAdd, AtomicISub, AtomicSMin, AtomicUMin, AtomicSMax = range(234, 239)
    AtomicUMax, AtomicAnd, AtomicOr, AtomicXor = range(239, 243)
    Phi, LoopMerge, SelectionMerge, Label, Branch, BranchConditional, Switch = range(245, 252)
    Kill, Return, ReturnValue, Unreachable = range(252, 256)
    NoLine = 317


class Glsl450(IntEnum):
    """The instructions of the extended set GLSL.std.450, which `Op.ExtInst` calls."""

    Round, RoundEven, Trunc, FAbs, SAbs, FSign, SSign, Floor, Ceil, Fract = range(1, 11)
    Radians, Degrees, Sin, Cos, Tan, Asin, Acos, Atan = range(11, 19)
    Sinh, Cosh, Tanh, Asinh, Acosh, Atanh, Atan2 = range(19, 26)
    Pow, Exp, Log, Exp2, Log2, Sqrt, InverseSqrt = range(26, 33)
    Determinant, MatrixInverse, Modf, ModfStruct = range(33, 37)
    FMin, UMin, SMin, FMax, UMax, SMax, FClamp, UClamp, SClamp, FMix = range(37, 47)
    Step, SmoothStep, Fma, Frexp, FrexpStruct, Ldexp = range(48, 54)
    PackSnorm4x8, PackUnorm4x8, PackSnorm2x16, PackUnorm2x16, PackHalf2x16 = range(54, 59)
    PackDouble2x32, UnpackSnorm2x16, UnpackUnorm2x16, UnpackHalf2x16 = range(59, 63)
    UnpackSnorm4x8, UnpackUnorm4x8, UnpackDouble2x32 = range(63, 66)
    Length, Distance, Cross, Normalize, FaceForward, Reflect, Refract = range(66, 73)
    FindILsb, FindSMsb, FindUMsb = range(73, 76)
    InterpolateAtCentroid, InterpolateAtSample, InterpolateAtOffset = range(76, 79)


class Decoration(IntEnum):
    """The decorations that an interface depends on."""

    RelaxedPrecision, SpecId, Block, BufferBlock, RowMajor = range(5)
    ArrayStride, MatrixStride = 6, 7
    BuiltIn = 11
    NoPerspective, Flat, Patch, Centroid, Sample = range(13, 18)
    NonWritable = 24
    Location = 30
    Binding, DescriptorSet, Offset, XfbBuffer, XfbStride = range(33, 38)


class StorageClass(IntEnum):
    UniformConstant, Input, Uniform, Output, Workgroup = range(5)
    Private = 6
    PushConstant, AtomicCounter = 9, 10
    StorageBuffer = 12


class ExecutionMode(IntEnum):
    PixelCenterInteger, OriginUpperLeft = 6, 7
    Xfb = 11
    LocalSize = 17
    OutputVertices = 26


class Capability(IntEnum):
    """The capabilities of the stages that the lab draws with."""

    Matrix, Shader, Geometry, Tessellation = range(4)
    Float64, Int64 = 10, 11
    Int16, TessellationPointSize, GeometryPointSize, ImageGatherExtended = range(22, 26)
    StorageImageMultisample, UniformBufferArrayDynamicIndexing = 27, 28
    SampledImageArrayDynamicIndexing, StorageBufferArrayDynamicIndexing = 29, 30
    StorageImageArrayDynamicIndexing, ClipDistance, CullDistance = 31, 32, 33
    ImageCubeArray, SampleRateShading = 34, 35
    InputAttachment = 40
    Sampled1D, Image1D, SampledCubeArray, SampledBuffer, ImageBuffer = range(43, 48)
    StorageImageExtendedFormats, ImageQuery, DerivativeControl = 49, 50, 51
    TransformFeedback = 53
    StorageImageReadWithoutFormat, StorageImageWriteWithoutFormat, MultiViewport = 55, 56, 57


class Instruction(NamedTuple):
    """One instruction: its opcode, its operand words, the index of its first word."""

    op: int
    words: tuple[int, ...]
    at: int


@dataclass(eq=False)
class Module:
    """What a module declares, by id. Callers of `parse` share it and must not change it.
    `decorations` have by decoration its literal words, `member_decorations` the same by (id,
    member), `decoration_words` by (id, decoration) the index of the first literal in the module's
    words. `types` have the OpType… instruction, with operands as in the specification, less the id,
    `variables` (pointed-to type, storage class), `initialisers` the id of a variable's constant;
    `constants` the words of scalar ones, `values` the instruction of every one; `comments` are the
    ids of instruction sets that change nothing. `entries` have by a stage's number in
    `shader_files.STAGES` the id of its `main`, and of what that reads and writes of other stages;
    `model` and `entry` are those of one stage."""

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
    variables: dict[int, tuple[int, int]] = field(default_factory=dict)
    initialisers: dict[int, int] = field(default_factory=dict)
    comments: set[int] = field(default_factory=set)
    entries: dict[int, tuple[int, frozenset[int]]] = field(default_factory=dict)
    entry: int = 0
    model: int = 0
    capabilities: set[int] = field(default_factory=set)
    modes: dict[int, tuple[int, ...]] = field(default_factory=dict)
    body: list[Instruction] = field(default_factory=list)

    def decorated(self, id_: int, decoration: int) -> tuple[int, ...] | None:
        """Return a decoration's literals (empty if it has none), or None if it is absent."""
        return self.decorations.get(id_, {}).get(decoration)

    def number(self, id_: int, decoration: int) -> int | None:
        """Return a decoration's first literal, or None if it is absent."""
        literals = self.decorated(id_, decoration)
        return literals[0] if literals else None

    def member(self, id_: int, index: int) -> Mapping[int, tuple[int, ...]]:
        return self.member_decorations.get((id_, index), {})


@functools.lru_cache(maxsize=8)  # matching, checking and reflecting stages parse them in turn
def parse(data: bytes) -> Module:
    """Return the declarations of a module. Raises ShaderError: the bytes are not a SPIR-V module in
    this machine's byte order."""
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
        in_function = in_function or op == Op.Function
        if in_function:
            module.body.append(instruction)
        else:
            _declare(module, instruction)
        at += count
    for id_, (_, storage) in module.variables.items():  # a module without names
        number = module.decorations.get(id_, {}).get(Decoration.Location)
        if number and storage in (StorageClass.Input, StorageClass.Output):
            module.names.setdefault(id_, f"{StorageClass(storage).name.lower()}{number[0]}")
    return module


def count_instructions(data: bytes) -> int:
    """Return how many instructions a module has; the first word of each says how long it is."""
    words = struct.unpack(f"{len(data) // 4}I", data)
    at, count = 5, 0
    while at < len(words):
        at += words[at] >> 16 or 1
        count += 1
    return count


_BUILT_IN = {
    0: "Position", 1: "PointSize", 15: "FragCoord", 16: "PointCoord", 17: "FrontFacing",
    22: "FragDepth", 28: "GlobalInvocationID", 42: "VertexIndex", 43: "InstanceIndex",
}  # fmt: skip
_MADE = ("SLANG_", "_", "RWStructured", "Structured", "EntryPointParams")


def adapt(module: Module, model: int) -> Module:
    """The module of another compiler with a stage's `main`, what that alone reads and writes, and
    names as GLSL has them: of what is built in, and of blocks, whose variables are named."""
    entry, used = module.entries[model]
    module = replace(
        module, entry=entry, model=model, names={**module.names}, variables={**module.variables}
    )
    for id_, (of, storage) in list(module.variables.items()):
        number, element = module.number(id_, Decoration.BuiltIn), unwrap(module, of)[1]
        if storage in (StorageClass.Input, StorageClass.Output) and id_ not in used:
            del module.variables[id_]
        elif number in _BUILT_IN:
            module.names[id_] = f"gl_{_BUILT_IN[number]}"
        elif module.names.get(id_) and module.names.get(element, "_").startswith(_MADE):
            module.names[element] = module.names[id_]
    return module


def _declare(module: Module, instruction: Instruction) -> None:
    op, words, at = instruction.op, instruction.words, instruction.at
    if op == Op.Name:
        module.names[words[0]] = _string(words[1:]).removeprefix(OWN)
    elif op == Op.MemberName:
        module.member_names[words[0], words[1]] = _string(words[2:])
    elif op == Op.Decorate:
        module.decorations.setdefault(words[0], {})[words[1]] = words[2:]
        module.decoration_words[words[0], words[1]] = at + 3
    elif op == Op.MemberDecorate:
        module.member_decorations.setdefault((words[0], words[1]), {})[words[2]] = words[3:]
    elif op == Op.ExtInstImport and _string(words[1:]).startswith("NonSemantic"):
        module.comments.add(words[0])
    elif op == Op.Capability:
        module.capabilities.add(words[0])
    elif op == Op.EntryPoint:
        used = len(_string(words[2:]).encode()) // 4 + 3
        module.entries[words[0]] = words[1], frozenset(words[used:])
        module.model, module.entry = words[:2]
    elif op == Op.ExecutionMode:
        module.modes[words[1]] = words[2:]
    elif op == Op.TypePointer:
        module.pointers[words[0]] = (words[2], words[1])
    elif Op.TypeVoid <= op <= Op.TypeStruct:
        module.types[words[0]] = Instruction(op, words[1:], at)
    elif op == Op.Undef or Op.ConstantTrue <= op <= Op.SpecConstantOp:
        module.values[words[1]] = instruction
        if op in (Op.Constant, Op.SpecConstant):
            module.constants[words[1]] = words[2]
    elif op == Op.Variable:
        module.variables[words[1]] = module.pointers[words[0]]
        if len(words) > 3:
            module.initialisers[words[1]] = words[3]


def _string(words: tuple[int, ...]) -> str:
    return struct.pack(f"<{len(words)}I", *words).split(b"\0")[0].decode("utf-8", "replace")


OPAQUE = (Op.TypeImage, Op.TypeSampler, Op.TypeSampledImage)
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
    """Return the GLSL name of a type: "vec3", "mat4x3", "sampler2DShadow", a struct's own name.

    Arrays give their element's name; see `unwrap`."""
    _, element = unwrap(module, id_)
    instruction = module.types[element]
    op, words = instruction.op, instruction.words
    if op == Op.TypeStruct:
        return module.names.get(element, "")
    if op == Op.TypeVector:
        return f"{_prefix(module, words[0])}vec{words[1]}"
    if op == Op.TypeMatrix:
        column = module.types[words[0]].words
        letter = _prefix(module, column[0])
        shape = f"{words[1]}" if words[1] == column[1] else f"{words[1]}x{column[1]}"
        return f"{letter}mat{shape}"
    if op == Op.TypeSampledImage:
        return _image(module, words[0], "sampler")
    if op == Op.TypeImage:
        return _image(module, element, "texture" if words[5] == 1 else "image")
    if op == Op.TypeSampler:
        return "sampler"
    return _scalar(module, element)


def unwrap(module: Module, id_: int) -> tuple[tuple[int, ...], int]:
    """Return an array's lengths, outermost first (0: known at run time), and its element."""
    lengths = []
    while module.types[id_].op in (Op.TypeArray, Op.TypeRuntimeArray):
        instruction = module.types[id_]
        known = instruction.op == Op.TypeArray
        lengths.append(module.constants.get(instruction.words[1], 0) if known else 0)
        id_ = instruction.words[0]
    return tuple(lengths), id_


def component_count(module: Module, id_: int) -> int:
    """Return the numbers in one element of the type; 0 for structs and opaque types."""
    _, element = unwrap(module, id_)
    op, words = module.types[element].op, module.types[element].words
    if op in (Op.TypeBool, Op.TypeInt, Op.TypeFloat):
        return 1
    if op == Op.TypeVector:
        return words[1]
    if op == Op.TypeMatrix:
        return words[1] * component_count(module, words[0])
    return 0


def slots(module: Module, id_: int) -> int:
    """Return the locations that a varying of the type takes between shader stages."""
    lengths, element = unwrap(module, id_)
    op, words = module.types[element].op, module.types[element].words
    if op == Op.TypeStruct:
        one = sum(slots(module, member) for member in words)
    elif op == Op.TypeMatrix:
        one = words[1] * slots(module, words[0])
    elif op == Op.TypeVector:
        one = 2 if _scalar(module, words[0]) == "double" and words[1] > 2 else 1
    else:
        one = 1
    return one * elements_of(lengths)


def leaves_count(module: Module, id_: int) -> int:
    """Return the locations that a uniform takes: one for each number, vector or matrix."""
    lengths, element = unwrap(module, id_)
    count = 1
    if module.types[element].op == Op.TypeStruct:
        count = sum(leaves_count(module, member) for member in module.types[element].words)
    return count * elements_of(lengths)


def elements_of(lengths: Iterable[int]) -> int:
    """Return the elements of an array of arrays; a length known at run time only counts as one."""
    return math.prod(max(length, 1) for length in lengths)


def image_format(module: Module, id_: int) -> str:
    """Return the format that an image's layout names, "" for none and for what is no image."""
    instruction = module.types[unwrap(module, id_)[1]]
    return _FORMATS[instruction.words[6]] if instruction.op == Op.TypeImage else ""


def _scalar(module: Module, id_: int) -> str:
    op, words = module.types[id_].op, module.types[id_].words
    if op == Op.TypeBool:
        return "bool"
    if op == Op.TypeInt:
        return {(32, 1): "int", (32, 0): "uint"}.get((words[0], words[1]), f"int{words[0]}")
    if op == Op.TypeFloat:
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


def interface_name(module: Module, id_: int) -> str:
    """Return the name that a variable has in all stages: its block's, or its own."""
    element = unwrap(module, module.variables[id_][0])[1]
    blocks = (Decoration.Block, Decoration.BufferBlock)
    is_block = any(module.decorated(element, block) is not None for block in blocks)
    return module.names.get(element if is_block else id_, "")
