"""Meshes in every layout, instances, uniform blocks, queries and costs, on the driver itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    Depth,
    Draw,
    Mesh,
    Pass,
    State,
    Target,
    UniformBuffer,
    Variant,
    attribute_layout,
    block_layout,
    cost,
    exact,
    formula,
    fullscreen,
    mesh_pass,
    query,
    sweep,
    value,
)
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError
from shaderlab.glslmath import mul, vec4
from shaderlab.model.mesh import LAYOUTS, UPLOADS, USAGES
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

SQUARE = {
    "aPos": np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)], np.float32),
    "aColor": np.array([(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)], np.float32),
    "aKind": np.array([1, 2, 3, 4], np.int32),
}
INDICES = np.array([0, 1, 2, 0, 2, 3])
PLAIN = """#version 330 core
in vec2 aPos; in vec3 aColor; in int aKind;
out vec3 color; flat out int kind;
void main() { color = aColor; kind = aKind; gl_Position = vec4(aPos, 0.0, 1.0); }
"""
COLORED = """#version 330 core
in vec3 color; flat in int kind; out vec4 FragColor;
void main() { FragColor = vec4(color, float(kind)); }
"""
INSTANCED = """#version 330 core
in vec2 aPos; in vec3 aColor; in int aKind; in mat4 place; in float gain;
out vec3 color; flat out int kind;
void main() { color = aColor * gain; kind = aKind; gl_Position = place * vec4(aPos, 0.0, 1.0); }
"""
BLOCKS = """#version 330 core
struct Light { vec3 place; float gain[2]; };
layout (std140) uniform Matrices { mat4 projection; layout (row_major) mat4 view; };
layout (std140) uniform Scene { float time; vec3 tint; mat3 turn; Light lights[2]; } scene;
in vec2 TexCoords;
out vec4 first; out vec4 second;
void main() {
    first = projection * (view * vec4(TexCoords, 0.5, 1.0));
    second = vec4(scene.turn * scene.tint * scene.time, scene.lights[1].gain[1])
        + vec4(scene.lights[0].place * scene.lights[1].place, scene.lights[0].gain[0]);
}
"""
RANDOM = np.random.default_rng(7)
MATRICES = {"projection": RANDOM.uniform(-1, 1, (4, 4)), "view": RANDOM.uniform(-1, 1, (4, 4))}
SCENE: dict[str, Any] = {
    "time": 0.75,
    "tint": (0.5, -0.25, 2.0),
    "turn": RANDOM.uniform(-1, 1, (3, 3)),
    "lights[0].place": (1.0, 2.0, 3.0),
    "lights[0].gain": (0.5, 0.25),
    "lights[1].place": (0.25, 0.5, 0.125),
    "lights[1].gain": (8.0, 16.0),
}


def first(TexCoords: Any, projection: Any, view: Any) -> Any:
    """What the shader makes of a block without an instance name."""
    return mul(projection, mul(view, vec4(TexCoords, 0.5, 1.0)))


def second(
    Scene_turn: Any, Scene_tint: Any, Scene_time: Any, Scene_lights_place: Any,
    Scene_lights_gain: Any, Scene_lights_1_gain: Any,
) -> Any:  # fmt: skip
    """And of one with an instance name, its structs' members as lists."""
    near, far = Scene_lights_place
    color = mul(Scene_turn, Scene_tint) * Scene_time
    return vec4(color, Scene_lights_1_gain[1]) + vec4(near * far, Scene_lights_gain[0][0])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    texts = {
        "plain.vert": PLAIN, "colored.frag": COLORED, "instanced.vert": INSTANCED,
        "blocks.frag": BLOCKS,
    }  # fmt: skip
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def run(folder: Path, **case: Any) -> list[Record]:
    made = Case(title="a case", id="a-case", file=str(folder / "case.py"), **case)
    with SceneRunner(RunOptions()) as lab:
        return [lab.run(scene) for scene in made.scenes()]


def passed(records: list[Record]) -> bool:
    for record in records:
        for outcome in record.expectations:
            print(record.variant, outcome.name, outcome.status, outcome.message, outcome.rows)
        print(record.message)
    return all(record.status == "pass" for record in records)


def square(name: str = "main", **mesh: Any) -> tuple[Pass, ...]:
    made = Mesh(attributes=SQUARE, indices=INDICES, **mesh)
    return mesh_pass("plain.vert", "colored.frag", made, name=name)


