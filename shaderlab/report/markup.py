"""Lessons and formulas as HTML: a little Markdown, and LaTeX as MathML."""

from __future__ import annotations

import html
import inspect
import re
from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from shaderlab.report.text import clean

if TYPE_CHECKING:
    from markdown_it import MarkdownIt
    from markupsafe import Markup

_ELEMENT = re.compile(r"m[a-z]+")
# Everything else (links, styles, handlers) is dropped.
_ATTRIBUTES = frozenset(
    {"accent", "display", "displaystyle", "fence", "form", "largeop", "linethickness"}
    | {"lspace", "mathvariant", "maxsize", "minsize", "movablelimits", "rspace", "scriptlevel"}
    | {"separator", "stretchy", "symmetric", "width", "height", "depth", "voffset"}
    | {"columnalign", "columnlines", "columnspacing", "rowlines", "rowspacing"}
)

_WIDE = ("1em", "2em")  # \quad and \qquad


def lesson(text: str) -> Markup:
    """A docstring as HTML: paragraphs, lists ("-" or "1."), `code`, and indented blocks.

    Everything else, asterisks above all, is text: most of them are multiplications.
    """
    from markupsafe import Markup

    source = inspect.cleandoc(clean(text))
    # A formula's next line may begin with its operator; that makes no list.
    source = re.sub(r"(?m)^(\s*[+*]) ", "\\1\u00a0", source)
    return Markup(_markdown().render(source))


def code_spans(text: str) -> Markup:
    """One line of text with its `code` marked up."""
    from markupsafe import Markup

    return Markup(_markdown().renderInline(clean(text)))


def formula(latex: str) -> Markup:
    r"""LaTeX as a block of MathML; what can't be converted is shown as it is written.

    What a wide space (\quad, \qquad) parts are elements of their own, between which a line may end.
    """
    from markupsafe import Markup

    source = clean(latex).strip()
    if not source:
        return Markup("")
    plain = Markup('<pre class="tex">{}</pre>').format(source)
    from latex2mathml.converter import convert_to_element

    try:
        element = convert_to_element(source, display="block")
        safe = _only_mathml(element)
    except Exception:  # the converter's errors have no common base
        return plain
    if safe is None:
        return plain
    return Markup(" ".join(ET.tostring(part, encoding="unicode") for part in _parted(safe)))


def _parted(math: ET.Element) -> Iterator[ET.Element]:
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


@cache
def _markdown() -> MarkdownIt:
    from markdown_it import MarkdownIt

    return MarkdownIt("zero").enable(["list", "backticks", "code"])


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
