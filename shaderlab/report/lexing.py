"""Lexers of Pygments that ask few questions at each place of a text, where Pygments asks dozens.

Pygments tries the rules of a state one by one. Here rules that follow one another are the
alternatives of one regular expression, so that the first that holds is found at once.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any

from pygments.token import Error, Whitespace

if TYPE_CHECKING:
    from pygments.lexer import RegexLexer

Token = tuple[Any, str]
Match = re.Match[str]
Matcher = Callable[[str, int], Match | None]

_FLAGS_IN_FRONT = re.compile(r"\(\?([aimsu]+)\)")
# What may hold a parenthesis that begins no group, or is one that does.
_PARENTHESIS = re.compile(r"\\.|\[\^?\]?(?:\\.|[^\]\\])*\]|\((?!\?)", re.DOTALL)
# Groups that a rule itself needs.
_BY_NAME_OR_NUMBER = re.compile(r"\\[1-9]|\(\?P|\(\?\(")
# Classes of all the letters that there are take longer to compile than they would save.
_LONGEST = 1000
_FIRST = "root"


@dataclass(frozen=True, slots=True)
class _Rule:
    """What Pygments has for a rule: `action` is a token's type, a function that makes tokens of a
    match, or None; `step` changes the stack of states."""

    match: Matcher
    action: Any
    step: Any

    @property
    def pattern(self) -> str:
        found: re.Pattern[str] = self.match.__self__  # type: ignore[attr-defined]
        return found.pattern

    @property
    def mixes(self) -> bool:
        """Whether it can be one of several alternatives, and is not better off alone."""
        return len(self.pattern) <= _LONGEST and not _BY_NAME_OR_NUMBER.search(self.pattern)


@dataclass(frozen=True, slots=True)
class _Rules:
    """Rules that follow one another in a state, as one expression: the number of the group that
    matched tells which of them it was. One that is alone has no number."""

    match: Matcher
    numbered: Sequence[_Rule]
    alone: _Rule | None = None


class Merged:
    """Takes texts apart as `lexer` does.

    Raises:
        ValueError: this is no lexer whose rules are known.
    """

    def __init__(self, lexer: RegexLexer) -> None:
        self._lexer = lexer
        self._rules: Mapping[str, Any] = getattr(lexer, "_tokens", {})
        self._states: dict[str, list[_Rules]] = {}
        if _FIRST not in self._rules or lexer.flags & re.VERBOSE:
            raise ValueError(f"the rules of {type(lexer).__name__} can't be merged")

    def tokens(self, text: str) -> Iterator[Token]:
        """The types and texts of all tokens; together they are `text`."""
        place, stack = 0, [_FIRST]
        state = self._state(_FIRST)
        while True:
            for rules in state:
                match = rules.match(text, place)
                if match is not None:
                    break
            else:
                if place == len(text):
                    return
                if text[place] == "\n":  # what nobody understands ends with its line
                    stack = [_FIRST]
                    state = self._state(_FIRST)
                    yield Whitespace, "\n"
                else:
                    yield Error, text[place]
                place += 1
                continue
            rule = rules.alone or rules.numbered[(match.lastindex or 0) - 1]
            if callable(rule.action):
                own = rule.match(text, place)  # with its groups
                for _, kind, value in rule.action(self._lexer, own):
                    yield kind, value
            elif rule.action is not None:
                yield rule.action, match.group()
            place = match.end()
            if rule.step is not None:
                _move(stack, rule.step)
                state = self._state(stack[-1])

    def _state(self, name: str) -> list[_Rules]:
        """A state's rules, merged when a text first comes to it: few get to most states."""
        if name not in self._states:
            rules = [_Rule(*rule) for rule in self._rules[name]]
            self._states[name] = [
                found
                for mixes, run in groupby(rules, lambda rule: rule.mixes)
                for found in (_together(list(run), self._lexer.flags) if mixes else _apart(run))
            ]
        return self._states[name]


def _apart(rules: Iterable[_Rule]) -> Iterable[_Rules]:
    return [_Rules(rule.match, (), rule) for rule in rules]


def _together(rules: Sequence[_Rule], flags: int) -> Iterable[_Rules]:
    # The empty groups are the only ones: to note where others begin would take most of the time.
    expression = "|".join(f"(?:{_without_groups(rule.pattern)})()" for rule in rules)
    try:
        merged = re.compile(expression, flags)
    except re.error:
        return _apart(rules)
    return [_Rules(merged.match, rules)] if merged.groups == len(rules) else _apart(rules)


def _without_groups(pattern: str) -> str:
    """What matches the same and keeps no group's text, with its flags for its own part only."""
    bare = _PARENTHESIS.sub(lambda found: "(?:" if found[0] == "(" else found[0], pattern)
    flags = _FLAGS_IN_FRONT.match(bare)
    return f"(?{flags[1]}:{bare[flags.end() :]})" if flags else bare


def _move(stack: list[str], step: Any) -> None:
    """Change a stack of states as a rule says; the lowest state stays."""
    for one in step if isinstance(step, tuple) else (step,):
        if one == "#push":
            stack.append(stack[-1])
        elif one == "#pop":
            del stack[max(len(stack) - 1, 1) :]
        elif isinstance(one, int):  # how many to leave, negative
            del stack[max(len(stack) + one, 1) :]
        else:
            stack.append(one)
