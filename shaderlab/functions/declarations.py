"""GLSL's types, and what a file declares at its top level, read from its preprocessed text.

In Python, a value of a type is an array whose last axes are the type's own `shape`; all axes before
those are the batch, over which a function is called. A struct is a mapping of its members, an array
of structs a sequence of such mappings.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from shaderlab.compiler.syntax import GlslDeclaration, Syntax, TypeSpecifier, check_brackets

_BASIC = re.compile(
    r"(?P<scalar>float|int|uint|bool)|(?P<kind>[iub]?)vec(?P<size>[234])"
    r"|mat(?P<columns>[234])(?:x(?P<rows>[234]))?"
)
_OPAQUE = re.compile(r"[iu]?(sampler|image|texture|subpassInput)\w*|sampler|atomic_uint")
_KINDS = {"": "float", "i": "int", "u": "uint", "b": "bool"}
DTYPES = {"float": "float32", "int": "int32", "uint": "uint32", "bool": "bool"}
"""NumPy's type for each kind of number."""


@dataclass(frozen=True)
class Type:
    """A GLSL type.

    Attributes:
        name: without array lengths: "vec3", "Light", "sampler2D".
        dims: array lengths, the outermost first.
        members: of a struct, by name, in order.
    """

    name: str
    dims: tuple[int, ...] = ()
    members: tuple[tuple[str, Type], ...] = ()

    def __str__(self) -> str:
        return self.name + "".join(f"[{n}]" for n in self.dims)

    @cached_property
    def kind(self) -> str:
        """What its numbers are: "float", "int", "uint" or "bool"; "" for any other type."""
        match = _BASIC.fullmatch(self.name)
        if match is None:
            return ""
        return match["scalar"] or _KINDS[match["kind"] or ""]

    @cached_property
    def base_shape(self) -> tuple[int, ...]:
        """The shape of one element: () for a scalar, (n,), or (rows, columns)."""
        match = _BASIC.fullmatch(self.name)
        if match is None or match["scalar"]:
            return ()
        if match["size"]:
            return (int(match["size"]),)
        return (int(match["rows"] or match["columns"]), int(match["columns"]))

    @property
    def shape(self) -> tuple[int, ...]:
        """The last axes of an array of such values: array lengths, then `base_shape`."""
        return self.dims + self.base_shape

    @property
    def element(self) -> Type:
        """The type of an element along an array's outermost axis."""
        return Type(self.name, self.dims[1:], self.members)

    @cached_property
    def opaque(self) -> bool:
        """Whether it is a sampler, or holds one."""
        return bool(_OPAQUE.fullmatch(self.name)) or any(t.opaque for _, t in self.members)

    @cached_property
    def known(self) -> bool:
        """Whether it can be passed and returned as numbers."""
        if self.members:
            return all(t.known for _, t in self.members)
        return bool(self.kind)

    @cached_property
    def words(self) -> int:
        """How many 32-bit words a value takes."""
        inner = sum(t.words for _, t in self.members)
        return math.prod(self.dims) * (inner or math.prod(self.base_shape))

    def leaves(self, name: str) -> Iterator[tuple[str, Type]]:
        """The whole name and the type of each member that is no struct: "lights[0].power"."""
        if self.dims and (self.members or self.opaque):
            for n in range(self.dims[0]):
                yield from self.element.leaves(f"{name}[{n}]")
        elif self.members:
            for member, its in self.members:
                yield from its.leaves(f"{name}.{member}")
        else:
            yield name, self


@dataclass(frozen=True)
class Declarations:
    """A file's declarations.

    Attributes:
        text: preprocessed, with directives blanked out.
        extensions: its `#extension` lines.
        all: in order.
        constants: the values of its integer constants, by name.
    """

    text: str
    extensions: tuple[str, ...]
    all: tuple[GlslDeclaration, ...]
    constants: Mapping[str, int]

    @cached_property
    def _structs(self) -> dict[str, GlslDeclaration]:
        return {one.name: one for one in self.all if one.kind in ("struct", "block")}

    def functions(self) -> dict[str, list[GlslDeclaration]]:
        """Function definitions by name; several where it is overloaded."""
        found: dict[str, list[GlslDeclaration]] = {}
        for one in self.all:
            if one.kind == "function":
                found.setdefault(one.name, []).append(one)
        return found

    def needed_by(self, function: GlslDeclaration) -> list[GlslDeclaration]:
        """What a function needs, itself included, in order."""
        by_name: dict[str, list[GlslDeclaration]] = {}
        for one in self.all:
            for name in one.declares:
                by_name.setdefault(name, []).append(one)
        found = {function.start}
        open_ends = list(function.uses)
        while open_ends:
            for one in by_name.get(open_ends.pop(), ()):
                if one.start not in found:
                    found.add(one.start)
                    open_ends += one.uses
        return [one for one in self.all if one.start in found]

    def type_of(self, written: TypeSpecifier) -> Type:
        """The type that is written so. Raises LookupError, which says what is not known."""
        dims = []
        for length in written.lengths:
            value = _constant(length, self.constants)
            if value is None or value < 1:
                raise LookupError(f"the length of {written.name}[{length}] is not known")
            dims.append(value)
        struct = self._structs.get(written.name)
        members = () if struct is None else struct.members
        return Type(
            written.name, tuple(dims), tuple((m.name, self.type_of(m.type)) for m in members)
        )


def read_declarations(text: str) -> Declarations:
    """What a preprocessed text declares.

    Raises:
        ShaderError: brackets do not match; its line is that of the text.
    """
    rows = text.split("\n")
    extensions = tuple(row.strip() for row in rows if row.lstrip().startswith("#extension"))
    text = "\n".join("" if row.lstrip().startswith("#") else row for row in rows)
    check_brackets(text)
    found = Syntax(text).declarations
    constants: dict[str, int] = {}
    for one in found:
        if one.kind == "variables" and "const" in one.qualifiers:
            for member in one.members:
                value = _constant(member.initialiser, constants)
                if value is not None:
                    constants[member.name] = value
    return Declarations(text, extensions, found, constants)


_OPERATIONS: Mapping[type[ast.operator], Callable[[int, int], int]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
}  # fmt: skip


def _constant(expression: str, known: Mapping[str, int]) -> int | None:
    """The value of an integer constant expression; None if it is anything else."""
    code = re.sub(r"(?<=\d)[uU]\b", "", expression).replace("/", "//").strip()
    try:
        return _evaluated(ast.parse(code, mode="eval").body, known)
    except (SyntaxError, KeyError, TypeError, ZeroDivisionError, ValueError):
        return None


def _evaluated(node: ast.expr, known: Mapping[str, int]) -> int:
    match node:
        case ast.Constant(value=int() as value):
            return value
        case ast.Name(id=name):
            return known[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_evaluated(operand, known)
        case ast.Call(func=ast.Name(id="int" | "uint"), args=[argument]):
            return _evaluated(argument, known)
        case ast.BinOp(left=left, op=op, right=right):
            return _OPERATIONS[type(op)](_evaluated(left, known), _evaluated(right, known))
    raise TypeError
