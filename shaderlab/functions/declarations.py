"""What a GLSL file declares at its top level, read from its preprocessed text."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from shaderlab.functions.scanner import Item, Scanner


@dataclass(frozen=True)
class Declarations:
    """A file's declarations.

    Attributes:
        text: preprocessed, with directives blanked out.
        extensions: its `#extension` lines.
        items: in order.
    """

    text: str
    extensions: tuple[str, ...]
    items: tuple[Item, ...]
    constants: Mapping[str, int] = field(default_factory=dict)

    def functions(self) -> dict[str, list[Item]]:
        """Function definitions by name; several where it is overloaded."""
        found: dict[str, list[Item]] = {}
        for item in self.items:
            if item.kind == "function":
                found.setdefault(item.name, []).append(item)
        return found

    def needed(self, function: Item) -> list[Item]:
        """The items that a function needs, itself included, in order."""
        by_name: dict[str, list[Item]] = {}
        for item in self.items:
            for declared in item.declares:
                by_name.setdefault(declared, []).append(item)
        found = {function.start}
        open_ends = list(function.uses)
        while open_ends:
            for item in by_name.get(open_ends.pop(), ()):
                if item.start not in found:
                    found.add(item.start)
                    open_ends += item.uses
        return [item for item in self.items if item.start in found]


def declarations(text: str) -> Declarations:
    """What a preprocessed text declares.

    Raises:
        ShaderError: brackets do not match; its line is that of the text.
    """
    rows = text.split("\n")
    extensions = tuple(row.strip() for row in rows if row.lstrip().startswith("#extension"))
    text = "\n".join("" if row.lstrip().startswith("#") else row for row in rows)
    scanner = Scanner(text)
    items = tuple(scanner.items())
    constants: dict[str, int] = {}
    for item in items:
        if item.kind == "variables" and "const" in item.qualifiers:
            for member in item.members:
                value = constant(member.default, constants)
                if value is not None:
                    constants[member.name] = value
    return Declarations(text, extensions, items, constants)


def constant(expression: str, known: Mapping[str, int]) -> int | None:
    """The value of an integer constant expression; None if it is anything else."""
    code = re.sub(r"(?<=\d)[uU]\b", "", expression).replace("/", "//").strip()
    try:
        tree = ast.parse(code, mode="eval")
        return _evaluated(tree.body, known)
    except (SyntaxError, KeyError, TypeError, ZeroDivisionError, ValueError):
        return None


def _evaluated(node: ast.expr, known: Mapping[str, int]) -> int:
    match node:
        case ast.Constant(value=int() as value):
            return value
        case ast.Name(id=name):
            return known[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_evaluated(operand, known)
        case ast.Call(func=ast.Name(id="int" | "uint"), args=[argument]):
            return _evaluated(argument, known)
        case ast.BinOp(left=left, op=op, right=right):
            a, b = _evaluated(left, known), _evaluated(right, known)
            operations = {
                ast.Add: int.__add__, ast.Sub: int.__sub__, ast.Mult: int.__mul__,
                ast.FloorDiv: int.__floordiv__, ast.Mod: int.__mod__,
                ast.LShift: int.__lshift__, ast.RShift: int.__rshift__,
            }  # fmt: skip
            return operations[type(op)](a, b)
    raise TypeError
