"""SPIR-V modules as the interpreter sees them: types, instructions, functions, programs."""

from __future__ import annotations

import functools
import math
import struct
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from shaderlab.compiler.compile_cache import compile_with_lines
from shaderlab.compiler.dialects import raise_version
from shaderlab.compiler.glslang import validate
from shaderlab.compiler.shader_files import STAGES
from shaderlab.compiler.sources import LineMap, Source
from shaderlab.compiler.spirv import (
    Decoration,
    ExecutionMode,
    Instruction as Raw,
    Module,
    Op,
    StorageClass,
    adapt,
    parse,
    unwrap,
)
from shaderlab.compiler.translation import read_module
from shaderlab.errors import NotInterpretedError, ShaderError

# In NonSemantic.Shader.DebugInfo.100.
DEBUG_LINE = 103

Kind = Literal["void", "bool", "int", "float", "vector", "matrix", "array", "struct", "image",
               "pointer", "sampler"]  # fmt: skip


@dataclass(frozen=True, eq=False)
class Type:
    """A type of values; sampled images are "image", what has no image is "sampler". A vector, array
    or matrix (of columns) is made `of` so many (`count`), 0 if only known at run time; `base` is
    the scalar that a vector or matrix is made of, else the type itself."""

    kind: Kind
    of: Type | None = None
    count: int = 0
    members: tuple[tuple[str, Type], ...] = ()
    signed: bool = True

    @property
    def base(self) -> Type:
        return self.of.base if self.of is not None and self.kind in ("vector", "matrix") else self

    def part(self, index: int) -> Type:
        """The type of a part: a struct's member, an array's element, a vector's component."""
        if self.kind == "struct":
            return self.members[index][1]
        assert self.of is not None
        return self.of

    def step(self, index: object) -> str:
        """How GLSL goes on to a part after this value's name.

        >>> Type("vector", Type("float"), 3).step(2), Type("array", Type("float"), 3).step(2)
        ('.z', '[2]')
        """
        if self.kind == "struct" and isinstance(index, int):
            return f".{self.members[index][0]}"
        if self.kind == "vector" and isinstance(index, int):
            return f".{'xyzw'[index]}"
        return f"[{index}]"


class Types(dict[int, Type]):
    """A module's types by id, each made when it is first needed; a pointer's id gives the type of
    the pointer, see `Program.variables` for what variables hold. Raises NotInterpretedError: a type
    is unknown, such as `double`."""

    def __init__(self, module: Module) -> None:
        self._module = module

    def __missing__(self, id_: int) -> Type:
        return self.setdefault(id_, self._make(id_))

    def _make(self, id_: int) -> Type:
        module = self._module
        if id_ in module.pointers:
            return Type("pointer")
        op, words = module.types[id_].op, module.types[id_].words
        match op:
            case Op.TypeVoid | Op.TypeBool:
                return Type("void" if op == Op.TypeVoid else "bool")
            case Op.TypeInt | Op.TypeFloat:
                return _make_number("int" if op == Op.TypeInt else "float", words)
            case Op.TypeVector | Op.TypeMatrix:
                kind: Kind = "vector" if op == Op.TypeVector else "matrix"
                return Type(kind, self[words[0]], words[1])
            case Op.TypeArray:
                return Type("array", self[words[0]], module.constants[words[1]])
            case Op.TypeRuntimeArray:
                return Type("array", self[words[0]])
            case Op.TypeStruct:
                names = [module.member_names.get((id_, i), f"_{i}") for i in range(len(words))]
                members = tuple(zip(names, (self[of] for of in words), strict=True))
                return Type("struct", members=members)
            case Op.TypeImage | Op.TypeSampledImage:
                return Type("image")
            case Op.TypeSampler:
                return Type("sampler")
        raise NotInterpretedError(f"not interpreted: a type of SPIR-V's opcode {op}")


def _make_number(kind: Literal["int", "float"], words: tuple[int, ...]) -> Type:
    if words[0] != 32:
        word = {64: "double", 16: "float16_t"}.get(words[0], "a number's type")
        name = word if kind == "float" else f"int{words[0]}_t"
        raise NotInterpretedError(f"not interpreted: {name}")
    return Type(kind, signed=kind == "int" and bool(words[1]))


INPUTS = (
    StorageClass.Input, StorageClass.UniformConstant, StorageClass.Uniform,
    StorageClass.PushConstant, StorageClass.StorageBuffer,
)  # fmt: skip


@dataclass(frozen=True)
class Instruction:
    """One instruction: its opcode, the ids of its result's type and of its result (0 for none),
    its other words, and the line of the source's text that it comes from."""

    op: int
    type: int
    id: int
    operands: tuple[int, ...]
    line: int


