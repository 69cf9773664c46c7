"""Loops that go on for longer than llvmpipe lets them are errors, in every stage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from shaderlab import glsl
from shaderlab.drivers.opengl import linking
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.loops import all_are_short
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderError
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record
from tests.gpu import faulty

GOES_ON = {
    "for ever": "while (true) {}",
    "with a test behind it": "do x = fract(x * 1.5 + .1); while (x < 2.0);",
    "at some pixels": "if (gl_FragCoord.x > 3.0) while (x < 2.0) x = fract(x * 1.5 + .1);",
    "late": "for (int i = 0; i < 100000; ++i) x = fract(x * 1.5 + .1);",
    "late by a break": "for (int i = 0;; ++i) { if (i > 70000) break; x = fract(x * 1.5 + .1); }",
    "one inside another": "for (int j=0; j<9; ++j) for (int i=0; i<9999; ++i) x = fract(x * 1.5);",
}
STAGES = {
    "vertex": "void main() { {loop} gl_Position = vec4(aPos, 1.0); }",
    "geometry": """layout(triangles) in; layout(triangle_strip, max_vertices = 3) out;
void main() { {loop} for (int i = 0; i < 3; ++i) {
    gl_Position = gl_in[i].gl_Position; EmitVertex(); } }""",
}
MESH = """import numpy as np
from shaderlab import Case, Mesh, exact, mesh_pass
corners = np.array([[-1, -1, 0], [3, -1, 0], [-1, 3, 0]], np.float32)
mesh = Mesh(attributes={"aPos": corners})
case = Case(title="T", passes=mesh_pass("a.vert", "a.frag", mesh{geometry}),
            expect=[exact("FragColor", (1.0, 0.5, 0.25, 1.0))])
"""
COMPUTE = """import numpy as np
from shaderlab import Case, compute, exact
case = Case(title="T", passes=compute("a.comp", groups=(1, 1, 1), buffers={"y": np.zeros(4)}),
            expect=[exact("y", 1.0)])
"""
ENDLESS = "float x = 0.5; while (x < 2.0) x = fract(x * 1.5 + .1);"


@pytest.fixture(scope="module")
def lab() -> SceneRunner:
    return SceneRunner(RunOptions(size=4, pictures=False, driver="llvmpipe"))


def run(lab: SceneRunner, file: Path) -> Record:
    lab.forget_shaders()
    (scene,) = load_case(file).scenes()
    return lab.run(scene)


@pytest.mark.parametrize("name", GOES_ON)
def test_a_loop_that_goes_on_is_an_error_by_its_line(
    tmp_path: Path, lab: SceneRunner, name: str
) -> None:
    record = run(lab, faulty.write(tmp_path, "a", body=GOES_ON[name]))
    assert record.status == "error" and "a.frag:7 does not end" in record.message


def test_a_loop_of_a_function_that_is_called(tmp_path: Path, lab: SceneRunner) -> None:
    (tmp_path / "l.glsl").write_text(f"float f(float y) {{\n    {ENDLESS}\n    return y;\n}}\n")
    with pytest.raises(ShaderError, match=r"l\.glsl:2 does not end"):
        glsl.load(tmp_path / "l.glsl").f(1.0)


def test_loops_of_es_are_left_to_the_driver(tmp_path: Path, lab: SceneRunner) -> None:
    """It has no buffer to count in."""
    file = faulty.write(tmp_path, "a", body="while (x > 0.5) x = fract(x * 1.5 + .1);")
    shader = tmp_path / "a.frag"
    text = shader.read_text().replace("330 core", "300 es\nprecision highp float;")
    shader.write_text(text)
    assert run(lab, file).status == "pass"


def test_a_long_loop_that_ends_passes(tmp_path: Path, lab: SceneRunner) -> None:
    body = "for (int i = 0; i < 60000; ++i) x = fract(x * 1.5 + .1);"
    assert run(lab, faulty.write(tmp_path, "a", body=body)).status == "pass"


def test_draws_of_one_shader_are_counted_by_one_program(
    tmp_path: Path, lab: SceneRunner, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = faulty.write(tmp_path, "a", body="while (x > 0.5) x = fract(x * 1.5 + .1) - 0.6;")
    drawn_thrice = """
