"""The std140 and std430 rules against figures from the specification, and against glslang's own."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

from shaderlab.evaluation.search_path import shaders_of
from shaderlab.glsl.compile import compile_program
from shaderlab.glsl.layout import Field, declared, layout


def offsets(*fields: Field, rules: str = "std140") -> list[int]:
    return [slot.offset for slot in layout(fields, rules).slots.values()]  # type: ignore[arg-type]


def field(name: str, type_: str | tuple[Field, ...], *array: int, row_major: bool = False) -> Field:
    return Field(name=name, type=type_, array=array, row_major=row_major)


def test_two_matrices_lie_at_0_and_64() -> None:
    two = (field("projection", "mat4"), field("view", "mat4"))
    assert offsets(*two) == [0, 64]
    assert layout(two).size == 128


def test_a_vec3_is_aligned_like_a_vec4_and_a_float_fits_behind_it() -> None:
    assert offsets(field("a", "float"), field("b", "vec3"), field("c", "float")) == [0, 16, 28]


def test_arrays_are_padded_in_std140_and_tight_in_std430() -> None:
    fields = (field("a", "float", 3), field("b", "vec2"))
    assert offsets(*fields) == [0, 48]
    assert offsets(*fields, rules="std430") == [0, 16]
    assert layout(fields).slots["a"].array_stride == 16
    assert layout(fields, "std430").slots["a"].array_stride == 4


def test_matrices_are_arrays_of_their_columns_or_rows() -> None:
    by_columns = layout([field("m", "mat2x3"), field("after", "float")])
    assert (by_columns.slots["m"].size, by_columns.slots["after"].offset) == (32, 32)
    by_rows = layout([field("m", "mat2x3", row_major=True), field("after", "float")])
    assert (by_rows.slots["m"].size, by_rows.slots["after"].offset) == (48, 48)
    assert layout([field("m", "mat2")], "std430").slots["m"].matrix_stride == 8


def test_structs_are_rounded_up_to_a_vec4_in_std140() -> None:
    light = (field("place", "vec3"), field("on", "bool"), field("gain", "float"))
    fields = (field("first", "float"), field("lights", light, 2), field("last", "float"))
    found = layout(fields).slots
    assert list(found) == [
        "first",
        *(f"lights[{i}].{name}" for i in (0, 1) for name in ("place", "on", "gain")),
        "last",
    ]
    assert [slot.offset for slot in found.values()] == [0, 16, 28, 32, 48, 60, 64, 80]


def test_doubles_take_twice_the_space() -> None:
    assert offsets(field("a", "float"), field("b", "dvec3"), field("c", "double")) == [0, 32, 56]


def test_arrays_of_arrays_have_a_slot_for_each_inner_one() -> None:
    found = layout([field("a", "vec2", 2, 3), field("b", "float")]).slots
    assert {n: s.offset for n, s in found.items()} == {"a[0]": 0, "a[1]": 48, "b": 96}


def test_an_empty_block_takes_nothing() -> None:
    assert layout([]).size == 0


BASIC = [
    "float",
    "vec2",
    "vec3",
    "vec4",
    "int",
    "uvec2",
    "mat2",
    "mat3",
    "mat4",
    "mat2x4",
    "mat4x3",
]


@st.composite
def declarations(draw: st.DrawFn) -> tuple[str, str]:
    """A struct's and a block's bodies."""

    def body(letter: str, types: list[str], may_turn: bool) -> str:
        lines = []
        for index in range(draw(st.integers(1, 5))):
            kind = draw(st.sampled_from(types))
            matrix = may_turn and "mat" in kind and draw(st.booleans())
            sizes = draw(st.sampled_from(["", "", "[1]", "[3]"]))
            major = "layout (row_major) " if matrix else ""
            lines.append(f"    {major}{kind} {letter}{index}{sizes};")
        return "\n".join(lines)

    return body("s", BASIC, False), body("m", [*BASIC, "Inner"], True)


@settings(max_examples=60)
@given(declarations())
def test_glslang_lays_out_every_block_the_same(bodies: tuple[str, str]) -> None:
    struct, block = bodies
    text = f"#version 330 core\nstruct Inner {{\n{struct}\n}};\n"
    text += f"layout (std140) uniform Block {{\n{block}\n}} one;\nout vec4 color;\n"
    text += "void main() { color = vec4(1.0); }\n"
    source = shaders_of(Path(), {}).from_text(text, "fragment", "<block>")
    interface = compile_program((source,), ("glsl", "opengl")).interface
    assert interface is not None
    theirs = interface.blocks["Block"]
    ours = layout(declared(theirs.members.values()))
    assert list(ours.slots) == list(theirs.members)
    for name, member in theirs.members.items():
        slot = ours.slots[name]
        assert slot.offset == member.offset, (name, text)
        assert slot.size == member.size, (name, text)
        assert slot.array_stride == member.array_stride, (name, text)
        assert slot.matrix_stride == member.matrix_stride, (name, text)
    assert ours.size == theirs.size


@pytest.mark.parametrize("rules", ["std140", "std430"])
def test_members_never_overlap(rules: str) -> None:
    inner = (field("a", "vec3", 2), field("b", "float"), field("c", "mat3"))
    fields = (field("x", "float"), field("y", inner, 3), field("z", "vec2"), field("w", "mat4x3"))
    taken = sorted((s.offset, s.offset + s.size) for s in layout(fields, rules).slots.values())  # type: ignore[arg-type]
    assert all(end <= start for (_, end), (start, _) in pairwise(taken))
