"""Finds what to watch in a shader, and wraps it: each point notes what the invocations saw."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, arguments_of, field, name_of, operator_of, reachable

# What each kind of point can see, a bit each, and what is to be said where it never did.
ITEMS: dict[str, tuple[str, ...]] = {
    "condition": ("is never true", "is never false"),
    "term": ("is always 0", "is always 1"),
    "factor": ("is always 0", "is always 1"),
    "divisor": ("", "is always 1"),
    "max": ("never gives its first argument", "never gives its second argument"),
    "min": ("never gives its first argument", "never gives its second argument"),
    "clamp": ("is never below its range", "is never inside its range", "is never above its range"),
    "normalize": ("is of a vector whose length is 1 already",),
}
_CALLS = {"max": 2, "min": 2, "clamp": 3, "normalize": 1}
_OPERANDS = {
    **dict.fromkeys(("&&", "||", "^^"), ("condition", "condition")),
    **dict.fromkeys(("+", "-"), ("term", "term")),
    "*": ("factor", "factor"),
    "/": ("factor", "divisor"),
}
_COMPOUND = {"+=": "term", "-=": "term", "*=": "factor", "/=": "divisor"}
# A main that is called by another one, and a last word before the fragment is gone.
_REPLACED = {
    ("identifier", "main"): "shaderlab_body",
    ("expression_statement", "discard;"): "{ shaderlab_note(); discard; }",
}
# What runs once for a program, or is no code: it can't be wrapped, nor does it vary.
_CONSTANT = ("preproc", "layout_specification", "struct_specifier", "array_declarator",
             "case_statement")  # fmt: skip


@dataclass(frozen=True)
class Point:
    """An expression that is watched: its kind, a key of ITEMS, its place in the text (line from 1,
    column from 0), its own text in one line, and the bit of its first item."""

    kind: str
    line: int
    column: int
    text: str
    bit: int


def wrapped(text: str) -> tuple[str, list[Point]]:
    """The text of a stage after includes with its points wrapped by the functions of `watching`,
    and the points; its main becomes `shaderlab_body`. Functions that main does not reach are left
    alone."""
    file = Syntax(text)
    functions = reachable(file)
    points: list[Point] = []
    bits = itertools.count()

    def number(kind: str, node: Node) -> int:
        row, column = node.start_point
        first, *_ = (next(bits) for _ in ITEMS[kind])
        points.append(Point(kind, row + 1, column, " ".join(file.of(node).split()), first))
        return first

    def render(node: Node, kind: str = "") -> str:
        """The node's text, wrapped as `kind` says, with everything below it wrapped as well."""
        if node.type.startswith(_CONSTANT) or _is_left_alone(node, file, functions):
            return file.of(node)
        if (node.type, file.of(node)) in _REPLACED:
            return _REPLACED[node.type, file.of(node)]
        call = _watched_call(node, file)
        head = f"{_name(kind)}({number(kind, node)}, " if kind and not _is_plain(node) else ""
        own = number(call, node) if call else None
        below = _kinds_below(node, file)
        parts, at = [], node.start_byte
        for child in node.children:
            parts.append(file.bytes[at : child.start_byte].decode())
            if own is not None and child.type == "argument_list":
                parts.append(f"({own}, " + render(child)[1:])
            elif own is not None and child == node.child_by_field_name("function"):
                parts.append(_name(call))
            else:
                parts.append(render(child, below(child)))
            at = child.end_byte
        parts.append(file.bytes[at : node.end_byte].decode())
        return head + "".join(parts) + (")" if head else "")

    return render(file.root), points


def _name(kind: str) -> str:
    return f"shaderlab_{kind}"


def _kinds_below(node: Node, file: Syntax) -> Callable[[Node], str]:
    """What the children of a node are watched as; "" for most."""
    found = {child.start_byte: kind for child, kind in _watched_children(node, file)}
    return lambda child: found.get(child.start_byte, "") if child.is_named else ""


def _watched_children(node: Node, file: Syntax) -> Iterator[tuple[Node, str]]:
    if node.type == "binary_expression":
        word = file.of(operator_of(node))
        left, right = field(node, "left"), field(node, "right")
        kinds = _OPERANDS.get(word, ("", ""))
        if not _goes_on(left, kinds[0], file):  # of a + b + c, a and b are watched, not their sum
            yield left, kinds[0]
        yield right, kinds[1]
    elif node.type == "assignment_expression":
        kind = _COMPOUND.get(file.of(operator_of(node)))
        if kind:
            yield field(node, "right"), kind
    elif node.type == "conditional_expression":
        yield field(node, "condition"), "condition"
    elif node.type == "parenthesized_expression" and _is_if(node.parent):
        yield next(child for child in node.children if child.is_named), "condition"


def _goes_on(left: Node, kind: str, file: Syntax) -> bool:
    """Whether a left operand is a sum or product that the same kind of operator goes on with."""
    if left.type != "binary_expression":
        return False
    return _OPERANDS.get(file.of(operator_of(left)), ("", ""))[0] == kind


def _is_if(node: Node | None) -> bool:
    return node is not None and node.type == "if_statement"


def _watched_call(node: Node, file: Syntax) -> str:
    """The kind of a call of a built-in function that chooses; "" for every other node."""
    if node.type != "call_expression":
        return ""
    name = file.of(field(node, "function"))
    watched = _CALLS.get(name) == len(arguments_of(node)) and name not in file.functions
    return name if watched else ""


def _is_plain(node: Node) -> bool:
    """Whether a node is a number, with a sign or without: what it is can be read."""
    if node.type in ("number_literal", "true", "false"):
        return True
    if node.type in ("unary_expression", "parenthesized_expression"):
        inner = [child for child in node.children if child.is_named]
        return len(inner) == 1 and _is_plain(inner[0])
    return False


def _is_left_alone(node: Node, file: Syntax, functions: set[str]) -> bool:
    """Whether nothing in a node is watched: constants and what is never called."""
    if node.type == "function_definition":
        return file.of(name_of(node)) not in functions
    if node.type == "declaration":
        # Outside of functions, an initialiser has to be a constant expression.
        outside = node.parent is None or node.parent.type == "translation_unit"
        return outside or any(
            child.type == "type_qualifier" and file.of(child) == "const" for child in node.children
        )
    return False
