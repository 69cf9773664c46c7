"""Where programs jump: the places between inputs at which their outputs change the most.

A threshold that was moved a little is hardly ever met by chance, so each program's jumps are
searched for by bisection, and both are compared on either side.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from shaderlab.model.frame import Array

from ..interpreter import Program
from .comparing import run
from .given import Given
from .roles import Role

PAIRS = 192
_PARTS, _ROUNDS = 8, 6  # each round looks for the steepest of so many parts
_SMOOTH = 2  # after so many rounds a change that goes on shrinking is no jump
_SHRINKS = 0.5  # what is left of a smooth change from one round to the next, at most
_JUMP = 1e9  # how far apart something and nothing are


@dataclass(frozen=True, eq=False)
class _Ways:
    """Straight ways from invocations to others, each along all inputs that vary, or along one."""

    start: Given
    end: Mapping[str, Array]
    roles: Mapping[str, Role]

    def at(self, t: Array) -> Given:
        """The inputs at a share of each way, (count,)."""
        each = dict(self.start.each)
        for name, end in self.end.items():
            start = each[name]
            value = start + t[:, None] * (end - start)
            if name in self.roles and self.roles[name].kind == "unit":
                with np.errstate(invalid="ignore"):
                    value = value / np.linalg.norm(value, axis=1, keepdims=True)
            each[name] = value.astype(np.float32)
        return Given(each, self.start.bindings, self.start.count)

    def repeated(self, times: int) -> _Ways:
        """Each way several times, all of them one after the other."""
        rows = np.tile(np.arange(self.start.count), times)
        end = {name: values[rows] for name, values in self.end.items()}
        return _Ways(self.start.part(rows), end, self.roles)


def jumps(
    programs: tuple[Program, Program],
    given: Given,
    roles: Mapping[str, Role],
) -> Given | None:
    """Inputs on both sides of places where one of the programs jumps; None where nothing can be
    varied steadily."""
    ways = _ways(given, roles, np.random.default_rng(23))
    if ways is None:
        return None
    ends = []
    for program in programs:
        ends += [ways.at(t) for t in _steepest(program, ways)]
    if not ends:
        return None
    each = {n: np.concatenate([end.each[n] for end in ends]) for n in ends[0].each}
    return Given(each, given.bindings, len(ends) * PAIRS)


def _steepest(program: Program, ways: _Ways) -> tuple[Array, ...]:
    """Both ends of the steepest little part of each way, (count,); nothing where a program changes
    smoothly along all of them."""
    all_ = np.arange(PAIRS)
    low, high, before = np.zeros(PAIRS), np.ones(PAIRS), np.full(PAIRS, np.inf)
    for number in range(_ROUNDS):
        t = low + np.linspace(0.0, 1.0, _PARTS + 1)[:, None] * (high - low)
        changes = _changes(_values(program, ways.repeated(_PARTS + 1).at(t.ravel())), _PARTS + 1)
        steepest = changes.argmax(axis=0)
        low, high = (t[steepest + k, all_] for k in (0, 1))
        change = changes[steepest, all_]
        if number >= _SMOOTH and (change <= _SHRINKS * before).all():
            return ()
        before = change
    return low, high


def _ways(given: Given, roles: Mapping[str, Role], rng: np.random.Generator) -> _Ways | None:
    steady = [
        name
        for name, values in given.each.items()
        if name != "gl_FragCoord" and len(values) == given.count
        if values.dtype.kind == "f" and values.ndim == 2
    ]
    if not steady or given.count < 2:
        return None
    rows = rng.integers(0, given.count, (2, PAIRS))
    start, end = (given.part(each) for each in rows)
    alone = rng.integers(0, len(steady), PAIRS)
    alone[: PAIRS // 2] = -1  # along all of them
    ends = {}
    for i, name in enumerate(steady):
        moves = ((alone == -1) | (alone == i))[:, None]
        ends[name] = np.where(moves, end.each[name], start.each[name])
    return _Ways(start, ends, roles)


def _values(program: Program, given: Given) -> dict[str, Array]:
    """Outputs without noise, with a jump's height where nothing is drawn or defined."""
    ran = run(program, given, 0)
    gone = ran.discarded[0][:, None]
    return {
        name: np.where(gone, _JUMP, np.where(np.isfinite(v[0]), v[0], -_JUMP))
        for name, v in ran.outputs.items()
    } or {"": np.where(gone, _JUMP, 0.0)}


def _changes(values: Mapping[str, Array], points: int) -> Array:
    """How much outputs change from one point of each way to the next, (points - 1, ways)."""
    found = []
    for output in values.values():
        along = output.reshape(points, -1, output.shape[-1])
        found.append(np.abs(np.diff(along, axis=0)).max(axis=-1))
    most: Array = np.max(found, axis=0)
    return most
