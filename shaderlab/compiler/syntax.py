"""GLSL as a syntax tree, by tree-sitter's grammar, and what a file declares at its top level."""

import re
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

from tree_sitter import Language, Node as Node, Parser

from shaderlab.errors import ShaderError

# What tree-sitter's grammar for GLSL does not know. Before declarations are parsed it is blanked
# out, to be read from the text: default precisions and layouts, C's qualifiers before others, and
# lengths between a type and its name.
_DEFAULT_LAYOUT = re.compile(rb"(?:\blayout\s*\([^)]*\)\s*)+(?:in|out|uniform|buffer)\s*;")
_UNKNOWN = (
    re.compile(rb"\bprecision\s+\w+\s+\w+\s*;"),
    re.compile(rb"\b(?:high|medium|low)p\b"),
    _DEFAULT_LAYOUT,
    re.compile(
        rb"\b(?:const|volatile|restrict)(?=\s+(?:const|volatile|restrict|in|out|inout|uniform|buffer|"
        rb"(?:high|medium|low)p|coherent|readonly|writeonly|precise|invariant)\b)"
    ),
    re.compile(rb"(?<=\w)\s*(?:\[[^\[\]]*\]\s*)+(?=[A-Za-z_]\w*\s*[=;,()\[])"),
)
_BLANKED_QUALIFIERS = re.compile(rb"(?:\b(?:const|volatile|restrict|(?:high|medium|low)p)\s+)+\Z")
_LENGTH = re.compile(r"\[([^\]]*)\]")
_WORD = re.compile(r"\w+")
# A name with the dot before it, if it is a member, and the parenthesis behind it, if it is called.
_USE = re.compile(r"(\.\s*)?\b([A-Za-z_]\w*)\b(\s*\()?")
_CLOSING = {"(": ")", "[": "]", "{": "}"}


@dataclass(frozen=True)
class TypeSpecifier:
    """A type as it is written: its name, and the texts between the brackets of its lengths."""

    name: str
    lengths: tuple[str, ...] = ()


@dataclass(frozen=True)
class Declarator:
    """A variable, member or parameter as it is declared: its name ("" for a parameter without one),
    its type with the lengths of the name, then those of the type, the words before that, those of
    its layout included, and the text of its initialiser, "" for none."""

    name: str
    type: TypeSpecifier
    qualifiers: frozenset[str] = frozenset()
    initialiser: str = ""


@dataclass(frozen=True, kw_only=True)
class GlslDeclaration:
    """One declaration at a file's top level, from the character `start` to `end`, the semicolon
    included. Kind "layout" is a default such as `layout(points) in;`, "other" a redeclaration such
    as `invariant gl_Position;`. `members` are a function's parameters, or what a struct, a block or
    a declaration declares, `prefix` is what stands before the type, or before a block's name, as it
    is written, `body` the text between the braces of a function, struct or block, `variables` what
    is declared after a struct's body; it `uses` the names that occur in it and are not its own."""

    kind: Literal["function", "prototype", "struct", "block", "variables", "layout", "other"]
    start: int
    end: int
    line: int
    name: str = ""
    members: tuple[Declarator, ...] = ()
    prefix: str = ""
    result: TypeSpecifier = TypeSpecifier("void")
    body: str = ""
    instance: Declarator | None = None
    variables: tuple[Declarator, ...] = ()
    uses: frozenset[str] = frozenset()

    @property
    def qualifiers(self) -> frozenset[str]:
        """The words of the prefix, those of layouts included."""
        return frozenset(_WORD.findall(self.prefix))

    @property
    def declares(self) -> Iterator[str]:
        """The global names that it declares."""
        if self.kind == "variables" or (self.kind == "block" and self.instance is None):
            yield from (member.name for member in self.members)
        if self.name:
            yield self.name
        if self.instance is not None:
            yield self.instance.name
        yield from (variable.name for variable in self.variables)


