"""Lines of coloured code: what Pygments' own formatter makes, without spans that have no colour."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, strategies as st
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import GLShaderLexer, PythonLexer

from shaderlab.report.sources import colour_lines
from shaderlab.report.text import clean

ROOT = Path(__file__).resolve().parents[2]
SHADERS = sorted(p for p in (ROOT / "shaders").rglob("*.*") if p.is_file())
MODULES = sorted(
    [*(ROOT / "cases").rglob("*.py"), *(ROOT / "shaderlab" / "reference").rglob("*.py")]
)[::6]
# What lexers have states for, some of it broken off, and what HTML must not take for itself.
PIECES = (
    "void main() { return 1.0e-3f; }", "#version 330 core\n", "#define A \\\n b", "/* no end",
    "*/", "// é\n", "0x1F", "?", "@", "\n", "\t ", "\\", "'", '"', "'''", '"""',
    'f"{x!r:>{w}}"', "def größe(x):", "from . import b as c", "lambda: 1_0j", "vec4", "self.x",
    "<b>", "&amp;", "·", "if", "gl_X", "0xF", "1.",
)  # fmt: skip
LEXERS = {
    "glsl": GLShaderLexer(stripnl=False, ensurenl=False),
    "python": PythonLexer(stripnl=False, ensurenl=False),
}


def by_pygments(text: str, language: str) -> list[str]:
    formatter = HtmlFormatter(nowrap=True, classprefix="t-")
    code = highlight(text, LEXERS[language], formatter)
    plain = re.sub(r'<span class="t-(?:w|p|n|o)">(.*?)</span>', r"\1", code)
    return plain.removesuffix("\n").split("\n")


@pytest.mark.parametrize(("language", "files"), [("glsl", SHADERS), ("python", MODULES)])
def test_the_labs_own_sources_look_as_pygments_makes_them(language: str, files: list[Path]) -> None:
    for file in files:
        text = clean(file.read_text(encoding="utf-8", errors="replace")).rstrip("\n") + "\n"
        assert list(colour_lines(text, language)) == by_pygments(text, language), file


@given(st.lists(st.sampled_from(PIECES), max_size=12), st.sampled_from(["", " "]))
def test_anything_looks_as_pygments_makes_it(pieces: list[str], between: str) -> None:
    text = between.join(pieces).rstrip("\n") + "\n"
    for language in LEXERS:
        assert list(colour_lines(text, language)) == by_pygments(text, language)


def test_each_line_can_stand_alone() -> None:
    lines = colour_lines("/* one\n\n<two> */ int x;\n", "glsl")
    assert list(lines) == [
        '<span class="t-cm">/* one</span>',
        "",
        '<span class="t-cm">&lt;two&gt; */</span> <span class="t-kt">int</span> x;',
    ]
