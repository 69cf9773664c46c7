"""Tells mutants that change nothing from those that nobody saw: draws them with other inputs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from contextlib import suppress

import numpy as np

from shaderlab.drivers.programs.prepare import Programs
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.reads import Named
from shaderlab.engine.lab import Lab
from shaderlab.errors import ShaderlabError, UnsupportedError
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, differ
from shaderlab.mutation.other_inputs import Round, other_inputs
from shaderlab.mutation.subjects import with_what_they_read
from shaderlab.mutation.tasks import Task, part_of, sound_part

ROUNDS = 6
_MOST_KEPT = 48  # rounds, each with the pictures of a scene

_Values = Mapping[tuple[Named, str], Array]
"""What was "drawn" and what the "fragment" and "vertex" stage made of numbers, by output."""


def _outputs(evaluation: Evaluation, given: Round, passes: Collection[str]) -> _Values:
    """What some passes draw, and what the stages of the round's program make of its numbers, as the
    target stores it."""
    session, drawn, key = evaluation.session, evaluation.drawn, given.probed
    found = {(o, "drawn"): image.values for o, image in drawn.images.items() if o[0] in passes}
    if key is None:
        return found
    bindings = drawn.bindings[key]
    with suppress(UnsupportedError):  # stages that can't be run on given inputs
        made = session.probe(key, "fragment", [bindings], given.fragments)[0].outputs
        for name, values in made.items():
            image = drawn.images.get((key[0], name))
            kept = values if image is None else _stored(values, image.format)
            found[(key[0], name), "fragment"] = kept
        if given.vertices:
            made = session.probe(key, "vertex", [bindings], given.vertices)[0].outputs
            found |= {((key[0], name), "vertex"): values for name, values in made.items()}
    return found


def _count(values: _Values) -> int:
    """How many inputs gave these values: pixels, and runs of a stage."""
    runs = {(name, kind): v[..., 0].size for ((name, _), kind), v in values.items()}
    return sum(runs.values())


def _stored(values: Array, format: str) -> Array:
    """What is left of float outputs in an attachment: 8-bit formats clamp, and keep 256 codes."""
    if format.endswith("8") and values.dtype.kind == "f":
        codes = 65535.0 if format.startswith("srgb") else 255.0  # sRGB has finer steps in the dark
        rounded: Array = np.rint(np.nan_to_num(np.clip(values, 0.0, 1.0)) * codes)
        return rounded
    return values.astype(np.float16) if format.endswith("16f") else values


_Known = tuple[Round, set[str], _Values]
"""Other inputs, the passes that are drawn with them, and what the case's own shaders make of it."""


class WiderInputs:
    """Other inputs for the scenes of a case, with what its own shaders make of them.

    Args:
        lab: the open device.
        originals: each scene's evaluation unmutated, by variant.
    """

    def __init__(self, lab: Lab, originals: Mapping[str, Evaluation]) -> None:
        self._lab, self._originals = lab, originals
        self._rounds: dict[tuple[str, frozenset[str], tuple[str, ...], int], _Known | None] = {}

    def difference(
        self, tasks: list[Task], prepare: Callable[[Task, Scene], Programs]
    ) -> tuple[Named | None, int]:
        """An output that a mutant changes, if one is found, and how many inputs were tried.

        `prepare` compiles the draws of a part of a scene, with the mutant's in them.
        """
        tried = 0
        for number in range(ROUNDS if tasks else 0):
            task = tasks[number % len(tasks)]
            known = self._round(task, number)
            if known is None:
                continue
            given, names, expected = known
            part = part_of(task.effect.scene, names, [])
            scene, programs = given.applied(part, prepare(task, part))
            run = self._lab.evaluation(scene, programs, like=self._originals[scene.variant])
            with run as mutant:  # what goes wrong is the mutant's: the part ran unmutated
                got = _outputs(mutant, given, task.effect.passes)
            for (output, kind), values in expected.items():
                if (output, kind) not in got or differ(values, got[output, kind]):
                    return output, tried
            tried += _count(expected)
        return None, tried

    def _round(self, task: Task, number: int) -> _Known | None:
        """Other inputs for what a mutant changes; None where it can't be drawn with them."""
        key = (task.scene.variant, task.effect.passes, task.effect.program, number)
        if key not in self._rounds:
            if len(self._rounds) >= _MOST_KEPT:
                del self._rounds[next(iter(self._rounds))]
            self._rounds[key] = self._new_round(*key)
        return self._rounds[key]

    def _new_round(
        self, variant: str, passes: frozenset[str], program: tuple[str, ...], number: int
    ) -> _Known | None:
        original = self._originals[variant]
        needed = with_what_they_read(original.scene, passes)
        given = other_inputs(original, needed, program, number)
        part = part_of(original.scene, needed, [])
        scene, programs = given.applied(part, {n: original.programs[n] for n in needed})
        names = with_what_they_read(scene, passes)
        programs = {name: programs[name] for name in names}
        with sound_part(part):
            try:
                run = self._lab.evaluation(part_of(scene, names, []), programs, like=original)
                with run as unmutated:
                    return given, names, _outputs(unmutated, given, passes)
            except ShaderlabError:
                return None
