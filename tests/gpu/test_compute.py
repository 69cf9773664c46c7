"""Compute passes: what buffers are given, what is left in them, and mistakes that are noticed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    Output,
    Pass,
    Pixel,
    Variant,
    block_layout,
    bounded,
    compute,
    exact,
    formula,
    fullscreen,
    measure,
    value,
)
from shaderlab.analysis.interpreter import Program, interpret, load
from shaderlab.analysis.interpreter.values import number_invocations
from shaderlab.analysis.invocations import sample_fragments
from shaderlab.analysis.self_check import SelfCheck
from shaderlab.compiler import Shaders
from shaderlab.drivers import Backend
from shaderlab.drivers.opengl import drawing as dispatch
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError, NotInterpretedError, UnsupportedError
from shaderlab.model.frame import Bindings, Texels
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record
from shaderlab.mutation.judging import Judge
from shaderlab.mutation.shader_mutants import mutate_case
from tests.meta.examples import File, examples

SUM = """#version 430 core
layout (local_size_x = 64) in;
layout (std430) readonly buffer In { uint values[]; };
layout (std430) buffer Sum { uint total; };
shared uint part[64];
void main() {
    uint i = gl_LocalInvocationIndex;
    part[i] = values[gl_GlobalInvocationID.x];
    barrier();
    for (uint step = 32u; step > 0u; step >>= 1u) {
        if (i < step) part[i] += part[i + step];
        barrier();
    }
    if (i == 0u) atomicAdd(total, part[0]);
}
"""
LAID_OUT = """#version 430 core
layout (local_size_x = 4) in;
struct Particle { vec3 place; float age; };
layout (LAYOUT) buffer Things { float dt; mat2x3 turn; layout (row_major) mat3 row; vec3 list[3]; };
layout (LAYOUT) buffer Swarm { ivec2 size; Particle particles[]; } swarm;
layout (LAYOUT) buffer Numbers { uint count; float numbers[]; };
layout (LAYOUT) buffer More { uint count; } more;
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i == 0u) {
        count = uint(numbers.length());
        more.count = uint(swarm.particles.length());
        turn[1] += turn[0];
        row[2][0] = row[0][2];
        list[2] = list[0] + list[1];
        swarm.size = -swarm.size;
    }
    swarm.particles[i].place *= 2.0;
    swarm.particles[i].age += dt;
    numbers[i] += float(i);
}
"""
TURN = np.arange(6.0).reshape(3, 2)
ROW = np.arange(9.0).reshape(3, 3)
THINGS: Mapping[str, Any] = {
    "dt": 0.1, "turn": TURN, "row": ROW, "list": np.arange(9.0).reshape(3, 3), "size": (3, -4),
    "particles.place": np.arange(12.0).reshape(4, 3), "particles.age": [1.0, 2.0, 3.0, 4.0],
    "Numbers.count": 0, "numbers": np.full(5, 0.5), "More.count": 0,
}  # fmt: skip


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions()) as made:
        yield made


def case_of(folder: Path, text: str, *expect: Any, **given: Any) -> Case:
    """A case of one shader, or of given passes of it."""
    (folder / "t.comp").write_text(text)
    passes = given.pop("passes", None) or compute("t.comp", **{"groups": (1, 1, 1), **given})
    return Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect)


def run(lab: SceneRunner, case: Case) -> Record:
    lab.forget_shaders()
    record = lab.run(case.scene("default"))
    print(record.message, *record.expectations, sep="\n")
    return record


def passed(record: Record) -> bool:
    return record.status == "pass"


def place(particles_place: Any) -> Any:
    return particles_place * 2.0


def age(particles_age: Any, dt: Any) -> Any:
    return particles_age + dt


def numbers(numbers: Any, list: Any) -> Any:
    """Of another length, an array is a list of its elements."""
    assert len(list) == 3
    return numbers + (list[2].x - 6.0)


# The guide's example ------------------------------------------------------------------------


@pytest.fixture
def guide(repository: Path, tmp_path: Path) -> Path:
    for each in examples(repository / "docs" / "guide" / "stages.md"):
        if isinstance(each, File) and each.name.startswith("smooth"):
            (tmp_path / each.name).write_text(each.text, encoding="utf-8")
    return tmp_path


def test_the_guides_example_passes_and_its_numbers_are_pictures(
    guide: Path, tmp_path: Path
) -> None:
    with SceneRunner(RunOptions(folder=tmp_path / "out")) as lab:
        records = [lab.run(scene) for scene in load_case(guide / "smooth.py").scenes()]
    assert all(map(passed, records)), records
    record = records[0]
    assert record.unread == ()
    assert [a.name for a in record.passes[0].attachments] == ["levels", "bright"]
    assert record.passes[1].reads == ("first.levels",)
    assert (tmp_path / "out" / record.images["picture"]).is_file()


@pytest.mark.parametrize(
    ("right", "wrong", "noticed"),
    [
        ("gain * samples[i]", "samples[i]", "first.levels"),
        ("uint i = gl_GlobalInvocationID.x", "uint i = gl_LocalInvocationID.x", "first.levels"),
        ("local_size_x = 64", "local_size_x = 63", "first.levels"),
        ("atomicAdd(bright, 1u)", "bright += 1u", "levels counted wrongly"),
        ("> 0.5", "> 0.4", "first.bright"),
    ],
)
def test_mistakes_in_a_shader_are_noticed(
    lab: SceneRunner, guide: Path, right: str, wrong: str, noticed: str
) -> None:
    shader = guide / "smooth.comp"
    text = shader.read_text()
    assert right in text
    shader.write_text(text.replace(right, wrong))
    record = run(lab, load_case(guide / "smooth.py"))
    assert noticed in [o.name for o in record.expectations if o.status == "fail"]


def test_mutants_of_a_compute_stage_are_judged(lab: SceneRunner, guide: Path) -> None:
    case = load_case(guide / "smooth.py")
    judge = Judge(lab, case)
    fates = [judge.judge(mutant).status for mutant in mutate_case(case)]
    assert fates.count("killed") > 8 and "survived" not in fates


def test_a_later_pass_is_judged_by_what_a_mutant_of_an_earlier_one_left(
    lab: SceneRunner, tmp_path: Path
) -> None:
    text = """#version 430 core
    layout (local_size_x = 8) in;
    layout (std430) buffer Data { uint values[]; };
    void main() { values[gl_GlobalInvocationID.x] *= 2u; }
    """
    (tmp_path / "first.comp").write_text(text.replace("2u", "3u"))

    def doubled(values: Any) -> Any:
        return values * 2

    groups = (1, 1, 1)
    passes = (
        *compute("first.comp", groups=groups, buffers={"values": np.arange(8)}, name="first"),
        *compute("t.comp", groups=groups, buffers={"values": Output("first.values")}),
    )
    case = case_of(tmp_path, text, formula("values", doubled), passes=passes)
    lab.forget_shaders()
    judge = Judge(lab, case)
    fates = {m.after: judge.judge(m).status for m in mutate_case(case) if m.shader == "first.comp"}
    assert "survived" in fates.values() and "killed" not in fates.values(), fates
    assert "killed" in [judge.judge(m).status for m in mutate_case(case) if m.shader == "t.comp"]


# Groups and barriers ------------------------------------------------------------------------


def total_of(lab: SceneRunner, folder: Path, text: str, groups: int) -> str:
    buffers = {"values": np.arange(256), "total": 0}
    expect = exact("total", 255 * 128)
    case = case_of(folder, text, expect, groups=(groups, 1, 1), buffers=buffers)
    return run(lab, case).expectations[0].status


def test_a_wrong_group_count_and_a_missing_barrier_are_noticed(
    lab: SceneRunner, tmp_path: Path
) -> None:
    assert total_of(lab, tmp_path, SUM, 4) == "pass"
    assert total_of(lab, tmp_path, SUM, 3) == "fail"
    assert total_of(lab, tmp_path, SUM.replace("    barrier();\n", ""), 4) == "fail"


def test_a_variant_changes_what_a_buffer_holds(lab: SceneRunner, tmp_path: Path) -> None:
    buffers = {"values": np.arange(64), "total": 0}
    ones = Variant("ones", {"values": np.ones(64)}, expect=[exact("total", 64)])
    case = replace(case_of(tmp_path, SUM, exact("total", 64), buffers=buffers), variants=[ones])
    lab.forget_shaders()
    assert passed(lab.run(case.scene("ones")))
    assert not passed(lab.run(replace(case, variants=[]).scene("default")))


def test_invocations_are_numbered_x_first(lab: SceneRunner, tmp_path: Path) -> None:
    text = """#version 430 core
    layout (local_size_x = 2, local_size_y = 3) in;
    layout (std430) buffer Data { uvec3 ids[]; };
    void main() {
        uvec3 id = gl_GlobalInvocationID, all = gl_NumWorkGroups * gl_WorkGroupSize;
        ids[(id.z * all.y + id.y) * all.x + id.x] = id;
    }
    """

    def ids(gl_GlobalInvocationID: Any) -> Any:
        return gl_GlobalInvocationID

    given = {"groups": (2, 1, 3), "buffers": {"ids": np.zeros((36, 3))}}
    assert passed(run(lab, case_of(tmp_path, text, formula("ids", ids), **given)))
    other = text.replace("id.y) * all.x", "id.y) * all.y")
    assert not passed(run(lab, case_of(tmp_path, other, formula("ids", ids), **given)))


# Layouts ------------------------------------------------------------------------------------


@pytest.mark.parametrize("layout", ["std430", "std140"])
def test_members_lie_where_the_layout_has_them(
    lab: SceneRunner, tmp_path: Path, layout: str
) -> None:
    turned, row = TURN.copy(), ROW.copy()
    turned[:, 1] += turned[:, 0]
    row[0, 2] = row[2, 0]
    stride = {"std430": 4, "std140": 16}[layout]
    text = LAID_OUT.replace("LAYOUT", layout)
    expect = [
        exact("turn", turned.T),  # a pixel for each column
        exact("row", row.T),
        exact("list", [(0, 1, 2), (3, 4, 5), (3, 5, 7)]),
        exact("size", (-3, 4)),
        exact("dt", np.float32(0.1)),
        exact("Numbers.count", 5),
        exact("More.count", 4),
        exact("numbers", 0.5 + np.array([0, 1, 2, 3, 0])),
        formula("particles.place", place),
        formula("particles.age", age),
        value("particles.age", reference=age, equals=4.1, digits=6, at=Pixel(3, 0)),
        block_layout("Numbers", {"count": 0, "numbers": max(4, stride)}),
    ]
    record = run(lab, case_of(tmp_path, text, *expect, buffers=THINGS))
    assert passed(record), record.message
    assert record.unread == ()


def test_another_layout_is_noticed(lab: SceneRunner, tmp_path: Path) -> None:
    """The lab gives each member its value wherever it lies: what a program outside would upload is
    judged by `block_layout`."""
    text = LAID_OUT.replace("LAYOUT", "std140")
    expect = block_layout("Numbers", {"count": 0, "numbers": 4})
    assert not passed(run(lab, case_of(tmp_path, text, expect, buffers=THINGS)))


def test_a_buffer_of_another_length_is_a_list(lab: SceneRunner, tmp_path: Path) -> None:
    text = LAID_OUT.replace("LAYOUT", "std430").replace("float(i)", "list[0].x")
    expect = formula("numbers", numbers)
    assert passed(run(lab, case_of(tmp_path, text, expect, groups=(2, 1, 1), buffers=THINGS)))


# What is refused ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"dt": None}, "t.comp: nothing is given for buffer dt (float)"),
        ({"speed": 1.0}, "t.comp: there is no buffer 'speed'"),
        ({"list": np.zeros((4, 3))}, "buffer 'list' is vec3[3]: it takes shape (3, 3), not (4, 3)"),
        ({"numbers": 1.0}, "buffer 'numbers' is float[]: it takes an array"),
        ({"numbers": []}, "buffer 'numbers' is float[]: it takes an array"),
        ({"Numbers.count": 0.5}, "buffer 'Numbers.count' is uint, but 0.5 is no integer"),
        ({"particles.age": [1.0]}, "one array of structs has one length"),
        ({"list": Output("later.list")}, "no earlier pass gives later.list"),
    ],
)
def test_what_does_not_fit_is_an_error(
    lab: SceneRunner, tmp_path: Path, change: dict[str, Any], said: str
) -> None:
    buffers = {name: v for name, v in {**THINGS, **change}.items() if v is not None}
    text = LAID_OUT.replace("LAYOUT", "std430")
    record = run(lab, case_of(tmp_path, text, exact("dt", 0.0), buffers=buffers))
    assert record.status == "error" and said in record.message


@pytest.mark.parametrize(
    ("declared", "said"),
    [
        ("layout (binding = 0) uniform atomic_uint c;", "c is an atomic_uint"),
        ("layout (std430) buffer Precise { double d; };", "d is double"),
        ("layout (std430) buffer Each { float e; } each[2];", "Each is an array of storage blocks"),
    ],
)
def test_what_is_not_supported_is_named(
    lab: SceneRunner, tmp_path: Path, declared: str, said: str
) -> None:
    text = SUM.replace("shared", f"{declared}\nshared")
    used = {"atomic_uint": "atomicCounterIncrement(c);", "Each": "each[1].e = 1.0;"}
    added = next((line for word, line in used.items() if word in declared), "d = 1.0LF;")
    text = text.replace("    barrier();\n    for", f"    {added}\n    barrier();\n    for")
    buffers = {"values": np.arange(64), "total": 0}
    record = run(lab, case_of(tmp_path, text, exact("total", 0), buffers=buffers))
    assert record.status == "unsupported" and said in record.message, record.message


def test_drivers_without_compute_say_so(
    lab: SceneRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(UnsupportedError, match="compute passes run on OpenGL drivers only"):
        Backend.require_compute(lab.backend)
    monkeypatch.setattr(dispatch, "has_compute", lambda device: False)
    buffers = {"values": np.arange(64), "total": 0}
    record = run(lab, case_of(tmp_path, SUM, exact("total", 0), buffers=buffers))
    assert record.status == "unsupported"
    assert "this driver has no compute shaders" in record.message


def test_kinds_that_need_a_fragment_stage_say_so(lab: SceneRunner, tmp_path: Path) -> None:
    buffers = {"values": np.arange(64), "total": 0}
    ranged = bounded("total", 0, 1, over="values", values=[0, 1])
    record = run(lab, case_of(tmp_path, SUM, ranged, buffers=buffers))
    assert record.status == "unsupported"
    assert "running a compute stage on given inputs" in record.message

    case = case_of(tmp_path, SUM, exact("total", 2016), buffers=buffers)
    scene = case.scene("default")
    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        with pytest.raises(NotInterpretedError, match="not interpreted: compute stage"):
            sample_fragments(evaluation, ("main", 0))
        with pytest.raises(UnsupportedError, match="it is a dispatch"):
            evaluation.session.query("time", "main", 1)
        (row,) = SelfCheck(evaluation, every=True).judgement()[1].outcome.rows
        assert row.measured == "not interpreted: compute stage"


def test_a_buffer_is_no_texture(lab: SceneRunner, tmp_path: Path) -> None:
    (tmp_path / "t.frag").write_text(
        "#version 330 core\nin vec2 TexCoords; uniform sampler2D s; out vec4 c;\n"
        "void main() { c = texture(s, TexCoords); }\n"
    )
    given = {"groups": (1, 1, 1), "buffers": {"values": np.arange(64), "total": 0}}
    drawn = fullscreen("t.frag", textures={"s": Output("sum.total")})
    passes = (*compute("t.comp", name="sum", **given), *drawn)
    record = run(lab, case_of(tmp_path, SUM, exact("c", 0.0), passes=passes))
    assert record.status == "unsupported" and "sampling a buffer" in record.message


def test_what_nothing_reads_is_named(lab: SceneRunner, tmp_path: Path) -> None:
    def rows(Numbers_count: Any) -> Any:
        return Numbers_count.item()

    text = LAID_OUT.replace("LAYOUT", "std430")
    figure = measure("count", rows, equals=5, digits=0)
    record = run(lab, case_of(tmp_path, text, figure, buffers=THINGS))
    assert passed(record) and "main.particles.age" in record.unread


@pytest.mark.parametrize(
    "given",
    [
        {"mesh": "x.vert"},
        {"groups": (0, 1, 1)},
        {"instances": 2},
        {"fragment": "t.frag"},
    ],
)
def test_a_dispatch_has_nothing_of_a_draw(given: dict[str, Any]) -> None:
    from shaderlab import Draw

    with pytest.raises(CaseError):
        Draw(compute="t.comp", **given)


def test_a_dispatch_is_a_pass_of_its_own() -> None:
    from shaderlab import Draw, Target

    draw = Draw(compute="t.comp", buffers={"a": 0})
    with pytest.raises(CaseError, match="the only draw of its pass"):
        Pass(draws=(draw, draw))
    with pytest.raises(CaseError, match="the only draw of its pass"):
        Pass(draws=(draw,), target=Target(size=(8, 8)))
    with pytest.raises(CaseError, match="belong to a compute shader"):
        Draw(fragment="t.frag", domain={}, buffers={"a": 0})
    with pytest.raises(CaseError, match="give a fragment shader, or a compute shader"):
        Draw()


# The interpreter ------------------------------------------------------------------------------


def test_what_workgroups_compute_is_what_the_interpreter_says(
    lab: SceneRunner, repository: Path, tmp_path: Path
) -> None:
    rng = np.random.default_rng(3)
    shaders = Shaders([repository / "shaders"])
    scan, fft = (
        load(shaders.load(f"ch15_beyond/{name}.comp", "compute")) for name in ("scan", "fft")
    )
    given = rng.integers(0, 1000, 256)
    each = {**workgroup(scan, 0), "numbers": given[None], "sums": np.zeros((1, 256))}
    summed = interpret(scan, each).outputs["sums"]
    sums = np.array([summed[k].lo[k, 0] for k in range(256)])
    assert np.array_equal(sums, np.cumsum(given))

    def sums_differ(sums: Any) -> float:
        return float(np.abs(np.ravel(sums) - expected).max())

    expected, figure = sums, measure("differ", sums_differ, equals=0, digits=0)
    buffers = {"numbers": given, "sums": np.zeros(256)}
    assert passed(run(lab, case_of(tmp_path, scan.source.text, figure, buffers=buffers)))

    before = rng.random((128, 128, 2), np.float32)
    turns = np.exp(-2j * np.pi * np.arange(64) / 128)
    uniforms = {"upright": False, "roots": np.stack([turns.real, turns.imag], 1).astype(np.float32)}
    texels = Texels(before, ("nearest",) * 2, ("clamp_to_edge",) * 3, (0.0,) * 4, format="rg32f")
    bindings = Bindings(uniforms=uniforms, textures={"before": texels, "after": texels})
    found = interpret(fft, workgroup(fft, 5), bindings).outputs
    line = np.zeros((128, 2), np.float32)
    for values, places in zip(found["after"], found["after at"], strict=True):
        assert (places.lo[:, 1] == 5).all()
        line[places.lo[:, 0]] = values
    whole = np.fft.fft(before[5, :, 0] + 1j * before[5, :, 1])
    assert np.allclose(line[:, 0] + 1j * line[:, 1], whole, atol=1e-4)

    def lines_differ(after: Any) -> float:
        return float(np.abs(np.asarray(after).reshape(128, 128, 2)[5] - line).max())

    figure = measure("differ", lines_differ, at_most=1e-4)
    images = {"before": before, "after": np.zeros((128, 128, 2))}
    case = case_of(
        tmp_path, fft.source.text, figure, groups=(128, 1, 1), uniforms=uniforms, images=images
    )
    assert passed(run(lab, case))


def workgroup(program: Program, number: int) -> dict[str, Any]:
    """What numbers the invocations of a workgroup in x."""
    size = program.local_size
    local = np.zeros((size[0], 3), np.int64)
    local[:, 0] = np.arange(size[0])
    return number_invocations(size, np.tile([number, 0, 0], (size[0], 1)), local)
