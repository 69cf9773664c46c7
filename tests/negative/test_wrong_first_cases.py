"""Realistic mistakes in the first cases' shaders: each makes its case fail, and says where."""

from __future__ import annotations

from pathlib import Path

import pytest

from shaderlab.compiler import Shaders
from shaderlab.engine.catalogue import data_folder
from tests.catalogue import shipped
from tests.negative.broken import first_failure, mistaken

# case, shader, what stands there, the mistake
MISTAKES = [
    ("orange-triangle", "ch01_setup/orange_triangle.frag", "0.5, 0.2", "0.51, 0.2"),
    ("orange-triangle", "ch01_setup/orange_triangle.frag", "1.0, 0.5, 0.2", "0.5, 1.0, 0.2"),
    ("orange-triangle", "ch01_setup/orange_triangle.vert", "vec4(aPos,", "vec4(1.01 * aPos,"),
    ("indexed-quad", "ch02_basics/indexed_quad.vert", "vec4(aPos,", "vec4(aPos.yxz,"),
    ("indexed-quad", "ch02_basics/indexed_quad.vert", "aPos, 1.0", "aPos, 0.99"),
    ("indexed-quad", "ch02_basics/indexed_quad.frag", "0.625, 0.25", "0.25, 0.625"),
    ("texture-mix", "ch02_basics/texture_mix.frag", "mix(texture(texture1", "mix(texture(texture2"),
    ("texture-mix", "ch02_basics/texture_mix.frag", "mixValue);", "1.0 - mixValue);"),
    ("texture-mix", "ch02_basics/texture_mix.frag", "TexCoords), mixV", "TexCoords.ts), mixV"),
    ("uniform-over-time", "ch02_basics/uniform_over_time.frag", "sin(time)", "cos(time)"),
    ("uniform-over-time", "ch02_basics/uniform_over_time.frag", "+ 0.5", "+ 0.505"),
    ("uniform-over-time", "ch02_basics/uniform_over_time.frag", "= ourColor", "= ourColor.grba"),
    ("mvp", "ch03_transforms/mvp.vert", "view * (model *", "model * (view *"),
    ("mvp", "ch03_transforms/mvp.vert", "aPos, 1.0", "aPos, 0.0"),
    ("mvp", "ch03_transforms/mvp.vert", "xyz / gl_Position.w", "xyz / gl_Position.z"),
    ("attenuation", "lib/attenuation.glsl", "linear * distance", "quadratic * distance"),
    ("attenuation", "lib/attenuation.glsl", "(distance * distance)", "distance"),
    ("attenuation", "lib/attenuation.glsl", "1.0 / (light.constant", "1.01 / (light.constant"),
    ("attenuation", "lib/attenuation.glsl", "+ 4.0 *", "- 4.0 *"),
    ("spotlight", "lib/spotlight.glsl", "normalize(light.position", "(light.position"),
    ("spotlight", "lib/spotlight.glsl", "normalize(-light", "normalize(light"),
    ("spotlight", "lib/spotlight.glsl", "(light.cutOff -", "(light.outerCutOff -"),
    ("spotlight", "lib/spotlight.glsl", "clamp(spotRatio(light, fragPos), 0.0, 1.0)",
     "min(spotRatio(light, fragPos), 1.0)"),
    ("gamma", "lib/gamma.glsl", "1.0 / gamma", "gamma"),
    ("gamma", "lib/gamma.glsl", "1.0 / 2.4) -", "1.0 / 2.2) -"),
    ("gamma", "lib/gamma.glsl", "1.055 * pow", "1.05 * pow"),
    ("gamma", "lib/gamma.glsl", "linear <= 0.0031308", "linear <= 0.031308"),
    ("gamma", "ch05_lighting/gamma.frag", "(linear, gamma)", "(linear, 2.4)"),
    ("gamma", "ch05_lighting/gamma.frag", "srgbDecode(linear)", "pow(linear, 2.2)"),
    ("blinn-phong", "lib/reflection.glsl", "pow(cosine, shininess)",
     "pow(cosine, 1.01 * shininess)"),
    ("blinn-phong", "lib/reflection.glsl", "normalize(lightDir + viewDir)", "lightDir + viewDir"),
    ("blinn-phong", "lib/reflection.glsl", "reflect(-lightDir", "reflect(lightDir"),
    ("blinn-phong", "ch05_lighting/blinn_phong.frag", "normalize(Normal)", "Normal * 1.001"),
    ("blinn-phong", "ch05_lighting/blinn_phong.frag", "diffuseFactor(normal, lightDir)",
     "dot(normal, lightDir)"),
    ("blend-equation", "ch06_tests/blend_equation.frag", "color, alpha", "alpha * color, alpha"),
    ("blend-equation", "ch06_tests/blend_equation.frag", "color, alpha", "color, 1.0 - alpha"),
    ("depth-functions", "ch06_tests/verdicts.frag", "* 2.0 - 1.0", "* 1.9 - 1.0"),
    ("depth-functions", "ch06_tests/count.frag", "total = worth", "total = 1.0 - worth"),
    ("stencil-functions", "ch06_tests/verdicts.frag", "edge.y), 0.1", "edge.y), 0.9"),
    ("stencil-functions", "ch06_tests/count.frag", "total = worth", "total = 1.0"),
]  # fmt: skip
# These two show their tables with the same shader.
TOGETHER = {"depth-functions", "stencil-functions"}
LIT_BY_LAMPS = {"directional-light", "point-light", "multiple-lights"}
# One law that several lessons are lit by: a mistake in it is one in all of them.
SHARED = {
    "ch06_tests/count.frag": {*TOGETHER, "depth-mask", "stencil-operations"},
    "ch06_tests/blend_equation.frag": {"blend-equation", "blend-factors"},
    "lib/attenuation.glsl": {"attenuation", "deferred-shading", "light-volumes", *LIT_BY_LAMPS},
    "lib/spotlight.glsl": {"spotlight", *LIT_BY_LAMPS},
    "lib/reflection.glsl": {
        "blinn-phong", "deferred-shading", "normal-map", "shadow-acne", "shadow-map", "shadow-pcf",
        "diffuse", "hdr", "light-struct", "lighting-maps", "material", "obj-model",
        "phong-vs-blinn", "shininess", "specular", "spotlight-hard", *LIT_BY_LAMPS,
    },
}  # fmt: skip


