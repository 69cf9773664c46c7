"""A program's interface as plain data, with the names that a driver reports.

"light.constant", "lights[0].position", "weights" for a whole array, "Block.member" for members
of a varying block with an instance name.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Interpolation = Literal["smooth", "flat", "noperspective"]


@dataclass(frozen=True, kw_only=True)
class Variable:
    """One input, output or uniform.

    Attributes:
        name: in GLSL.
        type: "float", "vec3", "mat4", "int", "uint", "bool", "sampler2D", "image2D", …
        location: in the module. Without the author's own, the compiler chooses one, and a driver
            that compiles GLSL may choose another.
        array: the number of elements, 0 if known at run time only, None if it is not an array.
        interpolation: of varyings.
        components: numbers in one element: 3 for vec3, 16 for mat4, 0 for samplers.
        used: whether the program's functions refer to it; a driver may still optimise it away.
        format: of an image, as its layout says ("rgba8"); "" for none.
        readonly: what GLSL says of an image.
        patch: of an evaluation stage's input, whether there is one for the whole patch.
    """

    name: str
    type: str
    location: int | None = None
    array: int | None = None
    interpolation: Interpolation = "smooth"
    components: int = 0
    used: bool = False
    format: str = ""
    readonly: bool = False
    patch: bool = False


@dataclass(frozen=True, kw_only=True)
class Member:
    """One member of a block. Sizes, strides and `offset` are in bytes; strides that don't apply
    are 0. `size` covers all elements of an array, and is 0 for an array of run-time length.

    `record_stride` is that of the array of structs of run-time length that the member lies in; it
    is described for the first of them ("particles[0].position"). `readonly` is what GLSL says of
    members of storage blocks.
    """

    name: str
    type: str
    offset: int
    size: int
    array: int | None = None
    array_stride: int = 0
    matrix_stride: int = 0
    row_major: bool = False
    record_stride: int = 0
    readonly: bool = False


@dataclass(frozen=True, kw_only=True)
class Block:
    """A uniform or storage block: members by their names without the block's.

    `size` is in bytes, rounded up to 16 for uniform blocks as std140 has it; for a storage
    block that ends in an array of run-time length it is the size without that array.
    """

    name: str
    kind: Literal["uniform", "storage"]
    members: Mapping[str, Member]
    size: int
    binding: int | None = None
    array: int | None = None
    instance: str = ""
    used: bool = False


@dataclass(frozen=True, kw_only=True)
class SpecConstant:
    """A specialisation constant: GLSL's name and type, its `constant_id`, its default value."""

    name: str
    type: str
    constant_id: int
    default: int | float | bool


@dataclass(frozen=True, kw_only=True)
class Interface:
    """Everything that a program declares, by name, without built-ins (`gl_…`).

    Attributes:
        attributes: inputs of the vertex stage.
        varyings: inputs of the fragment stage.
        vertex_outputs: outputs of the last stage before rasterisation.
        evaluation_inputs: inputs of the tessellation evaluation stage, by a patch's vertices.
        patch_vertices: of the patches that the tessellation control stage makes; 0 without one.
        outputs: outputs of the fragment stage.
        uniforms: uniforms outside blocks, samplers and images among them.
        blocks: uniform and storage blocks.
        constants: specialisation constants.
        local_size: of a compute stage, or None.
    """

    attributes: Mapping[str, Variable] = field(default_factory=dict)
    varyings: Mapping[str, Variable] = field(default_factory=dict)
    vertex_outputs: Mapping[str, Variable] = field(default_factory=dict)
    evaluation_inputs: Mapping[str, Variable] = field(default_factory=dict)
    patch_vertices: int = 0
    outputs: Mapping[str, Variable] = field(default_factory=dict)
    uniforms: Mapping[str, Variable] = field(default_factory=dict)
    blocks: Mapping[str, Block] = field(default_factory=dict)
    constants: Mapping[str, SpecConstant] = field(default_factory=dict)
    local_size: tuple[int, int, int] | None = None
