"""One case on several drivers: chosen by name, compared pixel by pixel."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from tests.gpu import faulty


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A case that is exact everywhere, and one whose sine each driver computes in its own way."""
    folder = tmp_path_factory.mktemp("drivers")
    faulty.write(folder / "cases", "same")
    faulty.write_wave(folder / "cases", "other")
    done = faulty.shaderlab(
        "./cases", "--drivers", "llvmpipe,softpipe", "--json", "out.json", "--size", "32",
        "--report", "run", cwd=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    data: dict[str, Any] = json.loads((folder / "out.json").read_text())
    return {**data, "text": done.stdout, "kept": (folder / "run" / "run.json").read_text()}


def test_each_scene_has_a_result_on_each_driver(compared: dict[str, Any]) -> None:
    found = [(r["driver"], r["id"], r["status"]) for r in compared["drivers"]]
    assert found == [
        (driver, case, "pass") for driver in ("llvmpipe", "softpipe") for case in ("other", "same")
    ]
    assert {r["driver"] in r["renderer"] for r in compared["drivers"]} == {True}


def test_where_they_disagree_is_counted(compared: dict[str, Any]) -> None:
    rows = {(d["id"], d["output"]): d for d in compared["disagreements"]}
    same, other = rows["same", "main.FragColor"], rows["other", "main.wave"]
    assert (same["pixels"], same["differing"], same["ulp"]) == (1024, 0, 0.0)
    assert 0 < other["differing"] <= 1024 and other["ulp"] > 0
    assert other["drivers"] == ["llvmpipe", "softpipe"]
    assert (same["verdict"], other["verdict"]) == ("equal", "within")
    cells = {
        line.split()[0]: line.split()[2:] for line in compared["text"].splitlines() if "✓" in line
    }
    assert cells["same"] == ["✓", "pass", "✓", "equal"] and cells["other"][2:] == ["✓", "within"]
    assert '"disagreements":[{' in compared["kept"]


@pytest.mark.parametrize(
    "options",
    [
        ["--driver", "nvidiapipe"],
        ["--drivers", "llvmpipe"],
        ["--drivers", "llvmpipe,llvmpipe"],
        ["--drivers", "llvmpipe,hardpipe"],
        ["--drivers", "llvmpipe,softpipe", "--driver", "llvmpipe"],
    ],
)
def test_a_wrong_choice_is_wrong_usage(
    options: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(cli, ["run", "orange-triangle", *options])
    assert done.exit_code == 2, done.output
    assert not (tmp_path / "reports").exists()


def test_softpipe_runs_alone(tmp_path: Path) -> None:
    faulty.write(tmp_path / "cases", "same")
    (tmp_path / "cases" / "heights.py").write_text(HEIGHTS)
    (tmp_path / "cases" / "place.frag").write_text(
        "#version 330 core\nout vec2 at;\nvoid main() { at = gl_FragCoord.xy; }\n"
    )
    done = faulty.shaderlab("./cases", "--driver", "softpipe", cwd=tmp_path)
    assert done.returncode == 0 and "on softpipe" in done.stdout, done.stdout


HEIGHTS = """from shaderlab import Case, Target, formula, fullscreen
from shaderlab.glslmath import swizzle
sides = (16, 8)
case = Case(
    title="One program, two heights",
    passes=[
        one for side in sides
        for one in fullscreen("place.frag", name=f"s{side}", target=Target(size=(side, side)))
    ],
    expect=[formula(f"s{s}.at", lambda frag_coord: swizzle(frag_coord, "xy")) for s in sides],
)
"""
"""Where gl_FragCoord is wrong in the second pass, capturing it says so."""


POINTS = """from shaderlab import Case, Mesh, State, coverage, mesh_pass
at = Mesh(attributes={"place": [(0.03, 0.07)]}, primitive="points")
case = Case(
    title="a point",
    passes=mesh_pass("point.vert", "point.frag", at, state=State(point_size=9.0)),
    expect=[coverage(81)],
)
"""
NUMBERED = """from shaderlab import Case, Mesh, exact, mesh_pass
at = Mesh(attributes={"place": [(-0.5, -0.5), (0.5, -0.5), (0.0, 0.5)]})
case = Case(
    title="a number", passes=mesh_pass("point.vert", "number.frag", at),
    expect=[exact("color", (0.0, 0.0, 0.0, 0.0))],
)
"""


def test_what_softpipe_can_not_do_is_found_out(tmp_path: Path) -> None:
    """Its gl_PointCoord lies an eighth of a pixel off, and it draws nothing where a fragment stage
    reads gl_PrimitiveID."""
    folder = tmp_path / "cases"
    folder.mkdir()
    head = "#version 330 core\n"
    (folder / "point.vert").write_text(
        head + "in vec2 place;\nvoid main() { gl_Position = vec4(place, 0.0, 1.0); }\n"
    )
    (folder / "point.frag").write_text(
        head + "out vec4 color;\nvoid main() { color = vec4(gl_PointCoord, 0.5, 1.0); }\n"
    )
    (folder / "number.frag").write_text(
        head + "out vec4 color;\nvoid main() { color = vec4(float(gl_PrimitiveID)); }\n"
    )
    (folder / "points.py").write_text(POINTS)
    (folder / "numbered.py").write_text(NUMBERED)
    done = faulty.shaderlab(
        "./cases", "--drivers", "llvmpipe,softpipe", "--size", "32", "--json", "out.json",
        "--report", "run", cwd=tmp_path,
    )  # fmt: skip
    data = json.loads((tmp_path / "out.json").read_text())
    found = {(r["driver"], r["id"]): r for r in data["drivers"]}
    numbered = found["softpipe", "numbered"]
    assert numbered["status"] == "unsupported" and "gl_PrimitiveID" in numbered["message"]
    assert found["llvmpipe", "numbered"]["status"] == "pass", done.stdout
    (point,) = data["disagreements"]
    assert (point["verdict"], point["outside"]) == ("within", []), done.stdout
    assert point["differing"] > 0 and point["ulp"] > 1.0
    page = (tmp_path / "run" / "index.html").read_text()
    assert "Differing outputs" in page and f"most at ({point['pixel'][0]}, " in page


def test_an_interrupted_run_goes_on_with_all_its_drivers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    faulty.write_wave(tmp_path / "waves", "wave")
    monkeypatch.setattr("shaderlab.cli.compare_drivers.shutil.rmtree", lambda *_, **__: None)
    shared = ("--json", "out.json", "--no-pictures")
    started = ("./waves", "--drivers", "llvmpipe,llvmpipe-spirv", "--size", "16", "--report", "run")
    runs = []
    for given in (started, ("--resume", "run")):
        done = CliRunner().invoke(cli, ["run", *given, *shared], catch_exceptions=False)
        assert done.exit_code == 0, done.output
        runs.append(json.loads(Path("out.json").read_text()))
        journal = Path("run/records.jsonl")
        journal.write_text("".join(journal.read_text().splitlines(keepends=True)[:2]))
    first, resumed = runs
    assert [r["driver"] for r in resumed["drivers"]] == ["llvmpipe", "llvmpipe-spirv"]
    assert resumed["disagreements"] == first["disagreements"] != []