from dataclasses import replace
case = replace(case, passes=tuple(replace(one, draws=3 * one.draws) for one in case.passes))
"""
    file.write_text(file.read_text() + drawn_thrice)
    linked: list[str] = []
    verbatim = linking.Linker._link

    def link(self: linking.Linker, stages: Mapping[str, str], feedback: Sequence[str]) -> Any:
        linked.append(stages["fragment"])
        return verbatim(self, stages, feedback)

    monkeypatch.setattr(linking.Linker, "_link", link)
    record = run(lab, file)
    assert record.status == "pass", record.message
    assert sum("shaderlab_turn(" in text for text in linked) == 1


@pytest.mark.parametrize("stage", STAGES)
def test_loops_of_other_stages(tmp_path: Path, lab: SceneRunner, stage: str) -> None:
    head = "#version 330 core\n"
    loops = {name: ENDLESS if name == stage else "" for name in STAGES}
    vertex = "in vec3 aPos;\n" + STAGES["vertex"].replace("{loop}", loops["vertex"])
    (tmp_path / "a.vert").write_text(head + vertex)
    (tmp_path / "a.geom").write_text(head + STAGES["geometry"].replace("{loop}", loops["geometry"]))
    color = "out vec4 FragColor;\nvoid main() { FragColor = vec4(1.0, 0.5, 0.25, 1.0); }\n"
    (tmp_path / "a.frag").write_text(head + color)
    file = tmp_path / "a.py"
    geometry = ', geometry="a.geom"' if stage == "geometry" else ""
    file.write_text(MESH.replace("{geometry}", geometry))
    record = run(lab, file)
    assert record.status == "error" and f"a.{stage[:4]}:3 does not end" in record.message


def test_loops_of_compute_passes(tmp_path: Path, lab: SceneRunner) -> None:
    text = "layout(local_size_x = 4) in;\nlayout(std430, binding = 0) buffer B { float y[]; };\n"
    main = f"void main() {{ {ENDLESS} y[gl_GlobalInvocationID.x] = 1.0; }}\n"
    (tmp_path / "a.comp").write_text("#version 430 core\n" + text + main)
    (tmp_path / "a.py").write_text(COMPUTE)
    record = run(lab, tmp_path / "a.py")
    assert record.status == "error" and "a.comp:4 does not end" in record.message


@pytest.mark.parametrize(
    ("loops", "short"),
    [
        (["for (int i = 0; i < 9; ++i) x += 1.0;"], True),
        (["for (uint i = 0u; i <= N - 1; i++) x += a[i];"], True),
        (["for (int i = 9; i >= 0; i -= 2) ;", "for (int j = 0; j < N; ++j) ;"], True),
        (["for (int i = 0; i < 99; ++i) ;", "for (int j = 0; j < 99; ++j) ;"], False),
        (["for (int i = 0; i < 9 && x > 0.5 && !b; ++i) ;"], True),
        (["for (int i = 0; i < 9 && i-- > 0; ++i) ;"], False),
        (["for (int i = 0; i < 9 && f(i); ++i) ;"], False),
        (["for (int i = 0; i < 9 || x > 0.5; ++i) ;"], False),
        (["for (int i = 0; i < 9 && b || x > 0.5; ++i) ;"], False),
        (["for (int i = 0; i < n; ++i) ;"], False),
        (["for (int i = 0; i < 9; --i) ;"], False),
        (["for (int i = 0; i < 9; ++i) i = 0;"], False),
        (["for (int i = 0; i < 9; ++i) --i;"], False),
        (["for (float f = 0.0; f < 1.0; f += 0.1) ;"], False),
        (["while (true) ;"], False),
        ([], True),
    ],
)
def test_only_loops_that_constants_bound_are_short(loops: list[str], short: bool) -> None:
    assert all_are_short("const int N = 12;\n", loops) == short
