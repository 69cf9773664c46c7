"""Dialects of GLSL: each target accepts what the commands accept, whatever else is asked for.

tests/dialects/accepted.toml is what glslangValidator and spirv-val say, written by
`python -m benchmarks.verdicts --write`.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from benchmarks.verdicts import DIALECTS, EXPLAINED
from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.glslang import ALL_TARGETS, TARGETS
from shaderlab.compiler.sources import Source

ACCEPTED: dict[str, list[str]] = tomllib.loads((DIALECTS / "accepted.toml").read_text())
SHADERS = Shaders([DIALECTS])


def test_every_file_has_its_verdicts() -> None:
    assert sorted(SHADERS.names()) == sorted(ACCEPTED)
    for target in ALL_TARGETS:
        assert 12 < sum(target in targets for targets in ACCEPTED.values()) < len(ACCEPTED) - 12


@pytest.mark.parametrize("name", ACCEPTED)
def test_the_lab_says_what_the_commands_say_with_any_other_targets(name: str) -> None:
    source = SHADERS.load(name)
    verdicts = {v.target: v for v in compile_program([source], ALL_TARGETS).verdicts}
    for target, verdict in verdicts.items():
        said = " / ".join(d.message for d in verdict.diagnostics)
        if not any(words in said for words in EXPLAINED):
            assert verdict.ok is (target in ACCEPTED[name]), (target, said)
    for targets in [*((target,) for target in TARGETS), ("vulkan", "opengl"), TARGETS[::-1]]:
        for verdict in compile_program([source], targets).verdicts:
            assert verdict == verdicts[verdict.target], targets


def test_each_difference_is_explained(repository: Path) -> None:
    page = " ".join((repository / "docs" / "guide" / "compiling.md").read_text().split())
    assert all(words in page for words in EXPLAINED.values())


def fragment(text: str) -> Source:
    return Shaders([]).from_text(f"#version 450\n{text}\n", "fragment", "a.frag")


def test_vulkans_dialect_is_told_its_own_mistakes() -> None:
    (verdict,) = compile_program([SHADERS.load("vk_separate_wrong.frag")], ["vulkan"]).verdicts
    error = next(d for d in verdict.diagnostics if d.severity == "error")
    assert (error.line, error.message) == (5, "'missing' : undeclared identifier")


@pytest.mark.parametrize(
    "text",
    [
        "uniform texture2D t;\nuniform vec3 a, b;\nlayout (location = 1) uniform vec4 a[2];",
        "uniform texture2D t;\nuniform\n  highp float\n a;\nuniform vec4 a;",
        "uniform texture2D t;\nuniform float a = 2.0;\nuniform struct S { float x; } a;",
    ],
)
def test_what_crashes_relaxed_rules_is_refused_first(text: str) -> None:
    source = fragment(text + "\nout vec4 c;\nvoid main() { c = vec4(a); }")
    assert not compile_program([source], ["vulkan"]).ok


def test_an_older_versions_interface_is_read() -> None:
    interface = compile_program([SHADERS.load("es300.frag")], ["glsl"]).interface
    assert interface is not None
    assert set(interface.varyings) == {"uv"} and set(interface.outputs) == {"color"}
    assert interface.uniforms["map"].type == "sampler2D"
    both = compile_program([SHADERS.load("v140.frag")], ["opengl", "glsl"])
    assert both.interface is not None and not both.verdicts[0].ok
    oldest = compile_program([SHADERS.load("es100.frag")], ["glsl"]).interface
    assert oldest is not None and set(oldest.varyings) == {"uv"}
    for name in ("vk_separate.frag", "es300_wrong.frag"):
        assert compile_program([SHADERS.load(name)], ["glsl"]).interface is None
