"""What judged pixels never exercise is listed, and nothing that they did."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from shaderlab import (
    Case,
    Depth,
    Draw,
    Mesh,
    Pass,
    State,
    Target,
    Variant,
    across,
    formula,
    fullscreen,
    sweep,
)
from shaderlab.cli import cli
from shaderlab.engine.run import SceneRunner
from shaderlab.mutation.code_coverage import measure_coverage

Gaps = Callable[..., list[str]]

HEAD = """\
#version 330 core
uniform float a;
in float x;
out vec4 color;
void main() {
"""
VERTEX = """\
#version 330 core
in vec3 aPos;
in float aX;
out float x;
void main() { x = aX; gl_Position = vec4(aPos, 1.0); }
"""


def anything(x: float) -> float:
    return x


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner() as opened:
        yield opened


@pytest.fixture
def gaps(lab: SceneRunner, tmp_path: Path) -> Gaps:
    """What is never done by `body`, a main with the input x in 0…1 and the uniform a."""

    def find(body: str, *values: float, **case: Any) -> list[str]:
        (tmp_path / "s.frag").write_text(HEAD + body + "\n}\n")
        passes = fullscreen("s.frag", domain={"x": across(0.0, 1.0)}, uniforms={"a": 1.0})
        variants = [Variant(str(v), {"a": v}) for v in values]
        fields: dict[str, Any] = {
            "passes": passes, "variants": variants, "expect": [formula("color", anything)],
        }  # fmt: skip
        whole = Case(title="t", id="t", file=str(tmp_path / "t.py"), **(fields | case))
        found = measure_coverage(lab, whole.scenes())
        return [f"{gap.text} {gap.what}" for gap in found.gaps]

    return find


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("color = vec4(x > 0.5 ? 1.0 : 0.0);", []),
        ("color = vec4(x > 2.0 ? 1.0 : 0.0);", ["x > 2.0 is never true"]),
        ("if (x < 2.0) color = vec4(1.0);", ["x < 2.0 is never false"]),
        ("color = vec4(x > 0.5 && x < 2.0);", ["x < 2.0 is never false"]),
        ("color = vec4(a * x);", ["a is always 1"]),
        ("color = vec4((a - 1.0) * x);", ["(a - 1.0) is always 0", "a is always 1"]),
        ("color = vec4(x / a);", ["a is always 1"]),
        ("color = vec4(max(x, 0.5));", []),
        ("color = vec4(max(x, 0.0));", ["max(x, 0.0) never gives its second argument"]),
        ("color = vec4(min(x, 0.0));", ["min(x, 0.0) never gives its first argument"]),
        ("color = vec4(clamp(x, 0.2, 3.0));", ["clamp(x, 0.2, 3.0) is never above its range"]),
        ("color = vec4(clamp(x, 0.2, 0.8));", []),
        ("color = vec4(normalize(vec2(x, 2.0)), 0.0, 0.0);", []),
        ("color = vec4(normalize(vec2(0.0, a)), 0.0, 0.0);",
         ["normalize(vec2(0.0, a)) is of a vector whose length is 1 already"]),
        ("vec2 v = max(vec2(x, 1.0 - x), vec2(0.5)); color = vec4(v, 0.0, 0.0);", []),
        ("if (x > 0.5) discard; color = vec4(1.0);", []),
        ("if (x > 0.5) { color = vec4(0.0); return; } color = vec4(1.0);", []),
        ("color = vec4(mat3(1.0) * vec3(x), 1.0);", ["mat3(1.0) is always 1"]),
    ],
)  # fmt: skip
def test_what_no_pixel_does_is_listed(gaps: Gaps, body: str, expected: list[str]) -> None:
    assert sorted(gaps(body)) == sorted(expected)


def test_a_variant_closes_a_gap(gaps: Gaps) -> None:
    body = "color = vec4(a * x);"
    assert gaps(body, 1.0) == ["a is always 1"]
    assert gaps(body, 1.0, 2.0) == []


def test_what_an_expectation_asks_for_counts(gaps: Gaps) -> None:
    body = "color = vec4(max(x, 2.0));"
    assert gaps(body) == ["max(x, 2.0) never gives its first argument"]
    further = [formula("color", anything), sweep("color", anything, over="x", values=[1.0, 3.0])]
    assert gaps(body, expect=further) == []


def test_passes_that_nothing_reads_do_not_count(gaps: Gaps) -> None:
    domain = {"x": across(1.0, 2.0)}
    other = fullscreen("s.frag", domain=domain, uniforms={"a": 1.0}, name="picture")
    mine = fullscreen("s.frag", domain={"x": across(0.0, 1.0)}, uniforms={"a": 1.0})
    body = "color = vec4(max(x, 1.5));"
    only = {"expect": [formula("main.color", anything)]}
    assert gaps(body, passes=[*other, *mine], **only) == [
        "max(x, 1.5) never gives its first argument"
    ]
    both = [formula("main.color", anything), formula("picture.color", anything)]
    assert gaps(body, passes=[*other, *mine], expect=both) == []


def test_fragments_that_fail_the_depth_test_do_not_count(gaps: Gaps, tmp_path: Path) -> None:
    (tmp_path / "s.vert").write_text(VERTEX)

    def quad(z: float, start: float) -> Draw:
        places = np.array([[-1, -1, z], [1, -1, z], [1, 1, z], [-1, 1, z]], np.float32)
        x = np.array([[start], [start + 1], [start + 1], [start]], np.float32)
        mesh = Mesh(attributes={"aPos": places, "aX": x}, indices=np.array([0, 1, 2, 0, 2, 3]))
        return Draw(
            vertex="s.vert", fragment="s.frag", mesh=mesh, uniforms={"a": 2.0},
            state=State(depth=Depth()),
        )  # fmt: skip

    def found(*draws: Draw) -> list[str]:
        target = Target(size=(8, 8), depth="depth24")
        expect = [formula("color", anything, draw=i) for i in range(len(draws))]
        return gaps(
            "color = vec4(max(x, 1.0));",
            passes=[Pass(target=target, draws=draws)],
            expect=expect,
        )

    near, far = quad(-0.5, 0.0), quad(0.5, 1.0)
    assert found(near, far) == ["max(x, 1.0) never gives its first argument"]
    assert found(far, near) == []


def test_vertex_shaders_are_watched_too(gaps: Gaps, tmp_path: Path) -> None:
    (tmp_path / "s.vert").write_text(VERTEX.replace("x = aX;", "x = aX * (1.0 + aPos.z);"))
    places = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32)
    mesh = Mesh(attributes={"aPos": places, "aX": places[:, :1]})
    draw = Draw(vertex="s.vert", fragment="s.frag", mesh=mesh, uniforms={"a": 2.0})
    assert gaps("color = vec4(x);", passes=[Pass(draws=[draw])]) == [
        "(1.0 + aPos.z) is always 1",
        "aPos.z is always 0",
    ]


CASE = """
from shaderlab import Case, across, formula, fullscreen

def bright(x):
    return x

case = Case(title="t", passes=fullscreen("s.frag", domain={"x": across(0.0, 1.0)}),
            expect=[formula("color", bright)])
"""


def test_run_lists_gaps_in_the_terminal_the_page_and_the_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "s.frag").write_text(
        "#version 330 core\nin float x;\nout float color;\nvoid main() { color = max(x, 0.0); }\n"
    )
    (tmp_path / "my.py").write_text(CASE)
    monkeypatch.chdir(tmp_path)
    words = ["run", "my.py", "--no-pictures", "-j", "0", "--coverage", "--json", "out.json"]
    done = CliRunner().invoke(cli, [*words, "--report", "r"])
    assert done.exit_code == 0, done.output
    assert "coverage of my: 1 of 2" in done.output
    assert "s.frag:4: max(x, 0.0) never gives its second argument" in done.output
    (found,) = json.loads(Path("out.json").read_text())["coverage"]
    assert found["id"] == "my" and found["items"] == 2
    assert found["gaps"] == [{"file": "s.frag", "line": 4, "text": "max(x, 0.0)",
                              "what": "never gives its second argument"}]  # fmt: skip
    page = Path("r/cases/my.html").read_text()
    assert "never gives its second argument" in page and ">Coverage<" in page
    assert ">Coverage<" not in _page_without(tmp_path)


def _page_without(folder: Path) -> str:
    done = CliRunner().invoke(cli, ["run", "my.py", "--no-pictures", "-j", "0", "--report", "s"])
    assert done.exit_code == 0, done.output
    return (folder / "s" / "cases" / "my.html").read_text()
