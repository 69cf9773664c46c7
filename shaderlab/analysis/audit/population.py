"""Invocations to try: drawn at random, special ones, and ones near those that almost go wrong."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from shaderlab.model.frame import Array, Bindings, Texels

from ..equivalence.drawing import drawn
from ..equivalence.given import Given
from ..equivalence.interface import Input
from ..equivalence.roles import Role, is_place, keep_in_order

DRAWN, NOTHING, EQUAL = range(3)
"""What is special about an invocation: nothing; a place that is 0; two places that are one."""
_LEAST_TEXEL = 0.02  # of textures that are drawn; less is a direction's
_NEAR_0 = 1e-5
_MOST_PAIRS = 120
_COPIES = 3  # of each special input, with other values of all others
_SHRINKING, _START = 0.4, 0.5  # of the steps of a search, in widths of the ranges


def concatenated(givens: Sequence[Given]) -> Given:
    """Several sets with the same bindings as one."""
    count = sum(given.count for given in givens)
    each = {
        name: np.concatenate(
            [np.broadcast_to(g.each[name], (g.count, *g.each[name].shape[1:])) for g in givens]
        )
        for name in givens[0].each
    }
    return Given(each, givens[0].bindings, count)


def first_ones(inputs: Mapping[str, Input], roles: Mapping[str, Role], count: int) -> Given:
    """Invocations at random, with special ones after them. Textures hold 0 and 1 here and there."""
    given = drawn(inputs, roles, count, 0)
    textures = {name: _with_ends(texels) for name, texels in given.bindings.textures.items()}
    given = Given(given.each, Bindings(textures=textures), given.count)
    parts = [given]
    rng = np.random.default_rng(5)
    for each in _special(inputs, roles):
        some = given.part(rng.integers(0, given.count, _COPIES))
        changed = dict(some.each)
        for name, value in each.items():
            other = changed[value] if isinstance(value, str) else np.float32(value)
            changed[name] = np.broadcast_to(other, changed[name].shape).copy()
        keep_in_order(changed, roles)
        parts.append(Given(changed, given.bindings, some.count))
    return concatenated(parts)


def origins(given: Given, inputs: Mapping[str, Input], roles: Mapping[str, Role]) -> Array:
    """What is special about each invocation that nobody said may be, (count,): a place is 0, or
    its w is, or two are the same one."""
    places = [
        name
        for name, one in inputs.items()
        if is_steady(one, roles[name]) and one.type != "float" and is_place(name)
        if roles[name].source == "assumed" and roles[name].kind == "number"
    ]
    found = np.full(given.count, DRAWN)
    for name in places:
        found[(given.each[name] == 0.0).all(axis=1)] = NOTHING
        if inputs[name].type == "vec4":  # its w, by which perspective divides
            found[np.abs(given.each[name][:, 3]) < _NEAR_0] = NOTHING
    for a, b in itertools.islice(itertools.combinations(places, 2), _MOST_PAIRS):
        if inputs[a].type == inputs[b].type:
            found[(given.each[a] == given.each[b]).all(axis=1)] = EQUAL
    return found


def _with_ends(texels: Texels) -> Texels:
    """The texture with rows of 0 and of 1, unless it holds directions."""
    if texels.values.min() < _LEAST_TEXEL:
        return texels
    values = texels.values.copy()
    rows = values.shape[-3]
    values[..., : rows // 4, :, :] = 0.0
    values[..., rows // 2 : 3 * rows // 4, :, :] = 1.0
    return replace(texels, values=values)


def _special(
    inputs: Mapping[str, Input], roles: Mapping[str, Role]
) -> Iterator[dict[str, float | str]]:
    """Inputs that are all 0 or an end of their range, and pairs that are equal: a value by input,
    or the name of another one."""
    steady = [n for n, one in inputs.items() if is_steady(one, roles[n])]
    for name in steady:
        role = roles[name]
        if role.kind == "number":
            for value in dict.fromkeys((0.0, role.low, role.high)):
                if role.low <= value <= role.high:
                    yield {name: value}
    pairs = [
        (a, b)
        for a, b in itertools.combinations(steady, 2)
        if inputs[a].type == inputs[b].type and roles[a].kind == roles[b].kind
        if roles[b].kind == "unit" or _meet(roles[a], roles[b])
    ]
    for a, b in pairs[:_MOST_PAIRS]:
        yield {a: b}


def _meet(a: Role, b: Role) -> bool:
    """Whether any value of one is one of the other's."""
    return a.low <= b.low and b.high <= a.high


def is_steady(one: Input, role: Role) -> bool:
    """Whether an input is a float, or a vector of floats, that may be changed a little."""
    return one.name != "gl_FragCoord" and one.type.startswith(("float", "vec")) and role.kind in (
        "number", "unit"
    )  # fmt: skip


class Search:
    """Children of invocations that are close to going wrong: moved a little, ever less.

    Args:
        inputs, roles: what may be moved, and where to.
    """

    def __init__(self, inputs: Mapping[str, Input], roles: Mapping[str, Role]) -> None:
        self._inputs, self._roles = inputs, roles
        self._steady = [n for n, one in inputs.items() if is_steady(one, roles[n])]
        self._rng = np.random.default_rng(11)

    def moved(self, parents: Given, generation: int) -> Given:
        """A child of each parent: in one input, or in one component of it, or in all."""
        rng, count = self._rng, parents.count
        each = dict(parents.each)
        which = rng.integers(-1, len(self._steady), count) if self._steady else np.zeros(count)
        size = _START * _SHRINKING**generation
        for i, name in enumerate(self._steady):
            role, values = self._roles[name], each[name].astype(np.float64)
            width = 1.0 if role.kind == "unit" else role.high - role.low
            step = rng.normal(size=values.shape) * width * size
            one = rng.integers(0, values.shape[1], count)[:, None] == np.arange(values.shape[1])
            step = np.where(one | (rng.random(count) < 0.5)[:, None], step, 0.0)
            moves = ((which == i) | (which == -1))[:, None]
            each[name] = self._kept(name, np.where(moves, values + step, values))
        keep_in_order(each, self._roles)
        return Given(self._whole(each), parents.bindings, count)

    def between(self, starts: Given, ends: Given, t: Array) -> Given:
        """Invocations on the straight ways from some to others, at a share of each, (count,)."""
        each = dict(starts.each)
        for name in self._steady:
            a, b = (g.each[name].astype(np.float64) for g in (starts, ends))
            each[name] = self._kept(name, a + t[:, None] * (b - a))
        return Given(each, starts.bindings, starts.count)

    def _kept(self, name: str, values: Array) -> Array:
        role = self._roles[name]
        if role.kind == "unit":
            with np.errstate(all="ignore"):
                values = values / np.linalg.norm(values, axis=1, keepdims=True)
            return np.nan_to_num(values, nan=0.57735).astype(np.float32)
        return np.clip(values, role.low, role.high).astype(np.float32)

    def _whole(self, each: dict[str, Array]) -> dict[str, Array]:
        """With integers drawn anew here and there."""
        for name, one in self._inputs.items():
            if one.workgroup is not None:
                continue  # they number the invocations
            if one.type.startswith(("int", "ivec", "uint", "uvec")) and name in each:
                values, role = each[name], self._roles[name]
                fresh = self._rng.integers(int(role.low), int(role.high) + 1, values.shape)
                each[name] = np.where(self._rng.random(values.shape) < 0.3, fresh, values)
        return each
