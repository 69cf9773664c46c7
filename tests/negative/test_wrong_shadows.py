"""Realistic mistakes in shadow mapping, and which expectations notice."""

from __future__ import annotations

from dataclasses import replace

import pytest

from shaderlab.engine.expectations.measure import Measure
from shaderlab.model.case import Case
from tests.catalogue import shipped
from tests.negative.broken import failures, mistaken

FOLDER = "ch05_lighting"
SHADOW, LIT = "lib/shadow.glsl", "shadow_map.frag"
COMPARED = "shadow_compare.frag"
CASCADED, POINT = "cascaded_shadows.frag", "point_shadow.frag"

# case, shader, what stands there, the mistake, what notices it among others
MISTAKES = [
    ("shadow-map", SHADOW, "lightSpace.w * 0.5 + 0.5", "lightSpace.w", "judged.shadow"),
    ("shadow-map", SHADOW, "current - bias > closest ? 1.0 : 0.0",
     "current - bias > closest ? 0.0 : 1.0", "shadows told wrongly"),
    ("shadow-map", "shadow_depth.vert", "lightSpaceMatrix * (model *", "lightSpaceMatrix * (",
     "shadow.gl_Position"),
    ("shadow-map", LIT, "(ambient + (1.0 - shadow) * (diffuse + specular)) * Color",
     "(1.0 - shadow) * (ambient + diffuse + specular) * Color",
     "grey in shadow keeps its ambient light"),
    ("shadow-map", LIT, "float ambient = 0.15;", "float ambient = 0.15 * Color.r;",
     "grey in shadow keeps its ambient light"),
    ("shadow-map", SHADOW, "texture(shadowMap, place.xy", "texture(shadowMap, fract(place.xy)",
     "dark outside the map"),
    ("shadow-map", SHADOW, "texture(shadowMap, place.xy", "texture(shadowMap, place.yx",
     "told otherwise than by a map of rays"),
    ("shadow-acne", LIT, "slopeBias(normal, lightDir, leastBias, mostBias)", "leastBias",
     "told otherwise than by a map of rays"),
    ("shadow-acne", SHADOW, "most * (1.0 - dot(normal, lightDir))", "most", "slope-512.shadow"),
    ("shadow-acne", LIT, "leastBias, mostBias)", "leastBias + 0.05, mostBias)",
     "wrongly bright"),
    ("shadow-acne", SHADOW, "current - bias > closest", "current + bias > closest",
     "told otherwise than by a map of rays"),
    ("shadow-acne", SHADOW, "current - bias > closest", "current - bias > closest + 0.01",
     "wrongly dark"),
    ("shadow-acne", SHADOW, "if (current > 1.0)", "if (current > 2.0)",
     "past the far plane nothing is dark"),
    ("shadow-pcf", SHADOW, "sum / (side * side)", "sum / (side * side + 0.2)",
     "distance from the nearest step"),
    ("shadow-pcf", SHADOW, "vec2(x, y) * texel", "vec2(x, x) * texel", "nine.shadow"),
    ("shadow-pcf", SHADOW, "sum += shadowOf(place.z, closest, bias)",
     "sum = max(sum, shadowOf(place.z, closest, bias))", "different values"),
    ("shadow-pcf", SHADOW, "x = -radius; x <= radius", "x = 0; x <= 0",
     "nine texels: told otherwise than by a map of rays"),
    ("shadow-pcf", SHADOW, "return sum /", "return 0.5 * sum /", "share of places in between"),
    ("shadow-pcf", SHADOW, "current - bias > closest", "current > closest",
     "one texel: told otherwise than by a map of rays"),
    ("shadow-pcf", SHADOW, "* texel).r;", "* texel + 0.05).r;", "error against rays"),
    ("shadow-pcf", COMPARED, "at.z - bias", "at.z",
     "NEAREST that compares, against one texel compared by hand"),
    ("shadow-pcf", COMPARED, "1.0 - bright", "1.0 - 0.5 * bright",
     "in between, of pixels compared by the sampler"),
    ("shadow-pcf", COMPARED, "at.z > 1.0 ? 0.0 : 1.0 - bright", "1.0 - bright",
     "past the far plane the sampler says nothing"),
    ("cascaded-shadows", CASCADED, "cascade)).r, bias)", "min(cascade, 1.0))).r, bias)",
     "logarithmic.shadow"),
    ("cascaded-shadows", CASCADED, "depth >= splits[i]", "depth >= 1.02 * splits[i]",
     "practical: pixels in a wrong cascade"),
    ("cascaded-shadows", CASCADED, "-(view * vec4(FragPos, 1.0)).z", "length(FragPos)",
     "logarithmic: pixels in a wrong cascade"),
    ("cascaded-shadows", CASCADED, "index = i + 1;", "index = 2;",
     "uniform: pixels in a wrong cascade"),
    ("cascaded-shadows", CASCADED, "vec3(at.xy, cascade)", "vec3(at.xy, 0.0)",
     "shadows told wrongly"),
    ("cascaded-shadows", SHADOW, "current - bias > closest", "current > closest",
     "told otherwise than by maps of rays"),
    ("cascaded-shadows", CASCADED, "vec3(at.xy, cascade)", "vec3(at.xy, min(cascade, 1.0))",
     "told otherwise than by maps of rays, in the large picture"),
    ("cascaded-shadows", CASCADED, "vec3(at.xy, cascade)", "vec3(at.xy, 2.0 - cascade)",
     "… for each by a single map"),
    ("point-shadow", "point_shadow_depth.frag", "length(FragPos - lightPos) / farPlane",
     "gl_FragCoord.z", "distances on +x"),
    ("point-shadow", POINT, "texture(shadowMap, ray)", "texture(shadowMap, -ray)",
     "wrongly bright"),
    ("point-shadow", POINT, "texture(shadowMap, ray)", "texture(shadowMap, ray.xzy)",
     "told otherwise than by a cube of rays"),
    ("point-shadow", POINT, "current * slopeBias", "-current * slopeBias",
     "told otherwise than by a cube of rays"),
    ("point-shadow", "lib/shadow.glsl", "current - bias > closest ? 1.0 : 0.0", "1.0",
     "wrongly dark"),
    ("point-shadow", POINT, "length(ray) / farPlane", "length(ray)", "judged.shadow"),
]  # fmt: skip
LESSONS = {"shadow-map", "shadow-acne", "shadow-pcf", "cascaded-shadows", "point-shadow"}
# What only mistakes in state break: those in the depth test.
OF_STATE = {
    "places hidden from the eye",
    "places hidden from the eye, in the large picture",
    "share of the large picture that is drawn",
    "pixels of the large picture that the order of drawing changes",
}


