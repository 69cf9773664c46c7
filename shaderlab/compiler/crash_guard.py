"""Texts that would crash a compiler are refused before it gets them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from shaderlab.model.records import Diagnostic

from .diagnostics import VERSION, find_line
from .engines import SETTINGS, Engine
from .sources import Source

MAX_NESTING = 200
MAX_OPERATORS = 5000

_OPERATORS = "+-*/%<>=&|^!~,"
_TOKEN = re.compile(r"\w+|[(){}\[\];?\n]|[-+*/%<>=&|^!~,]")
_BLOCK = re.compile(r"\b(?:uniform|buffer|in|out)\s+(\w+)\s*\{")
# After a type or another name; what an expression says of a built-in crashes nothing.
_BUILT_IN_MEMBER = re.compile(r"(?:[\w\]]\s+|,\s*)(gl_\w+)\s*[;,\[]")
_DEFINE = re.compile(r"#[ \t]*define\b[ \t]*(.*)")
# A macro for one number or name, or for nothing, does not nest.
_HARMLESS = re.compile(r"\w+(?:[ \t]+(?!(?:if|else|for|while|do|switch)\b)[\w.]+)?[ \t]*$")
_BRANCHES = frozenset(["if", "else", "for", "while", "do", "switch", "?"])


def find_crash(source: Source, engine: Engine) -> Diagnostic | None:
    """Return an error if the text would crash the compiler, or None."""
    code = source.code
    if "define" in code and not all(map(_HARMLESS.match, _DEFINE.findall(code))):
        code = engine.preprocess(source) or code  # a few macros can expand to many operators
    found = _find_crashing_block(code) or (None if _is_small(code) else _find_deep_nesting(code))
    if found is None:
        return None
    token, message, line = found
    return source.diagnostic(message, line, token=token)


def check_version(source: Source, target: str) -> Diagnostic | None:
    """glslang's error for a `#version` too old for SPIR-V.

    Below these versions glslang can't parse its own built-in functions, and prints all of them
    to the process's standard output.
    """
    minimum, name = SETTINGS[target].minimum, SETTINGS[target].api
    version, profile = source.version
    if version >= minimum or profile == "es" or version == 100:
        return None
    at = find_line(VERSION, source) or 1
    message = f"Desktop shaders for {name} SPIR-V require version {minimum} or higher"
    return source.diagnostic(message, at)


def _find_crashing_block(code: str) -> tuple[str, str, int] | None:
    """Return a block that crashes glslang 13: its name is reused for an array with an initialiser,
    or a member has a built-in's name. The token, the message and the line."""
    for block in _BLOCK.finditer(code):
        name, start = block[1], block.end()
        again = re.compile(rf"\b{name}\s*(\[[^\]]*\]\s*)+=").search(code, start)
        if again:
            return name, f"'{name}' : redefinition", code.count("\n", 0, again.start()) + 1
        end = code.find("}", start)
        member = _BUILT_IN_MEMBER.search(code, start, end if end >= 0 else len(code))
        if member and not name.startswith("gl_"):
            word = member.group(1)
            message = f"'{word}' : identifiers starting with \"gl_\" are reserved"
            return word, message, code.count("\n", 0, member.start(1)) + 1
    return None


def _find_deep_nesting(code: str) -> tuple[str, str, int] | None:
    overflows = "which overflows the compiler's stack"
    for line, nesting, operators in _depths(code):
        if nesting > MAX_NESTING:
            return "", f"nests deeper than {MAX_NESTING} levels, {overflows}", line
        if operators > MAX_OPERATORS:
            what = f"has a statement of more than {MAX_OPERATORS} operators"
            return "", f"{what}, {overflows}", line
    return None


def _is_small(code: str) -> bool:
    """Return whether the whole text has no more operators and brackets than one statement may have.
    Going through the tokens of every text would take a tenth of the time to compile it."""
    branches = sum(map(code.count, ("{", "(", "[", "?", "if", "else", "for", "while", "do")))
    return branches <= MAX_NESTING and sum(map(code.count, _OPERATORS)) <= MAX_OPERATORS


def _depths(code: str) -> Iterator[tuple[int, int, int]]:
    """For each token: its line, its nesting depth, and the operators so far in its expression."""
    line, branches, before = 1, 0, ";"
    inside = [_Bracket(is_list=False)]
    for match in _TOKEN.finditer(code):
        token = match.group()
        if token == "\n":
            line += 1
            continue
        here = inside[-1]
        if before in ";}":
            branches = here.operators = 0
            here.chain = here.chain + 1 if token == "else" else 0
        if token in "([{":
            branches = 0 if token == "{" else branches
            inside.append(_Bracket(is_list=_opens_list(token, before)))
        elif token in ")]}":
            del inside[max(len(inside) - 1, 1) :]
        elif token in _BRANCHES:
            branches += 1
        elif token == "," and here.is_list:
            here.operators = 0
        elif token in _OPERATORS:
            here.operators += 1
        before = token
        yield line, len(inside) + sum(b.chain for b in inside) + branches, inside[-1].operators


@dataclass
class _Bracket:
    """An open bracket: whether its commas separate a list, and so far the `else`s in the chain of
    branches, and the operators in the expression."""

    is_list: bool
    chain: int = 0
    operators: int = 0


def _opens_list(token: str, before: str) -> bool:
    """Return whether commas after the bracket separate arguments or elements, not operands."""
    return before[-1].isalnum() or before in "]_" if token == "(" else before in "=,({"
