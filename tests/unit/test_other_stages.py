"""Vertex and compute stages: interpreted, compared and audited; what is not is named."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.auditing import STAGES, Planted, audit_of, is_found, planted
from shaderlab.analysis.audit import Audit, audit_program
from shaderlab.analysis.comparison import compare_programs
from shaderlab.analysis.interpreter import Program, load
from shaderlab.analysis.requests import AuditCase
from shaderlab.compiler import Shaders
from shaderlab.errors import NotInterpretedError

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


def test_what_is_right_is_clean() -> None:
    assert audit_program(program(BUFFER, "compute")).hazards == ()


def test_vertex_stages_are_compared() -> None:
    text = "#version 330 core\nin vec3 p;\nvoid main() { gl_Position = vec4(p + p, 1.0); }"
    other = text.replace("p + p", "2.0 * p")
    assert compare_programs(program(text, "vertex"), program(other, "vertex")).same


def test_what_is_not_interpreted_is_named() -> None:
    strip = "layout (points) in; layout (points, max_vertices = 1) out; void main() {}"
    with pytest.raises(NotInterpretedError, match="geometry stage"):
        program(f"#version 330 core\n{strip}", "geometry")
    counting = SHARING.replace("float sums", "uint sums").replace("= data[", "+= int(data[")
    counting = counting.replace("ID.x];\n    b", "ID.x]);\n    atomicAdd(sums[0], 1u);\n    b")
    with pytest.raises(NotInterpretedError, match="SPIR-V's AtomicIAdd at line 8"):
        audit_program(program(counting, "compute"))
    with pytest.raises(NotInterpretedError, match="sums, which a workgroup shares"):
        compare_programs(program(SHARING, "compute"), program(SHARING, "compute"))


def test_a_case_s_stage_that_gives_nothing_is_not_audited(monkeypatch: pytest.MonkeyPatch) -> None:
    source = program(BUFFER, "compute").source
    monkeypatch.setattr(
        "shaderlab.analysis.invocations.case_stages", lambda lab, case: [(source, [])]
    )

    class Worker:
        note = lab = case = staticmethod(lambda *given: None)

    (audit,) = AuditCase(Path("a.py"), None, None).perform(Worker())  # type: ignore[arg-type]
    assert isinstance(audit, Audit) and audit.clean is None
    assert "not audited: what the case gives a compute stage" in audit.refused
