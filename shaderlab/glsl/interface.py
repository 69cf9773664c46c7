"""What a program declares, as plain data, under the names that a driver reports.

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
        name: GLSL's name of it.
        type: "float", "vec3", "mat4", "int", "uint", "bool", "sampler2D", "image2D", …
        location: as in the module. Where the author gives none, the compiler chooses one, and
            a driver that is given GLSL may choose another.
        array: how many elements, 0 for a run-time length, None where it is not an array.
        interpolation: of varyings.
        components: numbers in one element, 3 for vec3, 16 for mat4, 0 for samplers.
        used: whether a function that the program calls refers to it; a driver may still find
            that it changes nothing and remove it.
    """

    name: str
    type: str
    location: int | None = None
    array: int | None = None
    interpolation: Interpolation = "smooth"
    components: int = 0
    used: bool = False


@dataclass(frozen=True, kw_only=True)
class Member:
    """One member of a block; sizes, strides and `offset` in bytes, strides 0 where none apply.

    `size` covers all elements of an array; it is 0 for an array of run-time length.
    """

    name: str
    type: str
    offset: int
    size: int
    array: int | None = None
    array_stride: int = 0
    matrix_stride: int = 0
    row_major: bool = False


@dataclass(frozen=True, kw_only=True)
class Block:
    """A uniform or storage block: members by GLSL name less the block's own.

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
    """Everything a program declares, built-ins (`gl_…`) left out. All mappings are by name.

    Attributes:
        attributes: inputs of the vertex stage.
        varyings: inputs of the fragment stage.
        vertex_outputs: outputs of the last stage before rasterisation.
        outputs: outputs of the fragment stage.
        uniforms: uniforms outside blocks, samplers and images among them.
        blocks: uniform and storage blocks.
        constants: specialisation constants.
        local_size: of a compute stage, else None.
    """

    attributes: Mapping[str, Variable] = field(default_factory=dict)
    varyings: Mapping[str, Variable] = field(default_factory=dict)
    vertex_outputs: Mapping[str, Variable] = field(default_factory=dict)
    outputs: Mapping[str, Variable] = field(default_factory=dict)
    uniforms: Mapping[str, Variable] = field(default_factory=dict)
    blocks: Mapping[str, Block] = field(default_factory=dict)
    constants: Mapping[str, SpecConstant] = field(default_factory=dict)
    local_size: tuple[int, int, int] | None = None
