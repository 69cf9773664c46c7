"""Where a shader's text can be watched: its statements, conditions, and the functions it calls."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, field, name_of, walk

Kind = Literal["store", "return", "condition", "entry"]
_LOOPS = ("while_statement", "do_statement", "for_statement")
_CONDITIONAL = ("if_statement", "switch_statement", "conditional_expression", *_LOOPS)


@dataclass(frozen=True)
class WatchPoint:
    """A place in a shader's text at which a value is known.

    Attributes:
        kind: "store" is a declaration or an assignment, "return" one with a value, "condition" the
            expression that an `if`, a loop, a `switch` or `?:` goes by, "entry" a function's start.
        first, last: its lines, counted from 1; of an entry those of the function.
        name: the variable that is stored to, "f()" for a `return` of f, the function of an entry,
            "loop" where a condition is that of one.
        place: what is stored to, as it is written: "light.position.y"; of an entry the parameters.
        start, end: its bytes in the text.
        value: of a `return`, where the bytes of its expression end; and `type` that of its
            function.
        braced: whether it stands in braces of its own.
    """

    kind: Kind
    first: int
    last: int
    name: str
    place: str
    start: int
    end: int
    value: int = 0
    type: str = ""
    braced: bool = True


def statements(text: str) -> list[WatchPoint]:
    """The statements of a text that store or return a value, in its order."""
    return [point for point in watch_points(text) if point.kind in ("store", "return")]


def watch_points(text: str) -> list[WatchPoint]:
    """All that can be watched in a text: functions in its order, in each its entry, and then what
    is in it; a condition after those that it depends on."""
    file = Syntax(text)
    found = []
    for name, functions in file.functions.items():
        for function in functions:
            body, declared = field(function, "body"), field(function, "declarator")
            listed = declared.child_by_field_name("parameters")
            parameters = "" if listed is None else file.of(listed)
            lines = (function.start_point[0] + 1, function.end_point[0] + 1)
            start = body.start_byte + 1
            found.append(WatchPoint("entry", *lines, name, parameters, start, start))
            returned = file.of(field(function, "type"))
            inside = [p for node in walk(body) for p in _points(file, node, name, returned)]
            found += sorted(inside, key=lambda point: point.end)
    return found


def _points(file: Syntax, node: Node, function: str, returned: str) -> Iterator[WatchPoint]:
    parent = node.parent
    if node.type in _CONDITIONAL:
        condition = node.child_by_field_name("condition")
        if condition is not None:
            lines = (condition.start_point[0] + 1, condition.end_point[0] + 1)
            bytes_ = (condition.start_byte, condition.end_byte)
            name = "loop" if node.type in _LOOPS else "condition"
            yield WatchPoint("condition", *lines, name, file.of(condition), *bytes_)
        return
    if parent is None or (parent.type == "for_statement" and node != field(parent, "body")):
        return
    lines = (node.start_point[0] + 1, node.end_point[0] + 1)
    place = (node.start_byte, node.end_byte)
    braced = parent.type in ("compound_statement", "case_statement")
    if node.type == "return_statement" and node.named_children:
        end = node.named_children[0].end_byte
        yield WatchPoint("return", *lines, f"{function}()", "", *place, end, returned, braced)
    elif node.type == "declaration":
        for declared in node.children_by_field_name("declarator"):
            if declared.type == "init_declarator":
                name = file.of(name_of(declared))
                yield WatchPoint("store", *lines, name, name, *place, braced=braced)
    elif node.type == "expression_statement" and node.named_children:
        changed = node.named_children[0]
        if changed.type in ("assignment_expression", "update_expression"):
            side = "left" if changed.type == "assignment_expression" else "argument"
            left = file.of(field(changed, side))
            root = re.match(r"\w+", left)
            if root is not None:
                yield WatchPoint("store", *lines, root.group(), left, *place, braced=braced)
