"""Source text as lines of coloured HTML, by Pygments."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, lru_cache
from re import Match
from typing import ClassVar

from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexer import Lexer, inherit
from pygments.lexers.graphics import GLShaderLexer
from pygments.lexers.python import PythonLexer
from pygments.token import Name, Number, Operator, Punctuation, Text, Whitespace, _TokenType

PREFIX = "t-"
# Half of all tokens; the styles have no colour for them, so they get no span either.
_UNCOLOURED = (Name, Operator, Punctuation, Whitespace)
_TEXTS_KEPT = 256


@lru_cache(_TEXTS_KEPT)
def coloured_lines(text: str, language: str) -> tuple[str, ...]:
    """The lines of a text that ends with a line's end, each as HTML that can stand alone."""
    html: str = highlight(text, _lexer(language), _formatter())
    return tuple(html.removesuffix("\n").split("\n"))


# Pygments tries a lexer's rules in their order, for each token. With those of the commonest tokens
# first, and one for a run of characters that get no colour, the HTML is the same in half of the
# time.


@cache
def _kind(language: type[Lexer], word: str) -> _TokenType:
    return next(language(ensurenl=False).get_tokens_unprocessed(word))[1]


def _glsl_word(_: Lexer, match: Match[str]) -> Iterator[tuple[int, _TokenType, str]]:
    yield match.start(), _kind(GLShaderLexer, match.group()), match.group()


def _python_word(_: Lexer, match: Match[str]) -> Iterator[tuple[int, _TokenType, str]]:
    yield match.start(), _kind(PythonLexer, match.group()), match.group()


class _Glsl(GLShaderLexer):
    tokens: ClassVar = {
        "root": [
            (r"[\s;{}(),\[\]+\-~!*%<>=&^|?:]+", Text),
            (r"(?<!\w)[a-zA-Z_]\w*", _glsl_word),
            (r"\d*\.\d+([eE][-+]?\d+)?", Number.Float),
            inherit,
        ]
    }


class _Python(PythonLexer):
    tokens: ClassVar = {
        "root": [
            # Spaces at the start of a line belong to what follows: a docstring, or match and case.
            (r"(?<=\S) +", Text),
            (r"[]{}:(),;[+*/%<>=&^|~-]+ *", Text),
            (r"\d+\.\d+(?![\w.])", Number.Float),
            (r"^ +(?![ \t\"'rRuUbBmc])", Text),
            # But for words that begin what has rules of its own, and prefixes of strings.
            (
                r"(?<![.\w])(?!(?:def|class|from|import|lazy|match|case|async|yield)\b)"
                r"[a-zA-Z_]\w*(?![\"'\w]|[^\x00-\x7f])",
                _python_word,
            ),
            inherit,
        ]
    }


@cache
def _lexer(language: str) -> Lexer:
    known: type[Lexer] = _Python if language == "python" else _Glsl
    # stripnl would take blank first lines away and so shift every number.
    return known(stripnl=False, ensurenl=False)


@cache
def _formatter() -> HtmlFormatter[str]:
    made: HtmlFormatter[str] = HtmlFormatter(nowrap=True, classprefix=PREFIX)
    made.span_element_openers.update(dict.fromkeys(_UNCOLOURED, ""))
    return made
