"""Text as HTML: lessons from a little Markdown, formulas from LaTeX, and coloured source code."""

from __future__ import annotations

import html
import inspect
import re
from collections.abc import Iterator
from functools import cache, lru_cache
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from markupsafe import Markup

from shaderlab.report.text import clean

if TYPE_CHECKING:
    from markdown_it import MarkdownIt
    from pygments.formatters import HtmlFormatter
    from pygments.lexer import Lexer

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
    from markdown_it import MarkdownIt

    return MarkdownIt("zero").enable(["list", "backticks", "code"])


def render_formula(latex: str) -> Markup:
    r"""Render LaTeX as a block of MathML; what can't be converted is shown as it is written.

    What a wide space (\quad, \qquad) parts are elements of their own, between which a line may end.
    """
    source = clean(latex).strip()
    if not source:
        return Markup("")
    from latex2mathml.converter import convert_to_element

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
    from pygments import highlight

    code: str = highlight(text, _lexer(language), _formatter())
    return tuple(code.removesuffix("\n").split("\n"))


@cache
def _lexer(language: str) -> Lexer:
    from pygments.lexers.graphics import GLShaderLexer
    from pygments.lexers.python import PythonLexer

    # stripnl would take blank first lines away and so shift every number.
    return (PythonLexer if language == "python" else GLShaderLexer)(stripnl=False, ensurenl=False)


@cache
def _formatter() -> HtmlFormatter[str]:
    from pygments.formatters import HtmlFormatter
    from pygments.token import Name, Operator, Punctuation, Whitespace

    made: HtmlFormatter[str] = HtmlFormatter(nowrap=True, classprefix=PREFIX)
    # Half of all tokens; the styles have no colour for them, so they get no span either.
    made.span_element_openers.update(dict.fromkeys((Name, Operator, Punctuation, Whitespace), ""))
    return made
