"""GLSL as a syntax tree: tree-sitter's grammar, and the few questions that are asked of it."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from functools import cached_property

from tree_sitter import Language, Node, Parser


class Syntax:
    """One shader's text, parsed; `stage` is its stage, "" where that does not matter.

    Parsing never fails: what the grammar does not know becomes an error node, which `walk`
    leaves out together with everything below it.
    """

    def __init__(self, text: str, stage: str = "") -> None:
        self.text = text
        self.stage = stage
        self.bytes = text.encode()
        with warnings.catch_warnings():
            # The grammar's wheel hands its address over as a number, which tree-sitter regrets.
            warnings.simplefilter("ignore", DeprecationWarning)
            import tree_sitter_glsl

            language = Language(tree_sitter_glsl.language())
        self._tree = Parser(language).parse(self.bytes)

    @property
    def root(self) -> Node:
        """The whole file."""
        return self._tree.root_node

    def of(self, node: Node) -> str:
        """The text of one node."""
        return self.bytes[node.start_byte : node.end_byte].decode()

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


def walk(node: Node) -> Iterator[Node]:
    """`node` and all nodes below it in the order of the text, without what can't be parsed."""
    if node.is_error or node.is_missing:
        return
    yield node
    for child in node.children:
        yield from walk(child)


def name_of(definition: Node) -> Node:
    """The identifier that a function definition, declarator or parameter declares."""
    node = definition
    while (inner := node.child_by_field_name("declarator")) is not None:
        node = inner
    return node


def operator_of(node: Node) -> Node:
    """The operator token of an expression."""
    found = node.child_by_field_name("operator")
    assert found is not None
    return found


def field(node: Node, name: str) -> Node:
    """A child that the grammar always gives."""
    found = node.child_by_field_name(name)
    assert found is not None, f"{node.type} without {name}"
    return found


def arguments_of(call: Node) -> list[Node]:
    """The arguments of a call or constructor."""
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
