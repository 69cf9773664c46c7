"""What a driver computes inside of a fragment shader, step by step, by drawing the shader again
with outputs added.

`Watches` knows where in a shader's text each value that an interpretation stores can be watched;
`driver_values` draws the shader with outputs for them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shaderlab.analysis.instrument import (
    VALUE,
    Watch,
    WatchPoint,
    find_watch_points,
    instrument,
    watch_capacity,
)
from shaderlab.analysis.interpreter import Program, Stored
from shaderlab.analysis.interpreter.program import Instruction, Type
from shaderlab.analysis.interpreter.values import Flags, component
from shaderlab.bands import Band, Integer, TriBool
from shaderlab.compiler.spirv import Op
from shaderlab.drivers.programs.textures import output_format
from shaderlab.engine.evaluation import Evaluation
from shaderlab.errors import ShaderlabError, UnsupportedError
from shaderlab.model.frame import Array, PassDraw, differ

from .invocations import Invocations

_FIRST_TURNS = 4  # of a statement that is passed more often, and the last one
_LOOP_TURNS = 32  # of a loop's condition, likewise
_MOST_REFUSED = 24  # values, where none is believed
_Values = tuple[Array, Flags]


@dataclass(frozen=True, eq=False)
class DriverValue:
    """What a driver has where an interpretation of the same invocations stored a vector.

    Attributes:
        watched: what was stored.
        values: the driver's, (count, components).
        reached: the invocations that they are of: those that were there in both.
    """

    watched: WatchedValue
    values: Array
    reached: Flags


def driver_values(
    evaluation: Evaluation,
    key: PassDraw,
    given: Invocations,
    stored: Sequence[Stored],
    undecided: Flags,
) -> Iterator[DriverValue]:
    """What the driver has for what was stored, in that order; drawn as it is asked for. Of what an
    invocation passes again and again the first turns and the last one.

    Args:
        evaluation: the scene, which is on the device.
        key: the draw.
        given: its invocations.
        stored: what an interpretation of them stored.
        undecided: those of them that took both sides of a branch: what they passed more than once
            is left out, for the driver may have passed it less often.

    Raises:
        UnsupportedError: the shader has no room for another output, or whatever is watched, the
            driver computes others.
        ShaderlabError: the shader can't be drawn again.
    """
    draw = evaluation.programs[key[0]][key[1]]
    text = draw.text("fragment") or ""
    wanted = list(_plan_watches(Watches(text, given.program), stored, undecided))
    redraws = _Redraws(evaluation, key, given, text)
    size = watch_capacity(len(redraws.colors))
    if size < 4:
        raise UnsupportedError("the shader has no room for another output")
    known: dict[Watch, _Values | None] = {}
    for i, (watched, watch, rows) in enumerate(wanted):
        if watch not in known:
            left = [w for _, w, _ in wanted[i:] if w not in known]
            known.update(redraws.values(_batch(left, size)))
        values = known[watch]
        if values is not None:
            yield DriverValue(watched, values[0], rows & values[1])
        elif len(known) >= _MOST_REFUSED and not any(known.values()):
            break
    if wanted and not any(known.values()):
        raise UnsupportedError("the driver computes other outputs where the shader writes more")


def _plan_watches(
    watches: Watches, stored: Sequence[Stored], undecided: Flags
) -> Iterator[tuple[WatchedValue, Watch, Flags]]:
    """What to ask the driver for: a vector, what to write for it, and for which invocations. A
    struct that is passed on whole is recognised by its first member."""
    turns: dict[object, Array] = {}
    before = []
    for event in stored:
        slot = watches.slot(event)
        turn = turns.setdefault(slot, np.zeros(len(undecided), np.int64))
        before.append((slot, turn.copy()))
        turn += event.mask
    known: set[int] = set()
    for event, (slot, turn) in zip(stored, before, strict=True):
        parts = watches.of(event)
        if all(id(part.value) in known for part in parts):
            parts = parts[:1]
        known.update(id(part.value) for part in parts)
        first = _LOOP_TURNS if any(part.is_loop for part in parts) else _FIRST_TURNS
        asked = (turn < first) | (turn == turns[slot] - 1)
        asked &= ~undecided | (turns[slot] == 1)
        for number in np.unique(turn[event.mask & asked]):
            rows = event.mask & asked & (turn == number)
            for watched in parts:
                yield watched, replace(watched.watch, turn=int(number)), rows


def _batch(watches: Sequence[Watch], size: int) -> list[Watch]:
    """As many of the first ones as one drawing has room for."""
    found: dict[Watch, None] = {}
    for watch in watches:
        if watch not in found:
            size -= watch.size
            if size < 0:
                break
            found[watch] = None
    return list(found)


class _Redraws:
    """A draw that is made again and again, with values watched."""

    def __init__(
        self, evaluation: Evaluation, key: PassDraw, given: Invocations, text: str
    ) -> None:
        assert given.pixels is not None
        outputs = evaluation.programs[key[0]][key[1]].interface.outputs
        self.colors = {name: output_format(variable.type) for name, variable in outputs.items()}
        self._redraw = evaluation.session.redraw_with_text
        self._key, self._text = key, text
        self._at = given.pixels[:, 1], given.pixels[:, 0]
        self._plain = self._redraw(key, text, self.colors)

    def values(self, watches: Sequence[Watch]) -> dict[Watch, _Values | None]:
        """What the driver has at each; None where writing it changes the shader's own outputs.
        Those are found by halving."""
        together = self._values_together(watches)
        if together is not None:
            return dict(zip(watches, together, strict=True))
        if len(watches) == 1:
            return {watches[0]: None}
        half = len(watches) // 2
        return self.values(watches[:half]) | self.values(watches[half:])

    def _values_together(self, watches: Sequence[Watch]) -> list[_Values] | None:
        try:
            changed, places = instrument(self._text, watches)
            added = dict.fromkeys((name for one in places for name, _ in one.components), "rgba32f")
            images = self._redraw(self._key, changed, {**self.colors, **added})
        except (ShaderlabError, KeyError, AssertionError):  # or the text can't be changed
            return None
        if any(differ(images[name], self._plain[name]) for name in self.colors):
            return None
        found = []
        for one in places:
            pixels = [(images[name][self._at], k) for name, k in one.components]
            values = np.stack([image[:, k] for image, k in pixels], axis=-1)
            image, k = pixels[0]
            found.append((values, (image[:, 3].astype(np.int64) >> k & 1).astype(np.bool_)))
        return found


_MOST_PARTS = 16  # of a struct or a matrix
_XYZW = {letter: i for letters in ("xyzw", "rgba", "stpq") for i, letter in enumerate(letters)}
_At = tuple[tuple[WatchPoint, str], ...]


@dataclass(frozen=True, eq=False)
class WatchedValue:
    """A vector of what was stored, and what to ask a driver for it.

    Attributes:
        event: what was stored.
        name: the event's name, and the way to this part of it.
        value: a band, an `Integer` or a `TriBool`, (count or 1, components).
        watch: what to write, but for the turn.
    """

    event: Stored
    name: str
    value: Any
    watch: Watch

    @property
    def is_loop(self) -> bool:
        """Whether it is what a loop goes on by."""
        return self.watch.at[0][0].name == "loop" and self.event.is_flow

    def allows(self, values: Array) -> Flags:
        """Which of some float32 values (count, components) it may be, by invocation."""
        value = self.value
        if isinstance(value, Band):
            inside: Any = value.contains(values)
        elif isinstance(value, Integer):
            low, high = (bound.astype(np.float32) for bound in (value.lo, value.hi))
            give = 2.0**-23 * np.maximum(np.abs(low), np.abs(high))  # they are drawn as floats
            give = np.where(give < 2.0, 0.0, give)
            inside = ((values >= low - give) & (values <= high + give)) | value.anything
        else:
            inside = np.where(values != 0.0, ~value.all_false, ~value.all_true)
        found: Flags = np.all(inside, axis=-1)
        return found


class Watches:
    """The points of a text at which what a program stores can be watched. The text may be another
    than the program's, with the same lines."""

    def __init__(self, text: str, program: Program) -> None:
        self._program = program
        self._points: dict[str, list[WatchPoint]] = defaultdict(list)
        for point in find_watch_points(text):
            self._points[point.kind].append(point)
        self._branches = dict(_branches(program, self._points["condition"]))
        self._found: dict[object, _At] = {}

    def of(self, event: Stored) -> list[WatchedValue]:
        """An event's vectors; none where the text has no place for it."""
        slot = self.slot(event)
        if slot not in self._found:
            self._found[slot] = tuple(self._at(event))
        at = self._found[slot]
        if not at:
            return []
        parts = list(_parts(event.value, event.type))
        if len(parts) > _MOST_PARTS:
            return []
        return [
            WatchedValue(
                event,
                event.name + way,
                value,
                Watch(
                    tuple((point, place + way) for point, place in at),
                    value.shape[-1],
                    0,
                    _scalar(value),
                ),
            )
            for way, value in parts
        ]

    def slot(self, event: Stored) -> object:
        """What all events have in common that a driver passes the same points for."""
        if event.at.op == Op.FunctionCall:
            return event.at.operands[0], event.name
        return (event.at if event.is_flow else event.line), event.name

    def _at(self, event: Stored) -> Iterator[tuple[WatchPoint, str]]:
        """The points of an event's slot, and what stands for the value there."""
        name = event.name
        if event.is_flow and event.at.op != Op.FunctionCall:
            point = self._branches.get(event.at)
            if point is not None:
                yield point, VALUE
        elif event.at.op == Op.ReturnValue:
            for point in self._points["return"]:
                if point.name == name and point.first <= event.line <= point.last:
                    yield point, VALUE
        elif event.at.op == Op.FunctionCall:
            function, _, parameter = name[:-1].partition("(")
            found = [p for p in self._points["entry"] if p.name == function]
            if len(found) > 1:  # overloads
                called = self._program.functions[event.at.operands[0]]
                names = [self._program.name(id_) for id_ in called.parameters]
                found = [p for p in found if _declares(p.place, names)]
            if len(found) == 1:
                yield found[0], parameter
        else:
            root = name.partition(".")[0].partition("[")[0]
            for point in self._points["store"]:
                if point.name == root and point.first <= event.line <= point.last:
                    if "?" not in name and _covers(point.place, name):
                        yield point, name
                    elif "?" in name and not {"(", "+", "-"} & set(point.place):
                        yield point, point.place


