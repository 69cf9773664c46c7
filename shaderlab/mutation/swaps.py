"""Mistakes in names: another variable of the same type, another member, another component."""

from __future__ import annotations

from collections.abc import Iterator

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, field
from shaderlab.mutation.mutants import Change
from shaderlab.mutation.names import Names

MOST_NAMES = 3  # of many like variables, the ones declared nearest are mixed up
_SETS = ("xyzw", "rgba", "stpq")


def identifier(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """Another variable of the same type where one is read."""
    if node.type != "identifier" or not _is_read(node):
        return
    for other in names.like(file.of(node), node.start_byte)[:MOST_NAMES]:
        yield "variable", _expression(node), node, other


def member(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """Another member of the same type of a struct."""
    if node.type != "field_expression":
        return
    name = field(node, "field")
    for other in names.siblings(file.of(name))[:MOST_NAMES]:
        yield "member", _expression(node), name, other


def swizzle(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """One component of a swizzle changed into its neighbour, or two of them exchanged."""
    if node.type != "field_expression":
        return
    name = field(node, "field")
    word = file.of(name)
    letters = next((s for s in _SETS if set(word) <= set(s)), None)
    if letters is None or len(word) > 4 or names.siblings(word):
        return
    for index, letter in enumerate(word):
        place = letters.index(letter)
        # x ↔ y, z → y, w → z: never a component that the vector may lack.
        other = letters[place - 1] if place else letters[1]
        yield "swizzle", _expression(node), name, word[:index] + other + word[index + 1 :]
    for index in range(len(word) - 1):
        pair = word[index + 1] + word[index]
        yield "swizzle", _expression(node), name, word[:index] + pair + word[index + 2 :]


def _is_read(node: Node) -> bool:
    """Whether an identifier's value is used: not declared, called, assigned or a member's name."""
    around = node.parent
    if around is None or around.type in (
        "parameter_declaration",
        "function_declarator",
        "declaration",
        "array_declarator",
        "expression_statement",
        "qualifier",
    ):
        return False
    if around.type == "init_declarator":
        return around.child_by_field_name("value") == node
    if around.type == "call_expression":
        return around.child_by_field_name("function") != node
    if around.type == "assignment_expression":
        return around.child_by_field_name("left") != node
    if around.type in ("field_expression", "subscript_expression"):
        return not _is_assigned(around)
    return True


def _is_assigned(node: Node) -> bool:
    around = node.parent
    if around is None:
        return False
    if around.type in ("field_expression", "subscript_expression"):
        return _is_assigned(around)
    return around.type == "assignment_expression" and around.child_by_field_name("left") == node


def _expression(node: Node) -> Node:
    """What to show of a name: the expression around it, up to a call or an operator."""
    shown = node
    while shown.parent is not None and shown.parent.type in (
        "field_expression",
        "subscript_expression",
        "unary_expression",
    ):
        shown = shown.parent
    around = shown.parent
    if around is not None and around.type == "argument_list" and around.parent is not None:
        return around.parent
    if around is not None and around.type in (
        "binary_expression",
        "assignment_expression",
        "init_declarator",
        "return_statement",
    ):
        return around
    return shown
