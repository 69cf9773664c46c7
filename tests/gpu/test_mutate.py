"""`shaderlab mutate` on a driver: what is noticed, what gets by, and what can't take it down."""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.jobs import ProcessExecutor
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderlabError
from shaderlab.model.options import Limits
from shaderlab.mutation import (
    CaseTarget,
    MutantResult,
    MutationPlan,
    MutationRun,
    ShaderMutant,
    make_mutants,
)
from shaderlab.mutation.judging import Judge, PartError
from shaderlab.mutation.mutants import Effect
from shaderlab.mutation.state_mutants import mutate_state

SHADER = """\
#version 330 core
#include "law.glsl"
in float d;
uniform float gain;
layout (location = 0) out float factor;
layout (location = 1) out vec4 FragColor;

void main()
{
    factor = law(d, gain);
    FragColor = vec4(factor, 0.5, 0.25, 1.0);
}
"""
LAW = """\
// The law.
float law(float x, float gain)
{
    float sum = 0.0;
    for (int i = 0; i < 4; ++i)
        sum += gain * 0.25;
    return max(sum * x, 0.0) + 0.5;
}
float unused(float x) { return -x; }
"""
CASE = '''\
"""A law."""
from shaderlab import Case, across, formula, fullscreen
from shaderlab.glslmath import max


def law(d, gain):
    """The law."""
    return max(gain * d, 0.0) + 0.5


case = Case(
    title="A law",
    passes=fullscreen("law.frag", domain={"d": across(START, 2.0)}, uniforms={"gain": 3.0}),
    expect=[formula("factor", law)],
)
'''
STATEFUL = '''\
"""A quad, kept by a depth test."""
from shaderlab import Case, Depth, Mesh, State, Target, coverage, mesh_pass

QUAD = Mesh(attributes={"aPos": [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]]},
            primitive="triangle_strip")
case = Case(
    title="A quad",
    passes=mesh_pass("quad.vert", "quad.frag", QUAD,
                     target=Target(size=(8, 8), depth="depth24"), state=State(depth=Depth())),
    expect=[coverage(16)],
)
'''

COMPARED = '''\
"""Two overlapping quads, in either order."""
from shaderlab import Depth, Draw, Mesh, Pass, State, Target, Case
from shaderlab.engine.expectations.any_order import any_order, both_ways


def quad(z):
    corners = [[-0.5, -0.5, z], [0.5, -0.5, z], [-0.5, 0.5, z], [0.5, 0.5, z]]
    mesh = Mesh(attributes={"aPos": corners}, primitive="triangle_strip")
    state = State(depth=Depth(), cull="back")
    return Draw(vertex="deep.vert", fragment="deep.frag", mesh=mesh, state=state)


target = Target(size=(8, 8), depth="depth24")
case = Case(
    title="Two quads",
    passes=both_ways(Pass(name="quads", target=target, draws=(quad(0.5), quad(-0.5)))),
    expect=[any_order("quads.FragColor")],
)
'''


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "law.frag").write_text(SHADER)
    (tmp_path / "law.glsl").write_text(LAW)
    (tmp_path / "law.py").write_text(CASE.replace("START", "-1.0"))
    (tmp_path / "weak.py").write_text(CASE.replace("START", "0.0"))
    (tmp_path / "quad.py").write_text(STATEFUL)
    (tmp_path / "quad.vert").write_text(
        "#version 330 core\nin vec2 aPos;\nvoid main() { gl_Position = vec4(aPos, 0.0, 1.0); }\n"
    )
    (tmp_path / "quad.frag").write_text(
        "#version 330 core\nout vec4 FragColor;\nvoid main() { FragColor = vec4(1.0); }\n"
    )
    (tmp_path / "compared.py").write_text(COMPARED)
    (tmp_path / "deep.vert").write_text(
        "#version 330 core\nin vec3 aPos;\nvoid main() { gl_Position = vec4(aPos, 1.0); }\n"
    )
    (tmp_path / "deep.frag").write_text(
        "#version 330 core\nout vec4 FragColor;\n"
        "void main() { FragColor = vec4(gl_FragCoord.z); }\n"
    )
    return tmp_path