@pytest.mark.parametrize(
    ("case_id", "shader", "right", "wrong", "by"),
    MISTAKES,
    ids=[f"{case}-{wrong}" for case, _, _, wrong, _ in MISTAKES],
)
def test_a_mistake_makes_its_case_fail(
    case_id: str, shader: str, right: str, wrong: str, by: str
) -> None:
    path = shader if shader.startswith("lib/") else f"{FOLDER}/{shader}"
    scene = shipped()[case_id].scene("default")
    assert list(failures(scene, mistaken(path, right, wrong), only=[by]))


@pytest.mark.parametrize(
    ("case_id", "name", "by"),
    [
        ("shadow-pcf", "nine", "places hidden from the eye"),
        ("shadow-pcf", "one", "one: the same surfaces"),
        ("shadow-map", "judged", "places hidden from the eye"),
        ("point-shadow", "-y-256", "-y-256.depth: any order of drawing"),
        ("cascaded-shadows", "uniform-2-1", "uniform-2-1.depth: any order of drawing"),
        ("cascaded-shadows", "practical-1-2", "practical-1-2.depth: any order of drawing"),
    ],
)
def test_a_wrong_depth_test_shows_what_is_hidden(case_id: str, name: str, by: str) -> None:
    case = without_depth_test(shipped()[case_id], name)
    assert list(failures(case.scene("default"), only=[by]))


def test_a_wrong_depth_test_shows_a_lamp_that_is_hidden() -> None:
    case = without_depth_test(shipped()["point-shadow"], "scene")
    by = "pixels of the large picture that the order of drawing changes"
    assert list(failures(case.scene("default"), only=[by]))


def without_depth_test(case: Case, name: str) -> Case:
    """The case with a pass whose first draw has none."""
    passes = []
    for made in case.passes:
        if made.name == name:
            first, *others = made.draws
            plain = replace(first, state=replace(first.state, depth=None))
            made = replace(made, draws=(plain, *others))
        passes.append(made)
    assert tuple(passes) != case.passes
    return replace(case, passes=tuple(passes))


def test_every_lesson_and_every_measure_is_broken() -> None:
    broken = [case_id for case_id, *_ in MISTAKES]
    assert set(broken) == LESSONS
    assert min(broken.count(case_id) for case_id in LESSONS) >= 2
    seen = {(case_id, by) for case_id, *_, by in MISTAKES}
    for case_id in LESSONS:
        measures = {e.name for e in shipped()[case_id].expect if isinstance(e, Measure)}
        assert {(case_id, name) for name in measures - OF_STATE} <= seen
