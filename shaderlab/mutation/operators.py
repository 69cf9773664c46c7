"""The kinds of mistakes: operators, constants, and the list of all kinds.

Each kind is a generator over one node of the syntax tree. It may propose what does not compile:
a compiler tells faster and better than types worked out here.
"""

from __future__ import annotations

from collections.abc import Iterator

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, field, operator_of, walk
from shaderlab.mutation import calls, coverage, statements, swaps
from shaderlab.mutation.mutants import Change, Operator
from shaderlab.mutation.names import Names

_ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "*"}
_ASSIGNMENT = {"+=": "-=", "-=": "+=", "*=": "/=", "/=": "*="}
_COMPARISON = {
    "<": ("<=", ">"),
    "<=": ("<", ">"),
    ">": (">=", "<"),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
}
_LOGIC = {"&&": "||", "||": "&&", "^^": "||"}
_BITS = {"&": "|", "|": "&", "^": "&", "<<": ">>", ">>": "<<"}
_NOT_COMMUTATIVE = ("-", "/", "%", "<<", ">>")
SLIP = 0.01


def all_operators() -> tuple[Operator, ...]:
    """Every kind of mistake there is."""
    return (
        binary,
        operands,
        unary,
        constant,
        calls.dropped,
        calls.arguments,
        calls.sibling,
        swaps.identifier,
        swaps.member,
        swaps.swizzle,
        statements.removed,
        statements.condition,
        statements.branches,
        *coverage.ALL,
    )


def binary(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """Another arithmetic, comparison, logic or bit operator, or another compound assignment."""
    if node.type not in ("binary_expression", "assignment_expression"):
        return
    sign = operator_of(node)
    word = file.of(sign)
    for table in (_ARITHMETIC, _LOGIC, _BITS, _ASSIGNMENT):
        if word in table:
            yield "operator", node, sign, table[word]
    for other in _COMPARISON.get(word, ()):
        yield "comparison", node, sign, other


def operands(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """`a − b` the wrong way round; products too where a matrix is in them."""
    if node.type != "binary_expression":
        return
    word = file.of(operator_of(node))
    left, right = field(node, "left"), field(node, "right")
    inside = [file.of(n) for n in walk(node) if n.type == "identifier"]
    matrices = word == "*" and names.has_matrix(inside, node.start_byte)
    if word in _NOT_COMMUTATIVE or matrices:
        yield "operands swapped", node, node, f"{file.of(right)} {word} {_held(file, left)}"


def unary(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """A sign or a `!` forgotten, `++` for `--`."""
    if node.type == "unary_expression":
        word = file.of(operator_of(node))
        if word in "-!~":
            kind = "minus dropped" if word == "-" else "negation dropped"
            yield kind, node, node, file.of(field(node, "argument"))
    elif node.type == "update_expression":
        sign = operator_of(node)
        yield "operator", node, sign, "--" if file.of(sign) == "++" else "++"


def constant(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """A number that is off by 1 %, or by one if it is an integer; 0 for 1 and 1 for 0."""
    if node.type != "number_literal":
        return
    text = file.of(node)
    around = node.parent if node.parent is not None else node
    shown = around if around.type in ("binary_expression", "argument_list") else node
    if around.type == "argument_list" and around.parent is not None:
        shown = around.parent
    try:
        value = int(text, 0)
    except ValueError:
        pass
    else:
        for other in (value + 1, value - 1):
            yield "integer ± 1", shown, node, str(other)
        return
    suffix = text[-1] if text[-1] in "fF" else ""
    try:
        number = float(text.rstrip("fF"))
    except ValueError:
        return  # a double's suffix, or no number after all
    if number == 0.0:
        yield "constant 0 → 1", shown, node, "1.0" + suffix
        yield "constant + 0.01", shown, node, "0.01" + suffix
        return
    yield "constant + 1 %", shown, node, _literal(number * (1.0 + SLIP)) + suffix
    yield "constant − 1 %", shown, node, _literal(number * (1.0 - SLIP)) + suffix
    if number == 1.0:
        yield "constant 1 → 0", shown, node, "0.0" + suffix


def _literal(number: float) -> str:
    """A GLSL float literal with nine digits.

    >>> _literal(0.505), _literal(101.0), _literal(1.01e-6)
    ('0.505', '101.0', '1.01e-06')
    """
    text = f"{number:.9g}"
    return text if any(c in text for c in ".e") else text + ".0"


def _held(file: Syntax, node: Node) -> str:
    """A node's text in parentheses where it would fall apart on the right of an operator."""
    text = file.of(node)
    return f"({text})" if node.type in ("binary_expression", "conditional_expression") else text