@pytest.fixture(scope="module")
def law_fates(tmp_path_factory: pytest.TempPathFactory) -> Mapping[tuple[str, str, str], str]:
    """What becomes of each mutant of law.py."""
    folder = tmp_path_factory.mktemp("law")
    for name, text in (("frag", SHADER), ("glsl", LAW), ("py", CASE.replace("START", "-1.0"))):
        (folder / f"law.{name}").write_text(text)
    return fates(folder / "law.py")


def fates(file: Path, kind: str = "") -> dict[tuple[str, str, str], str]:
    """Each mutant's fate (of one kind only), judged in this process."""
    case = load_case(file)
    with SceneRunner() as lab:
        judge = Judge(lab, case)
        return {
            (m.operator, m.before, m.after): judge.judge(m).status
            for m in make_mutants(case, MutationPlan(state=False))
            if isinstance(m, ShaderMutant) and kind in m.operator
        }


def test_what_is_noticed_and_what_gets_by(
    folder: Path, law_fates: Mapping[tuple[str, str, str], str]
) -> None:
    found, weak = law_fates, fates(folder / "weak.py", "max dropped")
    assert found["constant + 1 %", "gain * 0.25", "gain * 0.2525"] == "killed"
    assert found["max dropped", "max(sum * x, 0.0)", "(sum * x)"] == "killed"
    assert found["operator", "max(sum * x, 0.0) + 0.5", "max(sum * x, 0.0) - 0.5"] == "killed"
    # Only the colour for people changes, which no expectation reads: that is missed.
    shown = ("vec4(factor, 0.5, 0.25, 1.0)", "vec4(factor, 0.505, 0.25, 1.0)")
    assert found["constant + 1 %", *shown] == "survived"
    # Where the case's inputs are all positive, a forgotten max gets by.
    assert weak["max dropped", "max(sum * x, 0.0)", "(sum * x)"] == "survived"
    assert not any("-x" in before for _, before, _ in found), "law.glsl's unused function"


def by_hand(text: str, right: str, wrong: str) -> ShaderMutant:
    """law.frag, which is `text` with its includes, with `wrong` in place of `right`."""
    assert right in text
    return ShaderMutant(
        file="law.frag", line=1, operator="by hand", before=right, after=wrong,
        program=("law.frag",), shader="law.frag", stage="fragment", text=text.replace(right, wrong),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("right", "wrong", "status"),
    [
        ("gain * 0.25", "0.25 * gain", "no difference"),
        ("max(sum * x, 0.0)", "max(0.0, sum * x)", "no difference"),
        ("sum * x", "(float(1 - 1) + sum) * x", "equivalent"),
        ("sum * x", "sum * y", "invalid"),
        ("float sum = 0.0", "float sum = 0", "equivalent"),
        ("float sum = 0.0", "bool sum = 0.0", "invalid"),
        ("+ 0.5", "+ 0.505", "killed"),
        # Nowhere in the case is |x| so large: only wider inputs tell.
        ("return max", "return x > 50.0 ? 0.0 : max", "survived"),
    ],
)
def test_a_mutant_of_every_fate(folder: Path, right: str, wrong: str, status: str) -> None:
    flat = SHADER.replace('#include "law.glsl"\n', LAW)
    with SceneRunner() as lab:
        fate = Judge(lab, load_case(folder / "law.py")).judge(by_hand(flat, right, wrong))
    assert fate.status == status
    if status == "no difference":
        assert re.fullmatch(r"no difference found in \d{5} inputs", fate.by)


GREY = """\
#version 330 core
in vec2 TexCoords;
uniform sampler2D image;
uniform float bias;
out vec4 FragColor;

void main()
{
    vec3 texel = texture(image, TexCoords).rgb;
    FragColor = vec4(texel.r, texel.g, min(texel.b, 4.0), clamp(bias, 0.0, 0.5));
}
"""
GREY_CASE = '''\
"""A grey picture."""
import numpy as np
from shaderlab import Case, Output, Texture, formula, fullscreen
from shaderlab.glslmath import vec4
from shaderlab.glslmath.sampling import texture


def shown(image, TexCoords, bias):
    return vec4(texture(image, TexCoords)[..., :3], bias)


GREYS = np.full((4, 4, 3), 0.25)
case = Case(
    title="Grey",
    passes=FIRST + fullscreen("law.frag", uniforms={"bias": 0.25},
                              textures={"image": SOURCE}),
    expect=[formula("FragColor", shown)],
)
'''
FLAT = """\
#version 330 core
out vec4 grey;
void main() { grey = vec4(0.25); }
"""
SOURCES = {
    "given": ("()", 'Texture(image=GREYS, format="rgb32f")'),
    "8 bits": ("()", 'Texture(image=GREYS, format="rgb8")'),
    "drawn": ('fullscreen("flat.frag", domain={}, name="first")', 'Output("first.grey")'),
}


