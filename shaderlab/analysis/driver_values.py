"""What a driver computes inside of a fragment shader, statement by statement: the shader is drawn
again, with further outputs that hold what its statements store."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from tree_sitter import Node

from shaderlab.bands import Band, Integer, TriBool
from shaderlab.compiler.spirv import Op
from shaderlab.compiler.syntax import Syntax, field, name_of, walk
from shaderlab.drivers.programs.stages import MOST_OUTPUTS, PREFIX, end_of_directives
from shaderlab.drivers.programs.textures import output_format
from shaderlab.engine.evaluation import Evaluation
from shaderlab.errors import ShaderlabError, UnsupportedError
from shaderlab.model.frame import Array, PassDraw, differ

from .interpreter import Stored

_FIRST_TURNS = 4  # of a statement that is passed more often, and the last one
_MOST_REFUSED = 24  # values, where none is believed
_SEEN, _VALUE, _TURN = PREFIX + "seen", PREFIX + "value", PREFIX + "turn"
_VALUES = 3  # in an output, whose last component says which of them were written
_XYZW = {letter: i for letters in ("xyzw", "rgba", "stpq") for i, letter in enumerate(letters)}


@dataclass(frozen=True)
class Statement:
    """A statement that stores or returns a value, or the entry of a function: its lines, counted
    from 1, the name of the variable that is stored to, "f()" for a `return` of f, the function of
    an entry, what is stored to, as it is written ("light.position.y"), and its bytes in the text;
    of a `return`, where those of its expression end, and its function's type."""

    kind: Literal["store", "return", "entry"]
    first: int
    last: int
    name: str
    place: str
    start: int
    end: int
    value: int = 0
    type: str = ""
    braced: bool = True


@dataclass(frozen=True)
class _Watch:
    """A value that is written when any of some statements is passed after `turn` passes before;
    each statement has the expression that holds the value there."""

    at: tuple[tuple[Statement, str], ...]
    size: int
    turn: int


def driver_values(
    evaluation: Evaluation,
    key: PassDraw,
    pixel: tuple[int, int],
    stored: Sequence[Stored],
    *,
    undecided: bool,
) -> dict[Stored, Array]:
    """What the driver has at a pixel for the numbers and vectors that were stored there, where that
    can be seen; of what is passed again and again the first turns and the last one. `stored` is
    what an interpretation of the pixel's invocation stored, in order. If it took both sides of a
    branch (`undecided`), what it passed more than once is left out: the driver may have passed it
    less often. Raises UnsupportedError: the shader has no room for another output, or whatever is
    watched, the driver computes others; ShaderlabError: it can't be drawn again."""
    text = evaluation.programs[key[0]][key[1]].text("fragment") or ""
    statements = find_statements(text)
    wanted = _plan_watches(statements, stored, undecided)
    redraws = _Redraws(evaluation, key, pixel, text)
    size = _VALUES * (MOST_OUTPUTS - 1 - len(redraws.colors))
    if size < 4:
        raise UnsupportedError("the shader has no room for another output")
    known: dict[_Watch, Array] = {}
    left = list(dict.fromkeys(wanted.values()))
    refused = 0
    while left and (known or refused < _MOST_REFUSED):
        ends = itertools.accumulate(watch.size for watch in left)
        some = [watch for watch, end in zip(left, ends, strict=True) if end <= size]
        known |= redraws.values(some)
        left, refused = left[len(some) :], refused + len(some)
    if wanted and not known:
        raise UnsupportedError("the driver computes other outputs where the shader writes more")
    return {event: known[watch] for event, watch in wanted.items() if watch in known}


def _plan_watches(
    statements: Sequence[Statement], stored: Sequence[Stored], undecided: bool
) -> dict[Stored, _Watch]:
    """What to watch for each event that a statement of the text stands for."""
    # All calls of a function pass its entry, and an event's line its statements there.
    slots = [(0 if event.is_argument else event.line, event.name) for event in stored]
    total = Counter(slots)
    passed: Counter[tuple[int, str]] = Counter()
    found = {}
    for event, slot in zip(stored, slots, strict=True):
        turn = passed[slot]
        passed[slot] += 1
        is_shown = turn < _FIRST_TURNS or turn == total[slot] - 1
        if not is_shown or (undecided and total[slot] > 1):
            continue
        at = tuple(_find_statements_of(event, statements))
        if at and isinstance(event.value, Band | Integer | TriBool) and event.value.ndim == 2:
            found[event] = _Watch(at, event.value.shape[-1], turn)
    return found


