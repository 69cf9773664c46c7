"""What fragment shaders got, however their inputs are declared: blocks, structs, arrays, matrices,
integers, every interpolation, many outputs. Real draws, each with a reference that can fail."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    Draw,
    Mesh,
    Pass,
    Ramp,
    across,
    coverage,
    exact,
    formula,
    fullscreen,
    mesh_pass,
    sweep,
    value,
)
from shaderlab.drivers.passes import PassSession
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import dot, mul, vec4
from shaderlab.model.frame import Fragments, PassDraw
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

QUAD = Mesh(
    attributes={"aPos": np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)},
    indices=np.array([0, 1, 2, 0, 2, 3]),
)
DECLARED = """
struct Surface { vec3 normal; float gloss; };
%s VS_OUT { vec3 FragPos; flat int id; mat3 TBN; vec2 uv[2]; } block;
%s BARE { vec3 bare; };
%s Surface surface;
%s vec3 v[2];
%s mat2x3 m;
"""
RICH_VERT = (
    "#version 330 core\nin vec3 aPos;\n"
    + DECLARED % (("out",) * 5)
    + """
void main() {
    block.FragPos = aPos * 2.0; block.id = 7 + gl_VertexID * 0;
    block.TBN = mat3(aPos, vec3(1.0, 2.0, 3.0), vec3(4.0, 5.0, 6.0));
    block.uv[0] = aPos.xy; block.uv[1] = aPos.yx * 3.0;
    bare = aPos + 1.0; surface.normal = aPos.zyx; surface.gloss = aPos.x * 0.5;
    v[0] = aPos; v[1] = -aPos; m = mat2x3(aPos, vec3(0.5, 0.25, 0.125));
    gl_Position = vec4(aPos, 1.0 + 0.5 * aPos.x * aPos.x);
}
"""
)
RICH_FRAG = (
    "#version 330 core\n"
    + DECLARED % (("in",) * 5)
    + """