UNSEEN = {
    "vec4(texel.r, texel.g,": "vec4(texel.g, texel.r,",  # a grey texture has no colours
    "min(texel.b, 4.0)": "texel.b",  # no texel is so large
    "clamp(bias, 0.0, 0.5)": "min(bias, 0.5)",  # the case's bias is 0.25
    "vec3 texel =": "if (gl_FragCoord.x > 70.0) return; vec3 texel =",  # its frame has 64 pixels
}


@pytest.mark.parametrize("source", SOURCES)
def test_what_no_input_of_the_case_shows_is_not_called_equivalent(
    tmp_path: Path, source: str
) -> None:
    first, image = SOURCES[source]
    (tmp_path / "law.frag").write_text(GREY)
    (tmp_path / "flat.frag").write_text(FLAT)
    file = tmp_path / "grey.py"
    file.write_text(GREY_CASE.replace("FIRST", first).replace("SOURCE", image))
    with SceneRunner() as lab:
        judge = Judge(lab, load_case(file))
        found = {right: judge.judge(by_hand(GREY, right, wrong)) for right, wrong in UNSEEN.items()}
    if source == "8 bits":  # which hold nothing above 1
        assert found.pop("min(texel.b, 4.0)").status == "no difference"
    missed = MutantResult(status="survived", by="only on other inputs: main.FragColor")
    assert found == dict.fromkeys(found, missed)


BLENDED_CASE = '''\
"""Light on a black ground."""
from shaderlab import Blend, Case, State, exact, fullscreen

case = Case(
    title="Blended",
    passes=fullscreen("flat.frag", domain={},
                      state=State(blend=Blend(source="one", destination="one"))),
    expect=[exact("grey", 0.25)],
)
'''


def test_a_black_ground_hides_a_mistake_in_blending(tmp_path: Path) -> None:
    (tmp_path / "flat.frag").write_text(FLAT)
    (tmp_path / "blended.py").write_text(BLENDED_CASE)
    case = load_case(tmp_path / "blended.py")
    (wrong,) = (m for m in mutate_state(case) if (m.path, m.new) == ("blend.destination", "zero"))
    with SceneRunner() as lab:
        fate = Judge(lab, case).judge(wrong)
    assert fate == MutantResult(status="survived", by="only on other inputs: main.grey")


UNREAD = """\
#version 330 core
in vec2 TexCoords;
layout (location = 0) out float judged;
layout (location = 1) out vec4 shown;

void main()
{
    judged = TexCoords.x;
    shown = vec4(TexCoords, 0.5, 1.0);
}
"""
UNREAD_CASE = '''\
"""Two outputs, of which one is read, and a pass that nothing reads."""
from shaderlab import Case, Draw, Pass, formula, fullscreen

(main,) = fullscreen("law.frag")
case = Case(
    title="Unread",
    passes=(main, *fullscreen("flat.frag", domain={}, name="picture")),
    expect=[formula("main.judged", lambda TexCoords: TexCoords[..., :1])],
)
'''


def test_what_no_expectation_reads_is_missed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "law.frag").write_text(UNREAD)
    (tmp_path / "flat.frag").write_text(FLAT)
    (tmp_path / "unread.py").write_text(UNREAD_CASE)
    monkeypatch.chdir(tmp_path)
    code, output = mutate("./unread.py", "--json", "out.json", "--fail-under", 90, "--jobs", 0)
    (case,) = json.loads((tmp_path / "out.json").read_text())["cases"]
    notes = {s["note"] for s in case["survived"]}
    assert code == 1 and case["score"] < 0.9, output
    assert "seen in default: main.shown, which no expectation reads" in notes
    assert "seen in default: picture.grey, which no expectation reads" in notes


