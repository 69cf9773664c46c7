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
from typing import Any

from shaderlab.compiler.syntax import Node, Syntax, field
from shaderlab.errors import ShaderError

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
class TypeText:
    """A type as it is written: its name, and the texts between the brackets of its lengths."""

    name: str
    lengths: tuple[str, ...] = ()


@dataclass(frozen=True)
class Variable:
    """A variable, member or parameter; `default` is the text of its initialiser."""

    name: str
    type: TypeText
    qualifiers: frozenset[str] = frozenset()
    default: str = ""


@dataclass(frozen=True)
class Declaration:
    """One declaration.

    Attributes:
        kind: "function", "prototype", "struct", "block" or "variables".
        start, end: where it is in the text.
        name: of a function, struct or block.
        members: a function's parameters, or what a struct, a block or a declaration declares.
        qualifiers: of the block, or of the variables.
        result: what a function returns.
        variables: what is declared after the body of a struct or block.
        uses: names that occur in it and that it does not declare.
    """

    kind: str
    start: int
    end: int
    name: str = ""
    members: tuple[Variable, ...] = ()
    qualifiers: frozenset[str] = frozenset()
    result: TypeText = TypeText("void")
    variables: tuple[Variable, ...] = ()
    uses: frozenset[str] = frozenset()

    @property
    def names(self) -> Iterator[str]:
        """The global names that it declares."""
        if self.kind == "variables" or (self.kind == "block" and not self.variables):
            yield from (member.name for member in self.members)
        if self.name:
            yield self.name
        yield from (variable.name for variable in self.variables)


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
    all: tuple[Declaration, ...]
    constants: Mapping[str, int]

    @cached_property
    def _structs(self) -> dict[str, Declaration]:
        return {one.name: one for one in self.all if one.kind in ("struct", "block")}

    def functions(self) -> dict[str, list[Declaration]]:
        """Function definitions by name; several where it is overloaded."""
        found: dict[str, list[Declaration]] = {}
        for one in self.all:
            if one.kind == "function":
                found.setdefault(one.name, []).append(one)
        return found

    def needed_by(self, function: Declaration) -> list[Declaration]:
        """What a function needs, itself included, in order."""
        by_name: dict[str, list[Declaration]] = {}
        for one in self.all:
            for name in one.names:
                by_name.setdefault(name, []).append(one)
        found = {function.start}
        open_ends = list(function.uses)
        while open_ends:
            for one in by_name.get(open_ends.pop(), ()):
                if one.start not in found:
                    found.add(one.start)
                    open_ends += one.uses
        return [one for one in self.all if one.start in found]

    def type_of(self, written: TypeText) -> Type:
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
    rows = text.encode("ascii", "replace").decode().split("\n")
    extensions = tuple(row.strip() for row in rows if row.lstrip().startswith("#extension"))
    text = "\n".join("" if row.lstrip().startswith("#") else row for row in rows)
    found = tuple(_Reader(text).declarations())
    constants: dict[str, int] = {}
    for one in found:
        if one.kind == "variables" and "const" in one.qualifiers:
            for member in one.members:
                value = _constant(member.default, constants)
                if value is not None:
                    constants[member.name] = value
    return Declarations(text, extensions, found, constants)


# What the grammar does not know, and what no function needs: precision, `const in`, layouts of a
# stage, and lengths that stand behind the type, as in `float[3] weights`.
_UNPARSED = re.compile(
    r"\bprecision\s+\w+\s+\w+\s*;|\b(?:highp|mediump|lowp)\b|\bconst(?=\s+in\b)"
    r"|\blayout\s*\([^()]*\)\s*(?:in|out|uniform|buffer)\s*;"
    r"|(?<=\w)\s*(?:\[[^][]*\]\s*)+(?=[A-Za-z_])"
)
_DECLARATOR = re.compile(r"(\w*)\s*((?:\[[^][]*\]\s*)*)")
_LENGTH = re.compile(r"\[([^][]*)\]")
_CLOSING = {"(": ")", "[": "]", "{": "}"}
_OPERATIONS: Mapping[type[ast.operator], Callable[[int, int], int]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
}  # fmt: skip
_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*")
# Words after which a name is not one that is declared there.
_NO_TYPES = frozenset(re.findall(r"\w+",
    "const uniform in out inout buffer shared varying attribute centroid flat smooth noperspective"
    " patch sample invariant precise highp mediump lowp coherent volatile restrict readonly"
    " writeonly subroutine layout return else case default do"
))  # fmt: skip


