"""Vertices that geometry shaders emit, and fragments behind them, judged from what went in."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Case, Draw, Mesh, Pass, coverage, formula, mesh_pass, value
from shaderlab.drivers.programs.captures import primitive_corners
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import cross, normalize, vec4, where
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

TRIANGLES = Mesh(
    attributes={
        "aPos": np.array(
            [[-0.9, -0.9, 0], [0.9, -0.9, 0.1], [0.7, 0.9, 0.2], [-0.8, 0.8, -0.3]], np.float32
        ),
        "aColor": np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]], np.float32),
    },
    indices=np.array([0, 1, 2, 0, 2, 3]),
)
VERTEX = """#version 330 core
in vec3 aPos; in vec3 aColor;
uniform float shift;
out VS_OUT { vec3 color; mat2 turn; } vs_out;
out vec3 world;
void main() {
    vs_out.color = aColor; vs_out.turn = mat2(aPos.xy, aColor.xy);
    world = aPos + vec3(shift * float(gl_InstanceID), 0.0, 0.0);
    gl_Position = vec4(world, 1.0);
}
"""
# Each triangle is moved along its normal, and drawn once more as a line of two points' colours.
EXPLODE = """#version 330 core
layout (triangles) in;
layout (triangle_strip, max_vertices = 4) out;
uniform float magnitude;
in VS_OUT { vec3 color; mat2 turn; } gs_in[];
in vec3 world[];
out vec3 tint; flat out int side; out vec2 turned;
void emit(int i, vec3 n) {
    gl_Position = gl_in[i].gl_Position + vec4(n * magnitude, 0.0);
    tint = gs_in[i].color * 0.5; side = i; turned = gs_in[i].turn * vec2(2.0, 3.0);
    EmitVertex();
}
void main() {
    vec3 n = normalize(cross(world[1] - world[0], world[2] - world[0]));
    for (int i = 0; i < 3; ++i) emit(i, n);
    EndPrimitive();
}
"""
FRAGMENT = """#version 330 core
in vec3 tint; flat in int side; in vec2 turned;
out vec3 FragColor; out float length_of;
void main() { FragColor = tint * tint; length_of = turned.x + float(side); }
"""
HOUSE = """#version 330 core
layout (points) in;
layout (triangle_strip, max_vertices = 5) out;
in vec3 world[];
out float corner;
void build(vec2 offset, float k) {
    gl_Position = gl_in[0].gl_Position + vec4(offset, 0.0, 0.0); corner = k; EmitVertex();
}
void main() {
    build(vec2(-0.2, -0.2), 0.0); build(vec2(0.2, -0.2), 1.0); build(vec2(-0.2, 0.2), 2.0);
    build(vec2(0.2, 0.2), 3.0);
    if (world[0].x > 0.0) build(vec2(0.0, 0.4), 4.0);
    EndPrimitive();
}
"""
NORMALS = """#version 330 core
layout (triangles) in;
layout (line_strip, max_vertices = 6) out;
in vec3 world[];
void main() {
    for (int i = 0; i < 3; ++i) {
        gl_Position = gl_in[i].gl_Position; EmitVertex();
        gl_Position = gl_in[i].gl_Position + vec4(world[i] * 0.25, 0.0); EmitVertex();
        EndPrimitive();
    }
}
"""
CORNER = """#version 330 core
in float corner; out float y; void main() { y = corner; }
"""
WHITE = """#version 330 core
out float y; void main() { y = 1.0; }
"""


def by_emitted(values: Any, emitted: Any) -> Any:
    """One of three vertices' values, by which vertex was emitted."""
    return where(emitted < 1.0, values[0], where(emitted < 2.0, values[1], values[2]))


def position(gl_in_gl_Position: Any, world: Any, magnitude: Any, emitted: Any) -> Any:
    n = normalize(cross(world[1] - world[0], world[2] - world[0]))
    return by_emitted(gl_in_gl_Position, emitted) + vec4(n * magnitude, 0.0)


def inward(gl_in_gl_Position: Any, world: Any, magnitude: Any, emitted: Any) -> Any:
    n = normalize(cross(world[2] - world[0], world[1] - world[0]))
    return by_emitted(gl_in_gl_Position, emitted) + vec4(n * magnitude, 0.0)


def tint_of(VS_OUT_color: Any, emitted: Any) -> Any:
    return by_emitted(VS_OUT_color, emitted) * 0.5


