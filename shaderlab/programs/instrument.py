"""Fragment shaders that also write what their statements store: one more output a statement."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, field, name_of, walk
from shaderlab.programs.stages import MOST_OUTPUTS, PREFIX

SEEN = PREFIX + "seen"
_DIRECTIVE = re.compile(r"^[ \t]*#[ \t]*(?:version|extension)[^\n]*\n?", re.MULTILINE)
_WIDE = {1: "vec4({0}, 0.0, 0.0, 1.0)", 2: "vec4({0}, 0.0, 1.0)", 3: "vec4({0}, 1.0)", 4: "{0}"}


@dataclass(frozen=True)
class Statement:
    """A declaration, assignment or `return` in a function of a shader's text.

    Attributes:
        first, last: its lines, counted from 1.
        name: the variable that is stored to, "f()" for a `return` of f.
        place: what is stored to, as it is written: "light.position.y".
        start, end: its bytes in the text.
        value: of a `return`, its expression; and `type` that of its function.
        braced: whether it stands in braces of its own.
    """

    first: int
    last: int
    name: str
    place: str
    start: int
    end: int
    value: str = ""
    type: str = ""
    braced: bool = True


def statements(text: str) -> list[Statement]:
    """The statements of a text that store a value, in its order."""
    file = Syntax(text)
    return [
        found
        for name, functions in file.functions.items()
        for function in functions
        for node in walk(field(function, "body"))
        for found in _stored(file, node, name, file.of(field(function, "type")))
    ]


def _stored(file: Syntax, node: Node, function: str, returned: str) -> Iterator[Statement]:
    parent = node.parent
    if parent is None or (parent.type == "for_statement" and node != field(parent, "body")):
        return
    lines = (node.start_point[0] + 1, node.end_point[0] + 1)
    place = (node.start_byte, node.end_byte)
    braced = parent.type in ("compound_statement", "case_statement")
    if node.type == "return_statement" and node.named_children:
        value = file.of(node.named_children[0])
        yield Statement(*lines, f"{function}()", "", *place, value, returned, braced)
    elif node.type == "declaration":
        for declared in node.children_by_field_name("declarator"):
            if declared.type == "init_declarator":
                name = file.of(name_of(declared))
                yield Statement(*lines, name, name, *place, braced=braced)
    elif node.type == "expression_statement" and node.named_children:
        assigned = node.named_children[0]
        if assigned.type == "assignment_expression":
            left = field(assigned, "left")
            root = re.match(r"\w+", file.of(left))
            if root is not None:
                yield Statement(*lines, root.group(), file.of(left), *place, braced=braced)


def room(outputs: int) -> int:
    """How many statements one drawing can watch beside a shader's own outputs."""
    return MOST_OUTPUTS - 1 - outputs


def instrumented(
    text: str, watched: Sequence[tuple[Statement, str, int]]
) -> tuple[str, Mapping[str, int]]:
    """The text with statements watched, each with the place whose value is written after it ("" for
    a `return`), and that value's number of components.

    Returns:
        The text, and each added output's number in `watched`; an output is 0 where its statement
        was not reached, and its last component 1 where it was and has fewer than four.
    """
    data = text.encode()
    written: dict[Statement, str] = {}
    for number, (at, place, size) in enumerate(watched):
        value = _WIDE[size].format(place or f"{PREFIX}value")
        written[at] = f"{written.get(at, '')} {SEEN}{number} = {value};"
    edits: list[tuple[int, int, str]] = []
    for at, stored in written.items():
        if at.value:
            kept = f"{PREFIX}value"
            new = f"{{ {at.type} {kept} = {at.value};{stored} return {kept}; }}"
        else:
            new = data[at.start : at.end].decode() + stored
            new = new if at.braced else f"{{ {new} }}"
        edits.append((at.start, at.end, new))
    body = field(Syntax(text).functions["main"][0], "body")
    outputs = {f"{SEEN}{number}": number for number in range(len(watched))}
    zeros = "".join(f" {name} = vec4(0.0);" for name in outputs)
    edits.append((body.start_byte + 1, body.start_byte + 1, zeros))
    for start, end, new in sorted(edits, reverse=True):
        data = data[:start] + new.encode() + data[end:]
    made = data.decode()
    top = max((found.end() for found in _DIRECTIVE.finditer(made)), default=0)
    declared = "".join(f"out vec4 {name};\n" for name in outputs)
    return made[:top] + declared + made[top:], outputs