class _Reader:
    """Reads the declarations of a text without directives, of ASCII characters only."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._root = Syntax(_UNPARSED.sub(_blank, text)).root
        if self._root.has_error:
            _check_brackets(text)

    def declarations(self) -> Iterator[Declaration]:
        nodes = self._root.children
        for node, after in zip(nodes, [*nodes[1:], None], strict=True):
            found = None
            if node.type == "function_definition":
                found = self._function(node, "function")
            elif node.type == "struct_specifier":
                end = after.end_byte if after is not None and after.type == ";" else node.end_byte
                found = self._struct(node, node, end)
            elif node.type == "declaration":
                found = self._declaration(node)
            if found is not None:
                yield found

    def _declaration(self, node: Node) -> Declaration | None:
        body = next((n for n in node.children if n.type == "field_declaration_list"), None)
        if body is not None:
            return self._block(node, body)
        type_ = node.child_by_field_name("type")
        declarators = node.children_by_field_name("declarator")
        if type_ is None:  # `invariant gl_Position;`
            return None
        if any(n.type == "function_declarator" for n in declarators):
            return self._function(node, "prototype")
        if type_.type == "struct_specifier":
            return self._struct(node, type_, node.end_byte)
        members = tuple(self._variables(node, type_))
        qualifiers = self._words(node.start_byte, type_.start_byte)
        return self._made("variables", node, members=members, qualifiers=qualifiers)

    def _function(self, node: Node, kind: str) -> Declaration | None:
        type_, declarator = (node.child_by_field_name(name) for name in ("type", "declarator"))
        if type_ is None or declarator is None or declarator.type != "function_declarator":
            return None
        own, listed = field(declarator, "declarator"), field(declarator, "parameters")
        parameters = []
        for each in listed.named_children:
            its = each.child_by_field_name("type")
            if its is not None and self._of(its) != "void":
                parameters += [*self._variables(each, its)] or [self._unnamed(each, its)]
        return self._made(
            kind,
            node,
            name=self._of(own),
            members=tuple(parameters),
            result=TypeText(self._of(type_), self._lengths(type_.end_byte, own.start_byte)),
        )

    def _unnamed(self, parameter: Node, kind: Node) -> Variable:
        lengths = self._lengths(kind.end_byte, parameter.end_byte)
        qualifiers = self._words(parameter.start_byte, kind.start_byte)
        return Variable("", TypeText(self._of(kind), lengths), qualifiers)

    def _struct(self, node: Node, struct: Node, end: int) -> Declaration:
        named = struct.child_by_field_name("name")
        name = "" if named is None else self._of(named)
        return self._made(
            "struct",
            node,
            end=end,
            name=name,
            members=self._members(field(struct, "body")),
            qualifiers=self._words(node.start_byte, struct.start_byte),
            variables=tuple(self._variables(node, struct, name)),
        )

    def _block(self, node: Node, body: Node) -> Declaration:
        """A block: the grammar does not say which of its names is the block's own."""
        identifiers = [n for n in node.children if n.type in ("identifier", "array_declarator")]
        own, *others = identifiers
        name = self._of(own)
        return self._made(
            "block",
            node,
            name=name,
            members=self._members(body),
            qualifiers=self._words(node.start_byte, own.start_byte),
            variables=tuple(self._variable(one, TypeText(name), frozenset()) for one in others),
        )

    def _members(self, body: Node) -> tuple[Variable, ...]:
        found: list[Variable] = []
        for each in body.named_children:
            kind = each.child_by_field_name("type")
            if kind is not None:
                found += self._variables(each, kind)
        return tuple(found)

    def _variables(self, node: Node, kind: Node, name: str | None = None) -> Iterator[Variable]:
        """What a declaration, a member or a parameter declares; `name` is that of its type."""
        qualifiers = self._words(node.start_byte, kind.start_byte)
        declarators = node.children_by_field_name("declarator")
        if declarators:
            lengths = self._lengths(kind.end_byte, declarators[0].start_byte)
            type_ = TypeText(self._of(kind) if name is None else name, lengths)
            yield from (self._variable(each, type_, qualifiers) for each in declarators)

    def _variable(self, declarator: Node, type_: TypeText, qualifiers: frozenset[str]) -> Variable:
        match = _DECLARATOR.match(self._of(declarator))
        assert match is not None  # it may be empty
        value = declarator.child_by_field_name("value")
        lengths = tuple(text.strip() for text in _LENGTH.findall(match[2]))
        default = "" if value is None else self._of(value)
        return Variable(
            match[1], TypeText(type_.name, lengths + type_.lengths), qualifiers, default
        )

    def _made(self, kind: str, node: Node, *, end: int | None = None, **fields: Any) -> Declaration:
        start, end = node.start_byte, node.end_byte if end is None else end
        uses = _used_names(self._text[start:end])
        return Declaration(kind, start, end, uses=uses, **fields)

    def _of(self, node: Node) -> str:
        return self._text[node.start_byte : node.end_byte]

    def _words(self, start: int, end: int) -> frozenset[str]:
        return frozenset(re.findall(r"\w+", self._text[start:end]))

    def _lengths(self, start: int, end: int) -> tuple[str, ...]:
        """The array lengths between a type and what it is the type of."""
        return tuple(text.strip() for text in _LENGTH.findall(self._text[start:end]))


def _blank(match: re.Match[str]) -> str:
    return re.sub(r"\S", " ", match.group())


def _used_names(text: str) -> frozenset[str]:
    """The names in a text, but for members behind a dot and what is declared there."""
    used: set[str] = set()
    declared: set[str] = set()
    called: set[str] = set()
    before, end = "", 0
    for match in _NAME.finditer(text):
        name = match.group()
        follows = before and not text[end : match.start()].strip()
        if follows and before not in _NO_TYPES:
            declared.add(name)
        elif text[match.end() :].lstrip()[:1] == "(":
            called.add(name)
        else:
            used.add(name)
        before, end = name, match.end()
    return frozenset(used - declared | called)


def _check_brackets(text: str) -> None:
    """Raise ShaderError where brackets do not match."""
    expected: list[tuple[str, re.Match[str]]] = []
    for match in re.finditer(r"[][(){}]", text):
        bracket = match.group()
        if bracket in _CLOSING:
            expected.append((_CLOSING[bracket], match))
        elif not expected or expected.pop()[0] != bracket:
            raise _bracket_error(f"{bracket!r} closes nothing", match)
    if expected:
        _, match = expected[0]
        raise _bracket_error(f"{match.group()!r} is never closed", match)


def _bracket_error(message: str, match: re.Match[str]) -> ShaderError:
    return ShaderError(message, line=match.string.count("\n", 0, match.start()) + 1)


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