def turned_of(VS_OUT_turn: Any, emitted: Any) -> Any:
    from shaderlab.glslmath import mul

    return by_emitted([mul(m, np.array([2.0, 3.0])) for m in VS_OUT_turn], emitted)


def side_of(emitted: Any) -> Any:
    return emitted


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("shaders")
    for name, text in {
        "world.vert": VERTEX, "explode.geom": EXPLODE, "tint.frag": FRAGMENT, "house.geom": HOUSE,
        "corner.frag": CORNER, "normals.geom": NORMALS, "white.frag": WHITE,
    }.items():  # fmt: skip
        (made / name).write_text(text)
    return made


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=32)) as made:
        yield made


def run(lab: SceneRunner, folder: Path, passes: Any, *expect: Any) -> Record:
    made = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect)
    return lab.run(made.scene("default"))


def exploded(**draw: Any) -> tuple[Pass, ...]:
    made = Draw(
        vertex="world.vert", geometry="explode.geom", fragment="tint.frag", mesh=TRIANGLES,
        uniforms={"shift": 0.25, "magnitude": 0.3}, **draw,
    )  # fmt: skip
    return (Pass(draws=(made,)),)


@pytest.mark.parametrize("instances", [1, 3])
def test_emitted_vertices_are_judged(lab: SceneRunner, folder: Path, instances: int) -> None:
    record = run(
        lab, folder, exploded(instances=instances),
        formula("gl_Position", position), formula("tint", tint_of), formula("side", side_of),
        formula("turned", turned_of), formula("gl_Position", inward),
    )  # fmt: skip
    assert [o.status for o in record.expectations] == ["pass"] * 4 + ["fail"], record
    assert record.expectations[0].judged == instances * 2 * 3 * 4
    worst = record.expectations[4].worst
    assert worst is not None and "world[1]" in worst.inputs


def test_the_vertex_stage_before_a_geometry_stage_is_judged(lab: SceneRunner, folder: Path) -> None:
    def moved(aPos: Any, gl_InstanceID: Any, shift: Any) -> Any:
        return aPos + shift * gl_InstanceID * np.array([1.0, 0.0, 0.0])

    def as_it_is(aColor: Any) -> Any:
        return aColor

    def half(aColor: Any) -> Any:
        return 0.5 * aColor

    record = run(
        lab, folder, exploded(instances=2),
        formula("world", moved), formula("VS_OUT.color", as_it_is),
        value("gl_in.gl_Position", at={"aPos": (2.0, 3.0, 4.0)}, equals=(2, 3, 4, 1), digits=4),
        formula("gl_in.gl_Position", lambda aPos: vec4(aPos, 1.0), name="without the shift"),
        formula("main.VS_OUT.color", half, name="half"),
    )  # fmt: skip
    assert [o.status for o in record.expectations] == ["pass"] * 3 + ["fail"] * 2, record
    assert record.expectations[0].judged == 2 * 4 * 3
    worst = record.expectations[4].worst
    assert worst is not None and set(worst.inputs) >= {"aColor"}
    unknown = run(lab, folder, exploded(), formula("gl_in.gl_PointSize", as_it_is))
    assert unknown.status == "error" and "gl_in.gl_Position" in unknown.message


def test_fragments_behind_a_geometry_shader_are_judged(lab: SceneRunner, folder: Path) -> None:
    def squared(tint: Any) -> Any:
        return tint * tint

    def length_of(turned: Any, side: Any) -> Any:
        return turned[..., 0:1] + side

    def doubled(tint: Any) -> Any:
        return tint + tint

    record = run(
        lab, folder, exploded(), formula("FragColor", squared), formula("length_of", length_of),
        value("FragColor", at={"tint": (0.5, 1.0, 2.0), "side": 0, "turned": (0.0, 0.0)},
              equals=(0.25, 1, 4), digits=4),
        formula("FragColor", doubled),
    )  # fmt: skip
    assert [o.status for o in record.expectations] == ["pass"] * 3 + ["fail"], record
    assert record.expectations[0].judged > 1000