@pytest.mark.parametrize(
    ("case_id", "shader", "right", "wrong"),
    MISTAKES,
    ids=[f"{case}-{wrong}" for case, _, _, wrong in MISTAKES],
)
def test_a_mistake_makes_its_case_fail_and_names_a_place(
    case_id: str, shader: str, right: str, wrong: str
) -> None:
    found = first_failure(shipped()[case_id], mistaken(shader, right, wrong), placed=True)
    assert found is not None
    assert found.worst is None or not found.worst.widths <= 1.0


def users() -> dict[str, set[str]]:
    """Which cases use each shader file."""
    found: dict[str, set[str]] = {}
    root = data_folder("shaders")
    shaders = Shaders([root])
    for case in shipped().values():
        for draw in (d for p in next(case.scenes()).passes for d in p.draws):
            for file, _ in (part for name in draw.shaders for part in shaders.load(name).parts):
                name = Path(file).resolve().relative_to(root.resolve()).as_posix()
                found.setdefault(name, set()).add(case.id)
    return found


def test_a_mistake_touches_no_other_case() -> None:
    used, wrong = users(), {}
    for case_id, shader, _, _ in MISTAKES:
        expected = TOGETHER if case_id in TOGETHER else {case_id}
        if used[shader] != SHARED.get(shader, expected):
            wrong[shader] = used[shader]
    assert wrong == {}


def test_every_first_case_is_broken_at_least_twice() -> None:
    broken = [case_id for case_id, *_ in MISTAKES]
    assert min(broken.count(case) for case in broken) >= 2
    assert len(set(broken)) == 12
