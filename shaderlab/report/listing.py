"""Sources as numbered, highlighted lines, with compilers' messages under the lines they mean."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from shaderlab.records import Diagnostic, SourceText
from shaderlab.report.text import clean

if TYPE_CHECKING:
    from markupsafe import Markup


@dataclass(frozen=True)
class Line:
    """One line: its number in the file, its anchor, its HTML, and the messages about it."""

    number: int
    anchor: str
    html: Markup
    messages: tuple[Diagnostic, ...]


@dataclass(frozen=True)
class Listing:
    """A source ready to print. `variants` says which variants use it, empty for all of them.

    `repeated` says that an earlier case shows the very same, under the same anchors.
    """

    file: str
    language: str
    anchor: str
    lines: tuple[Line, ...]
    variants: tuple[str, ...] = ()
    repeated: bool = False

    @property
    def place(self) -> str:
        """File and first line, as editors understand it."""
        return f"{self.file}:{self.lines[0].number}" if self.lines else self.file

    @property
    def has_messages(self) -> bool:
        """Whether a compiler said anything about it."""
        return any(line.messages for line in self.lines)

    def anchor_of(self, file: str, line: int) -> str | None:
        """The anchor of a line of a file, if it is in this listing."""
        index = line - self.lines[0].number if self.lines else -1
        if file != self.file or not 0 <= index < len(self.lines):
            return None
        return self.lines[index].anchor


def listing(
    source: SourceText,
    anchor: str,
    diagnostics: Iterable[Diagnostic] = (),
    variants: tuple[str, ...] = (),
) -> Listing:
    """`source` with those of `diagnostics` that speak of its file, each said once."""
    by_line: dict[int, list[Diagnostic]] = {}
    for message in dict.fromkeys(diagnostics):
        if message.file == source.file and message.line is not None:
            by_line.setdefault(message.line, []).append(message)
    lines = [
        Line(number, f"{anchor}-L{number}", html, tuple(by_line.get(number, ())))
        for number, html in enumerate(_highlighted(source.text, source.language), source.line)
    ]
    return Listing(source.file, source.language, anchor, tuple(lines), variants)


def _highlighted(text: str, language: str) -> list[Markup]:
    from markupsafe import Markup

    from shaderlab.report.colouring import colouring

    code = clean(text).expandtabs(4).rstrip("\n") + "\n"
    return [Markup(line) for line in colouring(language).lines(code)]
