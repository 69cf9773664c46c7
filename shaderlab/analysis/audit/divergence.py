"""Derivatives, and textures with mipmaps, where some of a quad's pixels are elsewhere.

Source: the OpenGL Shading Language 4.60 (Khronos), 8.9 "Texture Functions" and 8.14.1 "Derivative
Functions": both are undefined within non-uniform control flow.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.model.frame import Array, Texels

from ..equivalence.comparison import example
from ..equivalence.given import Given, cells_of
from ..equivalence.interface import Input
from ..interpreter import Program
from ..interpreter.memory import World
from ..interpreter.program import Instruction
from ..interpreter.running import Run
from .consequences import depending
from .hazard import Hazard
from .watching import Place, run_watched

KIND = "derivative in divergent control flow"
_DERIVATIVES, _SAMPLES = range(207, 216), (87, 89, 91, 93)
_SLOPE = 0.01  # of an input from a pixel to the next, in widths of its values


@dataclass
class _Divergent:
    """A `Watch` that keeps the first pixel of each derivative that not all of its quad take."""

    quads: Array
    found: dict[Place, tuple[int, Instruction, bool]] = field(default_factory=dict)

    def __call__(self, run: Run, at: Instruction, world: World, result: Any) -> Any:
        sampled = at.op in _SAMPLES
        if not sampled and at.op not in _DERIVATIVES:
            return result
        here = world.mask
        if here.all():
            return result
        count = int(self.quads.max()) + 1
        present = np.bincount(self.quads, here, count)
        alive = np.bincount(self.quads, here | ~run.killed, count)
        split = here & ((present < alive)[self.quads])
        if split.any():
            mipmapped = not sampled or _has_mipmaps(run.value(at.operands[0]))
            place = Place(at.id, tuple(run.calls), KIND)
            self.found.setdefault(place, (int(split.argmax()), at, mipmapped))
        return result


def _has_mipmaps(texels: Texels) -> bool:
    return texels.filter[0] != texels.filter[1]


def divergent(
    program: Program, given: Given, inputs: Mapping[str, Input], *, made_up: bool
) -> Iterator[Hazard]:
    """Derivatives in divergent control flow on which an output depends.

    Args:
        program: a fragment stage.
        given: whole quads; those that were made up become smooth, and uniform where they should.
        inputs: what it reads.
        made_up: whether nobody knows which textures have mipmaps: then those are possible ones.
    """
    ops = {one.op for one in program.definitions.values()}
    if program.stage != "fragment" or not ops & {*_DERIVATIVES, *_SAMPLES}:
        return
    if made_up:
        given = _smooth(given, inputs)
    quads = np.unique(cells_of(given.each["gl_FragCoord"]), return_inverse=True)[1].ravel()
    watch = _Divergent(quads)
    run_watched(program, given, watch)
    for place, (row, at, mipmapped) in watch.found.items():
        if not mipmapped and not made_up:
            continue
        quad = np.flatnonzero(quads == quads[row])
        some, own = given.part(quad), int(np.flatnonzero(quad == row)[0])
        outputs = depending(program, some, own, place)
        if not outputs:
            continue
        file, line = program.place(at.line)
        what = "a derivative" if at.op in _DERIVATIVES else "a texture's level of detail"
        words = f"{what} is undefined where other pixels of the quad take another branch"
        yield Hazard(
            file=file, line=line, kind=KIND,
            message=words if mipmapped else f"{words}; only if the texture has mipmaps",
            evident=mipmapped,
            inputs=example(given, row, inputs),
            outputs={name: tuple(map(float, value)) for name, value in outputs.items()},
            calls=tuple(program.place(call)[1] for call in place.calls),
        )  # fmt: skip


def _smooth(given: Given, inputs: Mapping[str, Input]) -> Given:
    """Whole quads whose pixels get the same uniforms, and nearly the same varyings."""
    places = given.each["gl_FragCoord"]
    cells = cells_of(places)
    _, first, of = np.unique(cells, return_index=True, return_inverse=True)
    rng = np.random.default_rng(17)
    offset = (places[:, :2] - places[first][of.ravel(), :2]).astype(np.float64)
    each: dict[str, Array] = {"gl_FragCoord": places}
    for name, values in given.each.items():
        if name == "gl_FragCoord":
            continue
        same = values[first][of.ravel()]
        if name in inputs and not inputs[name].uniform and same.dtype.kind == "f":
            width = float(np.ptp(values)) or 1.0
            slope = rng.normal(size=(2, len(first), *values.shape[1:])) * width * _SLOPE
            slope = slope[:, of.ravel()]
            extra = tuple(range(1, values.ndim))
            moved = sum(np.expand_dims(offset[:, k], extra) * slope[k] for k in (0, 1))
            same = (same + moved).astype(np.float32)
        each[name] = same
    return Given(each, given.bindings, given.count)
