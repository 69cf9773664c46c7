"""Inputs at random, each as its role says."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from shaderlab.errors import NotInterpretedError
from shaderlab.model.frame import Array, Bindings, Texels

from ..interpreter.workgroups import numbered
from .given import Given
from .interface import Input
from .roles import WORKGROUPS, Role, keep_in_order, words_of

_SIDE = 8  # of a texture
_CORNERS = 0.08  # the share of numbers that are an end of their range, 0 or 1
_PIXELS = 64  # in a row


def drawn(inputs: Mapping[str, Input], roles: Mapping[str, Role], count: int, seed: int) -> Given:
    """Inputs for `count` invocations, uniforms as well, which differ between them here.

    Raises:
        NotInterpretedError: there is a texture of a kind that has no formula.
    """
    rng = np.random.default_rng([19, seed])
    each: dict[str, Array] = {}
    textures: dict[str, Texels] = {}
    size = None
    for name, one in inputs.items():
        role = roles[name]
        if one.workgroup:
            size = one.workgroup
        elif role.kind == "texture":
            textures[name] = _texture(one, rng)
        elif name in ("gl_VertexID", "gl_VertexIndex"):
            each[name] = np.arange(count, dtype=np.int64)[:, None]
        elif name == "gl_FragCoord":
            each[name] = _places(count, rng)
        elif "mat" in one.type:
            each[name] = _matrices(one.type, role, count, rng)
        else:
            each[name] = _numbers(one.type, role, count, rng)
    if size is not None:
        groups = rng.integers(0, WORKGROUPS, (count, 3))
        each |= numbered(size, groups, rng.integers(0, size, (count, 3)))
    keep_in_order(each, roles)
    if "gl_FragCoord" not in each:
        each["gl_FragCoord"] = _places(count, rng)  # of derivatives' neighbours
    return Given(each, Bindings(textures=textures), count)


def _numbers(type_: str, role: Role, count: int, rng: np.random.Generator) -> Array:
    size = int(type_[-1]) if type_[-1].isdigit() else 1
    if role.kind == "unit":
        v = rng.normal(size=(count, size))
        few = rng.random(count) < _CORNERS  # along an axis
        v[few] = np.sign(v[few]) * (np.abs(v[few]) == np.abs(v[few]).max(axis=1, keepdims=True))
        found: Array = (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32)
        return found
    if type_.startswith(("int", "ivec", "uint", "uvec", "bool", "bvec")):
        whole = rng.integers(int(role.low), int(role.high) + 1, (count, size))
        if role.high - role.low > 2.0**16:  # of each magnitude as many
            whole = whole >> rng.integers(0, 32, (count, size))
            return whole % 2**32 if type_[0] == "u" else whole
        return whole if type_[0] == "i" else np.abs(whole) if type_[0] == "u" else whole > 0
    x = rng.uniform(role.low, role.high, (count, size))
    if role.low > 0.0 and role.high > 20.0 * role.low:  # of each magnitude as many
        x = np.exp(rng.uniform(np.log(role.low), np.log(role.high), (count, size)))
    ends = np.array([e for e in (role.low, role.high, 0.0, 1.0) if role.low <= e <= role.high])
    corner = rng.random((count, size)) < _CORNERS
    x = np.where(corner, rng.choice(ends, (count, size)), x)
    return np.asarray(np.clip(x.astype(np.float32), role.low, role.high), np.float32)


def _places(count: int, rng: np.random.Generator) -> Array:
    i = np.arange(count)
    x, y = i % _PIXELS + 0.5, i // _PIXELS + 0.5
    z, w = rng.uniform(0.0, 1.0, count), 1.0 / rng.uniform(0.5, 50.0, count)
    return np.stack([x, y, z, w], axis=1).astype(np.float32)


def _matrices(type_: str, role: Role, count: int, rng: np.random.Generator) -> Array:
    """Matrices as the interpreter has them, (count, rows, columns)."""
    columns, rows = (int(d) for d in (type_[3:].split("x") * 2)[:2])
    if role.kind == "number" or columns != rows:
        return rng.uniform(role.low, role.high, (count, rows, columns)).astype(np.float32)
    size = columns
    found = np.broadcast_to(np.eye(size), (count, size, size)).copy()
    if role.kind == "projection" and size == 4:
        focal, aspect = rng.uniform(0.7, 2.5, count), rng.uniform(0.5, 2.0, count)
        near, far = rng.uniform(0.1, 1.0, count), rng.uniform(5.0, 100.0, count)
        found[:, 0, 0], found[:, 1, 1] = focal / aspect, focal
        found[:, 2, 2], found[:, 2, 3] = (far + near) / (near - far), 2 * far * near / (near - far)
        found[:, 3, 2], found[:, 3, 3] = -1.0, 0.0
        return found.astype(np.float32)
    turn = min(size, 3)
    q, _ = np.linalg.qr(rng.normal(size=(count, turn, turn)))
    q = q * np.sign(np.linalg.det(q))[:, None, None] if turn == 3 else q
    if role.kind == "affine":
        q = q * rng.uniform(0.4, 2.5, (count, 1, turn))
        found[:, :3, 3] = rng.uniform(-4.0, 4.0, (count, 3))
    found[:, :turn, :turn] = q
    return found.astype(np.float32)


_SHAPES: Mapping[str, Callable[[int], tuple[int, ...]]] = {
    "2D": lambda n: (n, n, 4),
    "2DArray": lambda n: (4, n, n, 4),
    "Cube": lambda n: (6, n, n, 4),
    "2DMS": lambda n: (4, n, n, 4),
}


def _texture(one: Input, rng: np.random.Generator) -> Texels:
    """A small texture; one of normals holds unit vectors, by 0.5 + 0.5 n."""
    kind = one.type.partition("sampler")[2]
    shadow = kind.endswith("Shadow")
    kind = kind.removesuffix("Shadow")
    if kind not in _SHAPES or not one.type.startswith("sampler"):
        raise NotInterpretedError(f"not interpreted: {one.type} {one.name}")
    values = rng.uniform(0.02, 1.0, _SHAPES[kind](_SIDE))
    if "normal" in words_of(one.name):
        n = rng.normal(size=(*values.shape[:-1], 3))
        n[..., 2] = np.abs(n[..., 2])
        values[..., :3] = 0.5 + 0.5 * n / np.linalg.norm(n, axis=-1, keepdims=True)
    plain = ("nearest", "nearest") if kind == "2DMS" else ("linear", "linear")
    return Texels(
        values.astype(np.float32), plain, ("repeat", "repeat"), (0.0,) * 4,
        kind=kind, compare="lequal" if shadow else None,
    )  # fmt: skip
