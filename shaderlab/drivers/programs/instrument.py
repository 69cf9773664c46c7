"""Fragment shaders that also write what they compute on the way, to outputs of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from shaderlab.compiler.syntax import Syntax, field

from .stages import MOST_OUTPUTS, PREFIX, after_directives
from .watch_points import WatchPoint

SEEN = PREFIX + "seen"
VALUE = PREFIX + "value"
"""What a `return` gives, and what a condition is, where a `Watch` is written."""
_TURN = PREFIX + "turn"
_CONDITION = PREFIX + "condition"
_VALUES = 3  # in an output, whose last component says which of them were written


@dataclass(frozen=True)
class Watch:
    """A value that is written once it was there `turn` times before.

    Attributes:
        at: the points of the text at which it is known, each with the expression that has it there:
            `VALUE`, or a part of it, for what is returned and for conditions.
        size: its number of components.
        turn: how often any of the points was passed before.
        scalar: what a condition's value is.
    """

    at: tuple[tuple[WatchPoint, str], ...]
    size: int
    turn: int
    scalar: Literal["bool", "int", "uint"] = "bool"


@dataclass(frozen=True)
class Written:
    """Where a value is found: for each component an output, and the component of it."""

    components: tuple[tuple[str, int], ...]


def room(outputs: int) -> int:
    """How many components one drawing can watch beside a shader's own outputs."""
    return _VALUES * (MOST_OUTPUTS - 1 - outputs)


def instrumented(text: str, watched: Sequence[Watch]) -> tuple[str, list[Written]]:
    """The text with values watched, and where each of them is written.

    The outputs are `vec4`s. The last component of each counts which of the first three were
    written: the sum of 1 for the first, 2 for the second and 4 for the third.
    """
    cells = iter((f"{SEEN}{n // _VALUES}", n % _VALUES) for n in range(10_000))
    found = [Written(tuple(next(cells) for _ in range(watch.size))) for watch in watched]
    noted: dict[WatchPoint, str] = {}
    scalars: dict[WatchPoint, str] = {}
    for number, (watch, written) in enumerate(zip(watched, found, strict=True)):
        for point, place in watch.at:
            noted[point] = noted.get(point, "") + _note(number, watch, written, place)
            scalars[point] = watch.scalar
    edits: list[_Edit] = []
    functions = ""
    for number, (point, notes) in enumerate(noted.items()):
        if point.kind == "condition":
            name, scalar = f"{_CONDITION}{number}", scalars[point]
            functions += f"{scalar} {name}({scalar} {VALUE}) {{{notes} return {VALUE}; }}\n"
            edits += _around(point, f"({name}(", "))")
        elif point.kind == "return":
            begin, end = point.start, point.start + len("return")
            edits.append(_Edit(begin, end, f"{{ {point.type} {VALUE} = (", -point.end))
            tail = f");{notes} return {VALUE}; }}"
            edits.append(_Edit(point.value, point.end, tail, -point.start))
        else:
            edits += _around(point, *(("", notes) if point.braced else ("{ ", f"{notes} }}")))
    outputs = list(dict.fromkeys(name for each in found for name, _ in each.components))
    body = field(Syntax(text).functions["main"][0], "body").start_byte + 1
    zeros = "".join(f" {name} = vec4(0.0);" for name in outputs)
    edits.append(_Edit(body, body, zeros, -len(text)))
    made = _edited(text, edits)
    top = after_directives(made)
    declared = "".join(f"out highp vec4 {name};\n" for name in outputs)
    declared += "".join(f"int {_TURN}{number} = 0;\n" for number in range(len(watched)))
    return made[:top] + declared + functions + made[top:], found


def _note(number: int, watch: Watch, written: Written, place: str) -> str:
    """A statement that writes a value at a point."""
    parts = []
    for i, (name, k) in enumerate(written.components):
        part = place if watch.size == 1 else f"{place}[{i}]"
        parts.append(f"{name}.{'xyz'[k]} = float({part}); {name}.w += {1 << k}.0;")
    return f" if ({_TURN}{number}++ == {watch.turn}) {{ {' '.join(parts)} }}"


@dataclass(frozen=True)
class _Edit:
    """A part of a text that is replaced; where several begin at one place, in which order."""

    start: int
    end: int
    text: str
    order: int


def _around(point: WatchPoint, before: str, after: str) -> list[_Edit]:
    """What goes before a point, outer ones first, and what after it, inner ones first."""
    edits = [_Edit(point.start, point.start, before, -point.end)] if before else []
    return [*edits, _Edit(point.end, point.end, after, -(10**9) - point.start)]


def _edited(text: str, edits: Sequence[_Edit]) -> str:
    data, parts, at = text.encode(), [], 0
    for edit in sorted(edits, key=lambda edit: (edit.start, edit.order)):
        parts += [data[at : edit.start], edit.text.encode()]
        at = max(edit.end, at)
    return b"".join([*parts, data[at:]]).decode()
