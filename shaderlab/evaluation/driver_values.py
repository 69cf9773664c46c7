"""What a driver computes inside of a fragment shader: the value of each statement, by drawing the
shader again with outputs added."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shaderlab.bands import Band
from shaderlab.errors import ShaderlabError, UnsupportedError
from shaderlab.evaluation.evaluation import Evaluation
from shaderlab.evaluation.interpreting import Invocations
from shaderlab.frame import Array, PassDraw
from shaderlab.interpreter import Stored
from shaderlab.programs.formats import for_output
from shaderlab.programs.instrument import Statement, instrumented, room, statements

_Wanted = tuple["Slot", Statement, str, int]
Slot = tuple[int, str]
"""A line of the program's text and the name that it stores to, as `Stored` has them."""


@dataclass(frozen=True, kw_only=True)
class DriverValues:
    """What was stored last at each statement: (count, components), and where it was reached.

    `refused` says why there is nothing: the driver computes something else where it has to write
    more, or the text can't be changed.
    """

    values: Mapping[Slot, tuple[Array, Array]]
    refused: str = ""


def driver_values(
    evaluation: Evaluation, key: PassDraw, given: Invocations, stored: Sequence[Stored]
) -> DriverValues:
    """What the driver stores where an interpretation of the same invocations stored floats."""
    assert given.pixels is not None
    text = evaluation.programs[key[0]][key[1]].text("fragment") or ""
    at = given.pixels[:, 1], given.pixels[:, 0]
    try:
        wanted = list(_wanted(text, stored))
        return DriverValues(values=_drawn(evaluation, key, text, wanted, at))
    except (ShaderlabError, KeyError, AssertionError) as error:
        return DriverValues(values={}, refused=str(error).splitlines()[0])


def _wanted(text: str, stored: Sequence[Stored]) -> Iterator[_Wanted]:
    """The statements behind stored values, each once: what is stored to, and its components."""
    known = statements(text)
    seen: set[Slot] = set()
    for event in stored:
        slot = event.line, event.name
        if slot in seen or not isinstance(event.value, Band) or event.value.ndim != 2:
            continue
        seen.add(slot)
        root = event.name.partition(".")[0].partition("[")[0]
        for statement in known:
            if statement.name == root and statement.first <= event.line <= statement.last:
                place = statement.place if "?" in event.name or not statement.place else event.name
                yield slot, statement, place, event.value.shape[-1]
                break


def _drawn(
    evaluation: Evaluation,
    key: PassDraw,
    text: str,
    wanted: Sequence[_Wanted],
    at: tuple[Array, Array],
) -> dict[Slot, tuple[Array, Array]]:
    """The values, a few statements a drawing; one alone where together they change an output.

    Raises:
        UnsupportedError: whatever is watched, the outputs are others.
    """
    outputs = evaluation.programs[key[0]][key[1]].interface.outputs
    colors = {name: for_output(variable.type) for name, variable in outputs.items()}
    written = evaluation.session.written
    plain = written(key, text, colors)

    def seen(group: Sequence[_Wanted]) -> dict[Slot, tuple[Array, Array]] | None:
        """What the driver stores at some statements; None where its outputs are others then."""
        changed, added = instrumented(text, [(s, place, size) for _, s, place, size in group])
        images = written(key, changed, {**colors, **dict.fromkeys(added, "rgba32f")})
        if any(not np.array_equal(_bits(images[name]), _bits(plain[name])) for name in colors):
            return None
        found = {}
        for name, number in added.items():
            slot, _, _, size = group[number]
            values = images[name][at]
            reached = values[:, 3] == 1.0 if size < 4 else np.ones(len(values), np.bool_)
            found[slot] = values[:, :size], reached
        return found

    step = room(len(colors))
    if step < 1:
        raise UnsupportedError("the shader has no room for another output")
    found: dict[Slot, tuple[Array, Array]] = {}
    for start in range(0, len(wanted), step):
        group = wanted[start : start + step]
        together = seen(group)
        parts = [together] if together is not None else [seen([one]) for one in group]
        for part in parts:
            found.update(part or {})
    if wanted and not found:
        raise UnsupportedError("the driver computes other outputs where the shader writes more")
    return found


def _bits(values: Array) -> Array:
    return np.ascontiguousarray(values).view(np.uint32)
