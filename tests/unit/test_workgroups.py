"""Compute stages whose invocations share variables or write images: audited and interpreted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from shaderlab.analysis.audit import audit_program
from shaderlab.analysis.comparison import compare_programs
from shaderlab.analysis.hazards import Plan
from shaderlab.analysis.interpreter import FLOAT32, Bands, Program, interpret, load
from shaderlab.analysis.interpreter.values import number_invocations
from shaderlab.compiler import Shaders
from shaderlab.errors import NotInterpretedError

# Sums of neighbours in a workgroup, whose mean is left in a buffer.
SHARED = """#version 430 core
layout (local_size_x = 16, local_size_y = 2) in;
layout (std430) readonly buffer In { float values[32]; };
layout (std430) buffer Out { float sums[32]; };
uniform int count;
uniform float scale;
struct Cell { vec2 pair; int tag; bool used; };
shared Cell cells[32];
shared float total;
void main()
{
    uint own = gl_LocalInvocationIndex;
    cells[own] = Cell(vec2(values[own], 1.0), int(own), true);
    barrier();
    float sum = cells[own].pair.x + cells[own ^ 1u].pair.x * cells[own ^ 1u].pair.y;
    barrier();
    if (own == 3u) total = sum;
    barrier();
    sums[own] = scale * total + sum;
}
"""
IMAGE = """#version 430 core
layout (local_size_x = 4, local_size_y = 4) in;
layout (r32f) readonly uniform image2D before;
layout (rgba32f) writeonly uniform image2D after;
layout (r32ui) uniform uimage2D counts;
uniform float scale;
void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    vec4 here = imageLoad(before, p);
    uint n = imageLoad(counts, p).r;
    imageStore(counts, p, uvec4(n + 1u));
    imageStore(after, p, scale * here);
}
"""
RACE, DIVERGENT = "data race", "barrier in divergent control flow"
UNINITIALISED = "uninitialised read"
FEW = Plan(count=256)


def program(text: str) -> Program:
    return load(Shaders([Path()], overrides={"a.glsl": text}).load("a.glsl", "compute"))


def line_of(text: str, piece: str) -> int:
    return text[: text.index(piece)].count("\n") + 1


@pytest.mark.parametrize("text", [SHARED, IMAGE])
def test_what_is_right_is_clean(text: str) -> None:
    assert audit_program(program(text)).hazards == ()


@pytest.mark.parametrize(
    ("right", "wrong", "kind"),
    [
        # No barrier between what one writes and another reads, in either order.
        ("    barrier();\n    float sum", "    float sum", RACE),
        ("    barrier();\n    if (own", "    cells[own].pair.x = 0.5 * scale;\n    if (own", RACE),
        ("    barrier();\n    sums", "    sums", RACE),
        # Several write one element, or what each of them writes goes on to the next round.
        ("if (own == 3u) total", "if (own > 3u) total", RACE),
        ("pair.x + cells[own ^ 1u]", "pair.x; cells[0].tag = int(own); sum += cells[own]", RACE),
        # Not all come to a barrier: some return, or go another way.
        ("    barrier();\n    float", "    if (own > 9u) return;\n    barrier();\n    float",
         DIVERGENT),
        ("    barrier();\n    if", "    if (values[own] > 0.5) barrier();\n    if", DIVERGENT),
        ("    barrier();\n    if", "    for (uint k = 0u; k < own; k += 8u) barrier();\n    if",
         DIVERGENT),
        # Nobody writes what is read.
        ("if (own == 3u) total = sum;", "", UNINITIALISED),
        ("cells[own] = Cell(vec2(values[own], 1.0), int(own), true);", "cells[own].tag = 1;",
         UNINITIALISED),
        # What others computed goes wrong, and what depends on it.
        ("scale * total", "scale / (cells[own / 2u].pair.y - 1.0)", "division by 0"),
        ("+ sum;\n}", "+ sqrt(cells[own ^ 2u].pair.x - 0.5);\n}", "sqrt of a negative number"),
        ("+ sum;\n}", "+ log(float(cells[own ^ 2u].tag));\n}", "log of 0 or less"),
        ("cells[own ^ 1u].pair.x * ", "cells[own + 1u].pair.x * ", "index out of range"),
    ],
)  # fmt: skip
def test_hazards_between_invocations_are_found(right: str, wrong: str, kind: str) -> None:
    assert SHARED.count(right) == 1
    hazards = audit_program(program(SHARED.replace(right, wrong)), FEW).hazards
    assert kind in [hazard.kind for hazard in hazards], hazards


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("if (own == 3u) total = sum;", "if (own > 3u) total = scale;"),  # all the same number
        ("    if (own == 3u)", "    if (count > 2) { barrier(); }\n    if (own == 3u)"),  # uniform
        ("    float sum", "    for (int k = 0; k < count % 3; ++k) barrier();\n    float sum"),
        ("    float sum", "    cells[own].tag = 4;\n    float sum"),  # another part of an element
        ("own), true);", "own), true);\n    cells[own].pair.x += scale;"),  # its own
        ("scale * total", "scale / (total * total + 1.0)"),
        ("+ sum;\n}", "+ log(1.0 + float(cells[own ^ 2u].tag));\n}"),
    ],
)  # fmt: skip
def test_what_is_guarded_does_not_alarm(right: str, wrong: str) -> None:
    assert SHARED.count(right) == 1
    assert audit_program(program(SHARED.replace(right, wrong)), FEW).hazards == ()


@pytest.mark.parametrize(
    ("right", "wrong", "kind"),
    [
        ("scale * here", "scale / here", "division by 0"),
        ("scale * here", "vec4(sqrt(here.r - 0.9))", "sqrt of a negative number"),
        ("scale * here", "vec4(log(here.g))", "log of 0 or less"),  # r32f has no green
        ("uvec4(n + 1u)", "uvec4(12u / n)", "integer division by 0"),
        ("after, p, scale * here", "after, ivec2(p.x / int(n), 0), here", "integer division by 0"),
        ("scale * here", "vec4(1.0 / float(imageSize(counts).x % 8))", "division by 0"),
    ],
)
def test_hazards_behind_images_are_found(right: str, wrong: str, kind: str) -> None:
    assert IMAGE.count(right) == 1
    hazards = audit_program(program(IMAGE.replace(right, wrong)), FEW).hazards
    assert kind in [hazard.kind for hazard in hazards], hazards


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("scale * here", "scale / (here * here + 1.0)"),
        ("scale * here", "vec4(1.0 / here.a)"),  # alpha is 1, and 0 outside of the image
        ("scale * here", "vec4(0.0, 0.0, 0.0, here.g)"),
        ("uvec4(n + 1u)", "uvec4(1u, 1u / n, 0u, 0u)"),  # r32ui keeps no green
    ],
)
def test_what_images_guard_does_not_alarm(right: str, wrong: str) -> None:
    inside = (
        "if (any(greaterThanEqual(ivec2(gl_GlobalInvocationID.xy), imageSize(before)))) return;"
    )
    text = IMAGE.replace(right, wrong).replace("    ivec2 p", f"    {inside}\n    ivec2 p")
    assert audit_program(program(text)).hazards == ()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (IMAGE.replace("imageStore(after, p, scale * here)", "n = imageLoad(counts, p).r"),
         "imageLoad of counts, in which texels are stored before, at line 13"),
        (IMAGE.replace("uvec4(n + 1u))", "uvec4(imageAtomicAdd(counts, p, 1u)))"),
         "SPIR-V's ImageTexelPointer at line 12"),
        (IMAGE.replace("r32f) readonly uniform image2D", "r32f) readonly uniform imageCube")
         .replace("before, p", "before, ivec3(p, 0)"), "imageCube before"),
        (SHARED.replace("sums[own] =", "sums[own] = 1.0; barrier(); sum = sums[own]; sums[own] ="),
         "Out, which others may have changed"),
        (SHARED.replace("bool used;", "bool used; double more;").replace("true)", "true, 1.0lf)"),
         "double"),
    ],
)  # fmt: skip
def test_what_depends_on_other_invocations_is_refused(text: str, said: str) -> None:
    with pytest.raises(NotInterpretedError) as error:
        audit_program(program(text))
    assert f"not interpreted: {said}" in str(error.value)


def test_a_part_of_a_workgroup_is_refused() -> None:
    own = program(SHARED)
    with pytest.raises(NotInterpretedError, match="cells, total, which a workgroup shares"):
        compare_programs(own, own)
    each = number_invocations(own.local_size, np.zeros((16, 3), int), np.zeros((16, 3), int))
    for arithmetic in (FLOAT32, Bands()):
        with pytest.raises(NotInterpretedError, match="which a workgroup shares"):
            interpret(own, each, arithmetic=arithmetic)


def test_programs_that_write_images_are_compared() -> None:
    right, wrong = program(IMAGE), program(IMAGE.replace("scale * here", "scale * here * 1.01"))
    moved = program(IMAGE.replace("after, p,", "after, p.yx,"))
    assert compare_programs(right, program(IMAGE.replace("scale * here", "here * scale"))).same
    assert compare_programs(right, wrong).same is False
    assert compare_programs(right, moved).same is False


def test_what_others_may_have_stored_is_anything_in_a_proof() -> None:
    text = "#version 430 core\nlayout (local_size_x = 4) in;\nshared int n;\n"
    text += "buffer Out { float a[4]; };\nvoid main() { uint own = gl_LocalInvocationIndex;\n"
    text += "n = 1;\nbarrier();\na[own] = 1.0 / float(n);\na[own] += 1.0 / float(own + 1u); }\n"
    claims = audit_program(program(text), Plan(prove=True, count=64)).claims
    divided = {c.line: c.status for c in claims if c.what == "no division by 0"}
    assert divided == {8: "open", 9: "proved"}


def test_what_an_image_holds_that_nothing_writes_is_proved() -> None:
    divides = "uvec4(12u / (n + 1u)))", "scale / (here * here + 1.0)"
    text = IMAGE.replace("uvec4(n + 1u))", divides[0]).replace("scale * here", divides[1])
    claims = audit_program(program(text), Plan(prove=True, count=64)).claims
    divided = {c.what: c.status for c in claims if c.what.endswith("division by 0")}
    assert divided == {"no division by 0": "proved", "no integer division by 0": "open"}
