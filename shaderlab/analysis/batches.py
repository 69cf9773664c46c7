"""Batches of invocations: captured from a scene's draws or generated, joined, run, shown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from shaderlab.bands import Integer, TriBool
from shaderlab.compiler.spirv import Op
from shaderlab.model.frame import Array, Bindings, Fragments, Samples

from .interpreter import FLOAT32, Arithmetic, Interpreted, Program, interpret
from .interpreter.running import EndlessError

DERIVATIVES = range(Op.DPdx, Op.FwidthCoarse + 1)
_HUGE = float(np.finfo(np.float32).max)
_TRIES = 4  # to leave out what goes on for too long
_T = TypeVar("_T")


@dataclass(frozen=True, eq=False)
class InputBatch:
    """What some invocations get: `each` has what differs between them, by name, a row for each, or
    one row for all, `bindings` what does not."""

    each: Mapping[str, Array]
    bindings: Bindings
    count: int

    def part(self, rows: Array) -> InputBatch:
        """Some of the invocations."""
        each = {n: v if len(v) == 1 else v[rows] for n, v in self.each.items()}
        return InputBatch(each, self.bindings, len(rows))

    def rows_with(self, rows: Array, program: Program) -> Array:
        """Some rows, and where the program uses derivatives those of their quads, where it shares
        variables those of their workgroups."""
        if program.group > 1:
            groups = np.arange(self.count) // program.group
            return np.flatnonzero(np.isin(groups, groups[rows]))
        places = self.each.get("gl_FragCoord")
        if places is None or not asks_for_neighbours(program, self.bindings):
            return rows
        quads = quads_of(places)
        return np.flatnonzero(np.isin(quads, quads[rows]))

    def alone(self, row: int, program: Program) -> tuple[InputBatch, int]:
        """An invocation with those of its quad that it depends on, and its row among them."""
        rows = self.rows_with(np.array([row]), program)
        return self.part(rows), int(np.flatnonzero(rows == row)[0])

    def example(self, row: int, names: Iterable[str]) -> dict[str, tuple[float, ...]]:
        """What one invocation gets of some inputs, by name."""
        found = {}
        for name in names:
            values = self.each.get(name)
            if values is not None:
                one = values[row if len(values) > 1 else 0]
            elif name in self.bindings.uniforms:
                one = np.asarray(self.bindings.uniforms[name])
            else:
                continue
            found[name] = tuple(float(v) for v in np.ravel(one))
        return found


def quads_of(places: Array) -> Array:
    """A number for the quad of each gl_FragCoord."""
    cell = np.floor(places[:, :2] / 2.0).astype(np.int64)
    return np.asarray(cell[:, 1] * (1 << 20) + cell[:, 0])


def asks_for_neighbours(program: Program, bindings: Bindings) -> bool:
    """Whether invocations depend on others: by derivatives, by mipmaps, or in a workgroup."""
    mipmapped = any(texels.filter[0] != texels.filter[1] for texels in bindings.textures.values())
    derives = any(one.op in DERIVATIVES for one in program.definitions.values())
    return mipmapped or derives or program.group > 1


def run_batch(
    program: Program, batch: InputBatch, arithmetic: Arithmetic = FLOAT32, **options: Any
) -> Interpreted:
    """Run a program on a batch, by default with what is not written. Options and errors are those
    of `interpret`."""
    options = {"unwritten": True, **options}
    return interpret(program, batch.each, batch.bindings, arithmetic, count=batch.count, **options)


def run_ending(
    programs: Iterable[Program], act: Callable[[InputBatch], _T], batch: InputBatch
) -> tuple[_T | None, InputBatch]:
    """What a function gives for a batch, but for invocations for which a program goes on for too
    long, and the others; None where that is so for all, or for others again and again."""
    for _ in range(_TRIES):
        try:
            return act(batch), batch
        except EndlessError as error:
            going = np.asarray(error.invocations.reshape(-1, batch.count).any(axis=0))
        for program in programs:
            going[batch.rows_with(np.flatnonzero(going), program)] = True
        batch = batch.part(np.flatnonzero(~going))
        if not batch.count:
            break
    return None, batch


def flatten_outputs(outputs: Mapping[str, Any], finite: bool = True) -> list[tuple[str, Array]]:
    """Outputs as float64 (count, components), an array's elements each by its name; if `finite`,
    NaN where there is no finite float32."""
    found = []
    for name, value in outputs.items():
        if isinstance(value, tuple):
            parts = {f"{name}[{i}]": part for i, part in enumerate(value)}
            found += flatten_outputs(parts, finite)
            continue
        if isinstance(value, Integer):
            value = value.lo
        elif isinstance(value, TriBool):
            value = value.all_true
        numbers = np.asarray(value, np.float64)
        numbers = numbers.reshape(len(numbers), -1)
        if finite:
            numbers = np.where(np.abs(numbers) <= _HUGE, numbers, np.nan)
        found.append((name, numbers))
    return found


def merge_batches(batches: Sequence[InputBatch], program: Program, most: int) -> list[InputBatch]:
    """What several draws gave, as few batches: those with the same textures become one, in which
    uniforms differ between invocations; of each draw as many, `most` in all. Draws whose
    invocations depend on their neighbours stay apart."""
    found: list[InputBatch] = []
    groups: dict[int, list[InputBatch]] = {}
    for batch in batches:
        if asks_for_neighbours(program, batch.bindings):
            found.append(batch)
        else:
            groups.setdefault(_hash_textures(batch.bindings), []).append(batch)
    for group in groups.values():
        share = max(most // len(group), 16)
        parts = [
            b.part(np.unique(np.linspace(0, b.count - 1, min(share, b.count)).astype(int)))
            for b in group
        ]
        found.append(parts[0] if len(parts) == 1 else join_batches(parts))
    return found


def _hash_textures(bindings: Bindings) -> int:
    parts: list[object] = []
    for name, texels in sorted(bindings.textures.items()):
        parts += [name, texels.filter, texels.wrap, texels.compare, texels.kind, texels.format]
        parts += [level.tobytes() for level in (texels.values, *texels.smaller)]
    return hash(tuple(parts))


def join_batches(parts: Sequence[InputBatch]) -> InputBatch:
    """Batches with the same textures as one, in which uniforms differ between invocations."""
    each = {}
    names = [{**part.each, **part.bindings.uniforms} for part in parts]
    for name in names[0]:
        if not all(name in others for others in names):
            continue  # another stage's, which not all of these draws have
        rows = []
        for part in parts:
            values = part.each.get(name)
            if values is None:
                values = np.asarray(part.bindings.uniforms[name])[None]
            rows.append(np.broadcast_to(values, (part.count, *values.shape[1:])))
        each[name] = np.concatenate(rows)
    count = sum(part.count for part in parts)
    return InputBatch(each, replace(parts[0].bindings, uniforms={}), count)


def mix_batches(batch: InputBatch, row: int, others: InputBatch) -> InputBatch:
    """The `others`, in which each input may be that of a row of a batch instead."""
    each, rng = dict(others.each), np.random.default_rng(5)
    for name, values in each.items():
        if name in batch.each and len(values) == others.count:
            own, keep = batch.each[name], rng.random(len(values)) < 0.5
            each[name] = np.where(
                keep.reshape(-1, *[1] * (values.ndim - 1)), values, own[row if len(own) > 1 else 0]
            )
    return replace(others, each=each)


def fragment_batch(captured: Fragments, bindings: Bindings, most: int) -> InputBatch:
    """What a draw gave its fragment shader, those pixels too that it discards."""
    captured = captured.undiscarded or captured
    y, x = np.nonzero(captured.covered)
    rows = whole_quads(x, y, most)
    at = (y[rows], x[rows])
    each = {name: values[at] for name, values in captured.inputs.items()}
    return InputBatch({**each, "gl_FragCoord": captured.frag_coord[at]}, bindings, len(rows))


def vertex_batch(captured: Samples, bindings: Bindings, most: int) -> InputBatch:
    """What a draw gave its vertex shader."""
    inputs = (captured.entering or captured).inputs
    # Copied, for a part keeps the whole of an array alive.
    each = {name: values[:most].copy() for name, values in inputs.items()}
    return InputBatch(each, bindings, max((len(values) for values in each.values()), default=0))


def whole_quads(x: Array, y: Array, most: int | None, always: Sequence[int] = ()) -> Array:
    """The pixels of quads from all over a picture, and those of the pixels `always`; all where
    there are not too many."""
    if most is None or len(x) <= most:
        return np.arange(len(x))
    seen = np.zeros(((int(y.max()) >> 1) + 1, (int(x.max()) >> 1) + 1), np.bool_)
    seen[y >> 1, x >> 1] = True
    rows, columns = np.nonzero(seen)
    taken = scatter(len(rows), most // 4)
    seen[:] = False
    seen[rows[taken], columns[taken]] = True
    seen[y[list(always)] >> 1, x[list(always)] >> 1] = True
    return np.flatnonzero(seen[y >> 1, x >> 1])


def scatter(count: int, most: int) -> Array:
    """`most` of so many numbers from 0, one at random from each of as many equal stretches: in the
    order of a picture's pixels they follow no pattern of it. The same ones at each call."""
    if count <= most:
        return np.arange(count)
    edges = np.linspace(0, count, most + 1)
    found = edges[:-1] + np.random.default_rng(0).random(most) * np.diff(edges)
    numbers = np.minimum(found.astype(np.int64), count - 1)
    return numbers[np.diff(numbers, prepend=-1) > 0]
