"""Vertex stages are compared and audited as fragment stages are; what is refused is named."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.auditing import Planted, audit_of, is_found, planted
from shaderlab.analysis.audit import audit_program
from shaderlab.analysis.comparison import compare_programs
from shaderlab.analysis.interpreter import Program, load
from shaderlab.compiler import Shaders
from shaderlab.errors import NotInterpretedError


def program(text: str, stage: str) -> Program:
    return load(Shaders([Path()], overrides={"a.glsl": text}).load("a.glsl", stage))


def test_a_hazard_of_each_kind_is_found_at_its_line_in_a_vertex_stage() -> None:
    one_of_each: dict[str, Planted] = {one.kind: one for one in planted("vertex")}
    missed = [one for one in one_of_each.values() if not is_found(one, audit_of(one))]
    assert not missed


def test_vertex_stages_are_compared() -> None:
    text = "#version 330 core\nin vec3 p;\nvoid main() { gl_Position = vec4(p + p, 1.0); }"
    for other, same in (("2.0 * p", True), ("1.9 * p", False)):
        new = program(text.replace("p + p", other), "vertex")
        assert compare_programs(program(text, "vertex"), new).same is same


def test_what_is_not_interpreted_is_named() -> None:
    image = "in vec2 at;\nlayout (rgba8) uniform image2D i;\n"
    image += "void main() { imageStore(i, ivec2(at), vec4(1.0)); }"
    with pytest.raises(NotInterpretedError, match="image i at line 4"):
        audit_program(program(f"#version 430 core\n{image}", "fragment"))
    for stage in ("geometry", "compute"):
        with pytest.raises(NotInterpretedError, match=f"not interpreted: {stage} stage"):
            program("#version 430 core\nvoid main() {}", stage)
