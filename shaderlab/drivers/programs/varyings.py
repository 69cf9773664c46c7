"""Fragment inputs as GLSL declares them: blocks, structs, arrays and matrices, piece by piece.

An interface names an input as a driver reports it: "VS_OUT.FragPos" by its block's name, whatever
the instance is called. A shader's text has to be read for what the interface leaves out: the
instance's name, and the declarations that a vertex stage must repeat to the letter.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from shaderlab.compiler.interface import Variable
from shaderlab.compiler.text import without_comments
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array

_BLOCK = re.compile(
    r"\b(?P<direction>in|out)\s+(\w+)\s*\{([^{}]*)\}\s*(\w*)\s*((?:\[[^\]]*\]\s*)*);"
)
_STRUCT = re.compile(r"\bstruct\s+(\w+)\s*\{[^{}]*\}\s*;")
_INPUT = re.compile(
    r"^[ \t]*(?:(flat|smooth|noperspective)[ \t]+)?in[ \t]+"
    r"(float|u?int|[iu]?vec[234]|mat[234](?:x[234])?)[ \t]+(\w+)[ \t]*;",
    re.MULTILINE,
)
_IN = re.compile(r"\bin\b")
_QUALIFIERS = r"(?:layout\s*\([^)]*\)\s*|flat\s+|smooth\s+|noperspective\s+|centroid\s+|sample\s+)*"


@dataclass(frozen=True)
class Block:
    """A block of inputs in a shader's text; `instance` is "" where members are named alone."""

    name: str
    body: str
    instance: str
    array: str

    @property
    def members(self) -> tuple[str, ...]:
        """The members' names."""
        return tuple(re.findall(r"\b([A-Za-z_]\w*)\s*(?:\[[^\]]*\]\s*)*[;,]", self.body))


@dataclass(frozen=True)
class Piece:
    """A scalar or a vector out of an input: what one attachment or one attribute holds.

    Attributes:
        name: the input (or element of one) that it is part of.
        path: how it goes on from there in GLSL: "" or a matrix' column, "[2]".
        type: its GLSL type.
    """

    name: str
    path: str
    type: str


class Declared:
    """The input declarations in a fragment shader's text (after includes); with "out" for a
    direction, a vertex or geometry shader's outputs."""

    def __init__(self, text: str, direction: str = "in") -> None:
        self._text = without_comments(text)
        found = _BLOCK.findall(self._text)
        self.blocks = {b[1]: Block(*b[1:]) for b in found if b[0] == direction}

    def spelt(self, name: str) -> str:
        """An input as the shader itself writes it: a block's name becomes its instance's.

        >>> Declared("in VS_OUT { vec3 FragPos; } fs_in;").spelt("VS_OUT.FragPos")
        'fs_in.FragPos'
        """
        head, rest = re.fullmatch(r"(\w*)(.*)", name).groups()  # type: ignore[union-attr]
        block = self.blocks.get(head) if "." in name else None
        return name if block is None else block.instance + rest

    def block_of(self, name: str) -> Block | None:
        """The block that an input is a member of."""
        head = name.partition(".")[0].partition("[")[0]
        if "." in name and head in self.blocks:
            return self.blocks[head]
        return next((b for b in self.blocks.values() if not b.instance and head in b.members), None)

    def struct_of(self, name: str) -> tuple[str, str]:
        """The struct that an input like "surface.normal" is declared with: its type's name, and
        the array part of the declaration.

        Raises:
            UnsupportedError: the declaration can't be found.
        """
        head = re.escape(name.partition(".")[0].partition("[")[0])
        found = re.search(rf"\bin\s+(\w+)\s+{head}\s*((?:\[[^\]]*\]\s*)*);", self._text)
        if found is None:
            raise UnsupportedError(
                f"the declaration of the input {name!r} can't be read",
                remedy="declare it on its own (in Type name;), or draw a mesh",
            )
        return found.group(1), found.group(2)

    def structs(self) -> list[str]:
        """All struct declarations, as written."""
        return [found.group(0) for found in _STRUCT.finditer(self._text)]

    def plain_inputs(self) -> tuple[Variable, ...] | None:
        """The inputs, if each is written in a line of its own and none is an array or a member.
        What macros and `#if` make of them is not known.

        >>> [(v.name, v.type) for v in Declared("in vec2 uv;\\nflat in int id;").plain_inputs()]
        [('uv', 'vec2'), ('id', 'int')]
        """
        found = _INPUT.findall(self._text)
        if len(found) != len(_IN.findall(self._text)):
            return None
        return tuple(Variable(name=n, type=t, interpolation=i or "smooth") for i, t, n in found)

    def qualifiers(self, name: str) -> str:
        """What stands before `in` in the declaration of a plain input: `flat`, `centroid`, …"""
        found = re.search(rf"({_QUALIFIERS})in\s+\w+\s+[^;]*\b{re.escape(name)}\b", self._text)
        return found.group(1) if found else ""


def elements(variables: Iterable[Variable]) -> Iterator[Variable]:
    """The variables with each array's elements one by one: "v[0]", "v[1]", …"""
    for variable in variables:
        if variable.array is None:
            yield variable
        for index in range(variable.array or 0):
            yield replace(variable, name=f"{variable.name}[{index}]", array=None)


def pieces(variable: Variable) -> Iterator[Piece]:
    """A variable that is no array, as vectors: itself, or a matrix' columns.

    >>> from shaderlab.compiler.interface import Variable
    >>> [piece.path + piece.type for piece in pieces(Variable(name="m", type="mat2x3"))]
    ['[0]vec3', '[1]vec3']
    """
    if variable.type.startswith("d"):
        raise UnsupportedError(
            f"capturing {variable.name!r}: {variable.type} between stages",
            remedy="pass it on in single precision",
        )
    if not variable.type.startswith("mat"):
        yield Piece(variable.name, "", variable.type)
        return
    columns, _, rows = variable.type[3:].partition("x")
    for column in range(int(columns)):
        yield Piece(variable.name, f"[{column}]", f"vec{rows or columns}")


def assembled(parts: Mapping[Piece, Array]) -> dict[str, Array]:
    """The inputs by name: vectors (…, components), and matrices (…, rows, columns)."""
    found: dict[str, list[Array]] = {}
    for piece, values in parts.items():
        found.setdefault(piece.name, []).append(values)
    matrices = {piece.name for piece in parts if piece.path}
    return {
        name: np.stack(columns, axis=-1) if name in matrices else columns[0]
        for name, columns in found.items()
    }
