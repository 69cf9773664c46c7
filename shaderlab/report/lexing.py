"""Lexers of Pygments that ask few questions at each place of a text, where Pygments asks dozens.

Pygments tries the rules of a state one by one. Here rules that follow one another are the
alternatives of one regular expression, so that the first that holds is found at once.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
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
# Numbers and names of groups mean others where several rules are one expression.
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
    def pattern(self) -> re.Pattern[str]:
        found: re.Pattern[str] = self.match.__self__  # type: ignore[attr-defined]
        return found

    @property
    def mixes(self) -> bool:
        """Whether it can be one of several alternatives, and is better off so."""
        pattern = self.pattern.pattern
        return len(pattern) <= _LONGEST and not _BY_NAME_OR_NUMBER.search(pattern)


@dataclass(frozen=True, slots=True)
class _Rules:
    """Rules that follow one another in a state, as one expression: the number of the last group
    that matched tells which of them it was. One that is alone has no number."""

    match: Matcher
    numbered: Mapping[int, _Rule]
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
            rule = rules.alone or rules.numbered[match.lastindex or 0]
            if callable(rule.action):
                own = rule.match(text, place)  # its groups have other numbers beside others
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
            runs = [(mixes, list(run)) for mixes, run in groupby(rules, lambda rule: rule.mixes)]
            self._states[name] = [
                merged
                for mixes, run in runs
                for merged in ([_together(run, self._lexer.flags)] if mixes else map(_alone, run))
            ]
        return self._states[name]


def _alone(rule: _Rule) -> _Rules:
    return _Rules(rule.match, {}, rule)


def _together(rules: Sequence[_Rule], flags: int) -> _Rules:
    if len(rules) == 1:
        return _alone(rules[0])
    alternatives, numbered, groups = [], {}, 0
    for rule in rules:
        # An empty group at the rule's end is the last one to match, whichever others it has.
        alternatives.append(f"(?:{_with_own_flags(rule.pattern.pattern)})()")
        groups += rule.pattern.groups + 1
        numbered[groups] = rule
    return _Rules(re.compile("|".join(alternatives), flags).match, numbered)


def _with_own_flags(pattern: str) -> str:
    """Flags that hold for the whole of a pattern as flags for this part of an expression."""
    flags = _FLAGS_IN_FRONT.match(pattern)
    return f"(?{flags[1]}:{pattern[flags.end() :]})" if flags else pattern


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
