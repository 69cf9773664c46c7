"""What a driver does at some pixels of an output, and whether its own inputs allow that."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from shaderlab.errors import ShaderlabError
from shaderlab.model.frame import Array, Fragments, PassDraw
from shaderlab.model.observations import Fault, Look, Observation
from shaderlab.model.textures import outputs_read

from . import raster_faults, stage_faults
from .evaluation import Evaluation
from .expectations.needs import CapturedFragments, CapturedVertices
from .rasterised import covered

_DRAWS = 32  # of a pass, whose vertices are looked at
_WORK = 8_000_000  # pixels times draws of a scene: a second or two on a slow driver


def observe(evaluation: Evaluation, looks: Sequence[Look]) -> tuple[Observation, ...]:
    """Look at outputs of a scene that was drawn. What can't be looked at is named, no error; large
    passes of many draws are not, once `_WORK` is done."""
    images = evaluation.drawn.images
    budget = Budget(_WORK)
    found = {}
    for look in sorted(looks, key=lambda look: images[_key(look)].values.size):
        found[look.output] = _Observer(evaluation, look, budget).observation()
    return tuple(found[look.output] for look in looks)


class Budget:
    """How many pixels may still be drawn."""

    def __init__(self, left: int) -> None:
        self._left = left

    def take(self, cost: int) -> bool:
        """Whether so many may be drawn; then they are."""
        if cost > self._left:
            return False
        self._left -= cost
        return True


def _key(look: Look) -> tuple[str, str]:
    pass_name, _, output = look.output.rpartition(".")
    return pass_name, output


class _Observer:
    def __init__(self, evaluation: Evaluation, look: Look, budget: Budget) -> None:
        self._budget = budget
        self._evaluation = evaluation
        self._look = look
        self._pass, self._output = _key(look)
        self._pixels = np.array(look.pixels)
        self._refused: list[str] = []
        self._vertices: dict[str, str] = {}
        self._nobody = np.zeros(len(look.pixels), np.bool_)
        self._edges = np.zeros(len(look.pixels), np.bool_)
        self._size = evaluation.drawn.images[self._pass, self._output].values.shape[1::-1]
        self._target = evaluation.scene.find_pass(self._pass).target

    def observation(self) -> Observation:
        draws = self._evaluation.programs[self._pass]
        seen = np.full(len(self._pixels), -1)
        inputs: list[Mapping[str, tuple[float, ...]]] = [{} for _ in self._look.pixels]
        captures: dict[int, Fragments] = {}
        unknown = np.ones(len(self._pixels), np.bool_)
        for index in reversed(range(len(draws))):
            if not unknown.any():
                break
            captured = self._captured(index)
            if captured is None:
                continue
            captures[index] = captured
            for row, at in self._where(captured):
                seen[row], inputs[row] = index, _inputs(captured, at)
            place = captured.frag_coord[self._pixels[:, 1], self._pixels[:, 0], 3]
            self._nobody |= place == 0.0
            unknown &= place < 0.0  # there another draw is seen
        fault = next(self._faults(captures, seen), None)
        return Observation(
            output=self._look.output,
            seen=tuple(map(int, seen)),
            inputs=tuple(inputs),
            at_edge=tuple(map(bool, self._edges)),
            vertices=self._vertices,
            reads=tuple(dict.fromkeys(
                read.path for draw in draws for texture in draw.draw.textures.values()
                for read in outputs_read(texture)
            )),
            samples_textures=any(draw.draw.textures for draw in draws),
            after=self._after(),
            fault=fault,
            refused=tuple(dict.fromkeys(self._refused)),
        )  # fmt: skip

    def _captured(self, index: int) -> Fragments | None:
        """What a draw's fragments got; None where that can't be told."""
        need = CapturedFragments((self._pass, index))
        known = need in self._evaluation.answers
        cost = self._size[0] * self._size[1] * len(self._evaluation.programs[self._pass])
        if not known and not self._budget.take(cost):
            self._refused.append("the pass is too large, or has too many draws")
            return None
        try:
            found: Fragments = self._evaluation.answer(need)
        except ShaderlabError as error:
            self._refused.append(error.message)
            return None
        return found

    def _where(self, captured: Fragments) -> Iterator[tuple[int, tuple[int, int]]]:
        """The pixels at which a draw is seen: their number, and (row, column)."""
        for row, (x, y) in enumerate(self._look.pixels):
            if captured.covered[y, x]:
                yield row, (y, x)

    def _after(self) -> str:
        if self._target.samples:
            return "resolving samples"
        states = [draw.draw.state for draw in self._evaluation.programs[self._pass]]
        return "blending" if any(state.blend for state in states) else ""

    def _faults(self, captures: Mapping[int, Fragments], seen: Array) -> Iterator[Fault]:
        """What no inputs of a stage's own allow, the earliest stage first."""
        count = len(self._evaluation.programs[self._pass])
        for index in sorted({*captures, *range(min(count, _DRAWS))}):
            yield from self._of_vertices((self._pass, index), captures.get(index))
        for index in sorted(captures):
            yield from self._of_fragments((self._pass, index), seen == index)
        yield from stage_faults.of_clearing(
            self._evaluation, self._pass, self._output, captures.values(), self._look.pixels
        )

    def _of_vertices(self, key: PassDraw, captured: Fragments | None) -> Iterator[Fault]:
        draw = self._evaluation.programs[key[0]][key[1]]
        if draw.draw.mesh is None:
            return
        try:
            samples = self._evaluation.answer(CapturedVertices(key))
        except ShaderlabError as error:
            self._refused.append(error.message)
            return
        found = hashlib.blake2s()
        for values in samples.outputs.values():
            found.update(np.ascontiguousarray(values).data)
        self._vertices[str(key[1])] = found.hexdigest()
        if draw.last_stage != "vertex":
            return
        try:
            yield from stage_faults.of_vertices(self._evaluation, key)
        except ShaderlabError as error:
            self._refused.append(error.message)
        if self._target.samples:
            return
        pixels = self._look.pixels
        if draw.draw.mesh.primitive == "points" and captured is not None:
            yield from raster_faults.of_points(draw, samples, captured, pixels, self._size)
        what = covered(
            draw.draw.mesh, draw.draw.instances, samples, draw.draw.state, self._size, self._pixels
        )
        if what is None:
            return
        self._edges |= what.possible & ~what.inside
        yield from raster_faults.of_coverage(draw, key[1], captured, what, pixels, self._nobody)
        if captured is not None:
            yield from raster_faults.of_interpolation(draw, samples, captured, what, pixels)

    def _of_fragments(self, key: PassDraw, here: Array) -> Iterator[Fault]:
        if not here.any() or self._target.samples:
            return
        try:
            yield from stage_faults.of_fragments(
                self._evaluation, key, self._output, self._pixels[here], self._refused
            )
        except ShaderlabError as error:
            self._refused.append(error.message)


def _inputs(captured: Fragments, at: tuple[int, int]) -> Mapping[str, tuple[float, ...]]:
    found = {name: values[at] for name, values in captured.inputs.items()}
    found["gl_FragCoord"] = captured.frag_coord[at]
    return {name: tuple(map(float, np.ravel(value))) for name, value in found.items()}
