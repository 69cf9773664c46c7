"""What the optimiser proves to be the same program, and what it does not."""

from __future__ import annotations

import pytest

from shaderlab.compiler.sources import Shaders, Source
from shaderlab.mutation import judging

TEXT = """\
#version 330 core
in vec2 at;
uniform sampler2D image;
uniform float bias;
out vec4 color;
float unused(float x) { return x; }
void main()
{
    vec3 texel = texture(image, at).rgb;
    float sum = 0.5 + 0.25;
    color = vec4(texel * sum, clamp(bias, 0.0, 1.0));
}
"""


def source(text: str) -> tuple[Source]:
    return (Shaders([]).from_text(text, "fragment", "x.frag"),)


def same(right: str, wrong: str) -> bool:
    assert right in TEXT
    return judging.is_same_program(source(TEXT.replace(right, wrong)), source(TEXT))


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("0.5 + 0.25", "0.25 + 0.5"),
        ("return x;", "return -x;"),
        ("0.5 + 0.25;", "0.75; float same = sum; sum = same;"),
    ],
)
def test_the_same_program(right: str, wrong: str) -> None:
    assert same(right, wrong)


@pytest.mark.parametrize(
    ("right", "wrong"),
    [(").rgb", ").grb"), ("clamp(bias, 0.0, 1.0)", "bias"), ("0.25;", "0.2525;")],
)
def test_another_program(right: str, wrong: str) -> None:
    assert not same(right, wrong)


def test_without_an_optimiser_only_equal_modules_are_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(judging, "find_optimiser", lambda: None)
    judging.optimise.cache_clear()
    assert same("0.5 + 0.25", "0.25 + 0.5")  # the front end folds both
    assert not same("0.5 + 0.25;", "0.75; float same = sum; sum = same;")
    judging.optimise.cache_clear()
