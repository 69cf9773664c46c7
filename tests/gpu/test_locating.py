"""A mistake is traced to its own statement: to a condition before the branch that it opens, to an
argument before the function that gets it, to the call and the turn of a loop in which it shows."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from shaderlab import Case, Ramp, formula, fullscreen
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import vec4
from shaderlab.model.options import RunOptions
from shaderlab.mutation.locating import Traces, find_first_wrong, trace_draws

SHADER = """#version 330 core
in vec2 at;
out vec4 color;
struct Surface { vec3 normal; float gloss; };
float kept = 0.25;
float scaled(float x, float y)
{
    float double_ = x + x;
    return double_ * y;
}
float scaled(float x)
{
    return x * 0.5;
}
float shine(Surface surface)
{
    return surface.normal.x * surface.gloss;
}
void main()
{
    int steps = int(at.x * 4.0) + 1;
    Surface surface = Surface(
        vec3(at, 1.0),
        at.y);
    float value = scaled(at.x, 0.5) + scaled(at.y,
        0.75);
    value = value + scaled(scaled(value));
    if (at.x > 0.5 || at.y > 0.25)
        value = value + 0.125;
    else
        value = value + 0.375;
    value += at.y > 0.75
        ? at.x * 2.0
        : at.x + at.y;
    for (int i = 0; i < 3; ++i)
        if (i < steps) value += float(i) * 0.5; else value += 0.0625;
    while (value > 4.0) value -= 0.5;
    for (int i = 0; i < 12; ++i) value += 0.03125;
    switch (steps) {
    case 1: value += 1.0; break;
    default: value += 2.0;
    }
    mat2 turned = mat2(at.x, at.y,
                       -at.y, at.x);
    color.rgb = vec3(turned * at, shine(surface)) + kept; color.a = value;
}
"""


def line_of(words: str) -> int:
    return SHADER[: SHADER.index(words)].count("\n") + 1


# What is written in place of what; the line that it is traced to, the statement's first one or that
# of the mistake, and what of it.
MISTAKES = [
    ("int(at.x * 4.0) + 1", "int(at.x * 4.0) + 2", "int steps", "steps"),
    ("vec3(at, 1.0),", "vec3(at.y, at.x, 1.0),", "Surface surface =", "surface"),
    ("at.y);", "at.x);", "Surface surface =", "surface"),
    ("scaled(at.x, 0.5)", "scaled(at.x, 0.6)", "float value", "scaled(y)"),
    ("0.75);", "0.8);", "float value", "scaled(y)"),
    ("double_ * y", "double_ - y", "double_ * y", "scaled()"),
    ("scaled(scaled(value))", "scaled(scaled(value + 1.0))", "scaled(scaled", "scaled(x)"),
    ("at.x > 0.5", "at.x < 0.5", "at.x > 0.5", "condition"),
    ("at.y > 0.75", "at.y > 0.25", "at.y > 0.75", "condition"),
    ("at.x + at.y;", "at.x - at.y;", "value += at.y > 0.75", "value"),
    ("i < 3", "i < 4", "i < 3", "condition"),
    ("i < 12", "i < 8", "i < 12", "condition"),
    ("i < steps", "i > steps", "i < steps", "condition"),
    ("float(i) * 0.5", "float(i * i) * 0.5", "float(i) * 0.5", "value"),
    ("value > 4.0", "value > 5.0", "value > 4.0", "condition"),
    ("switch (steps)", "switch (steps - 1)", "switch", "selector"),
    ("-at.y, at.x);", "at.y, at.x);", "mat2 turned", "turned"),
    ("shine(surface)", "shine(Surface(surface.normal.zyx, 1.0))", "vec3(turned", "shine(surface)"),
]


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16)) as made:
        yield made


@pytest.fixture(scope="module")
def right(
    lab: SceneRunner, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[Evaluation, Traces]]:
    folder = tmp_path_factory.mktemp("located")
    (folder / "lit.frag").write_text(SHADER)
    domain = {"at": Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))}
    passes = fullscreen("lit.frag", domain=domain)
    judged = formula("color", lambda at: vec4(at, at))
    case = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=[judged])
    scene = case.scene("default")
    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        traces = trace_draws(evaluation)
    yield evaluation, traces


def named(lab: SceneRunner, right: tuple[Evaluation, Traces], text: str) -> tuple[int, str] | None:
    """The line and the name that a changed shader is traced to; None where it computes the same."""
    evaluation, traces = right
    changed = lab.prepare_for_opengl(evaluation.scene, {"lit.frag": text})
    with lab.evaluation(evaluation.scene, changed, like=evaluation) as wrong:
        found = find_first_wrong(wrong, evaluation, traces)
    if found is None:
        return None
    assert found[2] is not None
    return found[2].line, found[2].name


@pytest.mark.parametrize(("words", "wrong", "line", "name"), MISTAKES)
def test_a_mistake_is_traced_to_its_statement(
    lab: SceneRunner, right: tuple[Evaluation, Traces], words: str, wrong: str, line: str, name: str
) -> None:
    assert SHADER.count(words) == 1
    assert named(lab, right, SHADER.replace(words, wrong)) == (line_of(line), name)


def test_what_computes_the_same_is_traced_to_nothing(
    lab: SceneRunner, right: tuple[Evaluation, Traces]
) -> None:
    assert named(lab, right, SHADER.replace("x + x", "2.0 * x")) is None