def test_strips_are_taken_apart_as_they_are_drawn(lab: SceneRunner, folder: Path) -> None:
    """A house is four or five points of a strip: 2 or 3 triangles of 3 vertices each."""
    places = np.array([[-0.5, 0, 0], [0.5, 0, 0]], np.float32)
    points = Mesh(
        attributes={"aPos": places, "aColor": np.ones((2, 3), np.float32)}, primitive="points"
    )
    passes = mesh_pass(
        "world.vert", "corner.frag", points, geometry="house.geom", uniforms={"shift": 0.0}
    )

    def placed(gl_in_gl_Position: Any, emitted: Any, roof: Any = 0.4) -> Any:
        x = where(emitted > 3.5, 0.0, where(emitted % 2 < 0.5, -0.2, 0.2))
        y = where(emitted > 3.5, roof, where(emitted < 1.5, -0.2, 0.2))
        return gl_in_gl_Position[0] + vec4(x, y, 0.0, 0.0)

    def lower(gl_in_gl_Position: Any, emitted: Any) -> Any:
        return placed(gl_in_gl_Position, emitted, 0.39)

    record = run(lab, folder, passes, formula("gl_Position", placed), coverage(0))
    assert record.expectations[0].status == "pass", record
    assert record.expectations[0].judged == (2 + 3) * 3 * 4
    assert run(lab, folder, passes, formula("gl_Position", lower)).status == "fail"


def test_lines_that_show_normals(lab: SceneRunner, folder: Path) -> None:
    def along(gl_in_gl_Position: Any, world: Any, emitted: Any) -> Any:
        from shaderlab.glslmath import floor

        corner = floor(emitted * 0.5)
        foot = by_emitted(gl_in_gl_Position, corner)
        tip = emitted - 2.0 * corner
        return foot + vec4(by_emitted(world, corner) * 0.25, 0.0) * tip

    passes = mesh_pass("world.vert", "white.frag", TRIANGLES, geometry="normals.geom",
                       uniforms={"shift": 0.0})  # fmt: skip
    record = run(lab, folder, passes, formula("gl_Position", along))
    assert record.expectations[0].status == "pass", record
    assert record.expectations[0].judged == 2 * 6 * 4


def test_a_geometry_stage_takes_no_single_inputs(lab: SceneRunner, folder: Path) -> None:
    check = value("gl_Position", at={"aPos": (0.0, 0.0, 0.0)}, equals=(0, 0, 0, 1), digits=3,
                  reference=position)  # fmt: skip
    record = run(lab, folder, exploded(), check)
    assert record.status == "unsupported"
    assert "explode.geom" in record.message and "whole primitives" in record.message


@pytest.mark.parametrize("indexed", [False, True])
@pytest.mark.parametrize(
    ("primitive", "expected"),
    [
        ("points", [[0], [1], [2], [3], [4], [5]]),
        ("lines", [[0, 1], [2, 3], [4, 5]]),
        ("line_strip", [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]]),
        ("triangles", [[0, 1, 2], [3, 4, 5]]),
        ("triangle_strip", [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]]),
        ("triangle_fan", [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]),
    ],
)
def test_corners_of_primitives_are_those_that_the_driver_takes(
    lab: SceneRunner, folder: Path, primitive: str, expected: list[list[int]], indexed: bool
) -> None:
    order = np.array([3, 1, 4, 0, 5, 2]) if indexed else np.arange(6)
    positions = np.zeros((6, 3), np.float32)
    positions[order, 0] = np.arange(6)
    mesh = Mesh(
        attributes={"aPos": positions}, primitive=primitive, indices=order if indexed else None
    )
    assert primitive_corners(mesh).tolist() == order[np.array(expected)].tolist()
    word, size = {1: ("points", 1), 2: ("lines", 2), 3: ("triangles", 3)}[len(expected[0])]
    (folder / "number.vert").write_text(
        "#version 330 core\nin vec3 aPos; out float n;\n"
        "void main() { n = aPos.x; gl_Position = vec4(aPos, 1.0); }\n"
    )
    (folder / f"{word}.geom").write_text(
        f"#version 330 core\nlayout ({word}) in; layout (points, max_vertices = 3) out;\n"
        "in float n[]; out float m;\nvoid main() {\n"
        + "".join(
            f"m = n[{i}]; gl_Position = gl_in[{i}].gl_Position; EmitVertex();\n"
            for i in range(size)
        )
        + "}\n"
    )

    def emitted_in_order(n: Any, emitted: Any) -> Any:
        return by_emitted([*n, *n, *n][:3], emitted)

    passes = mesh_pass("number.vert", "white.frag", mesh, geometry=f"{word}.geom")
    record = run(lab, folder, passes, formula("m", emitted_in_order))
    assert record.expectations and record.expectations[0].status == "pass", record
