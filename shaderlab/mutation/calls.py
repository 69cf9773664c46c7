"""Mistakes in calls: a function forgotten, its arguments mixed up, its sibling called."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, arguments_of, field
from shaderlab.mutation.mutants import Change
from shaderlab.mutation.names import Names

# What is left when the call is forgotten: which arguments may stand in its place.
_DROPPABLE = {
    "max": (0, 1), "min": (0, 1), "clamp": (0,), "normalize": (0,), "abs": (0,), "sqrt": (0,),
    "floor": (0,), "ceil": (0,), "fract": (0,), "pow": (0,), "exp": (0,), "radians": (0,),
    "inverse": (0,), "transpose": (0,), "mix": (0, 1), "mod": (0,), "reflect": (0,),
}  # fmt: skip
_SYMMETRIC = ("max", "min", "dot", "distance", "equal", "notEqual")
_SIBLINGS = {
    "max": "min", "min": "max", "sin": "cos", "cos": "sin", "asin": "acos", "acos": "asin",
    "floor": "ceil", "ceil": "floor", "exp": "exp2", "exp2": "exp", "log": "log2", "log2": "log",
    "sqrt": "inversesqrt", "inversesqrt": "sqrt", "dFdx": "dFdy", "dFdy": "dFdx",
    "lessThan": "greaterThan", "greaterThan": "lessThan", "any": "all", "all": "any",
}  # fmt: skip


def dropped(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """`max(x, 0.0)` where only `x` was written, and the like."""
    if node.type != "call_expression":
        return
    name = file.of(field(node, "function"))
    arguments = arguments_of(node)
    for index in _DROPPABLE.get(name, ()):
        if index < len(arguments):
            text = file.of(arguments[index])
            simple = "expression" not in arguments[index].type
            kept = text if simple or arguments[index].type in _TIGHT else f"({text})"
            yield f"{name} dropped", node, node, kept


def arguments(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """Two neighbouring arguments in each other's place."""
    if node.type != "call_expression":
        return
    name = file.of(field(node, "function"))
    if name in _SYMMETRIC:
        return
    given = arguments_of(node)
    for index, (first, second) in enumerate(pairwise(given)):
        one, two = file.of(first), file.of(second)
        texts = [file.of(a) for a in given]
        texts[index], texts[index + 1] = two, one
        yield "arguments swapped", node, node, f"{name}({', '.join(texts)})"


def sibling(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """The function's sibling: `cos` for `sin`, `min` for `max`."""
    if node.type != "call_expression":
        return
    function = field(node, "function")
    other = _SIBLINGS.get(file.of(function))
    if other is not None:
        yield "function", node, function, other


_TIGHT = ("call_expression", "field_expression", "subscript_expression", "parenthesized_expression")