def _find_statements_of(
    event: Stored, statements: Sequence[Statement]
) -> Iterator[tuple[Statement, str]]:
    """The statements that an event may be of, and what stands for the value there."""
    name = event.name
    if event.is_argument:
        function, _, parameter = name[:-1].partition("(")
        entries = [one for one in statements if (one.kind, one.name) == ("entry", function)]
        if len(entries) == 1:  # not overloaded
            yield entries[0], parameter
        return
    kind = "return" if event.at.op == Op.ReturnValue else "store"
    root = name if kind == "return" else name.partition(".")[0].partition("[")[0]
    for one in statements:
        if (one.kind, one.name) != (kind, root) or not one.first <= event.line <= one.last:
            continue
        if kind == "return":
            yield one, _VALUE
        elif "?" not in name and _covers(one.place, name):
            yield one, name
        elif "?" in name and not {"(", "+", "-"} & set(one.place):
            yield one, one.place


def _covers(place: str, name: str) -> bool:
    """Whether storing to a place, as it is written, stores to what the interpreter calls `name`.

    >>> _covers("color.rgb", "color.y"), _covers("color.rg", "color.z"), _covers("a[0]", "a[0]")
    (True, False, True)
    """
    place = "".join(place.split())
    if place == name:
        return True
    root, dot, parts = place.rpartition(".")
    of, _, part = name.rpartition(".")
    if dot and parts and all(letter in _XYZW for letter in parts):
        return of == root and part in {"xyzw"[_XYZW[letter]] for letter in parts}
    return "[" in place and place.partition("[")[0] == name.partition("[")[0]


class _Redraws:
    """A draw that is made again and again, with values watched."""

    def __init__(
        self, evaluation: Evaluation, key: PassDraw, pixel: tuple[int, int], text: str
    ) -> None:
        outputs = evaluation.programs[key[0]][key[1]].interface.outputs
        self.colors = {name: output_format(variable.type) for name, variable in outputs.items()}
        self._redraw = evaluation.session.redraw_with_text
        self._key, self._pixel, self._text = key, pixel, text
        self._plain = self._redraw(key, text, self.colors)

    def values(self, watches: Sequence[_Watch]) -> dict[_Watch, Array]:
        """What the driver has at each, where that can be written without changing the shader's
        own outputs: compilers rearrange what they need not store. Those are found by halving."""
        together = self._values_together(watches)
        if together is not None or len(watches) == 1:
            return together or {}
        half = len(watches) // 2
        return self.values(watches[:half]) | self.values(watches[half:])

    def _values_together(self, watches: Sequence[_Watch]) -> dict[_Watch, Array] | None:
        try:
            changed, places = _instrument(self._text, watches)
            added = dict.fromkeys((name for one in places for name, _ in one), "rgba32f")
            images = self._redraw(self._key, changed, {**self.colors, **added})
        except (ShaderlabError, KeyError, AssertionError):  # or the text can't be changed
            return None
        if any(differ(images[name], self._plain[name]) for name in self.colors):
            return None
        found = {}
        x, y = self._pixel
        for watch, cells in zip(watches, places, strict=True):
            name, k = cells[0]
            if int(images[name][y, x, 3]) >> k & 1:  # the driver passed there
                found[watch] = np.array([images[name][y, x, k] for name, k in cells])
        return found


def find_statements(text: str) -> list[Statement]:
    """The entries of a text's functions, each with its statements that store or return a value, in
    their order."""
    file = Syntax(text)
    found = []
    for name, functions in file.functions.items():
        for function in functions:
            returned, body = file.of(field(function, "type")), field(function, "body")
            inside = (_statements_at(file, node, name, returned) for node in walk(body))
            start, lines = (
                body.start_byte + 1,
                (function.start_point[0] + 1, function.end_point[0] + 1),
            )
            found.append(Statement("entry", *lines, name, "", start, start))
            found += sorted(itertools.chain(*inside), key=lambda one: one.end)
    return found