def output(folder: Path, **mesh: Any) -> bytes:
    """All bytes of the picture of the square."""
    case = Case(
        title="a case", id="a-case", file=str(folder / "case.py"), passes=square(**mesh),
        expect=[exact("FragColor", 0.0)],
    )  # fmt: skip

    (scene,) = case.scenes()
    with SceneRunner() as lab, lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        return evaluation.frame.images["main", "FragColor"].values.tobytes()


def test_every_layout_upload_and_usage_draws_the_same_pixels(folder: Path) -> None:
    plain = output(folder)
    assert any(plain)
    for layout in LAYOUTS:
        for upload in UPLOADS:
            assert output(folder, layout=layout, upload=upload) == plain, (layout, upload)
    for usage in USAGES:
        assert output(folder, layout="batched", upload="sub_data", usage=usage) == plain, usage


PLACES = {
    "interleaved": {"aPos": (0, 24), "aColor": (8, 24), "aKind": (20, 24)},
    "batched": {"aPos": (0, 8), "aColor": (32, 12), "aKind": (80, 4)},
    "separate": {"aPos": (0, 8), "aColor": (0, 12), "aKind": (0, 4)},
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_opengl_reads_attributes_where_the_layout_says(folder: Path, layout: str) -> None:
    passes = square(layout=layout)
    assert passed(run(folder, passes=passes, expect=[attribute_layout(PLACES[layout])]))
    wrong = {**PLACES[layout], "aColor": (4, 12)}
    (record,) = run(folder, passes=passes, expect=[attribute_layout(wrong)])
    assert record.expectations[0].status == "fail"
    assert "aColor" in record.expectations[0].message
    (record,) = run(folder, passes=passes, expect=[attribute_layout({"aNormal": (0, 12)})])
    assert record.expectations[0].rows[0].measured == "not read"


def test_the_layout_is_in_the_record(folder: Path) -> None:
    mesh = {"layout": "interleaved", "usage": "stream_draw", "upload": "map"}
    (record,) = run(folder, passes=square(**mesh), expect=[attribute_layout({"aPos": (0, 24)})])
    (buffer,) = record.buffers
    assert (buffer.size, buffer.usage, buffer.upload) == (96, "stream_draw", "map")
    assert [(p.name, p.offset, p.stride) for p in buffer.parts] == [
        ("aPos", 0, 24), ("aColor", 8, 24), ("aKind", 20, 24),
    ]  # fmt: skip


def instanced(layout: str) -> tuple[Pass, ...]:
    mesh = Mesh(
        attributes=SQUARE,
        indices=INDICES,
        instance_attributes={"place": RANDOM.uniform(-1, 1, (3, 4, 4)), "gain": [0.5, 1.0, 2.0]},  # type: ignore[dict-item]
        layout=layout,
    )
    return mesh_pass("instanced.vert", "colored.frag", mesh, instances=3)


def placed(aPos: Any, place: Any) -> Any:
    return mul(place, vec4(aPos, 0.0, 1.0))


def gained(aColor: Any, gain: Any) -> Any:
    return aColor * gain


@pytest.mark.parametrize("layout", LAYOUTS)
def test_attributes_of_instances_matrices_too(folder: Path, layout: str) -> None:
    expect = [
        formula("gl_Position", placed),
        formula("color", gained),
        value("color", at={"aColor": (1.0, 0.5, 0.0), "gain": 3.0}, equals=(3.0, 1.5, 0.0),
              digits=6, reference=gained),
        query("vertices_submitted", equals=18),
    ]  # fmt: skip
    if layout == "interleaved":
        expect.append(attribute_layout({"place": (0, 68, 1), "gain": (64, 68, 1)}))  # type: ignore[arg-type]
    assert passed(run(folder, passes=instanced(layout), expect=expect))


def blocks(**buffers: UniformBuffer) -> tuple[Pass, ...]:
    given = {"Matrices": UniformBuffer(values=MATRICES), "Scene": UniformBuffer(values=SCENE)}
    return fullscreen("blocks.frag", blocks={**given, **buffers})


OFFSETS = {
    "time": 0, "tint": 16, "turn": 32, "lights[0].place": 80, "lights[0].gain": 96,
    "lights[1].place": 128, "lights[1].gain": 144,
}  # fmt: skip


def test_blocks_reach_the_shader_and_the_reference(folder: Path) -> None:
    expect = [
        formula("first", first),
        formula("second", second),
        block_layout("Matrices", {"projection": 0, "view": 64}, size=128),
        block_layout("Scene", OFFSETS, size=176),
        sweep("second", second, over="Scene.time", values=[0.0, 0.5, 3.0]),
        value("first", at={"TexCoords": (0.25, 0.5), "view": np.eye(4), "projection": np.eye(4)},
              equals=(0.25, 0.5, 0.5, 1.0), digits=6),
    ]  # fmt: skip
    records = run(
        folder, passes=blocks(), expect=expect,
        variants=[
            Variant("as it is"),
            Variant("later", {"Scene.time": 2.0, "Matrices.view": 2 * np.eye(4)}),
        ],
    )  # fmt: skip
    assert passed(records)
    assert [b.name for b in records[0].buffers] == ["Matrices", "Scene"]
    assert records[0].inputs["Scene.time"] == "0.75"
    assert records[1].inputs["Scene.time"] == "2"


def test_a_wrong_offset_is_noticed(folder: Path) -> None:
    expect = [block_layout("Scene", {"tint": 4, "turn": 32}, size=160)]
    (record,) = run(folder, passes=blocks(), expect=expect)
    assert [row.ok for row in record.expectations[0].rows] == [False, True, False]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"Matrices": UniformBuffer(values={"view": np.eye(4)})}, "projection"),
        (
            {"Matrices": UniformBuffer(values={**MATRICES, "model": np.eye(4)})},
            "no Matrices member 'model'",
        ),
        ({"Matrices": UniformBuffer(values={**MATRICES, "view": np.eye(3)})}, "mat4"),
        ({"Matrix": UniformBuffer(values=MATRICES)}, "no uniform block 'Matrix'"),
        ({"Scene": UniformBuffer(values={**SCENE, "lights[1].gain": (1.0, 2.0, 3.0)})}, "float"),
    ],
)
def test_what_does_not_fit_a_block_is_refused(
    folder: Path, change: dict[str, UniformBuffer], said: str
) -> None:
    (record,) = run(folder, passes=blocks(**change), expect=[formula("first", first)])
    assert record.status == "error"
    assert said in record.message


