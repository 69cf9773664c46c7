"""Mistakes in statements: one left out, a condition that is always or never true."""

from __future__ import annotations

from collections.abc import Iterator

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, field
from shaderlab.mutation.mutants import Change
from shaderlab.mutation.names import Names

REMOVABLE = ("expression_statement", "if_statement", "for_statement", "while_statement",
              "return_statement", "break_statement", "continue_statement")  # fmt: skip


def removed(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """A statement that is not there: an assignment, a whole `if` or loop, an early `return`."""
    if node.type not in REMOVABLE:
        return
    # A lone `;` keeps the grammar happy where the statement is a branch's only one.
    yield "statement removed", node, node, ";"
    if node.type == "if_statement":
        other = node.child_by_field_name("alternative")
        if other is not None:
            yield "else removed", node, other, ""


def condition(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """A branch that is always taken, or never."""
    if node.type == "if_statement":
        tested = field(node, "condition")
        for word in ("(true)", "(false)"):
            yield "condition", tested, tested, word
    elif node.type == "conditional_expression":
        tested = field(node, "condition")
        for word in ("true", "false"):
            yield "condition", node, tested, word


def branches(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """The two values of a `? :` in each other's place."""
    if node.type != "conditional_expression":
        return
    parts = (field(node, name) for name in ("condition", "consequence", "alternative"))
    tested, first, second = (file.of(part) for part in parts)
    yield "branches swapped", node, node, f"{tested} ? {second} : {first}"