out vec3 turned; out vec4 rest; out vec3 of_m;
void main() {
    turned = block.TBN * block.FragPos;
    rest = vec4(float(block.id) * bare.x, dot(surface.normal, v[0]) + surface.gloss,
                v[1].y * block.uv[1].x, block.uv[0].y);
    of_m = m * block.uv[0];
}
"""
)


def turned(VS_OUT_TBN: Any, VS_OUT_FragPos: Any) -> Any:
    return mul(VS_OUT_TBN, VS_OUT_FragPos)


def turned_wrongly(VS_OUT_TBN: Any, VS_OUT_FragPos: Any) -> Any:
    from shaderlab.glslmath import transpose

    return mul(transpose(VS_OUT_TBN), VS_OUT_FragPos)


def rest(
    VS_OUT_id: Any, bare: Any, surface_normal: Any, surface_gloss: Any, v: Any, VS_OUT_uv: Any
) -> Any:
    return vec4(
        VS_OUT_id * bare[..., 0:1],
        dot(surface_normal, v[0]) + surface_gloss,
        v[1][..., 1:2] * VS_OUT_uv[1][..., 0:1],
        VS_OUT_uv[0][..., 1:2],
    )


def of_m(m: Any, VS_OUT_uv_0: Any) -> Any:
    return mul(m, VS_OUT_uv_0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("shaders")
    (made / "rich.vert").write_text(RICH_VERT)
    (made / "rich.frag").write_text(RICH_FRAG)
    return made


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16)) as made:
        yield made


def run(lab: SceneRunner, folder: Path, passes: Any, *expect: Any) -> Record:
    made = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect)
    return lab.run(made.scene("default"))


def write(folder: Path, name: str, text: str) -> str:
    (folder / name).write_text("#version 330 core\n" + text)
    return name


def test_blocks_structs_arrays_and_matrices_reach_references(
    lab: SceneRunner, folder: Path
) -> None:
    passes = mesh_pass("rich.vert", "rich.frag", QUAD)
    record = run(
        lab, folder, passes,
        formula("turned", turned), formula("rest", rest), formula("of_m", of_m),
        formula("turned", turned_wrongly),
    )  # fmt: skip
    assert [o.status for o in record.expectations] == ["pass", "pass", "pass", "fail"], record
    assert record.expectations[1].judged == 4 * 100
    worst = record.expectations[1].worst
    assert worst is not None and "VS_OUT.id" in worst.inputs and "v[0]" in worst.inputs


def test_the_same_names_judge_vertex_outputs(lab: SceneRunner, folder: Path) -> None:
    def doubled(aPos: Any) -> Any:
        return aPos * 2.0

    def halved(aPos: Any) -> Any:
        return aPos[..., 0:1] * 0.5

    def negated(aPos: Any) -> Any:
        return -aPos

    def column(aPos: Any) -> Any:
        return aPos

    def seven() -> Any:
        return 7

    passes = mesh_pass("rich.vert", "rich.frag", QUAD)
    record = run(
        lab, folder, passes,
        formula("VS_OUT.FragPos", doubled), formula("surface.gloss", halved),
        formula("v[1]", negated), formula("VS_OUT.TBN[0]", column),
        formula("main.VS_OUT.FragPos", doubled), formula("VS_OUT.id", seven),
        value("VS_OUT.FragPos", at={"aPos": (1.5, 0.0, 0.0)}, equals=(3, 0, 0), digits=4),
        formula("v[0]", negated), formula("VS_OUT.TBN[1]", column),
    )  # fmt: skip
    assert [o.status for o in record.expectations] == ["pass"] * 7 + ["fail"] * 2, record
    refused = run(lab, folder, passes, formula("v", negated))
    assert refused.status == "error" and "v[0]" in refused.message


def test_a_program_is_run_on_given_members_and_elements(lab: SceneRunner, folder: Path) -> None:
    at: dict[str, Any] = {
        "VS_OUT.FragPos": (1.0, 2.0, 4.0), "VS_OUT.id": 1, "VS_OUT.uv[0]": (2.0, 3.0),
        "VS_OUT.uv[1]": (5.0, 0.0), "VS_OUT.TBN": np.arange(9.0).reshape(3, 3),
        "bare": (2.0, 0.0, 0.0), "surface.normal": (1.0, 1.0, 0.0), "surface.gloss": 0.25,
        "v[0]": (1.0, 2.0, 3.0), "v[1]": (0.0, 2.0, 0.0), "m": [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]],
    }  # fmt: skip
    passes = mesh_pass("rich.vert", "rich.frag", QUAD)
    record = run(
        lab, folder, passes,
        formula("turned", turned), formula("rest", rest), formula("of_m", of_m),
        value("turned", at=at, equals=(10, 31, 52), digits=4),
        value("rest", at=at, equals=(2, 3.25, 10, 3), digits=4),
        value("of_m", at=at, equals=(8, 18, 28), digits=4),
        sweep("turned", turned, over="VS_OUT.id", values=(1, 2), at={**at}),
        value("of_m", at=at, equals=(8, 18, 29), digits=4),
    )  # fmt: skip
    assert [o.status for o in record.expectations] == ["pass"] * 7 + ["fail"], record


@pytest.mark.parametrize("qualifier", ["smooth", "noperspective", "centroid", "flat"])
def test_every_interpolation_is_captured_as_it_is(
    lab: SceneRunner, folder: Path, qualifier: str
) -> None:
    vert = write(
        folder, f"{qualifier}.vert",
        f"in vec3 aPos; {qualifier} out vec2 st;\n"
        "void main() { st = aPos.xy; float w = 1.5 + aPos.x;\n"
        "              gl_Position = vec4(aPos.xy * w, 0.0, w); }\n",
    )  # fmt: skip
    frag = write(
        folder,
        f"{qualifier}.frag",
        f"{qualifier} in vec2 st; out vec2 y; void main() {{ y = st; }}\n",
    )

    def same(st: Any) -> Any:
        return st

    def across_the_screen(frag_coord: Any) -> Any:
        return frag_coord[..., 0:2] / 8.0 - 1.0

    passes = mesh_pass(vert, frag, QUAD)
    record = run(
        lab, folder, passes, formula("y", same), value("y", at={"st": (0.5, 3.0)},
        equals=(0.5, 3.0), digits=6), formula("y", across_the_screen),
    )  # fmt: skip
    assert [o.status for o in record.expectations[:2]] == ["pass", "pass"], record
    # Only without perspective is it linear on the screen: the three kinds do differ.
    linear = record.expectations[2]
    assert linear.worst is not None
    far = abs(linear.worst.measured[0] - linear.worst.reference[0])
    assert (far < 1e-5) == (qualifier == "noperspective")


def test_integers_and_built_in_inputs(lab: SceneRunner, folder: Path) -> None:
    vert = write(
        folder, "int.vert",
        "in vec3 aPos; flat out uvec2 u; flat out ivec3 i;\n"
        "void main() { u = uvec2(4294967295u, 3u); i = ivec3(-5, 2, 1 << 30);\n"
        "              gl_Position = vec4(aPos, 1.0); }\n",
    )  # fmt: skip
    frag = write(
        folder, "int.frag",
        "flat in uvec2 u; flat in ivec3 i; out uvec2 a; out float b;\n"
        "void main() { a = u; b = float(i.x) * (gl_FrontFacing ? 1.0 : -1.0); }\n",
    )  # fmt: skip

    def b(i: Any, gl_FrontFacing: Any) -> Any:
        return i[..., 0:1] * (gl_FrontFacing * 2.0 - 1.0)

    def b_turned(i: Any, gl_FrontFacing: Any) -> Any:
        return i[..., 0:1] * (1.0 - gl_FrontFacing * 2.0)

    record = run(
        lab, folder, mesh_pass(vert, frag, QUAD), exact("a", (4294967295, 3)),
        formula("b", b), formula("b", b_turned),
    )  # fmt: skip
    assert [o.status for o in record.expectations] == ["pass", "pass", "fail"], record


def test_the_number_of_the_primitive(lab: SceneRunner, folder: Path) -> None:
    if lab.driver["renderer"].startswith("softpipe"):
        pytest.skip("softpipe draws nothing with a fragment shader that reads gl_PrimitiveID")
    vert = write(folder, "plain.vert", "in vec3 aPos; void main() { gl_Position = vec4(aPos, 1); }")
    frag = write(folder, "id.frag", "out float y; void main() { y = float(gl_PrimitiveID) + 0.5; }")

    def y(gl_PrimitiveID: Any) -> Any:
        return gl_PrimitiveID + 0.5

    def above_the_diagonal(frag_coord: Any) -> Any:
        from shaderlab.glslmath import step

        return step(frag_coord[..., 0:1], frag_coord[..., 1:2]) + 0.5

    record = run(lab, folder, mesh_pass(vert, frag, QUAD), formula("y", y),
                 formula("y", above_the_diagonal))  # fmt: skip
    assert record.expectations[0].status == "pass"
    assert record.expectations[1].outside <= 16, "which triangle has the diagonal is the driver's"


@pytest.mark.parametrize("outputs", [6, 7, 8])
def test_as_many_attachments_as_there_are(lab: SceneRunner, folder: Path, outputs: int) -> None:
    declared = "".join(f"layout (location = {k}) out vec3 o{k};\n" for k in range(outputs))
    written = "".join(f"o{k} = x * {k + 1}.0;" for k in range(outputs))
    frag = write(
        folder, f"many{outputs}.frag", f"in vec3 x;\n{declared}void main() {{ {written} }}"
    )
    passes = fullscreen(frag, domain={"x": across((0.0, 1.0, 2.0), (1.0, 3.0, 0.0))})

    def times(factor: float) -> Any:
        def scaled(x: Any) -> Any:
            return x * factor

        return scaled

    checks = [formula(f"o{k}", times(k + 1.0)) for k in range(outputs)]
    record = run(lab, folder, passes, *checks, coverage(256), formula("o0", times(1.001)))
    assert [o.status for o in record.expectations] == ["pass"] * (outputs + 1) + ["fail"], record


def test_a_domain_feeds_blocks_and_structs(lab: SceneRunner, folder: Path) -> None:
    frag = write(
        folder, "fed.frag",
        "struct Surface { vec3 normal; float gloss; };\n"
        "in VS_OUT { vec3 FragPos; flat int id; mat2 turn; } fs_in; // with an instance\n"
        "in BARE { vec2 a, b; };\nin Surface surface;\n"
        "out vec4 y; out vec2 z;\n"
        "void main() { y = vec4(fs_in.FragPos * surface.gloss, float(fs_in.id));\n"
        "              z = fs_in.turn * (a + b) + surface.normal.xy; }\n",
    )  # fmt: skip

    def y(VS_OUT_FragPos: Any, surface_gloss: Any, VS_OUT_id: Any) -> Any:
        return vec4(VS_OUT_FragPos * surface_gloss, VS_OUT_id)

    def z(VS_OUT_turn: Any, a: Any, b: Any, surface_normal: Any) -> Any:
        return mul(VS_OUT_turn, a + b) + surface_normal[..., 0:2]

    def z_swapped(VS_OUT_turn: Any, a: Any, b: Any, surface_normal: Any) -> Any:
        return mul(VS_OUT_turn, a - b) + surface_normal[..., 0:2]

    domain = {
        "VS_OUT.FragPos": across((0.0, 1.0, 2.0), (1.0, 1.0, 0.0)), "VS_OUT.id": Ramp(3),
        "VS_OUT.turn": Ramp([[0.0, -1.0], [1.0, 0.0]]), "a": across((0.0, 0.0), (1.0, 2.0)),
        "b": across((1.0, 1.0), (0.0, 5.0)), "surface.normal": Ramp((0.0, 0.0, 1.0)),
        "surface.gloss": across(0.5, 1.0),
    }  # fmt: skip
    record = run(
        lab, folder, fullscreen(frag, domain=domain), formula("y", y), formula("z", z),
        formula("z", z_swapped),
    )  # fmt: skip
    assert [o.status for o in record.expectations] == ["pass", "pass", "fail"], record
    assert set(record.compile.values()) == {"pass"}


def test_what_no_vertex_stage_can_feed_is_said(lab: SceneRunner, folder: Path) -> None:
    frag = write(folder, "array.frag", "in vec3 v[2]; out vec3 y; void main() { y = v[0] + v[1]; }")
    passes = fullscreen(frag, domain={"v": Ramp((0.0, 0.0, 0.0))})
    record = run(lab, folder, passes, exact("y", 0.0))
    assert record.status == "unsupported"
    assert "'v'" in record.message and "draw a mesh" in record.message


def test_instances_are_told_apart(lab: SceneRunner, folder: Path) -> None:
    vert = write(
        folder, "many.vert",
        "in vec3 aPos; flat out int which; out float x;\n"
        "void main() { which = gl_InstanceID; x = aPos.x + float(gl_VertexID);\n"
        "    gl_Position = vec4(aPos.x * 0.25 - 0.75 + 0.5 * float(gl_InstanceID), aPos.yz, 1.0);"
        "}\n",
    )  # fmt: skip
    frag = write(
        folder, "many.frag", "flat in int which; out float y; void main() { y = float(which); }"
    )
    draw = Draw(vertex=vert, fragment=frag, mesh=QUAD, instances=4)

    def placed(aPos: Any, gl_InstanceID: Any) -> Any:
        x = aPos[..., 0:1] * 0.25 - 0.75 + 0.5 * gl_InstanceID
        return vec4(x, aPos[..., 1:3], 1.0)

    def numbered(aPos: Any, gl_VertexID: Any) -> Any:
        return aPos[..., 0:1] + gl_VertexID

    def instance(which: Any) -> Any:
        return which

    def column(frag_coord: Any) -> Any:
        from shaderlab.glslmath import floor

        return floor(frag_coord[..., 0:1] / 4.0)

    record = run(
        lab, folder, (Pass(draws=(draw,)),),
        formula("gl_Position", placed), formula("x", numbered), formula("y", instance),
        formula("y", column), coverage(256), formula("which", lambda gl_InstanceID: gl_InstanceID),
        formula("which", lambda gl_VertexID: gl_VertexID),
    )  # fmt: skip
    assert [o.status for o in record.expectations] == ["pass"] * 6 + ["fail"], record
    assert record.expectations[0].judged == 4 * 4 * 4


def test_an_output_that_is_never_written_keeps_no_other_from_being_judged(
    lab: SceneRunner, folder: Path
) -> None:
    write(folder, "idle.vert", "in vec3 aPos;\nout vec3 idle;\nout vec3 double_;\n"
          "void main() { double_ = 2.0 * aPos; gl_Position = vec4(aPos, 1.0); }\n")  # fmt: skip
    write(folder, "idle.frag", "out vec4 o;\nvoid main() { o = vec4(1.0); }\n")

    def doubled(aPos: Any) -> Any:
        return 2.0 * aPos

    def nothing(aPos: Any) -> Any:
        return 0.0 * aPos

    passes = mesh_pass("idle.vert", "idle.frag", QUAD)
    record = run(lab, folder, passes, formula("double_", doubled), formula("idle", nothing))
    assert [o.status for o in record.expectations] == ["pass", "fail"], record


@pytest.mark.parametrize("off", [(0.0, 1.0), (-1.0, 0.0), (np.nan, 0.0), (0.0, 0.0)])
def test_a_driver_with_another_idea_of_places_is_found_out(
    lab: SceneRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, off: tuple[float, float]
) -> None:
    captured = PassSession.capture_fragments

    def shifted(self: Any, key: PassDraw) -> Fragments:
        found = captured(self, key)
        return replace(found, frag_coord=found.frag_coord + np.float32([*off, 0.0, 0.0]))

    monkeypatch.setattr(PassSession, "capture_fragments", shifted)
    (tmp_path / "any.vert").write_text(
        "#version 330 core\nin vec3 aPos; out vec2 uv;\n"
        "void main() { uv = aPos.xy; gl_Position = vec4(aPos, 1.0); }\n"
    )
    (tmp_path / "any.frag").write_text(
        "#version 330 core\nin vec2 uv; out vec4 color;\n"
        "void main() { color = vec4(uv, 0.0, 1.0); }\n"
    )
    check = formula("main.color", lambda uv: vec4(uv, 0.0, 1.0))
    draw = Draw(vertex="any.vert", fragment="any.frag", mesh=QUAD)
    passes = [Pass(name="main", draws=[draw])]
    case = Case(title="t", id="t", file=str(tmp_path / "t.py"), passes=passes, expect=[check])
    (outcome,) = lab.run(case.scene("default")).expectations
    expected = "pass" if off == (0.0, 0.0) else "fail"
    assert outcome.status == expected, outcome.message
    assert ("the driver is wrong: gl_FragCoord is (" in outcome.message) == (expected == "fail")


def test_draws_of_a_pass_are_captured_together_as_each_by_itself(
    lab: SceneRunner, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    vert = write(
        folder, "half.vert",
        "in vec3 aPos; uniform float shift; out vec3 at; out vec2 uv;\n"
        "void main() { at = aPos + shift; uv = aPos.xy; gl_Position = aPos.xyzz;\n"
        "    gl_Position.x += shift; gl_Position.w = 1.0; }\n",
    )  # fmt: skip
    fragments = [
        write(folder, "first.frag", "in vec3 at; out vec4 o; void main() { o = vec4(at, 1.0); }"),
        write(
            folder, "second.frag",
            "in vec3 at; in vec2 uv; out vec4 o;\n"
            "void main() { if (uv.y > 0.5) discard; o = vec4(at.xy, uv); }",
        ),
        write(folder, "bare.frag", "out vec4 o; void main() { o = vec4(0.5); }"),
    ]  # fmt: skip
    draws = [
        Draw(vertex=vert, fragment=fragment, mesh=QUAD, uniforms={"shift": shift})
        for fragment, shift in zip(fragments, (-0.25, 0.5, 1.75), strict=True)
    ]
    captured, redrawn = PassSession.capture_fragments, PassSession.redraw_with_texts
    redraws: list[bool] = []

    def count_redraws(self: Any, *given: Any) -> Any:
        redraws.append(self.shares_captures)
        return redrawn(self, *given)

    def compare(self: Any, key: PassDraw) -> Fragments:
        found = captured(self, key)
        monkeypatch.setattr(self, "shares_captures", False)
        monkeypatch.setattr(self, "_together", {})
        alone = captured(self, key)
        monkeypatch.undo()
        patch()
        for one, other in ((found, alone), (found.undiscarded, alone.undiscarded)):
            if one is not None and other is not None:
                np.testing.assert_array_equal(one.frag_coord, other.frag_coord)
                np.testing.assert_array_equal(one.covered, other.covered)
                for name, values in one.inputs.items():
                    np.testing.assert_array_equal(
                        values[one.covered], other.inputs[name][one.covered]
                    )
        assert found.covered.any()
        return found

    def patch() -> None:
        monkeypatch.setattr(PassSession, "capture_fragments", compare)
        monkeypatch.setattr(PassSession, "redraw_with_texts", count_redraws)

    patch()
    record = run(
        lab, folder, (Pass(draws=draws),),
        formula("o", lambda at: vec4(at, 1.0), draw=0),
        formula("o", lambda at, uv: vec4(at[..., :2], uv), draw=1,
                discards=lambda uv: uv[..., 1:2] > 0.5),
        formula("o", lambda frag_coord: 0.5, draw=2),
    )  # fmt: skip
    assert [o.status for o in record.expectations] == ["pass"] * 3, [
        o.message for o in record.expectations
    ]
    # All three at once, and the second keeping what it discards.
    assert sum(redraws) == 2, redraws
