"""Lines of coloured code: what Pygments' own formatter makes, without spans that have no colour."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import GLShaderLexer, PythonLexer
from pygments.token import Name

from shaderlab.report import colouring as module
from shaderlab.report.colouring import Colouring, colouring
from shaderlab.report.text import clean

ROOT = Path(__file__).resolve().parents[2]
SHADERS = sorted(p for p in (ROOT / "shaders").rglob("*.*") if p.is_file())
MODULES = sorted(
    [*(ROOT / "cases").rglob("*.py"), *(ROOT / "shaderlab" / "reference").rglob("*.py")]
)
# What lexers have states for, some of it broken off, and what HTML must not take for itself.
PIECES = (
    "void main() { return 1.0e-3f; }", "#version 330 core\n", "#define A \\\n b", "/* no end",
    "*/", "// é\n", "0x1F", "?", "@", "\n", "\t ", "\\", "'", '"', "'''", '"""',
    'f"{x!r:>{w}}"', "def größe(x):", "from . import b as c", "lambda: 1_0j", "vec4", "self.x",
    "<b>", "&amp;", "·",
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
        assert colouring(language).lines(text) == by_pygments(text, language), file


@given(st.lists(st.sampled_from(PIECES), max_size=12))
def test_anything_looks_as_pygments_makes_it(pieces: list[str]) -> None:
    text = " ".join(pieces).rstrip("\n") + "\n"
    for language in LEXERS:
        assert colouring(language).lines(text) == by_pygments(text, language)


def test_each_line_can_stand_alone() -> None:
    lines = colouring("glsl").lines("/* one\n\n<two> */ int x;\n")
    assert lines == [
        '<span class="t-cm">/* one</span>',
        "",
        '<span class="t-cm">&lt;two&gt; */</span> <span class="t-kt">int</span> x;',
    ]


def test_what_is_kept_of_one_language_is_not_taken_for_the_other() -> None:
    for _ in range(2):
        assert colouring("glsl").lines("int\n") == ['<span class="t-kt">int</span>']
        assert colouring("python").lines("int\n") == ['<span class="t-nb">int</span>']
    assert colouring("glsl") is colouring("glsl")


def test_only_so_many_tokens_are_kept_and_only_short_ones() -> None:
    colours = Colouring(lambda text: [(Name, text)])
    long = "x" * (module._LONGEST_KEPT + 1)
    colours.lines(long + "\n")
    assert colours._kept.cache_info().currsize == 0
    for number in range(module._MOST_KEPT + 10):
        colours.lines(f"x{number}\n")
    assert colours._kept.cache_info().currsize == module._MOST_KEPT