@dataclass(eq=False)
class Function:
    """A function's result's type, those of its parameters by id, its blocks by label in the
    module's order, and its variables."""

    id: int
    result: int = 0
    parameters: dict[int, int] = field(default_factory=dict)
    blocks: dict[int, list[Instruction]] = field(default_factory=dict)
    variables: list[int] = field(default_factory=list)

    @functools.cached_property
    def order(self) -> dict[int, int]:
        """Each block's place: what a branch goes round lies before the place where it meets."""
        return {label: place for place, label in enumerate(self.blocks)}


_FIXED = (
    "Vertex'",
    "Normal",
    "Color",
    "MultiTex",
    "TexCoord",
    "Model",
    "Projection",
    "Light",
    "Fog",
)
"""How names of the fixed-function pipeline begin, after `gl_`."""
_FOLDED = (Op.FNegate, Op.FAdd, Op.FSub, Op.FMul, Op.FDiv, Op.VectorTimesScalar)


@dataclass(eq=False)
class Program:
    """One stage, ready to be interpreted: `source` is the text that the lines are of, None for a
    module from elsewhere, `variables` has the type and storage class of each, those of functions
    too, by id."""

    module: Module
    source: Source | None
    types: Types
    functions: dict[int, Function] = field(default_factory=dict)
    variables: dict[int, tuple[Type, int]] = field(default_factory=dict)

    @property
    def stage(self) -> str:
        """Of the source; "" for a module from elsewhere."""
        return "" if self.source is None else self.source.stage

    @property
    def path(self) -> str:
        """The file, though its first line may be an included one; "" if there is none."""
        return "" if self.source is None else self.source.path

    @property
    def main(self) -> Function:
        """The entry point."""
        return self.functions[self.module.entry]

    @functools.cached_property
    def instructions(self) -> tuple[Instruction, ...]:
        """Those of all functions, in the module's order."""
        return tuple(one for f in self.functions.values() for b in f.blocks.values() for one in b)

    @functools.cached_property
    def definitions(self) -> dict[int, Instruction]:
        """The instruction that each result's id stands for."""
        return {one.id: one for one in self.instructions if one.id}

    @functools.cached_property
    def numbers(self) -> frozenset[float]:
        """The numbers in the program's text, and what its integers are compared with."""
        found: set[float] = set()
        for id_, word in self.module.constants.items():
            type_ = self.types[self.module.values[id_].words[0]]
            bits = struct.pack("I", word)
            code = "f" if type_.kind == "float" else "i" if type_.signed else "I"
            found.add(float(struct.unpack(code, bits)[0]))
        for one in self.instructions:
            if one.op == Op.Switch:
                found.update(float(number) for number in one.operands[2::2])
        return frozenset(found)

    @functools.cached_property
    def folded(self) -> frozenset[int]:
        """The results of + - * / on constants alone, which every compiler computes itself."""
        found: set[int] = set()
        for id_, one in self.definitions.items():
            if one.op in _FOLDED and all(
                of in found or of in self.module.values for of in one.operands
            ):
                found.add(id_)
        return frozenset(found)

    @functools.cached_property
    def local_size(self) -> tuple[int, int, int]:
        """A compute stage's workgroup in x, y and z; one invocation of other stages."""
        x, y, z = (*self.module.modes.get(ExecutionMode.LocalSize, ()), 1, 1, 1)[:3]
        return x, y, z

    @functools.cached_property
    def group(self) -> int:
        """How many invocations share variables or wait for each other; 1 if none do."""
        shares = StorageClass.Workgroup in {storage for _, storage in self.variables.values()}
        return math.prod(self.local_size) if shares or self.line_of(Op.ControlBarrier) else 1

    def line_of(self, op: int) -> int:
        """The first line that has an instruction of this opcode, 0 if none does."""
        return next((one.line for one in self.instructions if one.op == op), 0)

    def name(self, id_: int) -> str:
        """GLSL's name of a variable or function, "" for what the compiler made."""
        return self.module.names.get(id_, "")

    def place(self, line: int) -> tuple[str, int]:
        """The author's file and line of an instruction's line."""
        return ("", line) if self.source is None else self.source.place(line)

    def not_interpreted(self, name: str, line: int, remedy: str = "") -> NotInterpretedError:
        """The error about what stands at a line."""
        file, own = self.place(line)
        where = f" at line {own}" if own else ""
        said = f"not interpreted: {name}{where}"
        return NotInterpretedError(said, file=file or None, remedy=remedy or None)


def load(source: Source) -> Program:
    """A shader stage compiled to SPIR-V with the lines of its text, for OpenGL, or for Vulkan if
    only that takes it. Raises ShaderError: it does not compile; NotInterpretedError: the module has
    a type that the interpreter does not know, or is of a geometry or tessellation stage."""
    if source.stage.startswith(("tess_", "geometry")):
        raise NotInterpretedError(f"not interpreted: {source.stage} stage", file=source.path)
    compiled = compile_with_lines(source)
    if not compiled.spirv and (newer := raise_version(source)) != source:
        source, compiled = newer, compile_with_lines(newer)
    for modules in compiled.spirv.values():
        return read(modules[source.stage], source)
    if any("GLSL for Vulkan" in d.message for v in compiled.verdicts for d in v.diagnostics):
        compiled = compiled.only(("vulkan",))
    try:
        compiled.require()
    except ShaderError as error:
        fixed = ("'ftransform", *(f"'gl_{name}" for name in _FIXED))
        if error.message.startswith(fixed):
            error.remedy = "declare it: nothing feeds the fixed-function pipeline here"
        raise
    raise ShaderError("does not become SPIR-V", file=source.path)