def test_a_missing_block_is_named(folder: Path) -> None:
    passes = fullscreen("blocks.frag", blocks={"Scene": UniformBuffer(values=SCENE)})
    (record,) = run(folder, passes=passes, expect=[formula("first", first)])
    assert record.status == "error"
    assert "uniform block Matrices" in record.message


def test_one_buffer_serves_several_programs_unless_they_lay_it_out_differently(
    folder: Path,
) -> None:
    same = "layout (std140) uniform Common { vec3 a; float b; };\n"
    head = "#version 330 core\nout vec4 color;\n"
    (folder / "one.frag").write_text(head + same + "void main() { color = vec4(a, b); }")
    (folder / "two.frag").write_text(head + same + "void main() { color = vec4(b, a); }")
    shared = UniformBuffer(values={"a": (1.0, 2.0, 3.0), "b": 4.0})
    passes = (
        *fullscreen("one.frag", name="one", blocks={"Common": shared}),
        *fullscreen("two.frag", name="two", blocks={"Common": shared}),
    )
    expect = [exact("one.color", (1, 2, 3, 4)), exact("two.color", (4, 1, 2, 3))]
    records = run(folder, passes=passes, expect=expect)
    assert passed(records)
    assert [b.used for b in records[0].buffers] == [2]

    (folder / "four.frag").write_text(
        head + "layout (std140) uniform Common { float b; vec3 a; };\n"
        "void main() { color = vec4(a, b); }"
    )
    passes = (
        *fullscreen("one.frag", name="one", blocks={"Common": shared}),
        *fullscreen("four.frag", name="four", blocks={"Common": shared}),
    )
    (record,) = run(folder, passes=passes, expect=[exact("one.color", (1, 2, 3, 4))])
    assert record.status == "error"
    assert "does not lie at the same place" in record.message


