"""Geometry and compute stages: interpreted, compared and audited; what is not is named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.auditing import STAGES, Planted, audit_of, is_found, planted
from shaderlab.analysis.answer import Answer
from shaderlab.analysis.audit import Audit, audit_program
from shaderlab.analysis.comparison import compare_programs
from shaderlab.analysis.interpreter import FLOAT64, Bands, Program, interpret, load
from shaderlab.analysis.requests import AuditCase
from shaderlab.compiler import Shaders
from shaderlab.errors import NotInterpretedError

STRIP = """#version 330 core
layout (triangles) in;
layout (triangle_strip, max_vertices = 6) out;
in vec4 corner[];
uniform int n; // range: 0..3
out float shade;
void main()
{
    for (int i = 0; i < n; ++i) {
        gl_Position = corner[i];
        shade = float(i) * 0.5;
        EmitVertex();
        if (i == 1) EndPrimitive();
    }
}
"""
BUFFER = """#version 430 core
layout (local_size_x = 8, local_size_y = 2) in;
layout (std430) buffer Data { float data[]; };
void main()
{
    float taken = data[gl_GlobalInvocationID.x];
    data[gl_GlobalInvocationID.x] = taken > 2.0 ? taken / taken : 0.0;
}
"""
SHARING = """#version 430 core
layout (local_size_x = 8) in;
layout (std430) buffer Data { float data[]; };
shared float sums[8];
void main()
{
    sums[gl_LocalInvocationIndex] = data[gl_GlobalInvocationID.x];
    barrier();
    data[gl_GlobalInvocationID.x] = sums[7u - gl_LocalInvocationIndex];
}
"""


def program(text: str, stage: str) -> Program:
    return load(Shaders([Path()], overrides={"a.glsl": text}).load("a.glsl", stage))


def some(stage: str) -> list[Planted]:
    """Some hazards that are a stage's own, and of those that it shares with others one of each kind
    in compute stages, of uninitialised values in all."""
    known: dict[tuple[str, bool], list[Planted]] = {}
    for one in planted(stage):
        if one.own or stage == "compute" or one.kind == "uninitialised read":
            known.setdefault((one.kind, one.own), []).append(one)
    return [one for (_, own), ones in known.items() for one in ones[: 4 if own else 1]]


@pytest.mark.parametrize("stage", STAGES[1:])
def test_hazards_of_each_stage_are_found_at_their_lines(stage: str) -> None:
    missed = [one for one in some(stage) if not is_found(one, audit_of(one))]
    assert not missed


@pytest.mark.parametrize(
    ("stage", "text"),
    [("geometry", STRIP), ("compute", BUFFER)],
)
def test_what_is_right_is_clean(stage: str, text: str) -> None:
    assert audit_program(program(text, stage)).hazards == ()


def test_vertices_are_what_was_emitted() -> None:
    corner = np.arange(36, dtype=np.float32).reshape(3, 3, 4)
    result = interpret(
        program(STRIP, "geometry"),
        {**{f"corner[{i}]": corner[:, i] for i in range(3)}, "n": np.array([[0], [2], [3]])},
        arithmetic=FLOAT64,
    )
    outputs: Any = result.outputs
    assert outputs["EmitVertex()"].lo.ravel().tolist() == [0, 2, 3]
    positions = [vertex.tolist() for vertex in outputs["gl_Position"]]
    assert positions[0] == [[0.0] * 4, *corner[1:, 0].tolist()]
    assert positions[2] == [[0.0] * 4, [0.0] * 4, corner[2, 2].tolist()]
    assert outputs["shade"][1].ravel().tolist() == [0.0, 0.5, 0.5]
    assert [strip.lo.ravel().tolist() for strip in outputs["EndPrimitive()"]] == [
        [0, 0, 0], [0, 0, 0], [0, 0, 1]
    ]  # fmt: skip


def test_what_is_behind_an_open_branch_is_not_emitted() -> None:
    text = STRIP.replace("i < n", "sin(corner[0].x) < 0.5 && i < 3")
    each = {f"corner[{i}]": np.full((1, 4), np.pi / 6, np.float32) for i in range(3)}
    with pytest.raises(NotInterpretedError, match="EmitVertex behind an open branch"):
        interpret(program(text, "geometry"), each, arithmetic=Bands())


def compared(stage: str, text: str, *pieces: str) -> Answer:
    return compare_programs(program(text, stage), program(text.replace(*pieces), stage))


@pytest.mark.parametrize(
    ("stage", "text", "piece", "other", "same"),
    [
        ("geometry", STRIP, "float(i) * 0.5", "0.5 * float(i)", True),
        ("geometry", STRIP, "float(i) * 0.5", "0.25 * float(i)", False),
        ("geometry", STRIP, "i == 1", "i == 0", False),
        ("vertex", "#version 330 core\nin vec3 p;\nvoid main() { gl_Position = vec4(p + p, 1.0); }",
         "p + p", "2.0 * p", True),
    ],
)  # fmt: skip
def test_stages_are_compared(stage: str, text: str, piece: str, other: str, same: bool) -> None:
    assert compared(stage, text, piece, other).same is same


def test_what_is_not_interpreted_is_named() -> None:
    with pytest.raises(NotInterpretedError, match="sums, which a workgroup shares"):
        audit_program(program(SHARING, "compute"))
    with pytest.raises(NotInterpretedError, match="SPIR-V's ControlBarrier at line 6"):
        audit_program(program(BUFFER.replace("    float", "    barrier(); float"), "compute"))
    image = "layout (local_size_x = 1) in;\nlayout (rgba8) uniform image2D i;\n"
    image += "void main() { imageStore(i, ivec2(0), vec4(1.0)); }"
    with pytest.raises(NotInterpretedError, match="image i at line 4"):
        audit_program(program(f"#version 430 core\n{image}", "compute"))


def test_a_case_s_stage_that_gives_nothing_is_not_audited(monkeypatch: pytest.MonkeyPatch) -> None:
    source = program(STRIP, "geometry").source
    monkeypatch.setattr(
        "shaderlab.analysis.invocations.case_stages", lambda lab, case: [(source, [])]
    )

    class Worker:
        note = lab = case = staticmethod(lambda *given: None)

    (audit,) = AuditCase(Path("a.py"), None, None).perform(Worker())  # type: ignore[arg-type]
    assert isinstance(audit, Audit) and audit.clean is None
    assert "not audited: what the case gives a geometry stage" in audit.refused
