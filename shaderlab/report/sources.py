"""A case's texts for its page: lessons, formulas and coloured source code as HTML, compilers'
messages, programs, SPIR-V, and the words that it is found by. What variants share is shown once."""

from __future__ import annotations

import html
import inspect
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from xml.etree import ElementTree as ET

from latex2mathml.converter import convert_to_element
from markdown_it import MarkdownIt
from markupsafe import Markup
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexer import Lexer
from pygments.lexers.graphics import GLShaderLexer
from pygments.lexers.python import PythonLexer
from pygments.token import Name, Operator, Punctuation, Whitespace

from shaderlab.errors import Diagnostic, Verdict
from shaderlab.model.records import Declared, Record, SourceText
from shaderlab.report.grouping import CaseGroup
from shaderlab.report.text import Anchors, clean

PREFIX = "t-"
"""What the classes of coloured code begin with."""
_TEXTS_KEPT = 256
_ELEMENT = re.compile(r"m[a-z]+")
# Everything else (links, styles, handlers) is dropped.
_ATTRIBUTES = frozenset(
    {"accent", "display", "displaystyle", "fence", "form", "largeop", "linethickness"}
    | {"lspace", "mathvariant", "maxsize", "minsize", "movablelimits", "rspace", "scriptlevel"}
    | {"separator", "stretchy", "symmetric", "width", "height", "depth", "voffset"}
    | {"columnalign", "columnlines", "columnspacing", "rowlines", "rowspacing"}
)
_WIDE = ("1em", "2em")  # \quad and \qquad


def render_lesson(text: str) -> Markup:
    """Render a docstring: paragraphs, lists ("-" or "1."), `code`, and indented blocks.

    Everything else, asterisks above all, is text: most of them are multiplications.
    """
    source = inspect.cleandoc(clean(text))
    # A formula's next line may begin with its operator; that makes no list.
    source = re.sub(r"(?m)^(\s*[+*]) ", "\\1\u00a0", source)
    return Markup(_markdown().render(source))


def code_spans(text: str) -> Markup:
    """Render one line of text with its `code` marked up."""
    return Markup(_markdown().renderInline(clean(text)))


@cache
def _markdown() -> MarkdownIt:
    return MarkdownIt("zero").enable(["list", "backticks", "code"])


def render_formula(latex: str) -> Markup:
    r"""Render LaTeX as a block of MathML; what can't be converted is shown as it is written.

    What a wide space (\quad, \qquad) parts are elements of their own, between which a line may end.
    """
    source = clean(latex).strip()
    if not source:
        return Markup("")
    try:
        safe = _only_mathml(convert_to_element(source, display="block"))
    except Exception:  # the converter's errors have no common base
        safe = None
    if safe is None:
        return Markup('<pre class="tex">{}</pre>').format(source)
    return Markup(" ".join(ET.tostring(part, encoding="unicode") for part in _split(safe)))


def _split(math: ET.Element) -> Iterator[ET.Element]:
    """The parts of a formula between its wide spaces, each an element like the whole."""
    if len(math) != 1:
        yield math
        return
    row = math[0]
    part: list[ET.Element] = []
    for child in (*row, None):
        if child is None or (child.tag == "mspace" and child.get("width") in _WIDE):
            if part:
                copy = ET.Element(math.tag, math.attrib)
                ET.SubElement(copy, row.tag, row.attrib).extend(part)
                yield copy
            part = []
        else:
            part.append(child)


def _only_mathml(element: ET.Element) -> ET.Element | None:
    """A copy with nothing in it but MathML's presentation elements; None if there was more."""
    tag = element.tag.rsplit("}", 1)[-1]
    if not _ELEMENT.fullmatch(tag) or tag in ("maction", "mglyph"):
        return None
    copy = ET.Element(tag, {k: v for k, v in element.items() if k in _ATTRIBUTES})
    # The converter leaves character references for a later stage to resolve.
    copy.text = html.unescape(element.text) if element.text else None
    copy.tail = html.unescape(element.tail) if element.tail else None
    for child in element:
        part = _only_mathml(child)
        if part is None:
            return None
        copy.append(part)
    return copy


@lru_cache(_TEXTS_KEPT)
def colour_lines(text: str, language: str) -> tuple[str, ...]:
    """Return the lines of a text that ends with a line's end, each as HTML that can stand alone."""
    code: str = highlight(text, _lexer(language), _formatter())
    return tuple(code.removesuffix("\n").split("\n"))


@cache
def _lexer(language: str) -> Lexer:
    # stripnl would take blank first lines away and so shift every number.
    return (PythonLexer if language == "python" else GLShaderLexer)(stripnl=False, ensurenl=False)


@cache
def _formatter() -> HtmlFormatter[str]:
    made: HtmlFormatter[str] = HtmlFormatter(nowrap=True, classprefix=PREFIX)
    # Half of all tokens; the styles have no colour for them, so they get no span either.
    made.span_element_openers.update(dict.fromkeys((Name, Operator, Punctuation, Whitespace), ""))
    return made


