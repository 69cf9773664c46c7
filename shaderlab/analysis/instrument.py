"""Where a shader's text can be watched: its statements, conditions, and the functions it calls."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, field, name_of, walk
from shaderlab.drivers.programs.stages import MOST_OUTPUTS, PREFIX, end_of_directives

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


def find_statements(text: str) -> list[WatchPoint]:
    """The statements of a text that store or return a value, in its order."""
    return [point for point in find_watch_points(text) if point.kind in ("store", "return")]


def find_watch_points(text: str) -> list[WatchPoint]:
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
            inside = [p for node in walk(body) for p in _find_points(file, node, name, returned)]
            found += sorted(inside, key=lambda point: point.end)
    return found


def _find_points(file: Syntax, node: Node, function: str, returned: str) -> Iterator[WatchPoint]:
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


SEEN = PREFIX + "seen"
VALUE = PREFIX + "value"
"""What a `return` gives, and what a condition is, where a `Watch` is written."""
_TURN = PREFIX + "turn"
_CONDITION = PREFIX + "condition"
_VALUES = 3  # in an output, whose last component says which of them were written


@dataclass(frozen=True)
class Watch:
    """A value that is written once it was there `turn` times before.

    Attributes:
        at: the points of the text at which it is known, each with the expression that has it there:
            `VALUE`, or a part of it, for what is returned and for conditions.
        size: its number of components.
        turn: how often any of the points was passed before.
        scalar: what a condition's value is.
    """

    at: tuple[tuple[WatchPoint, str], ...]
    size: int
    turn: int
    scalar: Literal["bool", "int", "uint"] = "bool"


@dataclass(frozen=True)
class Written:
    """Where a value is found: for each component an output, and the component of it."""

    components: tuple[tuple[str, int], ...]


def watch_capacity(outputs: int) -> int:
    """How many components one drawing can watch beside a shader's own outputs."""
    return _VALUES * (MOST_OUTPUTS - 1 - outputs)


def instrument(text: str, watched: Sequence[Watch]) -> tuple[str, list[Written]]:
    """The text with values watched, and where each of them is written.

    The outputs are `vec4`s. The last component of each counts which of the first three were
    written: the sum of 1 for the first, 2 for the second and 4 for the third.
    """
    cells = iter((f"{SEEN}{n // _VALUES}", n % _VALUES) for n in range(10_000))
    found = [Written(tuple(next(cells) for _ in range(watch.size))) for watch in watched]
    noted: dict[WatchPoint, str] = {}
    scalars: dict[WatchPoint, str] = {}
    for number, (watch, written) in enumerate(zip(watched, found, strict=True)):
        for point, place in watch.at:
            noted[point] = noted.get(point, "") + _note(number, watch, written, place)
            scalars[point] = watch.scalar
    edits: list[_Edit] = []
    functions = ""
    for number, (point, notes) in enumerate(noted.items()):
        if point.kind == "condition":
            name, scalar = f"{_CONDITION}{number}", scalars[point]
            functions += f"{scalar} {name}({scalar} {VALUE}) {{{notes} return {VALUE}; }}\n"
            edits += _around(point, f"({name}(", "))")
        elif point.kind == "return":
            begin, end = point.start, point.start + len("return")
            edits.append(_Edit(begin, end, f"{{ {point.type} {VALUE} = (", -point.end))
            tail = f");{notes} return {VALUE}; }}"
            edits.append(_Edit(point.value, point.end, tail, -point.start))
        else:
            edits += _around(point, *(("", notes) if point.braced else ("{ ", f"{notes} }}")))
    outputs = list(dict.fromkeys(name for each in found for name, _ in each.components))
    body = field(Syntax(text).functions["main"][0], "body").start_byte + 1
    zeros = "".join(f" {name} = vec4(0.0);" for name in outputs)
    edits.append(_Edit(body, body, zeros, -len(text)))
    made = _apply_edits(text, edits)
    top = end_of_directives(made)
    declared = "".join(f"out highp vec4 {name};\n" for name in outputs)
    declared += "".join(f"int {_TURN}{number} = 0;\n" for number in range(len(watched)))
    return made[:top] + declared + functions + made[top:], found


def _note(number: int, watch: Watch, written: Written, place: str) -> str:
    """A statement that writes a value at a point."""
    parts = []
    for i, (name, k) in enumerate(written.components):
        part = place if watch.size == 1 else f"{place}[{i}]"
        parts.append(f"{name}.{'xyz'[k]} = float({part}); {name}.w += {1 << k}.0;")
    return f" if ({_TURN}{number}++ == {watch.turn}) {{ {' '.join(parts)} }}"


@dataclass(frozen=True)
class _Edit:
    """A part of a text that is replaced; where several begin at one place, in which order."""

    start: int
    end: int
    text: str
    order: int


def _around(point: WatchPoint, before: str, after: str) -> list[_Edit]:
    """What goes before a point, outer ones first, and what after it, inner ones first."""
    edits = [_Edit(point.start, point.start, before, -point.end)] if before else []
    return [*edits, _Edit(point.end, point.end, after, -(10**9) - point.start)]


def _apply_edits(text: str, edits: Sequence[_Edit]) -> str:
    data, parts, at = text.encode(), [], 0
    for edit in sorted(edits, key=lambda edit: (edit.start, edit.order)):
        parts += [data[at : edit.start], edit.text.encode()]
        at = max(edit.end, at)
    return b"".join([*parts, data[at:]]).decode()
