"""What a driver computes inside of a fragment shader, step by step, by drawing the shader again
with outputs added."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shaderlab.analysis.interpreter import Stored
from shaderlab.analysis.interpreter.values import Flags
from shaderlab.drivers.programs.instrument import Watch, instrumented, room
from shaderlab.drivers.programs.textures import for_output
from shaderlab.errors import ShaderlabError, UnsupportedError
from shaderlab.model.frame import Array, PassDraw, differ

from .evaluation import Evaluation
from .interpreting import Invocations
from .watches import Watched, Watches

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

    watched: Watched
    values: Array
    reached: Flags


def driver_values(
    evaluation: Evaluation,
    key: PassDraw,
    given: Invocations,
    stored: Sequence[Stored],
    undecided: Flags,
    suspects: set[tuple[Stored, str]] | None = None,
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
        suspects: values that could not be watched without others being changed in almost the same
            shader: each is drawn alone. Those that are found are added.

    Raises:
        UnsupportedError: the shader has no room for another output, or whatever is watched, the
            driver computes others.
        ShaderlabError: the shader can't be drawn again.
    """
    draw = evaluation.programs[key[0]][key[1]]
    text = draw.text("fragment") or ""
    suspects = set() if suspects is None else suspects
    wanted = list(_wanted(Watches(text, given.program), stored, undecided))
    drawing = _Drawing(evaluation, key, given, text)
    size = room(len(drawing.colors))
    if size < 4:
        raise UnsupportedError("the shader has no room for another output")
    known: dict[Watch, _Values | None] = {}
    alone = {watch for each, watch, _ in wanted if (each.event, each.name) in suspects}
    for i, (watched, watch, rows) in enumerate(wanted):
        if watch not in known:
            left = [w for _, w, _ in wanted[i:] if w not in known and w not in alone]
            batch = [watch] if watch in alone else _batch(left, size)
            known.update(drawing.values(batch))
        values = known[watch]
        if values is not None:
            yield DriverValue(watched, values[0], rows & values[1])
        elif any(known.values()):
            suspects.add((watched.event, watched.name))
        elif len(known) >= _MOST_REFUSED:
            break
    if wanted and not any(known.values()):
        raise UnsupportedError("the driver computes other outputs where the shader writes more")


def _wanted(
    watches: Watches, stored: Sequence[Stored], undecided: Flags
) -> Iterator[tuple[Watched, Watch, Flags]]:
    """What to ask for: a vector, what to write for it, and the invocations that are meant. A struct
    that is handed on whole is told from others by its first member."""
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


class _Drawing:
    """A draw that is made again and again, with values watched."""

    def __init__(
        self, evaluation: Evaluation, key: PassDraw, given: Invocations, text: str
    ) -> None:
        assert given.pixels is not None
        outputs = evaluation.programs[key[0]][key[1]].interface.outputs
        self.colors = {name: for_output(variable.type) for name, variable in outputs.items()}
        self._written = evaluation.session.written
        self._key, self._text = key, text
        self._at = given.pixels[:, 1], given.pixels[:, 0]
        self._plain = self._written(key, text, self.colors)

    def values(self, watches: Sequence[Watch]) -> dict[Watch, _Values | None]:
        """What the driver has at each; None where its outputs are others if that is written. Those
        are told from others by halves."""
        together = self._together(watches)
        if together is not None:
            return dict(zip(watches, together, strict=True))
        if len(watches) == 1:
            return {watches[0]: None}
        half = len(watches) // 2
        return self.values(watches[:half]) | self.values(watches[half:])

    def _together(self, watches: Sequence[Watch]) -> list[_Values] | None:
        try:
            changed, places = instrumented(self._text, watches)
            added = dict.fromkeys((name for one in places for name, _ in one.components), "rgba32f")
            images = self._written(self._key, changed, {**self.colors, **added})
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