class Syntax:
    """One shader's text, parsed; `stage` is its stage, "" where that does not matter. Parsing never
    fails: what the grammar does not know becomes an error node, which `walk` leaves out together
    with everything below it."""

    def __init__(self, text: str, stage: str = "") -> None:
        self.text = text
        self.stage = stage
        self.bytes = text.encode()
        with warnings.catch_warnings():
            # The grammar's wheel passes its address as a number, which tree-sitter deprecates.
            warnings.simplefilter("ignore", DeprecationWarning)
            import tree_sitter_glsl

            self._parser = Parser(Language(tree_sitter_glsl.language()))
        self._tree = self._parser.parse(self.bytes)

    @property
    def root(self) -> Node:
        return self._tree.root_node

    def of(self, node: Node) -> str:
        return self._between(node.start_byte, node.end_byte)

    @cached_property
    def functions(self) -> dict[str, list[Node]]:
        """Function definitions by name; several where a name is overloaded."""
        found: dict[str, list[Node]] = {}
        for node in walk(self.root):
            if node.type == "function_definition":
                found.setdefault(self.of(name_of(node)), []).append(node)
        return found

    def calls(self, node: Node) -> set[str]:
        """Names of what is called anywhere below `node`."""
        return {
            self.of(called)
            for call in walk(node)
            if call.type == "call_expression"
            and (called := call.child_by_field_name("function")) is not None
        }

    @cached_property
    def outline(self) -> Node:
        """The whole file, without what the grammar does not know of declarations."""
        known = self.bytes
        for pattern in _UNKNOWN:
            known = pattern.sub(lambda found: re.sub(rb"[^\n]", b" ", found[0]), known)
        return self._parser.parse(known).root_node

    @cached_property
    def declarations(self) -> tuple[GlslDeclaration, ...]:
        """What the file declares at its top level, in order; all branches of `#if` are read."""
        found = [self._declaration(node) for node in _top_level(self.outline)]
        for match in _DEFAULT_LAYOUT.finditer(self.bytes):
            start, end = match.span()
            prefix = self._between(start, end - 1).strip()
            found.append(self._placed(start, end, kind="layout", prefix=prefix))
        return tuple(sorted(found, key=lambda declaration: declaration.start))

    def _declaration(self, node: Node) -> GlslDeclaration:
        type_ = node.child_by_field_name("type")
        declarators = node.children_by_field_name("declarator")
        body = next((child for child in node.children if child.type in _BODIES), None)
        start, end = self._start(node), node.end_byte
        if type_ is not None and type_.type == "struct_specifier" and not _has_body(type_):
            return self._placed(start, end, kind="other")
        if node.type == "struct_specifier":  # alone, its semicolon beside it
            if not _has_body(node):
                return self._placed(start, end, kind="other")
            end = self.bytes.find(b";", end) + 1 or end
            return self._struct(node, start, end, "", [])
        if type_ is not None and type_.type == "struct_specifier":
            prefix = self._between(start, type_.start_byte)
            return self._struct(type_, start, end, prefix, declarators)
        if type_ is None and body is not None:
            return self._block(node, body)
        if type_ is None or not declarators:
            return self._placed(start, end, kind="other")
        prefix = self._between(start, type_.start_byte).strip()
        if declarators[0].type != "function_declarator":
            members = self._declared(node)
            own = {member.name for member in members}
            uses = self._uses(start, end, own)
            return self._placed(
                start, end, kind="variables", members=members, prefix=prefix, uses=uses
            )
        kind: Literal["function", "prototype"] = "prototype" if body is None else "function"
        name = name_of(declarators[0])
        listed = field(declarators[0], "parameters").named_children
        parameters = [self._declared(p) for p in listed if p.type == "parameter_declaration"]
        members = tuple(one for each in parameters for one in each if one.type.name != "void")
        own = {self.of(name), *(member.name for member in members)}
        if body is not None:
            own |= {self.of(name_of(d)) for n in walk(body) for d in _declarators(n)}
        uses = self._uses(start, name.start_byte, own) | self._uses(name.end_byte, end, own)
        return self._placed(
            start,
            end,
            kind=kind,
            name=self.of(name),
            members=members,
            prefix=prefix,
            result=TypeSpecifier(self.of(type_), self._lengths(type_, name.start_byte)),
            body="" if body is None else self.of(body)[1:-1],
            uses=uses,
        )

    def _struct(
        self, struct: Node, start: int, end: int, prefix: str, declarators: list[Node]
    ) -> GlslDeclaration:
        named, body = struct.child_by_field_name("name"), field(struct, "body")
        name = "" if named is None else self.of(named)
        variables = tuple(
            self._declarator(declared, TypeSpecifier(name), frozenset(_WORD.findall(prefix)))
            for declared in declarators
        )
        members = self._members(body)
        own = {name, *(declared.name for declared in (*members, *variables))}
        return self._placed(
            start,
            end,
            kind="struct",
            name=name,
            members=members,
            prefix=prefix.strip(),
            body=self.of(body)[1:-1],
            variables=variables,
            uses=self._uses(start, end, own),
        )

    def _block(self, node: Node, body: Node) -> GlslDeclaration:
        start, end = self._start(node), node.end_byte
        named = next(child for child in node.children if child.type == "identifier")
        behind = node.children[node.children.index(body) + 1]
        name = self.of(named)
        instance = None
        if behind.type != ";":
            instance = self._declarator(behind, TypeSpecifier(name), frozenset())
        members = self._members(body)
        variables = members if instance is None else (*members, instance)
        own = {name, *(variable.name for variable in variables)}
        return self._placed(
            start,
            end,
            kind="block",
            name=name,
            members=members,
            prefix=self._between(start, named.start_byte).strip(),
            body=self.of(body)[1:-1],
            instance=instance,
            uses=self._uses(start, end, own),
        )

    def _members(self, body: Node) -> tuple[Declarator, ...]:
        fields = (child for child in body.children if child.type == "field_declaration")
        return tuple(member for each in fields for member in self._declared(each))

    def _declared(self, node: Node) -> tuple[Declarator, ...]:
        """Return the variables, members or the parameter of a declaration with a type."""
        type_ = field(node, "type")
        prefix = self._between(self._start(node), type_.start_byte)
        qualifiers = frozenset(_WORD.findall(prefix))
        declarators = node.children_by_field_name("declarator")
        end = node.end_byte if not declarators else declarators[0].start_byte
        type_lengths = self._lengths(type_, end)
        specifier = TypeSpecifier(self.of(type_), type_lengths)
        if not declarators:
            return (Declarator("", specifier, qualifiers),)
        return tuple(self._declarator(each, specifier, qualifiers) for each in declarators)

    def _declarator(
        self, node: Node, type_: TypeSpecifier, qualifiers: frozenset[str]
    ) -> Declarator:
        value = node.child_by_field_name("value")
        initialiser = "" if value is None else self.of(value)
        if value is not None:
            node = field(node, "declarator")
        name, _, lengths = self.of(node).partition("[")
        own = tuple(each.strip() for each in _LENGTH.findall("[" + lengths)) if lengths else ()
        specifier = TypeSpecifier(type_.name, own + type_.lengths)
        return Declarator(name.strip(), specifier, qualifiers, initialiser)

    def _lengths(self, type_: Node, end: int) -> tuple[str, ...]:
        """Return the lengths between a type and its name, which begins at the byte `end`."""
        between = self._between(type_.end_byte, end)
        return tuple(each.strip() for each in _LENGTH.findall(between))

    def _uses(self, start: int, end: int, own: set[str]) -> frozenset[str]:
        """Return the names in a range of bytes but members, and those in `own` unless called."""
        uses = _USE.findall(self._between(start, end))
        return frozenset(n for dot, n, called in uses if not dot and (called or n not in own))

    def _start(self, node: Node) -> int:
        """Return where a declaration begins, with the qualifiers that were blanked out."""
        before = self.bytes[max(node.start_byte - 64, 0) : node.start_byte]
        blanked = _BLANKED_QUALIFIERS.search(before)
        return node.start_byte - (len(blanked.group()) if blanked else 0)

    def _between(self, start: int, end: int) -> str:
        return self.bytes[start:end].decode(errors="replace")

    def _placed(self, start: int, end: int, **fields: Any) -> GlslDeclaration:
        """Return a declaration whose place is given in bytes."""
        line = self.bytes.count(b"\n", 0, start) + 1
        if len(self.bytes) != len(self.text):
            start, end = (len(self._between(0, at)) for at in (start, end))
        return GlslDeclaration(start=start, end=end, line=line, **fields)


