"""What some invocations of a shader get, and how that is taken from a scene's captures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shaderlab.model.frame import Array, Bindings, Fragments, Samples

from ..interpreter import Program

_DERIVATIVES = range(207, 216)  # OpDPdx to OpFwidthCoarse


@dataclass(frozen=True, eq=False)
class Given:
    """What some invocations get.

    Attributes:
        each: what differs between them, by name, a row for each.
        bindings: what does not.
        count: how many there are.
    """

    each: Mapping[str, Array]
    bindings: Bindings
    count: int

    def rows_with(self, rows: Array, program: Program) -> Array:
        """Some rows, and where the program asks for derivatives those of their quads."""
        places = self.each.get("gl_FragCoord")
        if places is None or not asks_for_neighbours(program, self.bindings):
            return rows
        cells = cells_of(places)
        return np.flatnonzero(np.isin(cells, cells[rows]))

    def part(self, rows: Array) -> Given:
        """Some of the invocations."""
        each = {n: v if len(v) == 1 else v[rows] for n, v in self.each.items()}
        return Given(each, self.bindings, len(rows))


def cells_of(places: Array) -> Array:
    """A number for the quad of each gl_FragCoord."""
    cell = np.floor(places[:, :2] / 2.0).astype(np.int64)
    found: Array = cell[:, 1] * (1 << 20) + cell[:, 0]
    return found


def asks_for_neighbours(program: Program, bindings: Bindings) -> bool:
    """Whether invocations depend on their quads: by derivatives, or by mipmaps."""
    if any(texels.filter[0] != texels.filter[1] for texels in bindings.textures.values()):
        return True
    return any(one.op in _DERIVATIVES for one in program.definitions.values())


def merged(givens: Sequence[Given], program: Program, most: int) -> list[Given]:
    """What several draws gave, as few sets: those with the same textures become one, in which
    uniforms differ between invocations; of each draw as many, `most` in all. Draws whose
    invocations depend on their neighbours stay apart."""
    found: list[Given] = []
    groups: dict[int, list[Given]] = {}
    for given in givens:
        if asks_for_neighbours(program, given.bindings):
            found.append(given)
        else:
            groups.setdefault(_looks(given.bindings), []).append(given)
    for group in groups.values():
        share = max(most // len(group), 16)
        parts = [
            g.part(np.unique(np.linspace(0, g.count - 1, min(share, g.count)).astype(int)))
            for g in group
        ]
        found.append(parts[0] if len(parts) == 1 else joined(parts))
    return found


def _looks(bindings: Bindings) -> int:
    """A number that is the same for the same textures."""
    parts: list[object] = []
    for name, texels in sorted(bindings.textures.items()):
        parts += [name, texels.filter, texels.wrap, texels.compare, texels.kind, texels.format]
        parts += [level.tobytes() for level in (texels.values, *texels.smaller)]
    return hash(tuple(parts))


def joined(parts: Sequence[Given]) -> Given:
    """Sets with the same textures as one, in which uniforms differ between invocations."""
    count = sum(part.count for part in parts)
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
    return Given(each, replace(parts[0].bindings, uniforms={}), count)


def given_fragments(captured: Fragments, bindings: Bindings, most: int) -> Given:
    """What a draw gave its fragment shader, those pixels too that it discards."""
    captured = captured.undiscarded or captured
    y, x = np.nonzero(captured.covered)
    rows = whole_quads(x, y, most)
    at = (y[rows], x[rows])
    each = {name: values[at] for name, values in captured.inputs.items()}
    return Given({**each, "gl_FragCoord": captured.frag_coord[at]}, bindings, len(rows))


def given_vertices(captured: Samples, bindings: Bindings, most: int) -> Given:
    """What a draw gave its vertex shader."""
    inputs = (captured.entering or captured).inputs
    # Copied, for a part keeps the whole of an array alive.
    each = {name: values[:most].copy() for name, values in inputs.items()}
    return Given(each, bindings, max((len(values) for values in each.values()), default=0))


def whole_quads(x: Array, y: Array, most: int | None, always: Sequence[int] = ()) -> Array:
    """The pixels of quads from all over a picture, and those of the pixels `always`; all where
    there are not too many."""
    if most is None or len(x) <= most:
        return np.arange(len(x))
    seen = np.zeros(((int(y.max()) >> 1) + 1, (int(x.max()) >> 1) + 1), np.bool_)
    seen[y >> 1, x >> 1] = True
    rows, columns = np.nonzero(seen)
    taken = scattered(len(rows), most // 4)
    seen[:] = False
    seen[rows[taken], columns[taken]] = True
    seen[y[list(always)] >> 1, x[list(always)] >> 1] = True
    return np.flatnonzero(seen[y >> 1, x >> 1])


def scattered(count: int, most: int) -> Array:
    """`most` of so many numbers from 0, one at random from each of as many equal stretches: in the
    order of a picture's pixels they follow no pattern of it. The same ones at each call."""
    if count <= most:
        return np.arange(count)
    edges = np.linspace(0, count, most + 1)
    found = edges[:-1] + np.random.default_rng(0).random(most) * np.diff(edges)
    numbers = np.minimum(found.astype(np.int64), count - 1)
    return numbers[np.diff(numbers, prepend=-1) > 0]
