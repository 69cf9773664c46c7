"""A step, an edge or a thin line that is off by a little changes no pixel, and is noticed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from shaderlab import Case, Ramp, boundaries, formula, fullscreen
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import abs, fract, step, swizzle, vec4, where
from shaderlab.model.records import Outcome, Record

SHADER = """#version 330 core
in vec2 place;
uniform float edge;
out vec4 FragColor;

void main()
{
    float lit = step(edge, place.x);
    if (abs(place.y - 0.3337) < 0.002)
        lit = 0.25;
    FragColor = vec4(lit, lit, 0.5 * place.y, 1.0);
}
"""


def drawn(place: Any, edge: Any) -> Any:
    x, y = swizzle(place, "x"), swizzle(place, "y")
    lit = where(abs(y - 0.3337) < 0.002, 0.25, step(edge, x))
    return vec4(lit, lit, 0.5 * y, 1.0)


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner() as opened:
        yield opened


def judged(lab: SceneRunner, folder: Path, text: str, expect: Any) -> Record:
    (folder / "edges.frag").write_text(text)
    case = Case(
        id="edges",
        title="Edges",
        file=str(folder / "edges.py"),
        passes=fullscreen(
            "edges.frag",
            domain={"place": Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))} if "place" in text else {},
            uniforms={"edge": 0.5031},
        ),
        expect=expect,
    )
    return lab.run(next(case.scenes()))


def both(lab: SceneRunner, folder: Path, text: str) -> tuple[Outcome, Outcome]:
    """The outcomes of the formula and of its boundaries."""
    record = judged(
        lab, folder, text, [formula("FragColor", drawn), boundaries("FragColor", drawn)]
    )
    assert record.message == "", record.message
    pixels, edges = record.expectations
    return pixels, edges


def test_the_right_shader_passes(lab: SceneRunner, tmp_path: Path) -> None:
    pixels, edges = both(lab, tmp_path, SHADER)
    assert pixels.status == edges.status == "pass", edges.message
    assert edges.judged == 512 * 4 and edges.undecided < 0.01 and edges.informative == 1.0


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("step(edge, place.x)", "step(1.0005 * edge, place.x)"),
        ("step(edge, place.x)", "step(edge, place.x + 0.0002)"),
        ("place.y - 0.3337", "place.y - 0.3339"),
        ("< 0.002", "< 0.0021"),
        ("lit = 0.25", "lit = 0.251"),
    ],
)
def test_what_no_pixel_shows_is_noticed(
    lab: SceneRunner, tmp_path: Path, right: str, wrong: str
) -> None:
    assert right in SHADER
    pixels, edges = both(lab, tmp_path, SHADER.replace(right, wrong))
    assert pixels.status == "pass"  # none of its pixels is near enough
    assert edges.status == "fail" and edges.outside, edges.message


def test_a_shader_without_inputs_has_no_boundaries(lab: SceneRunner, tmp_path: Path) -> None:
    text = "#version 330 core\nuniform float edge;\nout vec4 FragColor;\n"
    text += "void main() { FragColor = vec4(edge); }\n"
    record = judged(lab, tmp_path, text, [boundaries("FragColor", lambda edge: vec4(edge))])
    assert record.status == "error" and "no float input varies" in record.message


def test_a_reference_may_ask_for_the_pixel(lab: SceneRunner, tmp_path: Path) -> None:
    """The points that are run have pixels of their own, which shader and reference get alike."""
    text = SHADER.replace("0.5 * place.y", "mod(gl_FragCoord.x, 4.0) > 1.0 ? lit : 0.5")

    def dotted(place: Any, edge: Any, frag_coord: Any) -> Any:
        lit = swizzle(drawn(place, edge), "x")
        kept = fract(0.25 * swizzle(frag_coord, "x")) > 0.25
        return vec4(lit, lit, where(kept, lit, 0.5), 1.0)

    edges = boundaries("FragColor", dotted)
    for wrong, status in (("", "pass"), ("1.0005 * ", "fail")):
        (folder := tmp_path / status).mkdir()
        record = judged(lab, folder, text.replace("step(edge", f"step({wrong}edge"), [edges])
        assert [e.status for e in record.expectations] == [status], record.message
