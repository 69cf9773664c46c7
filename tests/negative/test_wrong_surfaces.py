"""Realistic mistakes in normal mapping, deferred shading, the furnace and tone mapping, and which
expectations notice."""

from __future__ import annotations

import pytest

from shaderlab.engine.expectations.measure import Measure
from tests.catalogue import shipped
from tests.negative.broken import failures, mistaken

FOLDER = "ch05_lighting"
FURNACE, FACETS = "lib/furnace.glsl", "lib/microfacets.glsl"

# case, shader, what stands there, the mistake, what notices it among others
MISTAKES = [
    ("normal-map", "normal_map.frag", "2.0 * texture(normalMap, TexCoords).rgb - 1.0",
     "texture(normalMap, TexCoords).rgb", "mapped: normals"),
    ("normal-map", "normal_map.frag", "normalize(TBN * normal)", "normalize(normal)",
     "mapped: normals"),
    ("normal-map", "normal_map.frag", "TBN * normal", "normal * TBN", "mapped: normals"),
    ("normal-map", "normal_map.geom", "* sign(determinant)", "", "mirrored: B"),
    ("normal-map", "normal_map.geom", "uv2.y * edge1 - uv1.y * edge2",
     "uv1.y * edge1 - uv2.y * edge2", "mapped: T"),
    ("normal-map", "normal_map.geom", "tangent - dot(tangent, N) * N", "tangent", "mapped: T"),
    ("normal-map", "normal_map.vert", "normalMatrix * aNormal", "mat3(model) * aNormal",
     "mapped: their normals"),
    ("normal-map", "normal_map.vert", "uv = aTexCoords", "uv = 0.5 * aTexCoords",
     "flat: their places in the texture"),
    ("normal-map", "normal_map_bytes.frag", "- 1.0", "- 128.0 / 127.5",
     "what bytes 128, 127 and 255 stand for"),
    ("deferred-shading", "deferred_buffer.frag", "normalize(Normal)", "Normal", "buffer.gNormal"),
    ("deferred-shading", "deferred_buffer.frag", "vec4(Color, 0.8 * Color.r)", "vec4(Color, 1.0)",
     "buffer.gAlbedoSpec"),
    ("deferred-shading", "deferred_lit.frag", "surface.rgb, surface.a", "surface.rgb, surface.r",
     "largest difference from forward shading"),
    ("deferred-shading", "deferred_forward.frag", "0.03 * Color", "0.05 * Color",
     "largest difference from forward shading"),
    ("deferred-shading", "lib/lamps.glsl", "1.4, 3.6)", "1.4, 3.5)", "deferred"),
    ("pbr-furnace", FACETS, "alpha2 / (PI * bracket * bracket)", "alpha2 / (bracket * bracket)",
     "∫ D (n·h) dω"),
    ("pbr-furnace", FACETS, "float alpha = roughness * roughness;", "float alpha = roughness;",
     "facing.facing"),
    ("pbr-furnace", FURNACE, "* halfOfG(form, normalView, roughness)", "",
     "largest share reflected"),
    ("pbr-furnace", FURNACE, "/ float(LEVELS * RING)", "/ float(LEVELS * RING - 24)",
     "share lost"),
    ("pbr-furnace", FURNACE, "viewHalf / cosine;", "viewHalf;", "table.smith"),
    ("pbr-furnace", FURNACE, "float k = form == DIRECT ?", "float k = form != DIRECT ?",
     "share lost, in figures"),
    ("hdr", "hdr.frag", "curve == CLIPPED", "curve != CLIPPED", "mean ΔE 2000 from clipping"),
    ("hdr", "lib/tone.glsl", "light / (1.0 + light)", "min(light, 1.0)",
     "mean ΔE 2000 from clipping"),
]  # fmt: skip
LESSONS = {"normal-map", "deferred-shading", "pbr-furnace"}


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


def test_every_lesson_is_broken_at_least_twice() -> None:
    broken = [case_id for case_id, *_ in MISTAKES]
    assert set(broken) >= LESSONS
    assert min(broken.count(case_id) for case_id in LESSONS) >= 2


def test_every_measure_of_these_lessons_is_seen_to_fail() -> None:
    seen = {by for *_, by in MISTAKES}
    there = {
        e.name
        for case_id in {case_id for case_id, *_ in MISTAKES}
        for e in shipped()[case_id].expect
        if isinstance(e, Measure)
    }
    assert there and there <= seen
