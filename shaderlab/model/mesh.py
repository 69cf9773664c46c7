"""Vertices, and how they lie in the buffers that OpenGL reads them from.

Where an attribute begins and how far it is from one vertex to the next follow from a mesh's layout
alone, so they are worked out here, without a device, and can be held against the driver's own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from shaderlab.errors import CaseError, suggest
from shaderlab.model.checked import Checked
from shaderlab.model.state import check_choice

from .frame import Array

PRIMITIVES = (
    "points", "lines", "line_strip", "triangles", "triangle_strip", "triangle_fan", "patches",
)  # fmt: skip
LAYOUTS = ("separate", "interleaved", "batched")
USAGES = (
    "stream_draw", "stream_read", "stream_copy", "static_draw", "static_read", "static_copy",
    "dynamic_draw", "dynamic_read", "dynamic_copy",
)  # fmt: skip
UPLOADS = ("data", "sub_data", "map")


@dataclass(frozen=True)
class Placement:
    """Where one attribute lies: `offset` bytes into its buffer, the next vertex's `stride` bytes
    further on. `buffer` counts the mesh's buffers from 0; `divisor` is 1 for an attribute that
    advances once per instance."""

    buffer: int
    offset: int
    stride: int
    divisor: int = 0


@dataclass(frozen=True, kw_only=True)
class Mesh(Checked):
    """Vertices by attribute name, each an array of shape (vertices, components).

    Float arrays are uploaded as float32. A matrix attribute has shape (vertices, rows, columns),
    rows first as mathematics writes it.

    Args:
        attributes: what each vertex has.
        indices: a flat integer array, or None. OpenGL gets those of type uint8 and uint16 as bytes
            and shorts; others are 32-bit numbers.
        primitive: one of PRIMITIVES; patches are what tessellation stages take.
        patch_vertices: how many vertices a patch has, 1…32.
        instance_attributes: what each instance has, shape (instances, components).
        layout: "separate" is a buffer for each attribute, "interleaved" one buffer of whole
            vertices (123123123), "batched" one buffer of one attribute after the other
            (111222333). Attributes of instances lie in buffers of their own, likewise.
        usage: the hint to glBufferData, one of USAGES.
        upload: "data" fills a buffer as it is made, "sub_data" makes it first and then fills it
            by glBufferSubData, one attribute at a time where these are not interleaved, "map"
            writes through glMapBufferRange.
    """

    attributes: Mapping[str, Array]
    indices: Array | None = None
    primitive: str = "triangles"
    patch_vertices: int = 3
    instance_attributes: Mapping[str, Array] = field(default_factory=dict)
    layout: str = "separate"
    usage: str = "static_draw"
    upload: str = "data"

    def __post_init__(self) -> None:
        check_choice("Mesh", "primitive", self.primitive, PRIMITIVES)
        check_choice("Mesh", "layout", self.layout, LAYOUTS)
        if not 1 <= self.patch_vertices <= 32:
            raise CaseError(f"Mesh: a patch has 1…32 vertices, not {self.patch_vertices}")
        check_choice("Mesh", "usage", self.usage, USAGES)
        check_choice("Mesh", "upload", self.upload, UPLOADS)
        vertices = _check_arrays("attributes", "vertices", self.attributes)
        object.__setattr__(self, "attributes", vertices)
        if not vertices:
            raise CaseError("Mesh: attributes need one common number of vertices, there are none")
        if not self.vertices:
            raise CaseError(
                "Mesh: there are no vertices", remedy="give each attribute a row per vertex"
            )
        instances = _check_arrays("instance_attributes", "instances", self.instance_attributes)
        object.__setattr__(self, "instance_attributes", instances)
        for name in instances:
            if name in vertices:
                raise CaseError(f"Mesh: {name!r} is an attribute of vertices and of instances")
        if self.indices is None:
            return
        indices = np.asarray(self.indices).ravel()
        if not indices.size or indices.dtype.kind not in "iu":
            given = f"{indices.size} of type {indices.dtype}"
            raise CaseError(f"Mesh: indices are one or more whole numbers, not {given}")
        if indices.min() < 0 or indices.max() >= self.vertices:
            raise CaseError(
                f"Mesh: indices run from {indices.min()} to {indices.max()}, "
                f"but there are {self.vertices} vertices"
            )
        kind = indices.dtype if indices.dtype in (np.uint8, np.uint16) else np.uint32
        object.__setattr__(self, "indices", indices.astype(kind))

    @staticmethod
    def later(make: Callable[[], Mesh]) -> Mesh:
        """A mesh that `make` makes when it is first used, such as one read from a file: importing
        a case does not have to wait for that."""
        return _Later(make)

    def made(self) -> Mesh:
        """The mesh itself, made now if it was to be made later."""
        return self

    @property
    def vertices(self) -> int:
        """Number of vertices stored (not of indices)."""
        return len(next(iter(self.attributes.values())))

    @property
    def instances(self) -> int | None:
        """Number of instances that there are attributes for; None without such attributes."""
        return next((len(a) for a in self.instance_attributes.values()), None)

    @property
    def inputs(self) -> dict[str, Array]:
        """All attributes, those of vertices first."""
        return {**self.attributes, **self.instance_attributes}

    def only(self, *names: str) -> Mesh:
        """The same mesh with these attributes alone, for shaders that read no others."""
        for name in names:
            if name not in self.inputs:
                raise CaseError(f"Mesh has no {name!r}", remedy=suggest(name, self.inputs))
        return replace(
            self,
            attributes={n: self.attributes[n] for n in names if n in self.attributes},
            instance_attributes={
                n: self.instance_attributes[n] for n in names if n in self.instance_attributes
            },
        )

    def placements(self) -> dict[str, Placement]:
        """Where each attribute lies.

        >>> mesh = Mesh(attributes={"aPos": np.zeros((3, 3)), "aColor": np.zeros((3, 3))},
        ...             layout="interleaved")
        >>> mesh.placements()["aColor"]
        Placement(buffer=0, offset=12, stride=24, divisor=0)
        >>> replace(mesh, layout="batched").placements()["aColor"]
        Placement(buffer=0, offset=36, stride=12, divisor=0)
        """
        found: dict[str, Placement] = {}
        for divisor, group in enumerate((self.attributes, self.instance_attributes)):
            first = max((p.buffer for p in found.values()), default=-1) + 1
            found.update(_place(group, self.layout, first, divisor))
        return found

    def parts(self) -> list[list[tuple[int, bytes]]]:
        """What is written into each buffer: pieces of bytes with their offsets, without gaps."""
        made: list[list[tuple[int, bytes]]] = []
        for group in (self.attributes, self.instance_attributes):
            rows = {name: _by_columns(array) for name, array in group.items()}
            if not rows:
                continue
            if self.layout == "interleaved":
                each = [np.ascontiguousarray(a).view(np.uint8) for a in rows.values()]
                made.append([(0, np.concatenate(each, axis=1).tobytes())])
            elif self.layout == "batched":
                places = _place(group, self.layout, 0, 0)
                made.append([(places[n].offset, a.tobytes()) for n, a in rows.items()])
            else:
                made += [[(0, a.tobytes())] for a in rows.values()]
        return made


class _Later(Mesh):
    """A mesh made when one of its fields is first read, once."""

    def __init__(self, make: Callable[[], Mesh]) -> None:
        object.__setattr__(self, "_make", make)

    def __getattribute__(self, name: str) -> Any:
        if name in _FIELDS:
            return getattr(self.made(), name)
        return super().__getattribute__(name)

    @property
    def instances(self) -> int | None:
        """As `Mesh.instances`; None before it is made: a draw asks when it is written."""
        return self.made().instances if "_mesh" in self.__dict__ else None

    def made(self) -> Mesh:
        """As `Mesh.made`. Raises whatever making it does, such as a damaged file."""
        if "_mesh" not in self.__dict__:
            object.__setattr__(self, "_mesh", self.__dict__["_make"]())
        made: Mesh = self.__dict__["_mesh"]
        return made

    def only(self, *names: str) -> Mesh:
        """As `Mesh.only`, and as late."""
        return _Later(lambda: self.made().only(*names))


_FIELDS = frozenset(each.name for each in fields(Mesh))


def _place(
    group: Mapping[str, Array], layout: str, first: int, divisor: int
) -> dict[str, Placement]:
    found = {}
    sizes = {n: a.itemsize * int(np.prod(a.shape[1:])) for n, a in group.items()}
    buffer, offset = first, 0
    for name, size in sizes.items():
        stride = sum(sizes.values()) if layout == "interleaved" else size
        found[name] = Placement(buffer, offset, stride, divisor)
        if layout == "separate":
            buffer += 1
        else:
            offset += size if layout == "interleaved" else group[name].nbytes
    return found


def _by_columns(array: Array) -> Array:
    turned = np.swapaxes(array, 1, 2) if array.ndim == 3 else array
    return np.ascontiguousarray(turned).reshape(len(array), -1)


def _check_arrays(owner: str, what: str, given: Mapping[str, Array]) -> dict[str, Array]:
    arrays = {name: _to_rows(name, value, what) for name, value in given.items()}
    counts = {name: len(a) for name, a in arrays.items()}
    if len(set(counts.values())) > 1:
        raise CaseError(f"Mesh: {owner} need one common number of {what}, not {counts}")
    return arrays


def _to_rows(name: str, value: Array, what: str) -> Array:
    array = np.asarray(value)
    if array.dtype.kind == "f":
        array = array.astype(np.float32)
    elif array.dtype.kind in "iub":
        array = array.astype(np.int32)
    else:
        raise CaseError(f"Mesh: attribute {name!r} must be numbers, not {array.dtype}")
    if array.ndim == 1:
        array = array[:, None]
    if array.ndim not in (2, 3) or not all(1 <= size <= 4 for size in array.shape[1:]):
        raise CaseError(
            f"Mesh: attribute {name!r} must be ({what}, 1…4) or ({what}, rows, columns), "
            f"not {array.shape}"
        )
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise CaseError(f"Mesh: attribute {name!r} holds a NaN or an infinity")
    return array