LAW_TWICE = '''\
"""One law in two programs; the second is drawn where the factor does not matter."""
from shaderlab import Case, across, formula, fullscreen
from shaderlab.glslmath import max


def law(d, gain):
    return max(gain * d, 0.0) + 0.5


def drawn(shader, name, end):
    domain = {"d": across(-1.0, end)}
    return fullscreen(shader, domain=domain, uniforms={"gain": 3.0}, name=name)


case = Case(
    title="Twice",
    passes=(*drawn("law.frag", "first", 2.0), *drawn("again.frag", "second", 0.0)),
    expect=[formula("first.factor", law), formula("second.factor", law)],
)
'''


def test_a_mutant_is_one_place_in_one_program(folder: Path) -> None:
    (folder / "again.frag").write_text(SHADER)
    (folder / "twice.py").write_text(LAW_TWICE)
    found = {}
    with SceneRunner() as lab:
        case = load_case(folder / "twice.py")
        judge = Judge(lab, case)
        for m in make_mutants(case, MutationPlan(state=False)):
            if (m.before, m.after) == ("gain * 0.25", "gain * 0.2525"):
                assert (m.file, m.line) == (str(folder / "law.glsl"), 6)
                found[m.program] = judge.judge(m).status
    assert found == {("law.frag",): "killed", ("again.frag",): "survived"}


def test_state_is_mutated_too(folder: Path) -> None:
    case = load_case(folder / "quad.py")
    with SceneRunner() as lab:
        judge = Judge(lab, case)
        found = {(m.path, m.new): judge.judge(m).status for m in mutate_state(case)}
    assert found == {
        ("depth", None): "no difference",  # nothing is there to be hidden by
        ("depth.write", False): "no difference",
        ("depth.func", "lequal"): "no difference",
        ("depth.func", "greater"): "killed",
    }


def test_what_is_compared_with_another_pass_is_drawn_with_it(folder: Path) -> None:
    case = load_case(folder / "compared.py")
    with SceneRunner() as lab:
        judge = Judge(lab, case)
        shaders = [judge.judge(m) for m in make_mutants(case, MutationPlan(state=False))]
        # Of the near quad and of the far one; each is a mistake in both passes.
        state = {m: judge.judge(m) for m in mutate_state(case)}
    hidden = list(state.values())
    # Both passes are drawn with the same mistake: a comparison of them can't tell.
    assert "survived" in {f.status for f in shaders}
    assert not [f for f in shaders + hidden if "CaseError" in f.by]
    killed = [f.by for f in hidden if f.status == "killed"]
    assert set(killed) == {"default · quads.FragColor: any order of drawing"}
    # Where two surfaces are equally far, either may be seen; no back side is there to be culled.
    # The far quad is hidden, whether it is culled or not.
    kept = {(m.path, m.new) for m, f in state.items() if f.status != "killed"}
    assert kept == {
        ("depth.func", "lequal"),
        ("cull", None),
        ("cull", "front"),
        ("front_face", "cw"),
    }
    near = {m.path for m, f in state.items() if ("quads", 1) in m.draws and f.status == "killed"}
    assert near == {"depth", "depth.write", "depth.func", "cull", "front_face"}


UNUSED = """\
#version 330 core
in vec2 aPos;
out vec3 place;
void main() { place = vec3(aPos, 0.5); gl_Position = vec4(aPos, 0.0, 1.0); }
"""


def test_an_output_that_a_mutant_never_writes_is_captured_nevertheless(folder: Path) -> None:
    """Nothing asks for it: the mutant compiles, draws the same, and gives the next stage less."""
    (folder / "quad.vert").write_text(UNUSED)
    case = load_case(folder / "quad.py")
    with SceneRunner() as lab:
        judge = Judge(lab, case)
        found = {
            m.after: judge.judge(m).by
            for m in make_mutants(case, MutationPlan(state=False))
            if isinstance(m, ShaderMutant) and m.operator == "statement removed"
            and "place" in m.before
        }  # fmt: skip
    missed = "only on other inputs: main.place, which no expectation reads"
    assert set(found.values()) == {missed}, found