def read_file(path: Path, stage: str | None = None) -> Program:
    """The program of a SPIR-V file, or of a shader that another language's compiler makes SPIR-V
    of. Its lines are those that the module states, or the numbers of its instructions. Raises
    ShaderError: it can't be read, or is no valid module; NotInterpretedError: as `load`."""
    try:
        data = read_module(path, stage)
        message = validate(data, "spv1.6")
    except OSError as error:
        message = str(error.strerror)
    if message:
        raise ShaderError(message, file=path)
    module = parse(data)
    if not module.entry:
        remedy = "add one that calls them"
        raise ShaderError("has functions and no entry point", file=path, remedy=remedy)
    wanted = STAGES.index(stage or "fragment")
    module = adapt(module, wanted if wanted in module.entries else module.model)
    source = Source(path.name, str(path), STAGES[module.model], "", LineMap(), ())
    return _build(module, source)


def adopt_names(program: Program, other: Program) -> Program:
    """The program with the names that another one has for what lies in the same place: variables
    between stages by location, blocks by binding or as push constants, their members by offset."""
    module, theirs = program.module, other.module
    names, members = dict(module.names), dict(module.member_names)
    twins = {_find_slot(theirs, id_): id_ for id_ in theirs.variables}
    for id_, twin in ((id_, twins.get(_find_slot(module, id_))) for id_ in module.variables):
        if twin is None or _find_slot(module, id_) is None:
            continue
        mine, own = (unwrap(m, m.variables[v][0])[1] for m, v in ((module, id_), (theirs, twin)))
        named = {id_: theirs.names.get(twin, ""), mine: theirs.names.get(own, "")}
        names.update((key, name) for key, name in named.items() if name)
        by_offset = {
            at: theirs.member_names.get((own, k), "") for k, at in enumerate(_offsets(theirs, own))
        }
        for i, offset in enumerate(_offsets(module, mine)):
            if by_offset.get(offset):
                members[mine, i] = by_offset[offset]
    return _build(replace(module, names=names, member_names=members), program.source)


def _find_slot(module: Module, id_: int) -> tuple[Any, ...] | None:
    storage, given = module.variables[id_][1], module.decorations.get(id_, {})
    if storage == StorageClass.PushConstant:
        return (storage,)
    kinds = (Decoration.Location, Decoration.DescriptorSet, Decoration.Binding)
    slot = tuple(given.get(kind) for kind in kinds)
    return (storage, *slot) if any(slot) else None


def _offsets(module: Module, struct: int) -> list[Any]:
    count = len(module.types[struct].words) if module.types[struct].op == Op.TypeStruct else 0
    return [module.member(struct, i).get(Decoration.Offset) for i in range(count)]


def read(data: bytes, source: Source | None = None) -> Program:
    """A module's bytes as a program; `source` is the text that its lines count. Raises ShaderError:
    the bytes are no SPIR-V module; NotInterpretedError: it has a type that the interpreter does not
    know."""
    return _build(parse(data), source)


def _build(module: Module, source: Source | None) -> Program:
    program = Program(module, source, Types(module))
    for id_, (pointee, storage) in module.variables.items():
        program.variables[id_] = (program.types[pointee], storage)
    line, function, block = 0, Function(0), []
    from_file = source is not None and not source.text
    for number, raw in enumerate(module.body, start=1):
        op, words = raw.op, raw.words
        if op == Op.Line:
            line = words[1]
        elif op == Op.ExtInst and words[2] in module.comments:
            line = module.constants[words[5]] if words[3] == DEBUG_LINE else line
        elif op == Op.Function:
            function = program.functions[words[1]] = Function(words[1], words[0])
        elif op == Op.FunctionParameter:
            function.parameters[words[1]] = words[0]
        elif op == Op.Label:
            block = function.blocks[words[0]] = []
        elif op not in (Op.FunctionEnd, Op.NoLine):
            instruction = _decode(module, raw, line or (number if from_file else 0))
            block.append(instruction)
            if op == Op.Variable:
                pointee, storage = module.pointers[words[0]]
                program.variables[words[1]] = (program.types[pointee], storage)
                function.variables.append(words[1])
    return program


def _decode(module: Module, raw: Raw, line: int) -> Instruction:
    # A type's id is never an operand in the first place, so it tells what has a result.
    words = raw.words
    if words and (words[0] in module.types or words[0] in module.pointers):
        return Instruction(raw.op, words[0], words[1], words[2:], line)
    return Instruction(raw.op, 0, 0, words, line)
