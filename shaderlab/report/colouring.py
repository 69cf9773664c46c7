"""Source text as lines of coloured HTML: Pygments' tokens in Pygments' spans, without those that no
style colours, which are half of them.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable
from functools import cache, lru_cache
from html import escape
from typing import Any

from pygments.formatters import HtmlFormatter
from pygments.lexers import GLShaderLexer, PythonLexer

PREFIX = "t-"
# White space, punctuation, names, operators.
_UNCOLOURED = frozenset(f'<span class="{PREFIX}{short}">' for short in "wpno")
_END = "</span>"
# Names and keywords come again and again, in one text and from one to the next; comments do not.
_MOST_KEPT = 4096
_LONGEST_KEPT = 40

Token = tuple[Any, str]
Span = tuple[str, str, list[str]]


class Colouring:
    """Colours the texts of one language; `tokens` takes them apart."""

    def __init__(self, tokens: Callable[[str], Iterable[Token]]) -> None:
        self._tokens = tokens
        self._formatter = HtmlFormatter(nowrap=True, classprefix=PREFIX)
        self._opening = cache(self._opening_of)
        self._kept = lru_cache(maxsize=_MOST_KEPT)(self._span)

    def lines(self, text: str) -> list[str]:
        """The lines of a text that ends with a line's end, each as HTML that can stand alone."""
        lines: list[str] = []
        line, inside = "", ""  # `inside` is the tag of a span that is open
        for kind, value in self._tokens(text):
            short = len(value) <= _LONGEST_KEPT
            opening, part, more = (self._kept if short else self._span)(kind, value)
            if part:
                if opening != inside:
                    line += _END + opening if inside else opening
                    inside = opening
                line += part
            for part in more:
                lines.append(line + _END if inside else line)
                line, inside = (opening + part, opening) if part else ("", "")
        return lines

    def _span(self, kind: Any, value: str) -> Span:
        """The tag before a token, "" for none, its text's first line, and the others."""
        first, *more = escape(value, quote=False).split("\n")
        return self._opening(kind), first, more

    def _opening_of(self, kind: Any) -> str:
        """The tag that the formatter puts before a token of this type; "" if it has no colour."""
        made = io.StringIO()
        self._formatter.format(((kind, "·"),), made)
        opening = made.getvalue().partition("·")[0]
        return "" if opening in _UNCOLOURED else opening


@cache
def colouring(language: str) -> Colouring:
    """What colours a language's texts, made once."""
    known = PythonLexer if language == "python" else GLShaderLexer
    # stripnl would take blank first lines away and so shift every number.
    lexer = known(stripnl=False, ensurenl=False)
    return Colouring(lexer.get_tokens)
