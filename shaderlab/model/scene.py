"""What is drawn: meshes, domains, draws, targets and passes. Pure data, no GL."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.errors import CaseError, nearest
from shaderlab.model.state import State, one_of
from shaderlab.model.textures import COLOR_FORMATS, DEPTH_FORMATS, TextureSource

Array = npt.NDArray[Any]
Number = float | int | bool
UniformValue = Number | Sequence[Any] | Array

PRIMITIVES = ("triangles", "triangle_strip", "triangle_fan", "lines", "line_strip", "points")


@dataclass(frozen=True)
class Ramp:
    """A fragment input that varies linearly over the screen: `origin + s·dx + t·dy`.

    s and t run from 0 to 1 over the target, left to right and bottom to top; `origin`, `dx` and
    `dy` are numbers or vectors of the input's own size.
    """

    origin: UniformValue
    dx: UniformValue = 0.0
    dy: UniformValue = 0.0


def across(start: UniformValue, stop: UniformValue) -> Ramp:
    """An input that goes from `start` at the left edge to `stop` at the right one."""
    return Ramp(start, dx=(np.asarray(stop, float) - np.asarray(start, float)).tolist())


def up(start: UniformValue, stop: UniformValue) -> Ramp:
    """An input that goes from `start` at the bottom edge to `stop` at the top one."""
    return Ramp(start, dy=(np.asarray(stop, float) - np.asarray(start, float)).tolist())


UNIT_SQUARE: Mapping[str, Ramp] = {"TexCoords": Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))}


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """Vertices by attribute name, each an array of shape (vertices, components).

    Float arrays are uploaded as float32. `indices` is a flat integer array, or None.
    """

    attributes: Mapping[str, Array]
    indices: Array | None = None
    primitive: str = "triangles"

    def __post_init__(self) -> None:
        one_of("Mesh", "primitive", self.primitive, PRIMITIVES)
        arrays = {name: _rows(name, value) for name, value in self.attributes.items()}
        counts = {name: len(a) for name, a in arrays.items()}
        if not arrays or len(set(counts.values())) != 1:
            raise CaseError(f"Mesh: attributes need one common number of vertices, not {counts}")
        object.__setattr__(self, "attributes", arrays)
        if self.indices is not None:
            self._check_indices(next(iter(counts.values())))

    def _check_indices(self, vertices: int) -> None:
        indices = np.asarray(self.indices).ravel()
        if indices.size and (indices.min() < 0 or indices.max() >= vertices):
            raise CaseError(
                f"Mesh: indices run from {indices.min()} to {indices.max()}, "
                f"but there are {vertices} vertices"
            )
        object.__setattr__(self, "indices", indices.astype(np.uint32))

    @property
    def vertices(self) -> int:
        """Number of vertices stored (not of indices)."""
        return len(next(iter(self.attributes.values())))

    def only(self, *names: str) -> Mesh:
        """The same mesh with these attributes alone, for shaders that read no others."""
        for name in names:
            if name not in self.attributes:
                raise CaseError(f"Mesh has no {name!r}", remedy=nearest(name, self.attributes))
        return replace(self, attributes={name: self.attributes[name] for name in names})


@dataclass(frozen=True, kw_only=True)
class Draw:
    """One draw call: a program, what it draws, and everything that is bound while it does.

    Either `vertex` and `mesh` are given, or `domain` (the fragment shader's inputs laid over the
    whole target; the vertex stage is then made by the lab). Uniforms are keyed as GLSL spells
    them: "model", "light.constant", "weights", "lights[0].position". Matrices are given as
    mathematics writes them, rows first; the lab transposes for GLSL.
    """

    fragment: str
    vertex: str | None = None
    geometry: str | None = None
    mesh: Mesh | None = None
    domain: Mapping[str, Ramp] | None = None
    uniforms: Mapping[str, UniformValue] = field(default_factory=dict)
    textures: Mapping[str, TextureSource] = field(default_factory=dict)
    state: State = field(default_factory=State)
    instances: int = 1
    vertex_array: bool = True

    def __post_init__(self) -> None:
        if (self.domain is None) == (self.mesh is None):
            raise CaseError(
                f"Draw of {self.fragment}: give either a mesh (with a vertex shader) or a domain"
            )
        if self.mesh is not None and self.vertex is None:
            raise CaseError(f"Draw of {self.fragment}: a mesh needs a vertex shader (vertex=…)")
        if self.domain is not None and (self.vertex or self.geometry):
            raise CaseError(
                f"Draw of {self.fragment}: over a domain the vertex stage is the lab's; "
                "drop vertex= and geometry=, or draw a mesh"
            )

    @property
    def shaders(self) -> tuple[str, ...]:
        """The shader files this draw names, in pipeline order."""
        return tuple(s for s in (self.vertex, self.geometry, self.fragment) if s is not None)


@dataclass(frozen=True, kw_only=True)
class Target:
    """What a pass draws into.

    `colors` are formats by output name; None gives each of the fragment shader's outputs a
    32-bit float (or integer) attachment of its own. `size` is (width, height) in pixels; None is
    the size the case is judged at (64 × 64) and, once more, the size its picture is drawn at.
    `clear` is the value every colour attachment starts from.
    """

    size: tuple[int, int] | None = None
    colors: Mapping[str, str] | None = None
    depth: str | None = None
    samples: int = 0
    clear: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    clear_depth: float = 1.0
    clear_stencil: int = 0

    def __post_init__(self) -> None:
        for name, word in (self.colors or {}).items():
            one_of(f"Target: color {name!r}", "format", word, COLOR_FORMATS)
        if self.depth is not None:
            one_of("Target", "depth", self.depth, DEPTH_FORMATS)
        if self.size is not None and not all(0 < n <= 16384 for n in self.size):
            raise CaseError(f"Target: size must lie in 1…16384, not {self.size}")


@dataclass(frozen=True, kw_only=True)
class Pass:
    """A target and the draws into it, in order."""

    name: str = "main"
    target: Target = field(default_factory=Target)
    draws: tuple[Draw, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "draws", tuple(self.draws))
        if not self.draws:
            raise CaseError(f"Pass {self.name!r} draws nothing")


def fullscreen(
    fragment: str,
    *,
    domain: Mapping[str, Ramp] | None = None,
    uniforms: Mapping[str, UniformValue] | None = None,
    textures: Mapping[str, TextureSource] | None = None,
    target: Target | None = None,
    state: State | None = None,
    name: str = "main",
) -> tuple[Pass, ...]:
    """One pass that runs a fragment shader over the whole target.

    `domain` lays each of its inputs over the screen (`across`, `up`, `Ramp`); without it the
    shader may read `in vec2 TexCoords`, from (0, 0) lower left to (1, 1) upper right.
    """
    draw = Draw(
        fragment=fragment,
        domain=UNIT_SQUARE if domain is None else domain,
        uniforms=uniforms or {},
        textures=textures or {},
        state=state or State(),
    )
    return (Pass(name=name, target=target or Target(), draws=(draw,)),)


def mesh_pass(
    vertex: str,
    fragment: str,
    mesh: Mesh,
    *,
    geometry: str | None = None,
    uniforms: Mapping[str, UniformValue] | None = None,
    textures: Mapping[str, TextureSource] | None = None,
    target: Target | None = None,
    state: State | None = None,
    name: str = "main",
) -> tuple[Pass, ...]:
    """One pass that draws one mesh with one program."""
    draw = Draw(
        vertex=vertex,
        geometry=geometry,
        fragment=fragment,
        mesh=mesh,
        uniforms=uniforms or {},
        textures=textures or {},
        state=state or State(),
    )
    return (Pass(name=name, target=target or Target(), draws=(draw,)),)


def _rows(name: str, value: Array) -> Array:
    array = np.asarray(value)
    if array.dtype.kind == "f":
        array = array.astype(np.float32)
    elif array.dtype.kind in "iub":
        array = array.astype(np.int32)
    else:
        raise CaseError(f"Mesh: attribute {name!r} must be numbers, not {array.dtype}")
    if array.ndim == 1:
        array = array[:, None]
    if array.ndim != 2 or not 1 <= array.shape[1] <= 4:
        raise CaseError(f"Mesh: attribute {name!r} must be (vertices, 1…4), not {array.shape}")
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise CaseError(f"Mesh: attribute {name!r} holds a NaN or an infinity")
    return array