def test_a_block_that_the_driver_lays_out_otherwise_is_an_error_that_names_the_member(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from shaderlab.drivers.opengl import buffers

    real = buffers.read_block

    def elsewhere(program: Any, block: Any) -> Any:
        reading = real(program, block)
        if "tint" not in reading.offsets:
            return reading
        return replace(reading, offsets={**reading.offsets, "tint": 20})

    monkeypatch.setattr(buffers, "read_block", elsewhere)
    (record,) = run(folder, passes=blocks(), expect=[formula("first", first)])
    assert record.status == "error"
    assert "std140 puts tint at byte 16, the driver has it at byte 20" in record.message


def test_an_array_of_blocks_is_not_supported(folder: Path) -> None:
    (folder / "array.frag").write_text(
        "#version 330 core\nout vec4 color;\n"
        "layout (std140) uniform Part { vec4 tint; } parts[2];\n"
        "void main() { color = parts[0].tint + parts[1].tint; }"
    )
    passes = fullscreen("array.frag", blocks={"Part": UniformBuffer(values={"tint": (1, 2, 3, 4)})})
    (record,) = run(folder, passes=passes, expect=[exact("color", 0.0)])
    assert record.status == "unsupported"
    assert "array of uniform blocks" in record.message


def two_squares(**state: Any) -> tuple[Pass, ...]:
    draw = Draw(
        vertex="plain.vert", fragment="colored.frag", state=State(**state),
        mesh=Mesh(attributes=SQUARE, indices=INDICES),
    )  # fmt: skip
    return (Pass(target=Target(size=(64, 64), depth="depth24"), draws=(draw, draw)),)


def test_samples_are_counted_behind_the_depth_test(folder: Path) -> None:
    expect = [query("samples_passed", equals=1024, draw=0), query("samples_passed", equals=1024)]
    assert passed(run(folder, passes=two_squares(), expect=expect))
    hidden = [
        query("samples_passed", equals=1024, draw=0),
        query("samples_passed", equals=0, draw=1),
        query("fragment_shader_invocations", at_least=1024, draw=0),
    ]
    assert passed(run(folder, passes=two_squares(depth=Depth()), expect=hidden))
    (record,) = run(folder, passes=two_squares(), expect=[query("samples_passed", equals=1023)])
    assert record.expectations[0].status == "fail"


def test_culling_leaves_no_samples(folder: Path) -> None:
    expect = [query("samples_passed", equals=0), query("vertices_submitted", equals=6)]
    assert passed(run(folder, passes=two_squares(cull="front"), expect=expect))


@pytest.mark.parametrize(
    "given", [{}, {"equals": 3, "at_least": 2}, {"counter": "samples", "equals": 1}]
)
def test_a_query_without_sense_is_refused(given: dict[str, Any]) -> None:
    with pytest.raises(CaseError):
        query(**{"counter": "samples_passed", **given})


def table(**options: Any) -> Any:
    series = {"each": {1: "main", 2: ["main", "other"]}, "all": {1: "main", 2: "main"}}
    return cost(series, repeats=2, **options)


def test_cost_counts_exactly_and_never_judges_time(folder: Path) -> None:
    passes = (*square(), *square("other"))
    counts = {
        "draw_calls": {"each": lambda n: n, "all": lambda n: 1},
        "vertices": {"each": lambda n: 6 * n},
    }
    for cheaper in (("each", "all"), ("all", "each")):
        expect = [table(claim="one is cheaper", cheaper=cheaper, **counts)]
        records = run(folder, passes=passes, expect=expect)
        assert passed(records)
        *rows, claim = records[0].expectations[0].rows
        assert len(rows) == 4
        assert all("ms" in row.measured and "the fastest" in row.note for row in rows)
        assert "this driver" in claim.measured
        (plot,) = records[0].plots
        assert plot.x_label == "N" and plot.log_x and plot.log_y
        assert {(p.series, p.x) for p in plot.points} == {
            ("each", 1.0), ("each", 2.0), ("all", 1.0), ("all", 2.0),
        }  # fmt: skip
        for point, row in zip(plot.points, rows, strict=True):
            assert row.measured.endswith(f", {point.y:.3g} ms") and point.ok
    (record,) = run(folder, passes=passes, expect=[table(draw_calls={"all": lambda n: n})])
    assert record.expectations[0].status == "fail"
    assert "all, N = 2" in record.expectations[0].message


@pytest.mark.parametrize(
    "options", [{"claim": "x"}, {"cheaper": ("each", "all")}, {"draw_calls": {"few": int}}]
)
def test_a_cost_without_sense_is_refused(options: dict[str, Any]) -> None:
    with pytest.raises(CaseError):
        table(**options)


def test_arrays_of_vectors_are_no_matrices(folder: Path) -> None:
    """vec4[4] has the shape of a mat4, and vec4[2] the components of a mat2 in each row."""
    (folder / "rows.frag").write_text(
        "#version 330 core\nout vec4 sum;\nuniform vec4 four[4];\nuniform vec2 two[2];\n"
        "void main() { sum = four[1] + vec4(two[1], two[0]); }\n"
    )
    uniforms = {"four": np.arange(16.0).reshape(4, 4), "two": [(1.0, 2.0), (3.0, 4.0)]}
    expect = [exact("sum", (7.0, 9.0, 7.0, 9.0))]
    assert passed(run(folder, passes=fullscreen("rows.frag", uniforms=uniforms), expect=expect))
