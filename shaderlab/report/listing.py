"""Sources as numbered, highlighted lines, with compilers' messages under the lines they mean."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from shaderlab.model.records import Diagnostic, SourceText
from shaderlab.report.text import clean

if TYPE_CHECKING:
    from markupsafe import Markup


@dataclass(frozen=True)
class Part:
    """Lines that follow one another as HTML, and the messages about the last of them."""

    html: Markup
    messages: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Listing:
    """A source ready to print: `count` lines, counted from `first`, and `messages` by line.
    `variants` says which variants use it, empty for all of them.

    `repeated`: an earlier case has the same listing, under the same anchors.
    """

    source: SourceText
    anchor: str
    count: int
    messages: Mapping[int, Sequence[Diagnostic]]
    variants: tuple[str, ...] = ()
    repeated: bool = False

    @property
    def first(self) -> int:
        """The number of its first line."""
        return self.source.line

    @property
    def place(self) -> str:
        """File and first line, as editors understand it."""
        return f"{self.source.file}:{self.first}"

    @property
    def has_messages(self) -> bool:
        """Whether compilers have messages about one of its lines."""
        return any(self.first <= line < self.first + self.count for line in self.messages)

    @property
    def parts(self) -> Iterator[Part]:
        """Its lines, coloured when they are asked for, cut after those with messages."""
        from shaderlab.report.colouring import coloured_lines

        lines = coloured_lines(_code(self.source), self.source.language)
        return _parts(lines, self.first, self.anchor, self.messages)

    def anchor_of(self, file: str, line: int) -> str | None:
        """The anchor of a line of a file, if it is in this listing."""
        if file != self.source.file or not 0 <= line - self.first < self.count:
            return None
        return _anchor(self.anchor, line)


def listing(
    source: SourceText,
    anchor: str,
    diagnostics: Iterable[Diagnostic] = (),
    variants: tuple[str, ...] = (),
) -> Listing:
    """`source` with the `diagnostics` about its file, each once."""
    by_line: dict[int, list[Diagnostic]] = {}
    for message in dict.fromkeys(diagnostics):
        if message.file == source.file and message.line is not None:
            by_line.setdefault(message.line, []).append(message)
    return Listing(source, anchor, _code(source).count("\n"), by_line, variants)


def _code(source: SourceText) -> str:
    return clean(source.text).expandtabs(4).rstrip("\n") + "\n"


def _parts(
    lines: Iterable[str], first: int, anchor: str, messages: Mapping[int, Sequence[Diagnostic]]
) -> Iterator[Part]:
    """Numbered lines, cut after those with messages.

    A page has more lines of code than of anything else, so a template gets many at once. `lines`
    are HTML, and anchors and numbers need no escaping.
    """
    from markupsafe import Markup

    rows = []
    for number, code in enumerate(lines, first):
        place = _anchor(anchor, number)
        rows.append(
            f'<span class="row" id="{place}"><a href="#{place}" tabindex="-1">{number}</a>'
            f"<span>{code}\n</span></span>"
        )
        if number in messages:
            yield Part(Markup("".join(rows)), tuple(messages[number]))
            rows = []
    yield Part(Markup("".join(rows)))


def anchor_of(texts: Iterable[Listing], file: str, line: int) -> str | None:
    """The anchor of a source line, if one of the listings shows it."""
    return next(filter(None, (text.anchor_of(file, line) for text in texts)), None)


def _anchor(listing: str, line: int) -> str:
    return f"{listing}-L{line}"
