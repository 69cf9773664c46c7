"""Lexers whose rules are merged give the very tokens that Pygments gives."""

from __future__ import annotations

import re
from pathlib import Path
from typing import ClassVar

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pygments.lexer import Lexer, RegexLexer, bygroups, combined, default, include
from pygments.lexers import GLShaderLexer, PythonLexer
from pygments.token import Comment, Keyword, Name, Number, String, Text

from shaderlab.report.lexing import Merged, Token

ROOT = Path(__file__).resolve().parents[2]
GLSL = GLShaderLexer(stripnl=False, ensurenl=False)
PYTHON = PythonLexer(stripnl=False, ensurenl=False)
SHADERS = sorted(p for p in (ROOT / "shaders").rglob("*.*") if p.is_file())
MODULES = sorted(
    [*(ROOT / "cases").rglob("*.py"), *(ROOT / "shaderlab" / "reference").rglob("*.py")]
)
# What lexers have states for, some of it broken off.
PIECES = (
    "void main() { return 1.0e-3f; }", "#version 330 core\n", "#define A \\\n b", "/* no end",
    "*/", "// é\n", "0x1F", "07", "?", "@", "$", "\n", "\t ", "\\", "\\\n", "'", '"', "'''", '"""',
    'f"{x!r:>{w}}"', "rb'\\x'", "F'''{", "}", "u'\\N{DASH}'", "'%(a)s %d'", "'{0.x[1]:<3}'",
    "def größe(x):", "class A:", "from . import b as c", "import a.b", "raise X from y",
    "yield from z", "match x:\n case _:", "@wrap\n", "lambda: 1_0j", "not in", "async for", "...",
    "self.__init__", "True", "vec4", "print", "a.print", "x:=3", ":", ",", "[", "(", ")", "]",
)  # fmt: skip


class Small(RegexLexer):
    """Has a rule of each kind that there is."""

    flags = re.MULTILINE | re.IGNORECASE
    tokens: ClassVar = {
        "root": [
            include("blank"),
            (r"(?s)/\*.*?\*/", Comment),
            (r"(?P<name>let)(\s+)", bygroups(Keyword, Text), "name"),
            (r"(['\"])[a-c]*\1", String),
            (r"(?i)END", Keyword, "#pop:2"),
            (r"(\d+)(px|em)", bygroups(Number, Keyword)),
            (r"\d+", Number),
            (r"\(", Text, "#push"),
            (r"\)", Text, "#pop"),
            (r"<", Text, ("inner", "name")),
            (r"=", Text, combined("name", "blank")),
        ],
        "blank": [(r"[ \t]+", Text)],
        "name": [(r"[a-z]+", Name, "#pop"), default("#pop")],
        "inner": [(r"x", Name), (r"(?x) a  # or b", Name), (r">", Text, ("#pop", "#push"))],
    }


def alike(lexer: RegexLexer, text: str) -> list[Token]:
    found = list(Merged(lexer).tokens(text))
    assert found == [(kind, value) for _, kind, value in lexer.get_tokens_unprocessed(text)]
    assert "".join(value for _, value in found) == text
    return found


@pytest.mark.parametrize(("lexer", "files"), [(GLSL, SHADERS), (PYTHON, MODULES)])
def test_what_the_lab_is_made_of_is_taken_apart_as_pygments_does(
    lexer: RegexLexer, files: list[Path]
) -> None:
    assert len(files) > 100
    merged = Merged(lexer)
    for file in files:
        text = file.read_text(encoding="utf-8", errors="replace")
        expected = [(kind, value) for _, kind, value in lexer.get_tokens_unprocessed(text)]
        assert list(merged.tokens(text)) == expected, file


@given(st.lists(st.sampled_from(PIECES) | st.text(max_size=3), max_size=12))
def test_broken_texts_are_taken_apart_as_pygments_does(pieces: list[str]) -> None:
    for between in ("", " "):
        text = between.join(pieces)
        alike(GLSL, text)
        alike(PYTHON, text)


@given(st.lists(st.sampled_from([*"<>()=x \n'\"1a$", "let ", "END", "/*", "*/", "2px"])))
def test_rules_of_every_kind_are_followed(pieces: list[str]) -> None:
    alike(Small(), "".join(pieces))


def test_what_can_not_be_an_alternative_stands_alone_in_its_place() -> None:
    found = alike(Small(), "let a 'b' \"c' 3em END")
    assert [kind for kind, _ in found].count(String) == 1
    state = Merged(Small())._state("root")
    assert [len(rules.numbered) for rules in state] == [2, 0, 0, 7]
    inner = Merged(Small())._state("inner")  # where flags make an expression impossible
    assert [rules.alone is not None for rules in inner] == [True] * 3


def test_few_questions_are_asked() -> None:
    for lexer in (GLSL, PYTHON):
        merged = Merged(lexer)
        rules = merged._rules["root"]
        assert len(merged._state("root")) <= len(rules) / 10


def test_a_lexer_without_rules_is_refused() -> None:
    class Other(Lexer):
        flags = 0

    with pytest.raises(ValueError, match="Other"):
        Merged(Other())  # type: ignore[arg-type]

    class Wordy(Small):
        flags = re.VERBOSE

    with pytest.raises(ValueError, match="Wordy"):
        Merged(Wordy())
