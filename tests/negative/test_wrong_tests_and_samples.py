"""Realistic mistakes in the cases of depth, stencil, blending and samples: shaders, then state."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from shaderlab import Stencil
from shaderlab.engine.run import SceneRunner
from shaderlab.model.case import Scene
from tests.catalogue import shipped
from tests.negative.broken import failures, first_failure, mistaken

CH6, CH9 = "ch06_tests", "ch09_antialiasing"
# case, shader, what stands there, the mistake
MISTAKES = [
    ("alpha-discard", f"{CH6}/alpha_discard.frag", "alpha < 0.1", "alpha < 0.11"),
    ("alpha-discard", f"{CH6}/alpha_discard.frag", "alpha < 0.1", "alpha <= 0.1"),
    ("alpha-discard", f"{CH6}/leaf.frag", "alpha < threshold", "alpha > threshold"),
    ("alpha-discard", f"{CH6}/leaf.frag", "1.0 - t)", "1.0 - t * t)"),
    ("stencil-outline", f"{CH6}/single_color.frag", "vec4(color, 1.0)", "vec4(color.bgr, 1.0)"),
    ("stencil-operations", f"{CH6}/count.frag", "total = worth", "total = 1.0"),
    ("depth-mask", f"{CH6}/count.frag", "total = worth", "total = 2.0 * worth"),
    ("blend-factors", f"{CH6}/blend_equation.frag", "color, alpha", "alpha * color, alpha"),
    ("blend-factors", f"{CH6}/blend_equation.frag", "color, alpha", "color, 1.0"),
    ("depth-precision", f"{CH6}/depth_ruler.frag", "1.0 / far - 1.0 / near",
     "1.0 / near - 1.0 / far"),
    ("depth-precision", f"{CH6}/depth_strip.frag", "1.0 / Distance - 1.0 / near",
     "Distance - near"),
    ("depth-precision", f"{CH6}/depth_strip.vert", "-Distance, 1.0", "Distance, 1.0"),
    ("depth-linear", f"{CH6}/depth_linear.frag", "2.0 * gl_FragCoord.z - 1.0", "gl_FragCoord.z"),
    ("depth-linear", f"{CH6}/depth_linear.frag", "(far + near - ndc", "(far - near - ndc"),
    ("depth-linear", f"{CH6}/depth_linear.vert", "-seen.z", "length(seen.xyz)"),
    ("z-fighting", f"{CH6}/z_fighting.vert", "aPos.x + rise * aPos.y + aGap", "aPos.x"),
    ("z-fighting", f"{CH6}/z_fighting.vert", "2.0 * far * near", "far * near"),
    ("transparency-order", f"{CH6}/glass.frag", "FragColor = color",
     "FragColor = vec4(color.a * color.rgb, color.a)"),
    ("transparency-order", f"{CH6}/glass.frag", "> radius * radius", "> radius"),
    ("multisample-coverage", f"{CH9}/multisample_coverage.frag", "pixel, k).r", "pixel, 0).r"),
    ("multisample-coverage", f"{CH9}/shape.vert", "aPos / size", "(aPos + 0.25) / size"),
    ("msaa", f"{CH9}/shape.vert", "2.0 * aPos", "1.9 * aPos"),
    ("msaa", f"{CH9}/lit.frag", "lit = 1.0", "lit = 0.9"),
    ("msaa-offscreen", f"{CH9}/mean_of_samples.frag", "mean *= 0.25", "mean *= 0.2"),
    ("msaa-offscreen", f"{CH9}/mean_of_samples.frag", "k < 4", "k < 3"),
]  # fmt: skip
# case, pass, draw, the state's field, another value
STATES: list[tuple[str, str, int, str, Any]] = [
    ("viewport", "patch", 0, "viewport", (11, 20, 640, 480)),
    ("viewport", "middle", 0, "depth_range", (0.0, 1.0)),
    ("viewport", "turned", 0, "depth_range", (0.0, 1.0)),
    ("stencil-operations", "table", 48, "stencil", None),
    ("stencil-operations", "table", -1, "blend", None),
    ("stencil-outline", "judged", 3, "stencil", None),
    ("stencil-outline", "judged", 1, "stencil", None),
    ("stencil-outline", "judged", 2, "depth", None),
    ("depth-mask", "kept", 28, "depth", None),
    ("depth-mask", "kept", 28, "depth_range", (0.3, 0.3)),
    ("alpha-discard", "behind", 0, "depth", None),
    ("alpha-discard", "behind", 0, "viewport", (1, 0, 64, 64)),
    ("blend-factors", "float", 12, "blend", None),
    ("blend-factors", "bytes", 27, "blend", None),
    ("depth-linear", "judged", 0, "depth", None),
    ("z-fighting", "picture", 5, "polygon_offset", None),
    ("z-fighting", "picture", 5, "polygon_offset", (1.0, 1.0)),
    ("z-fighting", "offset_depth16_001", 1, "polygon_offset", (-1.0, 0.0)),
    ("z-fighting", "offset_depth24_001", 1, "polygon_offset", (0.0, 0.0)),
    ("stencil-functions", "table", 62, "stencil", Stencil(func="less", reference=130, mask=67)),
    ("stencil-functions", "hollow", 1, "stencil", None),
    ("transparency-order", "judged_sorted", 3, "depth", None),
    ("transparency-order", "judged_sorted", 4, "blend", None),
    ("multisample-coverage", "where", 0, "sample_shading", None),
    ("multisample-coverage", "edge", 0, "multisample", False),
    ("msaa", "four", 0, "multisample", False),
    ("msaa-offscreen", "scene", 2, "depth", None),
]


@pytest.fixture(scope="module", autouse=True)
def _samples() -> None:
    """Cases of several samples need a driver that has them."""
    with SceneRunner() as lab:
        if int(lab.driver["max_samples"]) < 4:
            pytest.skip("this driver has one sample a pixel")


@pytest.mark.parametrize(
    ("case_id", "shader", "right", "wrong"),
    MISTAKES,
    ids=[f"{case}-{wrong}" for case, _, _, wrong in MISTAKES],
)
def test_a_mistake_in_a_shader_makes_its_case_fail(
    case_id: str, shader: str, right: str, wrong: str
) -> None:
    assert first_failure(shipped()[case_id], mistaken(shader, right, wrong))


def with_state(scene: Scene, name: str, index: int, **changes: Any) -> Scene:
    """The scene with one draw's state changed."""
    passes = []
    for description in scene.passes:
        draws = list(description.draws)
        if description.name == name:
            draws[index] = replace(draws[index], state=replace(draws[index].state, **changes))
        passes.append(replace(description, draws=tuple(draws)))
    return replace(scene, passes=tuple(passes))


@pytest.mark.parametrize(
    ("case_id", "name", "index", "field", "value"),
    STATES,
    ids=[f"{case}-{field}={value}" for case, _, _, field, value in STATES],
)
def test_a_mistake_in_state_makes_its_case_fail(
    case_id: str, name: str, index: int, field: str, value: Any
) -> None:
    scene = next(shipped()[case_id].scenes())
    wrong = with_state(scene, name, index, **{field: value})
    assert wrong != scene
    assert next(failures(wrong, changed=[name]), None)


def test_every_case_is_broken_at_least_twice() -> None:
    broken = [case for case, *_ in (*MISTAKES, *STATES)]
    assert all(broken.count(case) >= 2 for case in broken)
    assert len(set(broken)) == 14