def test_a_part_that_does_not_run_unmutated_kills_nobody(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Were a pass left out that another one is compared with, every mutant would seem noticed."""
    case = load_case(folder / "compared.py")
    with SceneRunner() as lab:
        judge = Judge(lab, case)
        mutant = next(m for m in make_mutants(case, MutationPlan(state=False)))
        assert judge.judge(mutant).status != "invalid"
        monkeypatch.setattr("shaderlab.mutation.mutants.with_read_passes", lambda *_: {"quads"})
        with pytest.raises(PartError, match="the passes quads do not run by themselves") as caught:
            judge.judge(mutant)
    assert caught.value.file == str(folder / "compared.py")


def test_an_error_of_the_mutant_alone_kills_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = load_case(folder / "quad.py")
    with SceneRunner() as lab:
        judge = Judge(lab, case)
        mutant = next(m for m in mutate_state(case))
        wrong = replace(next(case.scenes()), passes=())
        effect = Effect(wrong, frozenset({mutant.draws[0][0]}))
        monkeypatch.setattr(type(mutant), "effect", lambda *_: effect)
        fate = judge.judge(mutant)
    assert fate.status == "killed" and "Error" in fate.by


TROUBLE = """
import os, signal, time
from shaderlab.mutation import judging

right = judging.Judge.judge

def fate(self, mutant):
    if mutant.after == "(sum * x)":
        signal.setitimer(signal.ITIMER_REAL, 0.2)  # as the lab's own alarm does later
        time.sleep(600)
    if mutant.after == "i <= 4":
        os.abort()
    if mutant.after == "sum / x":
        return bytearray(64 << 30)
    return right(self, mutant)

judging.Judge.judge = fate
"""


def test_what_hangs_or_crashes_is_killed_and_the_rest_goes_on(
    folder: Path, law_fates: Mapping[tuple[str, str, str], str]
) -> None:
    """The case file itself brings the trouble, as its own process is the only one that loads it."""
    file, expected = folder / "law.py", law_fates
    file.write_text(file.read_text() + TROUBLE)
    plan = MutationPlan(state=False)
    with contextlib.closing(ProcessExecutor(limits=Limits(seconds=60.0), workers=2)) as executor:
        campaign = MutationRun([CaseTarget(file, "law", plan)], executor)
        told = list(campaign.judge())
    (result,) = campaign.results()
    assert len(told) == campaign.total == len(result.runs) >= len(expected)
    causes = {"(sum * x)": "timeout", "i <= 4": "SIGABRT", "sum / x": "SIGABRT"}
    for tried in result.runs:
        mutant, fate = tried.mutant, tried.result
        if mutant.after in causes:
            assert fate.status == "killed" and causes[mutant.after] in fate.by
        else:
            assert fate.status == expected[mutant.operator, mutant.before, mutant.after], mutant
    assert set(causes) <= {tried.mutant.after for tried in result.runs}


def test_a_case_that_dies_unmutated_is_not_opened_for_each_mutant(folder: Path) -> None:
    text = (folder / "law.py").read_text()
    opened = folder / "opened"
    (folder / "dies.py").write_text(
        text.replace(
            '    """The law."""\n',
            f"    open({str(opened)!r}, 'a').write('x')\n    import os; os._exit(3)\n",
        )
    )
    with contextlib.closing(ProcessExecutor(workers=1)) as executor:
        files = {folder / "dies.py": "dies", folder / "law.py": "law"}
        plan = MutationPlan(limit=5)
        campaign = MutationRun([CaseTarget(f, i, plan) for f, i in files.items()], executor)
        told = list(campaign.judge())
    broken, good = campaign.results()
    assert "does not run to its end: the process died: exit status 3" in broken.message
    assert broken.runs == () and len(good.runs) == 5 and not good.message
    assert [fate is None for _, fate in told] == [True] * 5 + [False] * 5
    # Once, once more in a fresh process, and where a worker was quicker than the news.
    assert 2 <= len(opened.read_text()) <= 3


def test_a_case_file_that_crashes_is_a_message_and_stops_no_other(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    (folder / "crashes.py").write_text((folder / "law.py").read_text() + "import os; os._exit(7)\n")
    code, output = mutate("./crashes.py", "./weak.py", "--limit", 1, "--json", "out.json")
    assert code == 1
    assert "crashes: making its mutants: the process died: exit status 7" in output
    broken, weak = json.loads((folder / "out.json").read_text())["cases"]
    assert "message" in broken and "message" not in weak


def mutate(*arguments: Any) -> tuple[int, str]:
    result = CliRunner().invoke(cli, ["mutate", *map(str, arguments)])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.output


def test_the_command_shows_each_survivor_s_place_and_writes_json(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    code, output = mutate("./weak.py", "--json", "out.json", "--report", "kept", "--jobs", 0)
    assert code == 0
    assert "law.glsl:7  max dropped: max(sum * x, 0.0) → (sum * x)" in output
    data = json.loads((folder / "out.json").read_text())
    assert json.loads((folder / "kept" / "mutation.json").read_text()) == data
    (case,) = data["cases"]
    assert case["id"] == "weak" and case["killed"] > 20
    assert 0.5 < case["score"] < 1.0 and case["score"] == data["score"]
    assert any(s["line"] == 7 and s["operator"] == "max dropped" for s in case["survived"])


def test_both_stages_of_one_file_are_drawn_and_mutated(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mistake in one stage leaves the other as it is: each mutant compiles."""
    monkeypatch.chdir(folder)
    both = [f"#type {stage}\n{(folder / f'quad.{stage[:4]}').read_text()}"
            for stage in ("vertex", "fragment")]  # fmt: skip
    (folder / "both.glsl").write_text("\n".join(both))
    words = STATEFUL.replace("quad.vert", "both.glsl").replace("quad.frag", "both.glsl")
    (folder / "both.py").write_text(words)
    found = []
    for name in ("quad", "both"):
        mutate(f"./{name}.py", "--json", "out.json", "--jobs", 0)
        (case,) = json.loads((folder / "out.json").read_text())["cases"]
        found.append({key: case[key] for key in ("killed", "invalid", "equivalent")})
    assert found[0] == found[1] and found[0]["killed"] > 5


def test_a_sample_and_a_score_to_reach(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    code, _ = mutate("./weak.py", "--limit", 6, "--seed", 3, "--json", "a.json", "--jobs", 0)
    again, _ = mutate("./weak.py", "--limit", 6, "--seed", 3, "--json", "b.json", "--jobs", 0)
    one, other = (json.loads((folder / f"{n}.json").read_text()) for n in "ab")
    for data in (one, other):
        data["cases"][0].pop("seconds")
    assert (code, again, one) == (0, 0, other)
    case = one["cases"][0]
    counted = sum(case[k] for k in ("killed", "equivalent", "invalid"))
    assert counted + len(case["survived"]) + len(case["no_difference"]) == 6
    code, _ = mutate("./weak.py", "--limit", 6, "--seed", 3, "--fail-under", 100, "--jobs", 0)
    assert code == (0 if one["score"] == 1.0 else 1)


@pytest.mark.parametrize(
    ("end", "status"), [(KeyboardInterrupt(), 130), (ShaderlabError("can't start a worker"), 1)]
)
def test_what_ends_it_early_keeps_the_cases_that_are_done(
    folder: Path, monkeypatch: pytest.MonkeyPatch, end: BaseException, status: int
) -> None:
    monkeypatch.chdir(folder)
    judge = MutationRun.judge

    def until_the_second_case(self: MutationRun) -> Iterator[tuple[str, MutantResult | None]]:
        for case_id, fate in judge(self):
            yield case_id, fate
            if len(self.results(complete=True)) == 1:
                raise end

    monkeypatch.setattr(MutationRun, "judge", until_the_second_case)
    words = ("./weak.py", "./law.py", "--no-state", "--limit", 3, "--json", "a.json", "--jobs", 0)
    code, output = mutate(*words)
    assert code == status
    assert "interrupted: 3 of 6 mutants were judged" in output
    kept = json.loads((folder / "a.json").read_text())
    assert kept["interrupted"] is True and len(kept["cases"]) == 1


def test_a_case_that_fails_as_it_is_is_not_measured(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    (folder / "law.glsl").write_text(LAW.replace("+ 0.5", "+ 0.6"))
    code, output = mutate("./law.py", "--jobs", 0)
    assert code == 1
    assert "'factor' fails with the case's own shaders" in output
