"""What geometry and compute stages alone do: emit vertices, wait for a workgroup."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..memory import World
from ..program import Instruction
from .handler import Handler

if TYPE_CHECKING:
    from ..running import Run


def _emit_vertex(run: Run, at: Instruction, world: World) -> None:
    run.emission.emit(run, at, world)


def _end_primitive(run: Run, at: Instruction, world: World) -> None:
    run.emission.end(world)


def _wait(run: Run, at: Instruction, world: World) -> None:
    """All invocations of a workgroup take each step together."""


STAGES: Mapping[int, Handler] = {
    218: _emit_vertex,
    219: _end_primitive,
    224: _wait,
    225: _wait,
}
