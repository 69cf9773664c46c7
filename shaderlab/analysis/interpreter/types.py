"""SPIR-V's types as the interpreter sees them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from shaderlab.compiler.reflection import Instruction, Module, Op
from shaderlab.errors import NotInterpretedError

Kind = Literal[
    "void", "bool", "int", "float", "vector", "matrix", "array", "struct", "image", "pointer"
]


@dataclass(frozen=True, eq=False)
class Type:
    """A type of values.

    Attributes:
        kind: see `Kind`; samplers and sampled images are "image".
        of: what a vector, matrix (its columns) or array is made of.
        count: how many of them, 0 if that is known at run time only.
        members: a struct's members by name, in order.
        signed: of integers.
        base: the scalar that a vector or matrix is made of, else the type itself.
    """

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


class Types(Mapping[int, Type]):
    """A module's types by id, each made when it is first asked for; a pointer's id gives the type
    of the pointer, see `Program.variables` for what variables hold.

    Raises:
        NotInterpretedError: a type is unknown, such as `double`.
    """

    def __init__(self, module: Module) -> None:
        self._module = module
        self._known: dict[int, Type] = {}

    def __getitem__(self, id_: int) -> Type:
        if id_ not in self._known:
            self._known[id_] = self._made(id_)
        return self._known[id_]

    def __iter__(self) -> Iterator[int]:
        return iter(self._module.types)

    def __len__(self) -> int:
        return len(self._module.types)

    def _made(self, id_: int) -> Type:
        if id_ in self._module.pointers:
            return Type("pointer")
        declared = self._module.types[id_]
        if declared.op not in _MAKERS:
            raise NotInterpretedError(f"not interpreted: a type of SPIR-V's opcode {declared.op}")
        return _MAKERS[declared.op](self, id_, declared)

    def array(self, _: int, declared: Instruction) -> Type:
        """An array of known length."""
        element, length = declared.words
        return Type("array", self[element], self._module.constants[length])

    def struct(self, id_: int, declared: Instruction) -> Type:
        """A struct with its members' names."""
        names = self._module.member_names
        members = enumerate(declared.words)
        return Type(
            "struct",
            members=tuple((names.get((id_, i), f"_{i}"), self[of]) for i, of in members),
        )

    def number(self, kind: Kind, declared: Instruction) -> Type:
        """An integer or a float of 32 bits."""
        if declared.words[0] != 32:
            word = {64: "double", 16: "float16_t"}.get(declared.words[0], "a number's type")
            raise NotInterpretedError(
                f"not interpreted: {word if kind == 'float' else f'int{declared.words[0]}_t'}"
            )
        return Type(kind, signed=kind == "int" and bool(declared.words[1]))


def _several(kind: Kind) -> _Maker:
    """A maker of vectors, matrices, and arrays whose length is known at run time only."""

    def made(types: Types, _: int, declared: Instruction) -> Type:
        element, count = (*declared.words, 0)[:2]
        return Type(kind, types[element], count)

    return made


def _plain(kind: Kind) -> _Maker:
    return lambda types, id_, declared: Type(kind)


_Maker = Callable[[Types, int, Instruction], Type]
_MAKERS: Mapping[int, _Maker] = {
    Op.TYPE_VOID: _plain("void"),
    Op.TYPE_BOOL: _plain("bool"),
    Op.TYPE_INT: lambda types, id_, declared: types.number("int", declared),
    Op.TYPE_FLOAT: lambda types, id_, declared: types.number("float", declared),
    Op.TYPE_VECTOR: _several("vector"),
    Op.TYPE_MATRIX: _several("matrix"),
    Op.TYPE_IMAGE: _plain("image"),
    Op.TYPE_SAMPLER: _plain("image"),
    Op.TYPE_SAMPLED_IMAGE: _plain("image"),
    Op.TYPE_ARRAY: Types.array,
    Op.TYPE_RUNTIME_ARRAY: _several("array"),
    Op.TYPE_STRUCT: Types.struct,
}
