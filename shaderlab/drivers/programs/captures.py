"""A cache of captured fragments.

Over a domain the vertex stage is the lab's own, and what it feeds a fragment shader depends on few
things: many small programs of one folder get the same inputs at the same pixels. Those are captured
once and kept, as long as there is room, for the next draw that must get the same.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import replace

from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, Fragments, PassDraw
from shaderlab.model.state import State

from . import stages
from .prepare import Programs

ROOM = 8 << 20
"""Capacity of the cache, in bytes of arrays."""


class CaptureCache:
    """Captured fragments by what they depend on, the most recent in `room` bytes."""

    def __init__(self, room: int = ROOM) -> None:
        self._room = room
        self._kept: dict[Hashable, Fragments] = {}

    def get(self, identity: Hashable | None, capture: Callable[[], Fragments]) -> Fragments:
        """What was captured under the same `identity`, or else what `capture` gives now.

        The arrays of what is kept can't be written to. With None for an identity nothing is kept.
        """
        if identity is None:
            return capture()
        found = self._kept.pop(identity, None)
        if found is None:
            found = capture()
            for array in _arrays(found):
                array.flags.writeable = False
            self._make_room(_size(found))
        if _size(found) <= self._room:
            self._kept[identity] = found  # the last one used is the last one to go
        return found

    def clear(self) -> None:
        """Let go of all that is kept."""
        self._kept.clear()

    def _make_room(self, wanted: int) -> None:
        """Evict the least recently used entries; none for one that never fits."""
        taken = sum(map(_size, self._kept.values()))
        while wanted <= self._room < taken + wanted:
            taken -= _size(self._kept.pop(next(iter(self._kept))))


def identity(
    scene: Scene, programs: Programs, key: PassDraw, size: tuple[int, int]
) -> Hashable | None:
    """All that a draw's fragments depend on, or None where that is not known.

    It is known for the only draw of a pass, over a domain and without a test of depth or
    stencil, whose shader takes every fragment as it comes. A shader whose outputs leave no
    room for captured inputs is not cached: capturing them may be unsupported.
    """
    description = scene.find_pass(key[0])
    draws = programs[key[0]]
    draw = draws[key[1]]
    fragment, state = draw.text("fragment") or "", draw.draw.state
    if description.onto or len(draws) > 1 or draw.draw.domain is None:
        return None
    if state.depth or state.stencil or state.alpha_to_coverage:
        return None
    if stages.crowded(draw.interface.outputs):
        return None
    if stages.may_keep_out(fragment) or stages.changes_inputs(fragment):
        return None
    varyings = draw.interface.varyings
    return (
        draw.text("vertex"),
        tuple(stages.input_pieces(fragment, varyings.values())),
        tuple((name, values.dtype.str, values.tobytes()) for name, values in draw.ramps.items()),
        replace(state, blend=None, srgb=False, color_mask=State().color_mask),
        draw.draw.instances,
        draw.draw.vertex_array,
        description.target.size or size,
    )


def _arrays(captured: Fragments) -> tuple[Array, ...]:
    return (captured.covered, captured.frag_coord, *captured.inputs.values())


def _size(captured: Fragments) -> int:
    return sum(array.nbytes for array in _arrays(captured))
