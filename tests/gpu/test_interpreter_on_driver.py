"""What a driver computes lies in the band of the program that it was given, and outside of the band
of another one: control flow of every kind, textures, derivatives, vertices."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Case, Ramp, Texture, formula, fullscreen
from shaderlab.analysis.interpreter import FLOAT32, Bands, Interpreted, interpret, load
from shaderlab.analysis.invocations import Invocations, sample_fragments
from shaderlab.compiler import Shaders
from shaderlab.engine.run import SceneRunner
from shaderlab.model.options import RunOptions

HEAD = "#version 330 core\nin vec2 at; out vec4 color;\n"
PROGRAMS = {
    "flow": """
uniform float limit;
float folded(float x, inout int turns) {
    while (x > limit) { x *= 0.75; if (++turns > 12) return -1.0; }
    return x;
}
void main() {
    int turns = int(at.x * 3.0);
    float x = folded(at.x * 4.0 + at.y, turns), sum = 0.0;
    for (int i = 0; i < 6; ++i) {
        if ((i & 1) == turns % 2 || at.y > 0.9) continue;
        sum += x / float(i + 1);
        if (sum > 0.8) break;
    }
    switch (turns) {
        case 0: sum += 1.0;
        case 1: sum += 2.0; break;
        case 5: sum = 0.5;
        default: sum *= 3.0;
    }
    if (length(at - 0.5) > 0.65) discard;
    float weights[3] = float[](0.25, 0.5, 0.125);
    color = vec4(sum, weights[turns % 3], at.x < at.y ? pow(at.x + 0.1, 2.2) : sqrt(at.y), x);
}
""",
    "textures": """
uniform sampler2D smooth_, sharp;
void main() {
    vec2 turned = mat2(0.8, 0.6, -0.6, 0.8) * at * 3.0;
    color = texture(smooth_, turned) + 0.25 * texelFetch(sharp, ivec2(at * 7.5), 0)
          + textureOffset(sharp, at, ivec2(1, -1)) + vec4(fwidth(turned), dFdx(at.x * at.y), 1.0);
}
""",
}
# In each program a statement's text, and that of a mistake in it.
WRONG = {"flow": ("sum += 2.0", "sum += 2.001"), "textures": ("0.25 *", "0.26 *")}
NOISE = np.random.default_rng(3).uniform(0, 1, (8, 8, 4)).astype(np.float32)


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=64)) as made:
        yield made


def drawn(lab: SceneRunner, folder: Path, body: str) -> Invocations:
    name = f"{hashlib.sha256(body.encode()).hexdigest()[:8]}.frag"
    (folder / name).write_text(HEAD + body)
    textures = {
        "smooth_": Texture(image=NOISE, format="rgba32f", filter=("linear", "linear")),
        "sharp": Texture(image=NOISE, format="rgba32f", filter=("nearest", "nearest")),
    }
    used = {sampler: made for sampler, made in textures.items() if sampler in body}
    draws = fullscreen(
        name,
        domain={"at": Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))},
        uniforms={"limit": 0.7} if "limit" in body else {},
        textures=used,
    )
    case = Case(title="t", id="t", file=str(folder / "t.py"), passes=draws,
                expect=[formula("color", lambda at: at)])  # fmt: skip
    scene = case.scene("default")
    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        return sample_fragments(evaluation, ("main", 0))


def run(given: Invocations, arithmetic: Any, text: str = "") -> Interpreted:
    program = load(Shaders([]).from_text(HEAD + text, "fragment", "t.frag")) if text else None
    return interpret(program or given.program, given.each, given.bindings, arithmetic)


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_driver_stays_in_the_program_s_band(
    lab: SceneRunner, tmp_path: Path, name: str
) -> None:
    given = drawn(lab, tmp_path, PROGRAMS[name])
    got = given.measured["color"]
    result = run(given, Bands())
    band = result.outputs["color"]
    assert result.discarded.all_false.all()  # what was discarded is not seen
    assert band.contains(got).all() and band.vacuous.mean() < 0.1
    numbers = run(given, FLOAT32).outputs["color"]
    assert np.median(np.abs(numbers - got)) < 1e-6

    right, wrong = WRONG[name]
    other = run(given, Bands(), PROGRAMS[name].replace(right, wrong)).outputs["color"]
    assert not other.contains(got).all()