def _declares(parameters: str, names: Sequence[str]) -> bool:
    """Whether a list of parameters, as it is written, is of these names."""
    declared = [one.partition("[")[0].split() for one in parameters.strip("()").split(",")]
    return [words[-1] for words in declared if words] == list(names)


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


def _parts(value: Any, type_: Type, way: str = "") -> Iterator[tuple[str, Any]]:
    """The vectors and scalars of a value, each with the way to it."""
    if type_.kind in ("vector", "float", "int", "bool"):
        if isinstance(value, Band | Integer | TriBool) and value.ndim == 2:
            yield way, value
    elif type_.kind in ("matrix", "array", "struct"):
        count = len(type_.members) if type_.kind == "struct" else type_.count
        for i in range(min(count, _MOST_PARTS + 1)):
            yield from _parts(component(value, i), type_.part(i), way + type_.step(i))


def _scalar(value: Any) -> Any:
    if isinstance(value, Integer):
        return "uint" if value.unsigned else "int"
    return "bool"


def _branches(
    program: Program, conditions: Sequence[WatchPoint]
) -> Iterator[tuple[Instruction, WatchPoint]]:
    """The condition in a text that each branch goes by, of lines where that is plain: as many
    branches as conditions."""
    lines: Mapping[WatchPoint, list[Instruction]] = {point: [] for point in conditions}
    for function in program.functions.values():
        for block in function.blocks.values():
            for before, at in zip([None, *block], block, strict=False):
                decides = at.op in (Op.BranchConditional, Op.Switch) and not _is_logic(
                    function.blocks, before
                )
                if decides or at.op == Op.Select:
                    for point in conditions:
                        if point.first <= at.line <= point.last:
                            lines[point].append(at)
    for point, found in lines.items():
        rivals = [p for p, others in lines.items() if set(others) & set(found)]
        if found and len(found) == len(rivals):
            at = found[rivals.index(point)]
            if at.op != Op.Select:
                yield at, point


def _is_logic(blocks: Mapping[int, list[Instruction]], merge: Instruction | None) -> bool:
    """Whether what branches is `&&` or `||`: where both sides meet, a value is chosen."""
    return (
        merge is not None
        and merge.op == Op.SelectionMerge
        and blocks[merge.operands[0]][0].op == Op.Phi
    )
