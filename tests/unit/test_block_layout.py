"""Where the members of uniform and storage blocks lie, held against figures by the rules.

Source: The OpenGL Graphics System: A Specification (version 4.5 core profile), M. Segal and
K. Akeley, 2017, §7.6.2.2, "Standard uniform block layout", rules 1 to 10.
"""

from __future__ import annotations

from itertools import pairwise

import pytest

from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.reflection import Block


def block(members: str, declared: str = "layout (std140) uniform", structs: str = "") -> Block:
    text = f"#version 430 core\n{structs}\n{declared} Block {{ {members} }};\n"
    text += "out vec4 color;\nvoid main() { color = vec4(1.0); }\n"
    source = Shaders([]).from_text(text, "fragment", "<block>")
    compiled = compile_program((source,), ("glsl", "opengl"))
    compiled.require()
    assert compiled.interface is not None
    return compiled.interface.blocks["Block"]


LIGHT = "struct Light { vec3 place; bool on; float gain; };"
STD140 = [
    ("mat4 projection; mat4 view;", [0, 64], 128),
    ("float a; vec3 b; float c;", [0, 16, 28], 32),
    ("float a[3]; vec2 b;", [0, 48], 64),
    ("mat2x3 m; float after;", [0, 32], 48),
    ("layout (row_major) mat2x3 m; float after;", [0, 48], 64),
    ("float first; Light lights[2]; float last;", [0, 16, 28, 32, 48, 60, 64, 80], 96),
    ("float a; dvec3 b; double c;", [0, 32, 56], 64),
    ("vec2 a[2][3]; float b;", [0, 48, 96], 112),
]


@pytest.mark.parametrize(("members", "offsets", "size"), STD140)
def test_uniform_blocks_are_laid_out_by_std140(members: str, offsets: list[int], size: int) -> None:
    found = block(members, structs=LIGHT)
    assert [member.offset for member in found.members.values()] == offsets
    assert found.size == size


def test_arrays_are_padded_in_std140_and_tight_in_std430() -> None:
    tight = block("float a[3]; vec2 b; mat2 c;", "layout (std430) buffer").members
    assert [member.offset for member in tight.values()] == [0, 16, 24]
    assert (tight["a"].array_stride, tight["c"].matrix_stride) == (4, 8)
    assert block("float a[3];").members["a"].array_stride == 16


@pytest.mark.parametrize("declared", ["layout (std140) uniform", "layout (std430) buffer"])
def test_members_never_overlap(declared: str) -> None:
    structs = "struct Inner { vec3 a[2]; float b; mat3 c; };"
    members = block("float x; Inner y[3]; vec2 z; mat4x3 w;", declared, structs).members.values()
    taken = sorted((member.offset, member.offset + member.size) for member in members)
    assert all(end <= start for (_, end), (start, _) in pairwise(taken))
