"""Source text as lines of coloured HTML, by Pygments."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from re import Match
from typing import ClassVar

from pygments import highlight
from pygments.filter import Filter
from pygments.formatters import HtmlFormatter
from pygments.lexer import Lexer, inherit
from pygments.lexers.graphics import GLShaderLexer
from pygments.lexers.python import PythonLexer
from pygments.token import Name, Operator, Punctuation, Text, Whitespace, _TokenType

PREFIX = "t-"
# Half of all tokens; the styles have no colour for them, so they get no span either.
_UNCOLOURED = frozenset({Name, Operator, Punctuation, Whitespace})


def coloured_lines(text: str, language: str) -> list[str]:
    """The lines of a text that ends with a line's end, each as HTML that can stand alone."""
    html: str = highlight(text, _lexer(language), _formatter())
    return html.removesuffix("\n").split("\n")


# Pygments tries a lexer's rules in their order. With those of the commonest tokens first, which
# changes no token, it takes a third of the time for GLSL and two thirds for Python.


@cache
def _kind(word: str) -> _TokenType:
    return next(GLShaderLexer(ensurenl=False).get_tokens_unprocessed(word))[1]


def _word(_: Lexer, match: Match[str]) -> Iterator[tuple[int, _TokenType, str]]:
    yield match.start(), _kind(match.group()), match.group()


class _Glsl(GLShaderLexer):
    tokens: ClassVar = {
        "root": [
            (r"\s+", Whitespace),
            (r"(?<!\w)[a-zA-Z_]\w*", _word),
            (r"[;{}(),\[\]]", Punctuation),
            inherit,
        ]
    }


class _Python(PythonLexer):
    # Not at the start of a line: spaces there belong to a docstring.
    tokens: ClassVar = {"root": [(r"(?<=\S) +", Text), (r"[]{}:(),;[]", Punctuation), inherit]}


class _PlainText(Filter):
    """Gives tokens without a colour the type of plain text."""

    def filter(
        self, lexer: Lexer | None, stream: Iterable[tuple[_TokenType, str]]
    ) -> Iterator[tuple[_TokenType, str]]:
        for kind, value in stream:
            yield (Text if kind in _UNCOLOURED else kind), value


@cache
def _lexer(language: str) -> Lexer:
    known: type[Lexer] = _Python if language == "python" else _Glsl
    # stripnl would take blank first lines away and so shift every number.
    lexer = known(stripnl=False, ensurenl=False)
    lexer.add_filter(_PlainText())
    return lexer


@cache
def _formatter() -> HtmlFormatter[str]:
    return HtmlFormatter(nowrap=True, classprefix=PREFIX)
