"""Patches divided by tessellation stages: what each stage gives, and mistakes that are noticed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Case, Draw, Mesh, formula, mesh_pass, query, value
from shaderlab.analysis.interpreter import load
from shaderlab.drivers.opengl import linking
from shaderlab.drivers.programs.stages import patch_primitive
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError, NotInterpretedError, UnsupportedError
from shaderlab.glslmath import vec4
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record
from shaderlab.mutation.judging import Judge
from shaderlab.mutation.shader_mutants import mutate_case
from tests.meta.examples import File, examples

VERTEX = """#version 430 core
in vec3 aPos; in mat2 turn;
out VS { vec3 colour; mat2 turn; } made;
void main() { gl_Position = vec4(aPos, 1.0); made.colour = aPos * 0.5 + 0.5; made.turn = turn; }
"""
CONTROL = """#version 430 core
layout (vertices = 3) out;
#define i gl_InvocationID
in VS { vec3 colour; mat2 turn; } got[];
struct Bend { float much; ivec2 where; vec3 corners[3]; };
out CS { vec3 colour; mat2 turn; } made[];
out float weights[][2];
patch out Bend bend;
void main() {
    gl_out[i].gl_Position = gl_in[2 - i].gl_Position;
    made[i].colour = got[i].colour; made[i].turn = got[i].turn;
    weights[i][0] = float(i); weights[i][1] = 0.5;
    bend.much = 0.25; bend.where = ivec2(gl_PrimitiveID, 7); bend.corners[i] = got[i].colour;
    gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = 3.0;
    gl_TessLevelInner[0] = 2.0;
}
"""
EVALUATION = """#version 430 core
layout (LAYOUT) in;
in CS { vec3 colour; mat2 turn; } got[];
struct Bend { float much; ivec2 where; vec3 corners[3]; };
in float weights[][2];
patch in Bend bend;
out vec3 colour; flat out ivec2 at; out mat2 turned;
void main() {
    vec3 t = gl_TessCoord;
    gl_Position = t.x * gl_in[0].gl_Position + t.y * gl_in[1].gl_Position
        + t.z * gl_in[2].gl_Position;
    colour = bend.much * (t.x * got[0].colour + t.y * got[1].colour)
        + bend.corners[2] * weights[2][0];
    at = bend.where; turned = got[1].turn * weights[1][1];
}
"""
FRAGMENT = """#version 430 core
in vec3 colour; flat in ivec2 at; in mat2 turned;
out vec4 c;
void main() { c = vec4(colour, float(at.x)) + turned[0][1]; }
"""
STAGES = {"t.vert": VERTEX, "t.tesc": CONTROL, "t.tese": EVALUATION, "t.frag": FRAGMENT}
RANDOM = np.random.default_rng(4)
PATCHES = Mesh(
    attributes={"aPos": RANDOM.uniform(-0.9, 0.9, (6, 3)), "turn": RANDOM.random((6, 2, 2))},
    indices=np.array([0, 1, 2, 3, 2, 5]),
    primitive="patches",
)


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions()) as made:
        yield made


def run(lab: SceneRunner, folder: Path, *expect: Any, texts: Any = None, **given: Any) -> Record:
    for name, text in {**STAGES, **(texts or {})}.items():
        (folder / name).write_text(text.replace("LAYOUT", "triangles"))
    stages = {"tess_control": "t.tesc", "tess_evaluation": "t.tese", "mesh": PATCHES, **given}
    passes = mesh_pass("t.vert", "t.frag", **stages)
    case = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect)
    lab.forget_shaders()
    record = lab.run(case.scene("default"))
    print(record.message, *record.expectations, sep="\n")
    return record


def failed(record: Record) -> list[str]:
    assert record.status in ("pass", "fail"), record.message
    return [o.name for o in record.expectations if o.status == "fail"]


# The guide's example ------------------------------------------------------------------------


@pytest.fixture
def guide(repository: Path, tmp_path: Path) -> Path:
    for each in examples(repository / "docs" / "guide" / "stages.md"):
        if isinstance(each, File) and each.name.startswith("sheet"):
            (tmp_path / each.name).write_text(each.text, encoding="utf-8")
    return tmp_path


def test_the_guides_example_passes_and_shows_each_stage(guide: Path, lab: SceneRunner) -> None:
    lab.forget_shaders()
    record = lab.run(load_case(guide / "sheet.py").scene("default"))
    assert failed(record) == [] and record.unread == ()
    (program,) = record.programs
    files = {Path(source.file).name for source in program.sources}
    assert files == {"sheet.vert", "sheet.tesc", "sheet.tese", "sheet.frag"}


@pytest.mark.parametrize(
    ("stage", "right", "wrong", "noticed"),
    [
        ("tesc", "gl_TessLevelOuter[i] = level", "gl_TessLevelOuter[i] = level + 1.0",
         "gl_TessLevelOuter[1]"),
        ("tesc", "gl_TessLevelInner[1] = level", "gl_TessLevelInner[1] = level - 1.0",
         "primitives generated"),
        ("tesc", "gl_in[gl_InvocationID]", "gl_in[gl_InvocationID ^ 1]", "gl_Position"),
        ("tesc", "gl_in[1].gl_Position.x -", "gl_in[2].gl_Position.x -", "bend"),
        ("tese", "gl_in[3].gl_Position, gl_in[2].gl_Position",
         "gl_in[2].gl_Position, gl_in[3].gl_Position", "gl_Position"),
        ("tese", "mix(lower, upper, uv.y)", "mix(lower, upper, uv.y * uv.y)", "gl_Position"),
        ("tese", "equal_spacing", "fractional_odd_spacing", "primitives generated"),
        ("tese", "gl_TessCoord.xy", "gl_TessCoord.yx", "gl_Position"),
        ("vert", "vec4(aPos, 0.0, 1.0)", "vec4(aPos.yx, 0.0, 1.0)", "gl_Position"),
    ],
)  # fmt: skip
def test_mistakes_in_a_stage_are_noticed(
    lab: SceneRunner, guide: Path, stage: str, right: str, wrong: str, noticed: str
) -> None:
    shader = guide / f"sheet.{stage}"
    assert right in shader.read_text()
    shader.write_text(shader.read_text().replace(right, wrong))
    lab.forget_shaders()
    assert noticed in failed(lab.run(load_case(guide / "sheet.py").scene("default")))


def test_mutants_of_both_stages_are_judged(lab: SceneRunner, guide: Path) -> None:
    lab.forget_shaders()
    case = load_case(guide / "sheet.py")
    judge = Judge(lab, case)
    killed = {"sheet.tesc": 0, "sheet.tese": 0}
    for mutant in mutate_case(case)[::2]:
        if mutant.shader in killed:
            status = judge.judge(mutant).status
            killed[mutant.shader] += status == "killed"
            assert status != "survived", mutant
    assert min(killed.values()) > 4, killed


# What the stages hand on --------------------------------------------------------------------


def test_blocks_structs_arrays_and_matrices_are_inputs_and_outputs(
    lab: SceneRunner, tmp_path: Path
) -> None:
    def position(gl_TessCoord: Any, gl_in_gl_Position: Any) -> Any:
        t, p = gl_TessCoord, gl_in_gl_Position
        return t.x * p[0] + t.y * p[1] + t.z * p[2]

    def reversed_corner(aPos: Any) -> Any:
        return vec4(aPos[2], 1.0)

    def colour(gl_TessCoord: Any, CS_colour: Any, bend_much: Any, bend_corners: Any) -> Any:
        t = gl_TessCoord
        return bend_much * (t.x * CS_colour[0] + t.y * CS_colour[1]) + bend_corners[2] * 2.0

    def own(aPos: Any) -> Any:
        return aPos * 0.5 + 0.5

    def stored(aPos: Any) -> Any:
        return vec4(aPos, 1.0)

    expect = [
        formula("gl_Position", position),
        formula("gl_in[0].gl_Position", reversed_corner),
        formula("colour", colour),
        formula("CS[1].colour", lambda aPos_1: aPos_1 * 0.5 + 0.5),
        formula("bend.corners[2]", lambda aPos_2: aPos_2 * 0.5 + 0.5),
        formula("turned[0]", lambda CS_1_turn: CS_1_turn[..., 0] * 0.5),
        formula("at", lambda bend_where: bend_where),
        formula("weights[2][0]", lambda: 2.0),
        formula("gl_TessLevelInner[0]", lambda: 2.0),
        formula("VS.colour", own),
        formula("gl_in.gl_Position", stored),
    ]
    assert failed(run(lab, tmp_path, *expect)) == []
    for stage, right, wrong, noticed in (
        ("t.tesc", "gl_in[2 - i]", "gl_in[i]", "gl_in[0].gl_Position"),
        ("t.tese", "bend.corners[2]", "bend.corners[1]", "colour"),
        ("t.tesc", "made[i].turn = got[i].turn", "made[i].turn = got[0].turn", ""),
        ("t.vert", "aPos * 0.5 + 0.5", "aPos * 0.5", "VS.colour"),
    ):
        text = STAGES[stage].replace(right, wrong)
        found = failed(run(lab, tmp_path, *expect, texts={stage: text}))
        assert (noticed in found) if noticed else found == []


@pytest.mark.parametrize(
    ("layout", "kind", "count"),
    [("triangles", "triangles", 9), ("triangles, point_mode", "points", 10),
     ("isolines", "lines", 9)],
)  # fmt: skip
def test_triangles_lines_and_points_come_out(
    lab: SceneRunner, tmp_path: Path, layout: str, kind: str, count: int
) -> None:
    def position(gl_TessCoord: Any, gl_in_gl_Position: Any) -> Any:
        t, p = gl_TessCoord, gl_in_gl_Position
        return t.x * p[0] + t.y * p[1] + t.z * p[2]

    assert patch_primitive(f"layout ({layout}) in; // isolines, point_mode") == kind
    texts = {"t.tese": EVALUATION.replace("LAYOUT", layout)}
    expect = [formula("gl_Position", position), query("primitives_generated", equals=2 * count)]
    record = run(lab, tmp_path, *expect, texts=texts)
    assert failed(record) == [], record.expectations
    wrong = {"t.tese": texts["t.tese"].replace("t.y * gl_in[1]", "t.x * gl_in[1]")}
    assert failed(run(lab, tmp_path, *expect, texts=wrong)) == ["gl_Position"]


def test_a_geometry_stage_may_follow(lab: SceneRunner, tmp_path: Path) -> None:
    geometry = """#version 430 core
    layout (triangles) in;
    layout (points, max_vertices = 1) out;
    in vec3 colour[]; flat in ivec2 at[]; in mat2 turned[];
    out vec3 tint;
    void main() {
        tint = colour[0]; gl_Position = gl_in[0].gl_Position; gl_PointSize = 9.0; EmitVertex();
    }
    """
    (tmp_path / "t.geom").write_text(geometry)
    plain = "#version 430 core\nin vec3 tint; out vec4 c; void main() { c = vec4(tint, 1.0); }\n"
    drawn = formula("c", lambda tint: vec4(tint, 1.0))
    given = {"texts": {"t.frag": plain}, "geometry": "t.geom"}
    assert failed(run(lab, tmp_path, drawn, **given)) == []
    record = run(lab, tmp_path, formula("gl_Position", lambda: 0.0), **given)
    assert record.status == "unsupported" and "makes of tessellated patches" in record.message


# What is refused ----------------------------------------------------------------------------


def test_stages_and_patches_belong_together(lab: SceneRunner, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="tessellation takes both stages"):
        Draw(fragment="t.frag", vertex="t.vert", tess_control="t.tesc", mesh=PATCHES)
    with pytest.raises(CaseError, match="drop all stages but the fragment shader"):
        Draw(fragment="t.frag", tess_control="t.tesc", tess_evaluation="t.tese", domain={})
    with pytest.raises(CaseError, match=r"a patch has 1…32 vertices, not 33"):
        Mesh(attributes={"aPos": np.zeros((3, 3))}, primitive="patches", patch_vertices=33)
    triangles = Mesh(attributes=PATCHES.attributes)
    record = run(lab, tmp_path, formula("at", lambda: 0.0), mesh=Mesh.later(lambda: triangles))
    assert record.status == "error" and "tessellation stages take patches" in record.message
    given = {"tess_control": None, "tess_evaluation": None}
    record = run(lab, tmp_path, formula("c", lambda: 0.0), **given)
    assert "a mesh of patches needs tessellation stages" in record.message


def test_what_takes_single_invocations_says_so(lab: SceneRunner, tmp_path: Path) -> None:
    at = {"aPos": (0.0, 0.0, 0.0), "turn": np.eye(2)}
    record = run(lab, tmp_path, value("gl_Position", equals=(0, 0, 0, 1), digits=3, at=at))
    assert record.status == "unsupported"
    assert "running t.tese on given inputs: it takes whole primitives" in record.message
    case = Case(title="t", id="t", file=str(tmp_path / "t.py"), passes=mesh_pass(
        "t.vert", "t.frag", PATCHES, tess_control="t.tesc", tess_evaluation="t.tese"
    ), expect=[formula("at", lambda: 0.0)])  # fmt: skip
    for source in lab.prepare_for_opengl(case.scene("default"))["main"][0].sources[1:3]:
        with pytest.raises(NotInterpretedError, match=f"not interpreted: {source.stage} stage"):
            load(source)


def test_vulkan_names_what_it_leaves_out() -> None:
    pytest.importorskip("vulkan")
    modules = pytest.importorskip("shaderlab.drivers.vulkan.program")
    with pytest.raises(UnsupportedError, match="tess_control stage: the lab tessellates on OpenGL"):
        modules.check_capabilities(None, {"tess_control": b""})


def test_a_driver_without_the_stages_makes_a_case_unsupported(
    guide: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(linking.LEAST_VERSIONS, "tess_control", 9999)
    with SceneRunner(RunOptions()) as other:
        record = other.run(load_case(guide / "sheet.py").scene("default"))
    assert record.status == "unsupported" and "has no tess_control stage" in record.message
