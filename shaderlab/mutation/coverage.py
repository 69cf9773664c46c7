"""Mistakes in what a shader writes at all: pixels thrown away, an end too early, an output that is
half as large or never written.

Each is put into `main` and nowhere else. Left out by name: geometry and compute stages, which
write at other places than their end; arrays and blocks of outputs; `gl_Position`, whose half is
the same place.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, field, name_of, walk
from shaderlab.mutation.mutants import Change
from shaderlab.mutation.names import Names
from shaderlab.mutation.statements import REMOVABLE

_BUILT_IN = {"gl_FragColor": "vec4", "gl_FragDepth": "float", "gl_PointSize": "float"}
_HALF = {"float": "*= 0.5", "vec": "*= 0.5", "mat": "*= 0.5", "int": "/= 2", "ivec": "/= 2",
         "uint": "/= 2u", "uvec": "/= 2u"}  # fmt: skip
_SECOND_PIXEL = "(int(gl_FragCoord.x) + int(gl_FragCoord.y)) % 2 == 1"


def covered(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """Every second pixel thrown away, or those where an output of floats is above 0.25."""
    end = _end_of_main(node, file)
    if end is None or file.stage != "fragment":
        return
    yield "every second pixel discarded", end, end, f"if ({_SECOND_PIXEL}) discard; }}"
    for name, kind in _outputs(file, names).items():
        if kind in ("float", "vec2", "vec3", "vec4"):
            first = name if kind == "float" else f"{name}.x"
            yield "bright pixels discarded", end, end, f"if ({first} > 0.25) discard; }}"


def ended(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """A `return` at the top of `main`, or before its last statement where leaving that out alone
    is no mistake of its own."""
    end = _end_of_main(node, file)
    if end is None or end.parent is None:
        return
    first, *statements = (n for n in end.parent.children[:-1] if n.type != "comment")
    if statements:
        yield "early return", first, first, "{ return;"
        if statements[-1].type not in REMOVABLE:
            last = statements[-1]
            yield "early return", last, last, f"return; {file.of(last)}"


def halved(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """Each output half as large."""
    end = _end_of_main(node, file)
    if end is not None:
        for name, kind in _outputs(file, names).items():
            half = _HALF.get(kind.rstrip("234x"))
            if half is not None:
                yield "output halved", end, end, f"{name} {half}; }}"


def unwritten(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """An output that is never written: `main` writes to a variable of its own of the same name.

    Where there is one assignment only, that is a statement removed; where another function writes
    it too, none is made.
    """
    end = _end_of_main(node, file)
    if end is None or end.parent is None:
        return
    written = [_root(n, file) for n in walk(file.root) if n.type == "assignment_expression"]
    inside = [_root(n, file) for n in walk(end.parent) if n.type == "assignment_expression"]
    for name, kind in names.outputs.items():
        if "[" not in kind and 1 < written.count(name) == inside.count(name):
            first = end.parent.children[0]
            yield "output never written", first, first, f"{{ {kind} {name};"


def _end_of_main(node: Node, file: Syntax) -> Node | None:
    """The closing brace of `main`, where `node` is its definition in a stage that ends there."""
    if file.stage not in ("vertex", "fragment") or node.type != "function_definition":
        return None
    return field(node, "body").children[-1] if file.of(name_of(node)) == "main" else None


def _outputs(file: Syntax, names: Names) -> Mapping[str, str]:
    """The outputs, and the built-in ones that are assigned: type by name."""
    written = {_root(n, file) for n in walk(file.root) if n.type == "assignment_expression"}
    return {**names.outputs, **{n: kind for n, kind in _BUILT_IN.items() if n in written}}


def _root(assignment: Node, file: Syntax) -> str:
    """The variable that an assignment writes: `color` of `color.rgb = …`."""
    target = field(assignment, "left")
    while target.type in ("field_expression", "subscript_expression"):
        target = target.children[0]
    return file.of(target)


ALL = (covered, ended, halved, unwritten)
