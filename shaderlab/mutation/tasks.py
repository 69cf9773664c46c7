"""A mutant's way through one scene: what has to be drawn, who may notice, what was seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from shaderlab.model import Scene
from shaderlab.mutation.subjects import with_what_they_read


@dataclass(frozen=True)
class Task:
    """One scene to try a mutant on.

    Attributes:
        scene, changed: the scene as it is, and with the mistake if that is one of state.
        texts: shaders to be replaced, by name.
        touched: passes that may draw something else.
        about: the expectations that may notice, by their place.
    """

    scene: Scene
    changed: Scene
    texts: Mapping[str, str]
    touched: set[str]
    about: list[int]

    def part(self, everything: bool = False) -> Scene:
        """As much of the changed scene as these expectations need, or `everything` touched."""
        names = {name for i in self.about for name in self.scene.expect[i].passes(self.scene)}
        names |= self.touched if everything else set()
        return part_of(self.changed, with_what_they_read(self.scene, names), self.about)


@dataclass
class Seen:
    """Where an unnoticed mutant shows: in what an expectation reads, or only elsewhere."""

    read: str = ""
    elsewhere: str = ""

    def note(self, where: str, read: bool) -> None:
        """Note a change; the first one of each kind is kept."""
        if read:
            self.read = self.read or where
        else:
            self.elsewhere = self.elsewhere or where


def part_of(scene: Scene, passes: set[str], expect: list[int]) -> Scene:
    """The scene with some of its passes and expectations."""
    return replace(
        scene,
        passes=tuple(p for p in scene.passes if p.name in passes),
        expect=tuple(scene.expect[i] for i in expect),
    )
