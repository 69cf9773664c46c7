"""Source text as lines of coloured HTML, by Pygments."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache

from pygments import highlight
from pygments.filter import Filter
from pygments.formatters import HtmlFormatter
from pygments.lexer import Lexer
from pygments.lexers import GLShaderLexer, PythonLexer
from pygments.token import Name, Operator, Punctuation, Text, Whitespace, _TokenType

PREFIX = "t-"
# Half of all tokens; the styles have no colour for them, so they get no span either.
_UNCOLOURED = frozenset({Name, Operator, Punctuation, Whitespace})


def coloured_lines(text: str, language: str) -> list[str]:
    """The lines of a text that ends with a line's end, each as HTML that can stand alone."""
    html: str = highlight(text, _lexer(language), _formatter())
    return html.removesuffix("\n").split("\n")


class _PlainText(Filter):
    """Gives tokens without a colour the type of plain text."""

    def filter(
        self, lexer: Lexer | None, stream: Iterable[tuple[_TokenType, str]]
    ) -> Iterator[tuple[_TokenType, str]]:
        for kind, value in stream:
            yield (Text if kind in _UNCOLOURED else kind), value


@cache
def _lexer(language: str) -> Lexer:
    known: type[Lexer] = PythonLexer if language == "python" else GLShaderLexer
    # stripnl would take blank first lines away and so shift every number.
    lexer = known(stripnl=False, ensurenl=False)
    lexer.add_filter(_PlainText())
    return lexer


@cache
def _formatter() -> HtmlFormatter[str]:
    return HtmlFormatter(nowrap=True, classprefix=PREFIX)
