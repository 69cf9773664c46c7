"""A reader's own shader in the place of ours: right ones pass however they are written, wrong ones
fail, and the run says where.

`own_shaders/` has complete fragment shaders written without a look at the shipped ones: others
names, another order, no includes, loops, powers by exp2. Only the interface is the same.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from shaderlab.cli import cli
from shaderlab.model.case import Case
from tests.catalogue import shipped
from tests.negative.broken import failures, first_failure

OWN = Path(__file__).parent / "own_shaders"
PLACE = {
    "blinn": ("blinn-phong", "ch05_lighting/blinn_phong.frag"),
    "pbr": ("pbr", "ch05_lighting/pbr.frag"),
}
RIGHT = sorted(file.stem for file in OWN.glob("*.frag"))

# file, what stands there, the mistake
MISTAKES = {
    "normal not normalised": ("blinn_in_functions", "(normalize(Normal),", "(1.001 * Normal,"),
    "reflect for the halfway vector": (
        "blinn_by_hand", "dot(normalize(V + L), N)", "dot(reflect(-L, N), V)"),
    "halfway vector not normalised": (
        "blinn_in_functions", "dot(d.normal, halfway) / length(halfway)", "dot(d.normal, halfway)"),
    "exponent 1 % off": ("blinn_without_halfway", "power(cosine, s", "power(cosine, 1.01 * s"),
    "no max for light from behind": ("blinn_in_functions", "max(0.0, dot(d.light, d.normal))",
                                     "dot(d.light, d.normal)"),
    "gamma twice": ("blinn_by_hand", "vec3(1.0 / 2.2)", "vec3(1.0 / 4.84)"),
    "F0 of 0.05": ("pbr_by_hand", "0.04 * (1.0 - m", "0.05 * (1.0 - m"),
    "alpha not squared": ("pbr_in_functions", "alpha = roughness * roughness", "alpha = roughness"),
    "the constant of D half a percent off": (
        "pbr_as_printed", "(a2 - 1.0) + 1.0;", "(a2 - 1.0) + 1.005;"),
    "no max for lamps from behind": (
        "pbr_channel_by_channel", "nl[i] = max(dot(n, l), 0.0) /", "nl[i] = dot(n, l) /"),
    "encoded before it is encoded": (
        "pbr_by_hand", "            F = f;\n        }\n    }\n",
        "            F = f;\n        }\n    }\n"
        "    FragColor.rgb = pow(FragColor.rgb, vec3(1.0 / 2.2));\n"),
}  # fmt: skip

Run = Callable[..., Result]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Run:
    """`shaderlab run` in an empty folder and in this process, without pictures."""
    monkeypatch.chdir(tmp_path)

    def call(*words: str) -> Result:
        options = ("--no-pictures", "--no-modules", "-j", "0", "--json", "out.json")
        return CliRunner().invoke(cli, ["run", *words, *options])

    return call


def written(folder: Path, text: str) -> str:
    (folder / "my.frag").write_text(text, encoding="utf-8")
    return "my.frag"


def outcomes(folder: Path) -> list[dict[str, Any]]:
    cases: list[dict[str, Any]] = json.loads((folder / "out.json").read_text())["cases"]
    return cases


def test_there_are_several_of_each() -> None:
    assert [sum(name.startswith(f"{kind}_") for name in RIGHT) for kind in PLACE] == [3, 4]


def place(name: str) -> tuple[Case, str]:
    """The case that one of these shaders is for, and the shipped shader in whose place it is."""
    case_id, shader = PLACE[name.partition("_")[0]]
    return shipped()[case_id], shader


def mistake_in(mistake: str) -> tuple[str, str]:
    """The name of a right shader, and its text with the mistake."""
    name, right, wrong = MISTAKES[mistake]
    text = (OWN / f"{name}.frag").read_text(encoding="utf-8")
    assert text.count(right) == 1
    return name, text.replace(right, wrong)


@pytest.mark.parametrize("name", RIGHT)
def test_a_right_one_passes_however_it_is_written(name: str) -> None:
    case, shader = place(name)
    text = (OWN / f"{name}.frag").read_text(encoding="utf-8")
    for scene in case.scenes():
        assert list(failures(scene, {shader: text})) == [], scene.variant


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_wrong_one_fails(mistake: str) -> None:
    name, text = mistake_in(mistake)
    case, shader = place(name)
    failed = first_failure(case, {shader: text}, placed=True)
    assert failed and failed.worst and failed.worst.pixel and failed.worst.widths > 1.0


@pytest.mark.parametrize("mistake", ["exponent 1 % off", "F0 of 0.05"])
def test_the_command_judges_it_and_says_where(run: Run, tmp_path: Path, mistake: str) -> None:
    name, text = mistake_in(mistake)
    case, shader = place(name)
    words = (f"{case.id}[{next(case.scenes()).variant}]", "--shader")
    right = (OWN / f"{name}.frag").read_text(encoding="utf-8")
    assert run(*words, f"{Path(shader).name}={written(tmp_path, right)}").exit_code == 0
    result = run(*words, f"{Path(shader).name}={written(tmp_path, text)}")
    assert result.exit_code == 1, result.output
    assert [record["status"] for record in outcomes(tmp_path)] == ["fail"]
    assert "worst pixel" in result.output
    assert "my.frag:" in result.output  # the line that writes what is wrong


def test_one_without_the_gate_is_told_just_that(run: Run, tmp_path: Path) -> None:
    text = (OWN / "blinn_without_halfway.frag").read_text(encoding="utf-8")
    gated, leaking = "nl > 0.0 ? power(cosine, shininess) : 0.0", "power(cosine, shininess)"
    assert text.count(gated) == 1
    mine = written(tmp_path, text.replace(gated, leaking))
    assert run("blinn-phong", "--shader", f"blinn_phong.frag={mine}").exit_code == 1
    for record in outcomes(tmp_path):
        failed = [e["name"] for e in record["expectations"] if e["status"] == "fail"]
        assert failed == ["no highlight on a face turned away"], record["variant"]


@pytest.mark.parametrize("name", ["specular.frag", "ch05_lighting/specular.frag"])
def test_a_name_may_be_the_end_of_one(
    run: Run, tmp_path: Path, repository: Path, name: str
) -> None:
    text = (repository / "shaders/ch05_lighting/specular.frag").read_text(encoding="utf-8")
    wrong = written(tmp_path, text.replace("specularStrength * spec", "spec"))
    assert run("specular", "--shader", f"{name}={wrong}").exit_code == 1


def test_a_name_of_no_shader_is_refused_with_the_nearest(run: Run, tmp_path: Path) -> None:
    mine = written(tmp_path, "void main() {}\n")
    result = run("blinn-phong", "--shader", f"blin_phong.frag={mine}")
    assert result.exit_code == 2
    assert "there is no such shader" in result.output and "blinn_phong.frag" in result.output


def test_a_name_of_two_shaders_is_refused_with_both(run: Run, tmp_path: Path) -> None:
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "glow.frag").write_text("#version 330 core\nvoid main() {}\n")
    (tmp_path / "lamp.py").write_text(
        '"""A lamp."""\nfrom shaderlab import Case, exact, fullscreen\n'
        'case = Case(title="", section="5", passes=fullscreen("one/glow.frag"), '
        'expect=[exact("FragColor", 1.0)])\n'
    )
    result = run("./lamp.py", "--shader", f"glow.frag={written(tmp_path, '')}")
    assert result.exit_code == 2
    assert "one/glow.frag, two/glow.frag" in result.output


def test_a_shader_that_no_case_reads_is_no_pass(run: Run, tmp_path: Path) -> None:
    mine = written(tmp_path, "this is no GLSL\n")
    result = run("orange-triangle", "--shader", f"gamma.frag={mine}")
    assert result.exit_code == 2
    assert "nothing was judged in its place" in result.output
    assert "orange_triangle.frag" in result.output
