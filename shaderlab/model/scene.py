"""What is drawn: draws, targets, passes, and passes of one draw or dispatch. Pure data, no GL."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.checked import Checked, require_unmasked
from shaderlab.model.frame import Array
from shaderlab.model.mesh import Mesh
from shaderlab.model.state import State, check_choice
from shaderlab.model.textures import (
    COLOR_FORMATS,
    DEPTH_FORMATS,
    ImageValue,
    Output,
    TextureSource,
    outputs_read,
)

Number = float | int | bool
UniformValue = Number | Sequence[Any] | Array
Uniform = UniformValue | Mapping[str, Any]
BufferValue = UniformValue | Output


@dataclass(frozen=True)
class Pixel(Checked):
    """A place in a frame: x to the right, y up, from (0, 0) at the lower left."""

    x: int
    y: int


@dataclass(frozen=True)
class Ramp(Checked):
    """A fragment input that varies linearly over the screen: `origin + s·dx + t·dy`.

    s and t run from 0 to 1 over the target, left to right and bottom to top; `origin`, `dx` and
    `dy` are numbers or vectors of the input's own size.
    """

    origin: UniformValue
    dx: UniformValue = 0.0
    dy: UniformValue = 0.0


def across(start: UniformValue, stop: UniformValue) -> Ramp:
    """An input that goes from `start` at the left edge to `stop` at the right one."""
    return Ramp(start, dx=_difference("across", start, stop))


def up(start: UniformValue, stop: UniformValue) -> Ramp:
    """An input that goes from `start` at the bottom edge to `stop` at the top one."""
    return Ramp(start, dy=_difference("up", start, stop))


def _difference(name: str, start: UniformValue, stop: UniformValue) -> Any:
    require_unmasked({"start": start, "stop": stop}, name)
    try:
        return (np.asarray(stop, float) - np.asarray(start, float)).tolist()
    except (TypeError, ValueError):
        raise CaseError(
            f"{name}: {start!r:.60} and {stop!r:.60} are not numbers or vectors of one size",
            remedy=f"{name}(0.0, 1.0), or {name}((0.0, 0.0), (1.0, 1.0))",
        ) from None


UNIT_SQUARE: Mapping[str, Ramp] = {"TexCoords": Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))}


@dataclass(frozen=True, kw_only=True, eq=False)
class UniformBuffer(Checked):
    """Values for a uniform block's members, by their GLSL names inside the block ("projection",
    "lights[0].position"). The lab lays them out by the std140 rules.

    It is one buffer on the device, wherever it is used: give the same object to several draws,
    and their programs share it.
    """

    values: Mapping[str, Uniform]

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", flatten_structures(self.values))


@dataclass(frozen=True, kw_only=True)
class Draw(Checked):
    """One draw call or dispatch: a program, what it draws, and all that is bound while it does.

    Either `vertex` and `mesh` are given (with `geometry`, or with both tessellation stages and a
    mesh of patches), or `domain` (the fragment shader's inputs laid over the
    whole target; the vertex stage is then made by the lab), or for a dispatch `compute`, `groups`,
    `buffers` and `images`, as in `compute`, and no other shader. Uniforms are keyed as GLSL spells
    them: "model", "light.constant", "weights", "lights[0].position"; structures may be given as
    mappings of their members, arrays of them as lists of such mappings. Matrices are given as
    mathematics writes them, rows first; the lab transposes for GLSL. `blocks` are uniform blocks
    by the name that GLSL gives the block itself.
    """

    fragment: str = ""
    vertex: str | None = None
    geometry: str | None = None
    tess_control: str | None = None
    tess_evaluation: str | None = None
    mesh: Mesh | None = None
    domain: Mapping[str, Ramp] | None = None
    uniforms: Mapping[str, Uniform] = field(default_factory=dict)
    textures: Mapping[str, TextureSource] = field(default_factory=dict)
    blocks: Mapping[str, UniformBuffer] = field(default_factory=dict)
    state: State = field(default_factory=State)
    instances: int = 1
    vertex_array: bool = True
    compute: str = ""
    groups: tuple[int, int, int] = (1, 1, 1)
    buffers: Mapping[str, BufferValue] = field(default_factory=dict)
    images: Mapping[str, ImageValue] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "uniforms", flatten_structures(self.uniforms))
        if self.compute:
            self._check_dispatch()
            return
        if not self.fragment:
            raise CaseError("Draw: give a fragment shader, or a compute shader (compute=…)")
        if self.buffers or self.images or self.groups != (1, 1, 1):
            raise CaseError(
                f"Draw of {self.fragment}: groups=, buffers= and images= belong to a compute "
                "shader",
                remedy="Draw(compute=…, groups=…, buffers=…, images=…), or shaderlab.compute",
            )
        if (self.domain is None) == (self.mesh is None):
            raise CaseError(
                f"Draw of {self.fragment}: give either a mesh (with a vertex shader) or a domain"
            )
        if self.mesh is not None and self.vertex is None:
            raise CaseError(f"Draw of {self.fragment}: a mesh needs a vertex shader (vertex=…)")
        if (self.tess_control is None) != (self.tess_evaluation is None):
            raise CaseError(
                f"Draw of {self.fragment}: tessellation takes both stages",
                remedy="give tess_control= and tess_evaluation=",
            )
        if self.domain is not None and (self.vertex or self.geometry or self.tess_control):
            raise CaseError(
                f"Draw of {self.fragment}: over a domain the vertex stage is the lab's; "
                "drop all stages but the fragment shader, or draw a mesh"
            )
        given = self.mesh.instances if self.mesh is not None else None
        if given not in (None, self.instances):
            raise CaseError(
                f"Draw of {self.fragment}: the mesh has attributes for {given} instances, "
                f"{self.instances} are drawn",
                remedy=f"draw instances={given}",
            )

    def _check_dispatch(self) -> None:
        others = (*self.shaders[:-1], self.mesh, self.domain)
        if any(others) or self.state != State() or self.instances != 1:
            raise CaseError(
                f"Draw of {self.compute}: a compute shader is a whole program; it has no "
                "other stage, mesh, domain, state or instances"
            )
        if min(self.groups) < 1:
            raise CaseError(f"Draw of {self.compute}: {self.groups} groups compute nothing")

    @property
    def shaders(self) -> tuple[str, ...]:
        """The shader files this draw names, in pipeline order."""
        before = (self.vertex, self.tess_control, self.tess_evaluation, self.geometry)
        return tuple(s for s in (*before, self.fragment, self.compute) if s)

    def outputs_read(self) -> Iterator[Output]:
        """The outputs of earlier passes that it reads as textures, in buffers and in images."""
        given = (self.textures, self.buffers, self.images)
        for source in (value for mapping in given for value in mapping.values()):
            yield from outputs_read(source)


@dataclass(frozen=True, kw_only=True)
class Target(Checked):
    """What a pass draws into.

    `colors` are formats by output name; None gives each of the fragment shader's outputs a
    32-bit float (or integer) attachment of its own. `size` is (width, height) in pixels; None is
    the size the case is judged at (64 × 64) and, once more, the size its picture is drawn at.
    `clear` is the value every colour attachment starts from. `depth_storage` is where depth and
    stencil are kept: in a "texture", which later passes can sample, or in a "renderbuffer", which
    can only be drawn with; of several samples a pixel it is a renderbuffer in any case.
    """

    size: tuple[int, int] | None = None
    colors: Mapping[str, str] | None = None
    depth: str | None = None
    depth_storage: str = "texture"
    samples: int = 0
    clear: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    clear_depth: float = 1.0
    clear_stencil: int = 0

    def __post_init__(self) -> None:
        for name, word in (self.colors or {}).items():
            check_choice(f"Target: color {name!r}", "format", word, COLOR_FORMATS)
        if self.depth is not None:
            check_choice("Target", "depth", self.depth, DEPTH_FORMATS)
        check_choice("Target", "depth_storage", self.depth_storage, ("texture", "renderbuffer"))
        if self.size is not None and not all(0 < n <= 16384 for n in self.size):
            raise CaseError(f"Target: size must lie in 1…16384, not {self.size}")


@dataclass(frozen=True, kw_only=True)
class Pass(Checked):
    """A target and the draws into it, in order.

    With `onto` the name of an earlier pass, they continue where that one stopped, in the same
    target, which is not cleared; `target` must then be the same. What the earlier pass drew is read
    as the later one's output from then on.
    """

    name: str = "main"
    target: Target = field(default_factory=Target)
    draws: tuple[Draw, ...]
    onto: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "draws", tuple(self.draws))
        if not self.draws:
            raise CaseError(f"Pass {self.name!r} draws nothing")
        alone = len(self.draws) == 1 and self.target == Target() and not self.onto
        if any(draw.compute for draw in self.draws) and not alone:
            raise CaseError(
                f"Pass {self.name!r}: a dispatch is the only draw of its pass, and has no target",
                remedy="one pass for each; a later one reads Output('pass.name')",
            )
        if self.onto and (self.target.depth or self.target.samples):
            raise CaseError(
                f"Pass {self.name!r} continues in the target of {self.onto!r}, which has "
                "depth, stencil or samples: its draws could not be captured alone",
                remedy="draw all of it in one pass",
            )
        for index, draw in enumerate(self.draws):
            if draw.state.in_pixels and self.target.size is None:
                raise CaseError(
                    f"Pass {self.name!r}: draw {index} has a {draw.state.in_pixels} in pixels, "
                    "but its target has no size",
                    remedy="Target(size=(width, height)), or Cell(…), which fits every size",
                )

    @property
    def computes(self) -> bool:
        """Whether it is a dispatch, which draws nothing."""
        return bool(self.draws[0].compute)


def flatten_structures(values: Mapping[str, Any]) -> Mapping[str, Any]:
    """Each value under its name in GLSL; the very same mapping if no value is of a structure.

    >>> flatten_structures({"light": {"linear": 0.09}, "lamps": [{"on": True}, {"on": False}]})
    {'light.linear': 0.09, 'lamps[0].on': True, 'lamps[1].on': False}
    """
    if any(_structured(value) for value in values.values()):
        return {
            name: value for own, given in values.items() for name, value in _members(own, given)
        }
    return values


def _structured(value: Any) -> bool:
    first = value[0] if isinstance(value, list | tuple) and value else value
    return isinstance(first, Mapping)


def _members(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    if not _structured(value):
        yield name, value
    elif isinstance(value, Mapping):
        for member, its in value.items():
            yield from _members(f"{name}.{member}", its)
    else:
        for n, element in enumerate(value):
            yield from _members(f"{name}[{n}]", element)


def fullscreen(
    fragment: str,
    *,
    domain: Mapping[str, Ramp] | None = None,
    uniforms: Mapping[str, Uniform] | None = None,
    textures: Mapping[str, TextureSource] | None = None,
    blocks: Mapping[str, UniformBuffer] | None = None,
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
        **_present(uniforms=uniforms, textures=textures, blocks=blocks, state=state),
    )
    return (Pass(name=name, draws=(draw,), **_present(target=target)),)


def mesh_pass(
    vertex: str,
    fragment: str,
    mesh: Mesh,
    *,
    geometry: str | None = None,
    tess_control: str | None = None,
    tess_evaluation: str | None = None,
    uniforms: Mapping[str, Uniform] | None = None,
    textures: Mapping[str, TextureSource] | None = None,
    blocks: Mapping[str, UniformBuffer] | None = None,
    target: Target | None = None,
    state: State | None = None,
    instances: int = 1,
    name: str = "main",
) -> tuple[Pass, ...]:
    """One pass that draws one mesh with one program."""
    draw = Draw(
        vertex=vertex,
        geometry=geometry,
        tess_control=tess_control,
        tess_evaluation=tess_evaluation,
        fragment=fragment,
        mesh=mesh,
        instances=instances,
        **_present(uniforms=uniforms, textures=textures, blocks=blocks, state=state),
    )
    return (Pass(name=name, draws=(draw,), **_present(target=target)),)


def compute(
    shader: str,
    *,
    groups: tuple[int, int, int],
    buffers: Mapping[str, BufferValue] | None = None,
    images: Mapping[str, ImageValue] | None = None,
    uniforms: Mapping[str, Uniform] | None = None,
    textures: Mapping[str, TextureSource] | None = None,
    blocks: Mapping[str, UniformBuffer] | None = None,
    name: str = "main",
) -> tuple[Pass, ...]:
    """One pass that runs a compute shader once.

    Each member of its storage blocks that is not `readonly` is an output, called by its name: an
    image of one row that has a pixel for each element. So is each of its images.

    Args:
        shader: the compute shader.
        groups: how many work groups are dispatched in x, y and z.
        buffers: what the members of storage blocks hold before, by the names that GLSL gives them,
            with the block's before it where two blocks share one ("Block.values"). Arrays have
            shape (length, components); one of run-time length is as long as what is given. An
            `Output` is what an earlier pass left.
        images: what each `image2D` holds before, by its name: an array (height, width, components)
            whose row 0 is the bottom one, a function that makes one, a file's path, or an `Output`.
            An `image2DArray` or `image3D` takes (layers, height, width, components). Its format is
            the one that the shader's layout names.
        uniforms, textures, blocks, name: as in `Draw` and `Pass`.
    """
    draw = Draw(
        compute=shader,
        groups=groups,
        **_present(buffers=buffers, images=images),
        **_present(uniforms=uniforms, textures=textures, blocks=blocks),
    )
    return (Pass(name=name, draws=(draw,)),)


def _present(**arguments: Any) -> dict[str, Any]:
    return {name: value for name, value in arguments.items() if value is not None}