def _statements_at(file: Syntax, node: Node, function: str, returned: str) -> Iterator[Statement]:
    parent = node.parent
    if parent is None or (parent.type == "for_statement" and node != field(parent, "body")):
        return
    lines = (node.start_point[0] + 1, node.end_point[0] + 1)
    place = (node.start_byte, node.end_byte)
    braced = parent.type in ("compound_statement", "case_statement")
    if node.type == "return_statement" and node.named_children:
        end = node.named_children[0].end_byte
        yield Statement("return", *lines, f"{function}()", "", *place, end, returned, braced)
    elif node.type == "declaration":
        for declared in node.children_by_field_name("declarator"):
            if declared.type == "init_declarator":
                name = file.of(name_of(declared))
                yield Statement("store", *lines, name, name, *place, braced=braced)
    elif node.type == "expression_statement" and node.named_children:
        changed = node.named_children[0]
        if changed.type in ("assignment_expression", "update_expression"):
            side = "left" if changed.type == "assignment_expression" else "argument"
            left = file.of(field(changed, side))
            root = re.match(r"\w+", left)
            if root is not None:
                yield Statement("store", *lines, root.group(), left, *place, braced=braced)


_Cells = tuple[tuple[str, int], ...]
"""For each component of a value, the output that it is written to, and the component of that."""


def _instrument(text: str, watched: Sequence[_Watch]) -> tuple[str, list[_Cells]]:
    """The text with values watched, and where each of them is written.

    The outputs are `vec4`s. The last component of each counts which of the first three were
    written: the sum of 1 for the first, 2 for the second and 4 for the third."""
    free = ((f"{_SEEN}{n // _VALUES}", n % _VALUES) for n in itertools.count())
    found = [tuple(itertools.islice(free, watch.size)) for watch in watched]
    notes: dict[Statement, str] = {}
    for number, (watch, cells) in enumerate(zip(watched, found, strict=True)):
        for statement, place in watch.at:
            note = _write_note(number, watch, cells, place)
            notes[statement] = notes.get(statement, "") + note
    outputs = list(dict.fromkeys(name for cells in found for name, _ in cells))
    body = field(Syntax(text).functions["main"][0], "body").start_byte + 1
    edits = [(body, body, "".join(f" {name} = vec4(0.0);" for name in outputs))]
    for one, note in notes.items():
        if one.kind == "return":
            edits.append((one.start, one.start + len("return"), f"{{ {one.type} {_VALUE} = ("))
            edits.append((one.value, one.end, f");{note} return {_VALUE}; }}"))
        elif one.braced:
            edits.append((one.end, one.end, note))
        else:
            edits += [(one.start, one.start, "{ "), (one.end, one.end, f"{note} }}")]
    made = _apply_edits(text, edits)
    top = end_of_directives(made)
    declared = "".join(f"out highp vec4 {name};\n" for name in outputs)
    declared += "".join(f"int {_TURN}{number} = 0;\n" for number in range(len(watched)))
    return made[:top] + declared + made[top:], found


def _write_note(number: int, watch: _Watch, cells: _Cells, place: str) -> str:
    parts = []
    for i, (name, k) in enumerate(cells):
        part = place if watch.size == 1 else f"{place}[{i}]"
        parts.append(f"{name}.{'xyz'[k]} = float({part}); {name}.w += {1 << k}.0;")
    return f" if ({_TURN}{number}++ == {watch.turn}) {{ {' '.join(parts)} }}"


def _apply_edits(text: str, edits: Sequence[tuple[int, int, str]]) -> str:
    """Replace the bytes from one place to another; what is inserted at one place stays in order."""
    data, parts, at = text.encode(), [], 0
    for start, end, new in sorted(edits, key=lambda edit: edit[:2]):
        parts += [data[at:start], new.encode()]
        at = end
    return b"".join([*parts, data[at:]]).decode()
