"""A mutant's way through one scene: what has to be drawn, and what may notice."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from shaderlab.errors import CaseError, UnsupportedError
from shaderlab.model.case import Scene
from shaderlab.mutation.mutants import Effect
from shaderlab.mutation.subjects import with_what_they_read


class PartError(CaseError):
    """A part of a case that mutants are judged by does not run unmutated."""


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


@contextmanager
def sound_part(part: Scene) -> Iterator[None]:
    """What goes wrong here goes wrong without any mutant."""
    try:
        yield
    except UnsupportedError:
        raise
    except Exception as error:
        raise PartError(
            f"{part.case.id}[{part.variant}]: the passes "
            f"{', '.join(p.name for p in part.passes)} do not run by themselves "
            f"({type(error).__name__}: {error}), so that mutants of them can't be judged",
            file=part.case.file or None,
            remedy="this is a fault of shaderlab, not of the case: please report it",
        ) from error
