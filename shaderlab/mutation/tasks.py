"""A mutant's way through one scene: what has to be drawn, and who may notice."""

from __future__ import annotations

from dataclasses import dataclass, replace

from shaderlab.model import Scene
from shaderlab.mutation.mutants import Effect
from shaderlab.mutation.subjects import with_what_they_read


@dataclass(frozen=True)
class Task:
    """One scene to try a mutant on.

    Attributes:
        scene: the scene as it is.
        effect: what the mutant changes in it.
        touched: passes that may draw something else.
        about: the expectations that may notice, by their place.
    """

    scene: Scene
    effect: Effect
    touched: set[str]
    about: list[int]

    def part(self, everything: bool = False) -> Scene:
        """As much of the changed scene as these expectations need, or `everything` touched."""
        names = {name for i in self.about for name in self.scene.expect[i].passes(self.scene)}
        names |= self.touched if everything else set()
        return part_of(self.effect.scene, with_what_they_read(self.scene, names), self.about)

    @property
    def unmutated(self) -> Task:
        """The same part of the scene as it is."""
        return replace(self, effect=Effect(self.scene, self.effect.passes))


def part_of(scene: Scene, passes: set[str], expect: list[int]) -> Scene:
    """The scene with some of its passes and expectations."""
    return replace(
        scene,
        passes=tuple(p for p in scene.passes if p.name in passes),
        expect=tuple(scene.expect[i] for i in expect),
    )