@dataclass(frozen=True)
class Part:
    """Lines that follow one another as HTML, and the messages about the last of them."""

    html: Markup
    messages: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Listing:
    """A source ready to print: `count` lines, and `messages` by line.
    `variants` says which variants use it, empty for all of them.
    """

    source: SourceText
    anchor: str
    count: int
    messages: Mapping[int, Sequence[Diagnostic]]
    variants: tuple[str, ...] = ()

    @property
    def place(self) -> str:
        return f"{self.source.file}:{self.source.line}"

    @property
    def has_messages(self) -> bool:
        return any(0 <= line - self.source.line < self.count for line in self.messages)

    @property
    def parts(self) -> Iterator[Part]:
        """Its lines, numbered and coloured, cut after those with messages.

        A page has more lines of code than of anything else, so a template gets many at once.
        Anchors and numbers need no escaping.
        """
        rows = []
        lines = colour_lines(_code(self.source), self.source.language)
        for number, code in enumerate(lines, self.source.line):
            place = f"{self.anchor}-L{number}"
            rows.append(
                f'<span class="row" id="{place}"><a href="#{place}" tabindex="-1">{number}</a>'
                f"<span>{code}\n</span></span>"
            )
            if number in self.messages:
                yield Part(Markup("".join(rows)), tuple(self.messages[number]))
                rows = []
        yield Part(Markup("".join(rows)))


def _code(source: SourceText) -> str:
    return clean(source.text).expandtabs(4).rstrip("\n") + "\n"


def anchor_of(texts: Iterable[Listing], file: str, line: int) -> str | None:
    for text in texts:
        if file == text.source.file and 0 <= line - text.source.line < text.count:
            return f"{text.anchor}-L{line}"
    return None


def list_sources(
    group: CaseGroup, anchors: Anchors
) -> tuple[tuple[Listing, ...], tuple[Listing, ...]]:
    """Return each source text once, GLSL and Python apart, with the messages of all compilers."""
    users: dict[SourceText, list[str]] = {}
    messages: dict[Diagnostic, None] = {}
    judged_by: set[str] = set()
    for record in group.records:
        sources: dict[SourceText, None] = {}
        for program in record.programs:
            sources.update(dict.fromkeys(program.sources))
            for verdict in program.verdicts:
                messages.update(dict.fromkeys(verdict.diagnostics))
        for outcome in record.expectations:
            sources.update(dict.fromkeys(outcome.sources))
            judged_by.update(source.file for source in outcome.sources)
        for source in sources:
            users.setdefault(source, []).append(record.variant)
    # Without a text that another one of the same file holds at the same lines. Sources of checks
    # come first, others (pictures, included files) after them.
    whole = [source for source in users if not any(_contains(other, source) for other in users)]
    texts = []
    for source in sorted(whole, key=lambda source: source.file not in judged_by):
        by_line: dict[int, list[Diagnostic]] = {}
        for message in messages:
            if message.file == source.file and message.line is not None:
                by_line.setdefault(message.line, []).append(message)
        variants = _unless_all(users[source], group)
        count = _code(source).count("\n")
        texts.append(Listing(source, anchors.short(), count, by_line, variants))
    return (
        tuple(text for text in texts if text.source.language == "glsl"),
        tuple(text for text in texts if text.source.language == "python"),
    )


def _contains(whole: SourceText, part: SourceText) -> bool:
    if whole.file != part.file or whole.line > part.line or len(whole.text) <= len(part.text):
        return False
    # Without indentation, which a line quoted alone has often lost.
    lines = [line.strip() for line in part.text.rstrip().split("\n")]
    start = part.line - whole.line
    return lines == [line.strip() for line in whole.text.split("\n")[start : start + len(lines)]]


@dataclass(frozen=True)
class Compiled:
    """Programs with the same files and verdicts. `variants` is empty where all share them."""

    files: tuple[str, ...]
    verdicts: tuple[Verdict, ...]
    variants: tuple[str, ...]
    declared: tuple[Declared, ...] = ()


def list_programs(group: CaseGroup) -> tuple[Compiled, ...]:
    """Return each program with its verdicts; variants that agree share an entry."""
    users: dict[tuple[tuple[str, ...], tuple[Verdict, ...], tuple[Declared, ...]], list[str]] = {}
    for record in group.records:
        for program in record.programs:
            names = users.setdefault((program.files, program.verdicts, program.declared), [])
            if record.variant not in names:
                names.append(record.variant)
    return tuple(
        Compiled(files, verdicts, _unless_all(names, group), declared)
        for (files, verdicts, declared), names in users.items()
    )


def _unless_all(variants: Sequence[str], group: CaseGroup) -> tuple[str, ...]:
    return () if len(variants) == len(group.records) else tuple(variants)


def collect_words(records: Iterable[Record]) -> str:
    """Return the words that a case's page shows, but for numbers and compilers' tables, each once
    and in small letters."""
    texts: dict[str, None] = {}
    for record in records:
        texts.update(dict.fromkeys(_texts(record)))
    found = dict.fromkeys(word for text in texts for word in clean(text).lower().split())
    return " ".join(found)


def _texts(record: Record) -> Iterator[str]:
    yield from (record.id, record.title, record.section, record.chapter, record.file)
    place = record.place
    yield from (place.title_zh, place.stage_title, place.stage_title_zh, place.section_title)
    yield place.section_title_zh
    yield from (record.variant, record.lesson, record.message, *record.notices, *record.inputs)
    for outcome in record.expectations:
        yield from (outcome.name, outcome.kind, outcome.message)
        yield from (text for row in outcome.rows for text in (row.label, row.note))
        yield from (source.text for source in outcome.sources)
    for program in record.programs:
        yield from (text for source in program.sources for text in (source.file, source.text))
        yield from (d.message for verdict in program.verdicts for d in verdict.diagnostics)
