"""What is watched in a shader, and that wrapping it leaves the rest alone."""

from __future__ import annotations

import pytest

from shaderlab.mutation.code_coverage import wrap_points

SHADER = """\
#version 330 core
#define TWICE(x) ((x) + (x))
const float K = 2.0 * 3.0;
uniform float a;
out vec4 color;
float never(float x) { return x * a; }
void main() {
    const float half_ = 0.5 * K;
    CODE
}
"""


def points(code: str) -> list[tuple[str, str]]:
    """Kind and text of each point in the body of main."""
    return [(point.kind, point.text) for point in wrap_points(SHADER.replace("CODE", code))[1]]


@pytest.mark.parametrize(
    ("code", "found"),
    [
        ("if (a > 1.0) color = vec4(1);", [("condition", "a > 1.0")]),
        ("color = vec4(a > 1.0 ? a : 0.0);", [("condition", "a > 1.0")]),
        ("bool b = a > 1.0 && a < 2.0;", [("condition", "a > 1.0"), ("condition", "a < 2.0")]),
        ("float x = a + 2.0;", [("term", "a")]),
        ("float x = a - K - a;", [("term", "a"), ("term", "K"), ("term", "a")]),
        ("float x = -1.0 * a;", [("factor", "a")]),
        ("float x = 1.0 / a;", [("divisor", "a")]),
        ("float x = K; x *= a;", [("factor", "a")]),
        ("float x = max(a, 0.0);", [("max", "max(a, 0.0)")]),
        ("float x = clamp(min(a, K), 0.0, 1.0);",
         [("clamp", "clamp(min(a, K), 0.0, 1.0)"), ("min", "min(a, K)")]),
        ("vec3 n = normalize(vec3(a));", [("normalize", "normalize(vec3(a))")]),
        ("float x = 1.0 + 2.0; x = sin(a);", []),
        ("for (int i = 0; i < 3; i++) {}", []),
    ],
)  # fmt: skip
def test_what_is_watched(code: str, found: list[tuple[str, str]]) -> None:
    assert points(code) == found


def test_constants_macros_and_functions_that_are_never_called_are_left_alone() -> None:
    shader = SHADER.replace("CODE", "color = vec4(a);")
    text, found = wrap_points(shader)
    assert found == [] and text == shader.replace("main", "shaderlab_body")


def test_each_point_has_bits_of_its_own_and_its_place() -> None:
    code = "float x = clamp(a, 0.0, 1.0) * a;\n    if (x > 0.5) discard;"
    text, found = wrap_points(SHADER.replace("CODE", code))
    assert sorted((p.bit, p.kind, p.line) for p in found) == [
        (0, "factor", 9), (2, "clamp", 9), (5, "factor", 9), (7, "condition", 10),
    ]  # fmt: skip
    assert "shaderlab_factor(0, shaderlab_clamp(2, a, 0.0, 1.0)) * shaderlab_factor(5, a)" in text
    assert "if (shaderlab_condition(7, x > 0.5)) { shaderlab_note(); discard; }" in text