_BODIES = ("compound_statement", "field_declaration_list")
_BRANCHES = ("preproc_if", "preproc_ifdef", "preproc_elif", "preproc_elifdef", "preproc_else")


def _has_body(struct: Node) -> bool:
    """Whether a struct has members; C's `struct Light light;` has none."""
    return struct.child_by_field_name("body") is not None


def _top_level(node: Node) -> Iterator[Node]:
    """Yield the declarations below a node, in all branches of its `#if`s."""
    for child in node.children:
        if child.type in _BRANCHES:
            yield from _top_level(child)
        elif child.type in ("declaration", "function_definition", "struct_specifier"):
            yield child


def _declarators(node: Node) -> list[Node]:
    is_declaration = node.type in ("declaration", "struct_specifier")
    return node.children_by_field_name("declarator") if is_declaration else []


def check_brackets(text: str) -> None:
    """Check that brackets match in a text without comments and directives. Raises ShaderError: one
    of them is never closed, or closes nothing; it has the text's line."""
    open_brackets: list[tuple[str, int]] = []
    for match in re.finditer(r"[][(){}]", text):
        bracket, line = match.group(), text.count("\n", 0, match.start()) + 1
        if bracket in _CLOSING:
            open_brackets.append((bracket, line))
        elif not open_brackets or _CLOSING[open_brackets.pop()[0]] != bracket:
            raise ShaderError(f"{bracket!r} closes nothing", line=line)
    if open_brackets:
        bracket, line = open_brackets[0]
        raise ShaderError(f"{bracket!r} is never closed", line=line)


def walk(node: Node) -> Iterator[Node]:
    """`node` and all nodes below it in the order of the text, without what can't be parsed."""
    if node.is_error or node.is_missing:
        return
    yield node
    for child in node.children:
        yield from walk(child)


def name_of(definition: Node) -> Node:
    """Return the identifier that a function definition, declarator or parameter declares."""
    node = definition
    while (inner := node.child_by_field_name("declarator")) is not None:
        node = inner
    return node


def operator_of(node: Node) -> Node:
    found = node.child_by_field_name("operator")
    assert found is not None
    return found


def field(node: Node, name: str) -> Node:
    """Return a child that the grammar always gives."""
    found = node.child_by_field_name(name)
    assert found is not None, f"{node.type} without {name}"
    return found


def arguments_of(call: Node) -> list[Node]:
    return [n for n in field(call, "arguments").named_children if n.type != "comment"]


def reachable(file: Syntax, roots: Iterable[str] = ("main",)) -> set[str]:
    """Names of the functions that a shader's `main` reaches, or others; their own included."""
    found: set[str] = set()
    open_ends = list(roots)
    while open_ends:
        name = open_ends.pop()
        if name not in found and name in file.functions:
            found.add(name)
            for node in file.functions[name]:
                open_ends += file.calls(node)
    return found
