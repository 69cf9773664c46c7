"""What operators work with: the changes they propose, and what a shader's names stand for.

Enough of GLSL's types is known here to swap like for like.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, field, name_of, walk

Change = tuple[str, Node, Node, str]
"""What an operator proposes: its name, the node to show, the node to replace, the new text."""

_QUALIFIERS = ("uniform", "in", "out", "inout", "const")


@dataclass(frozen=True)
class Variable:
    """A declared variable: its type, where it may be used (in bytes), whether it can be read."""

    name: str
    type: str
    start: int
    end: int
    readable: bool


@dataclass(frozen=True)
class Names:
    """All variables of one shader, its outputs (type by name), and the members of its structs."""

    variables: tuple[Variable, ...]
    outputs: Mapping[str, str]
    members: Mapping[str, tuple[tuple[str, str], ...]]

    def of_same_type(self, name: str, at: int) -> list[str]:
        """Return other variables of the same type that can be read at byte `at`, nearest first."""
        visible = {v.name: v for v in self.variables if v.start <= at < v.end}
        own = visible.get(name)
        if own is None:
            return []
        others = [
            v for v in visible.values() if v.type == own.type and v.name != name and v.readable
        ]
        return [v.name for v in sorted(others, key=lambda v: abs(v.start - own.start))]

    def has_matrix(self, words: Iterable[str], at: int) -> bool:
        types = {v.name: v.type for v in self.variables if v.start <= at < v.end}
        return any(types.get(word, "").startswith("mat") for word in words)

    def siblings(self, member: str) -> list[str]:
        """Return other members of the same type in the structs that have this member."""
        found: dict[str, None] = {}
        for members in self.members.values():
            types = dict(members)
            if member in types:
                same = (n for n, type in members if type == types[member] and n != member)
                found.update(dict.fromkeys(same))
        return list(found)


Operator = Callable[[Node, Syntax, Names], Iterator[Change]]


def collect_names(file: Syntax) -> Names:
    """Return the variables, outputs and structs of a shader with its includes expanded."""
    members = {
        file.of(field(node, "name")): tuple(_members(file, node))
        for node in walk(file.root)
        if node.type == "struct_specifier" and node.child_by_field_name("name") is not None
    }
    variables = tuple(found for node in walk(file.root) for found in _declarations(file, node))
    end = file.root.end_byte
    outputs = {v.name: v.type for v in variables if v.end == end and not v.readable}
    return Names(variables, outputs, members)


def _members(file: Syntax, struct: Node) -> list[tuple[str, str]]:
    found = []
    for node in walk(struct):
        if node.type == "field_declaration":
            kind = file.of(field(node, "type"))
            for declarator in node.children_by_field_name("declarator"):
                found.append((file.of(name_of(declarator)), kind + _array(file, declarator)))
    return found


def _declarations(file: Syntax, node: Node) -> list[Variable]:
    if node.type not in ("declaration", "parameter_declaration"):
        return []
    kind = node.child_by_field_name("type")
    if kind is None:
        return []
    words = {file.of(child) for child in node.children if child.type in _QUALIFIERS}
    scope = _scope(node)
    if node.type == "parameter_declaration" and scope.type != "function_definition":
        return []  # of a prototype
    found = []
    for declarator in node.children_by_field_name("declarator"):
        if declarator.type == "function_declarator":
            continue
        found.append(
            Variable(
                name=file.of(name_of(declarator)),
                type=file.of(kind) + _array(file, declarator),
                # Readable from its own declaration's end on, to the end of the block around it.
                start=node.end_byte if node.type == "declaration" else node.start_byte,
                end=scope.end_byte,
                readable="out" not in words,
            )
        )
    return found


def _scope(node: Node) -> Node:
    around = node.parent
    while around is not None and around.parent is not None:
        if around.type in ("compound_statement", "for_statement", "function_definition"):
            return around
        around = around.parent
    return around or node


def _array(file: Syntax, declarator: Node) -> str:
    for node in walk(declarator):
        if node.type == "array_declarator":
            size = node.child_by_field_name("size")
            return "[]" if size is None else f"[{file.of(size)}]"
    return ""
