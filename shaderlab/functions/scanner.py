"""Reads a GLSL text's declarations at its top level, token by token.

Bodies are not parsed: which names they use is enough to tell what a function needs.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from shaderlab.errors import ShaderError

_TOKEN = re.compile(r"[A-Za-z_]\w*|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\w*|<<|>>|\S")
_NAME = re.compile(r"[A-Za-z_]\w*")
_WORDS = re.compile(r"\w+")
QUALIFIERS = frozenset(_WORDS.findall(
    "const uniform in out inout buffer shared varying attribute centroid flat smooth noperspective"
    " patch sample invariant precise highp mediump lowp coherent volatile restrict readonly"
    " writeonly subroutine layout"
))  # fmt: skip
_NO_TYPES = QUALIFIERS | {"return", "else", "case", "default", "do"}
_CLOSING = {"(": ")", "[": "]", "{": "}"}


@dataclass(frozen=True)
class Spec:
    """A type as it is written: its name, and the texts between the brackets of its lengths."""

    name: str
    lengths: tuple[str, ...] = ()


@dataclass(frozen=True)
class Named:
    """A variable, member or parameter; `default` is its initialiser."""

    name: str
    spec: Spec
    qualifiers: frozenset[str] = frozenset()
    default: str = ""


@dataclass(frozen=True)
class Item:
    """One declaration.

    Attributes:
        kind: "function", "prototype", "struct", "block", "variables", or "other" for what no
            function needs.
        start, end: where it is in the text.
        name: of a function, struct or block.
        members: a function's parameters, or what a struct, a block or a declaration declares.
        qualifiers: of the block, or of the variables.
        result: what a function returns.
        instance: a block's variable.
        variables: what is declared after a struct's body.
        uses: names that occur in it and are not its own.
    """

    kind: str
    start: int
    end: int
    name: str = ""
    members: tuple[Named, ...] = ()
    qualifiers: frozenset[str] = frozenset()
    result: Spec = Spec("void")
    instance: Named | None = None
    variables: tuple[Named, ...] = ()
    uses: frozenset[str] = frozenset()

    @property
    def declares(self) -> Iterator[str]:
        """The global names that it declares."""
        if self.kind == "variables" or (self.kind == "block" and self.instance is None):
            yield from (member.name for member in self.members)
        if self.name:
            yield self.name
        if self.instance is not None:
            yield self.instance.name
        yield from (variable.name for variable in self.variables)


class Scanner:
    """Reads a text one declaration at a time. Raises ShaderError where brackets do not match."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens = [(m.group(), m.start(), m.end()) for m in _TOKEN.finditer(text)]
        self._at = 0

    def items(self) -> Iterator[Item]:
        while self._at < len(self._tokens):
            first = self._at
            kind, fields = self._declaration()
            start, end = self._tokens[first][1], self._tokens[self._at - 1][2]
            uses = self._uses(first, self._at)
            yield Item(kind, start, end, uses=uses, **fields)

    def _declaration(self) -> tuple[str, dict[str, Any]]:
        qualifiers = self._qualifiers()
        word = self._next()
        if word == ";":
            return "other", {}
        if word == "precision":
            self._skip_to(";")
            return "other", {}
        if word == "struct":
            name = self._next() if self._peek() != "{" else ""
            members = self._members()
            variables = self._declarators(Spec(name), qualifiers)
            return "struct", {
                "name": name, "members": members, "variables": variables, "qualifiers": qualifiers,
            }  # fmt: skip
        if self._peek() == "{":
            members = self._members()
            instance = None
            if self._peek() != ";":
                (instance,) = self._declarators(Spec(word), qualifiers)
            else:
                self._next()
            return "block", {
                "name": word, "members": members, "instance": instance, "qualifiers": qualifiers,
            }  # fmt: skip
        if self._peek() in (";", ","):  # `invariant gl_Position;`
            self._skip_to(";")
            return "other", {}
        spec = Spec(word, self._lengths())
        if self._at + 1 < len(self._tokens) and self._tokens[self._at + 1][0] == "(":
            return self._function(spec)
        members = self._declarators(spec, qualifiers)
        return "variables", {"members": members, "qualifiers": qualifiers}

    def _function(self, result: Spec) -> tuple[str, dict[str, Any]]:
        name = self._next()
        close = self._closing(self._at)
        self._next()
        parameters = []
        while self._at < close:
            qualifiers = self._qualifiers()
            word = self._next()
            lengths = self._lengths()
            own = self._next() if self._at < close and self._peek() != "," else ""
            lengths = self._lengths() + lengths
            if word != "void":
                parameters.append(Named(own, Spec(word, lengths), qualifiers))
            self._next()
        self._at = close + 1
        kind = "prototype"
        if self._peek() == "{":
            self._at = self._closing(self._at) + 1
            kind = "function"
        else:
            self._skip_to(";")
        return kind, {"name": name, "members": tuple(parameters), "result": result}

    def _members(self) -> tuple[Named, ...]:
        close = self._closing(self._at)
        self._next()
        found: list[Named] = []
        while self._at < close:
            qualifiers = self._qualifiers()
            word = self._next()
            found += self._declarators(Spec(word, self._lengths()), qualifiers)
        self._at = close + 1
        return tuple(found)

    def _declarators(self, spec: Spec, qualifiers: frozenset[str]) -> tuple[Named, ...]:
        """The names up to the semicolon, which is taken too."""
        found = []
        word = self._next()
        while word != ";":
            if word != ",":
                own = Spec(spec.name, self._lengths() + spec.lengths)
                found.append(Named(word, own, qualifiers, self._initialiser()))
            word = self._next()
        return tuple(found)

    def _initialiser(self) -> str:
        if self._peek() != "=":
            return ""
        self._next()
        start = self._tokens[self._at][1] if self._at < len(self._tokens) else 0
        while self._peek() not in (",", ";"):
            self._at = self._closing(self._at) if self._peek() in _CLOSING else self._at
            self._next()
        return self._text[start : self._tokens[self._at - 1][2]]

    def _lengths(self) -> tuple[str, ...]:
        found = []
        while self._peek() == "[":
            close = self._closing(self._at)
            found.append(self._text[self._tokens[self._at][2] : self._tokens[close][1]].strip())
            self._at = close + 1
        return tuple(found)

    def _qualifiers(self) -> frozenset[str]:
        found = set()
        while self._peek() in QUALIFIERS:
            found.add(self._next())
            if self._peek() == "(":
                close = self._closing(self._at)
                found |= {token for token, _, _ in self._tokens[self._at : close]}
                self._at = close + 1
        return frozenset(found)

    def _uses(self, first: int, last: int) -> frozenset[str]:
        """The names in some tokens, but for members after a dot and what is declared there."""
        used: set[str] = set()
        own: set[str] = set()
        called: set[str] = set()
        words = [token for token, _, _ in self._tokens[first:last]]
        for before, token, after in zip(["", *words], words, [*words[1:], ""], strict=False):
            if not _NAME.match(token) or before == ".":
                continue
            declared = bool(_NAME.match(before)) and before not in _NO_TYPES
            (own if declared else called if after == "(" else used).add(token)
        return frozenset(used - own | called)

    def _peek(self) -> str:
        if self._at >= len(self._tokens):
            raise self._error("the text ends in the middle of a declaration", -1)
        return self._tokens[self._at][0]

    def _next(self) -> str:
        token = self._peek()
        self._at += 1
        return token

    def _skip_to(self, wanted: str) -> None:
        while self._next() != wanted:
            pass

    def _closing(self, start: int) -> int:
        """The number of the token that closes the bracket at `start`."""
        expected: list[str] = []
        for number in range(start, len(self._tokens)):
            token = self._tokens[number][0]
            if token in _CLOSING:
                expected.append(_CLOSING[token])
            elif token in _CLOSING.values():
                if not expected or expected.pop() != token:
                    raise self._error(f"{token!r} closes nothing", number)
                if not expected:
                    return number
        raise self._error(f"{self._tokens[start][0]!r} is never closed", start)

    def _error(self, message: str, token: int) -> ShaderError:
        at = self._tokens[token][1] if self._tokens else 0
        return ShaderError(message, line=self._text.count("\n", 0, at) + 1)
