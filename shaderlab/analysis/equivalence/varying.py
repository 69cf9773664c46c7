"""Captured inputs, varied: other values of the same kind.

What a scene gives a shader obeys laws that no type says: a normal has length 1, a distance is not
negative, a matrix turns. They are learned from the captures, and kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shaderlab.model.frame import Array, Texels

from .given import Given, cells_of
from .roles import Role, is_direction, keep_in_order, lower_one

_NEAR = 1e-3  # how far from 1 the length of a unit vector is found
_AFFINE = np.array([0.0, 0.0, 0.0, 1.0])


def learned(captured: Sequence[Given]) -> dict[str, Role]:
    """What the captures' floats are, by name."""
    values: dict[str, list[Array]] = {}
    for given in captured:
        for name, rows in [*given.each.items(), *given.bindings.uniforms.items()]:
            array = np.asarray(rows)
            if array.dtype.kind == "f" and name != "gl_FragCoord":
                own = array if name in given.each else array[None]
                values.setdefault(name, []).append(own)
    found = {name: _role(name, arrays) for name, arrays in values.items()}
    for name, role in found.items():
        lower = lower_one(name, found)
        if lower and role.kind == found[lower].kind == "number":
            found[name] = replace(role, above=lower)
    return found


def _role(name: str, arrays: Sequence[Array]) -> Role:
    shape = arrays[0].shape[1:]
    flat = np.concatenate([a.reshape(-1, *shape[-1:]) for a in arrays])
    if len(shape) == 2 and shape[0] == shape[1] and shape[0] > 1:
        whole = np.concatenate(arrays).astype(np.float64)
        turn = whole[:, :3, :3]
        square = turn @ np.swapaxes(turn, 1, 2)
        if shape[0] < 4 or (whole[:, 3] == _AFFINE).all():
            turns = np.abs(square - np.eye(turn.shape[1])).max() < _NEAR
            moves = shape[0] == 4 and not (whole[:, :3, 3] == 0.0).all()
            return Role("rotation" if turns and not moves else "affine", source="learned")
        return Role("projection", source="learned")
    with np.errstate(all="ignore"):
        length = np.linalg.norm(flat.astype(np.float64), axis=-1)
        unit = shape[-1:] in ((2,), (3,)) and bool((np.abs(length - 1.0) < _NEAR).all())
        if unit and (is_direction(name) or (flat < 0.0).any()):
            return Role("unit", source="learned")
        low = 0.0 if flat.min(initial=0.0) >= 0.0 else -np.inf
        high = 1.0 if low == 0.0 and flat.max(initial=0.0) <= 1.0 else np.inf
    return Role("number", low, high, "learned")


def varied(given: Given, roles: Mapping[str, Role], seed: int) -> Given:
    """Other inputs of the same roles: uniforms differ between quads of pixels now, and texels have
    changed places."""
    rng = np.random.default_rng([29, seed])
    group = _groups(given)
    each = dict(given.each)
    for name, values in given.bindings.uniforms.items():
        array = np.asarray(values)
        if name in roles and name not in each:
            each[name] = np.repeat(array[None], given.count, axis=0)
    for name, role in roles.items():
        if name in each:
            each[name] = _varied(each[name], role, group, rng)
    keep_in_order(each, roles)
    if "gl_FragCoord" in each:
        each["gl_FragCoord"] = _moved(each["gl_FragCoord"], rng)
    textures = {name: _shuffled(texels, rng) for name, texels in given.bindings.textures.items()}
    return Given(each, replace(given.bindings, textures=textures), given.count)


def _groups(given: Given) -> Array:
    """A number for each invocation, the same in a quad of pixels."""
    places = given.each.get("gl_FragCoord")
    if places is None:
        return np.arange(given.count)
    found: Array = np.unique(cells_of(places), return_inverse=True)[1].ravel()
    return found


def _moved(places: Array, rng: np.random.Generator) -> Array:
    """The pixels elsewhere: at the lower left corner, or near it; quads stay whole."""
    found = places.copy()
    for axis in (0, 1):
        start = 2.0 * np.floor(found[:, axis].min() / 2.0)
        found[:, axis] += rng.choice([0.0, 2.0 * rng.integers(1, 32)]) - start
    return found


def _varied(values: Array, role: Role, group: Array, rng: np.random.Generator) -> Array:
    """Values of the same role, changed alike in each group."""
    count, shape = int(group.max(initial=0)) + 1, values.shape[1:]
    if len(values) == 1:
        values = np.repeat(values, len(group), axis=0)
    x = values.astype(np.float64)
    if role.kind in ("rotation", "affine", "projection") and len(shape) == 2:
        return _turned(x, role, group, count, rng)
    if role.kind == "unit":
        x = x + rng.normal(scale=0.4, size=(count, *shape))[group]
        return np.asarray(x / np.linalg.norm(x, axis=-1, keepdims=True), np.float32)
    size = max(float(np.nanmax(np.abs(x), initial=0.0)), 0.1)
    x = x * np.exp(rng.uniform(-0.7, 0.7, (count, *shape)))[group]
    low = 0.0 if role.low == 0.0 else -1.0
    moved = rng.uniform(low, 1.0, (count, *shape)) * 0.2 * size
    x = x + np.where(rng.random((count, *shape)) < 0.5, moved, 0.0)[group]
    if role.source != "learned":  # what was learned does not hold: signs are free
        x = np.where((rng.random((count, *shape)) < 0.3)[group], -x, x)
    return np.asarray(np.clip(x, role.low, role.high), np.float32)


def _turned(x: Array, role: Role, group: Array, count: int, rng: np.random.Generator) -> Array:
    size = x.shape[-1]
    if role.kind == "projection":
        return np.asarray(
            x * np.exp(rng.uniform(-0.3, 0.3, (count, size, size)))[group], np.float32
        )
    turn = min(size, 3)
    q, r = np.linalg.qr(np.eye(turn) + 0.3 * rng.normal(size=(count, turn, turn)))
    by = np.broadcast_to(np.eye(size), (count, size, size)).copy()
    by[:, :turn, :turn] = q * np.sign(np.einsum("nii->ni", r))[:, None, :]
    if role.kind == "affine":
        by[:, :turn, :turn] *= np.exp(rng.uniform(-0.3, 0.3, (count, 1, turn)))
    if role.kind == "affine" and size == 4:
        by[:, :3, 3] = rng.uniform(-0.3, 0.3, (count, 3))
    return np.asarray(x @ by[group], np.float32)


def _shuffled(texels: Texels, rng: np.random.Generator) -> Texels:
    def mixed(values: Array) -> Array:
        flat = values.reshape(-1, values.shape[-1])
        return flat[rng.permutation(len(flat))].reshape(values.shape)

    smaller = tuple(mixed(level) for level in texels.smaller)
    return replace(texels, values=mixed(texels.values), smaller=smaller)
