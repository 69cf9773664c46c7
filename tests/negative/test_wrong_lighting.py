"""Realistic mistakes in the lighting cases' shaders: each makes its case fail, and says where."""

from __future__ import annotations

import numpy as np
import pytest

from cases.scenes.lit import TURNED_AWAY
from shaderlab.compiler.sources import Shaders
from shaderlab.engine.catalogue import data_folder
from tests.catalogue import judged_only, shipped
from tests.negative.broken import failing, failures, mistaken

FOLDER = "ch05_lighting"
PHONG, LIGHTS, FACETS = "lib/reflection.glsl", "lib/lights.glsl", "lib/microfacets.glsl"
FADING, SPOT = "lib/attenuation.glsl", "lib/spotlight.glsl"

# case, shader, what stands there, the mistake
MISTAKES = [
    ("colour-product", "colour_product.frag", "lightColor * objectColor", "lightColor"),
    ("colour-product", "colour_product.frag", "lightColor * objectColor",
     "min(lightColor, objectColor)"),
    ("ambient", "ambient.frag", "ambientStrength * lightColor", "ambientStrength * vec3(1.0)"),
    ("ambient", "ambient.frag", "ambient * objectColor", "ambient + objectColor"),
    ("diffuse", "diffuse.vert", "transpose(inverse(mat3(model)))", "inverse(mat3(model))"),
    ("diffuse", "diffuse.vert", "transpose(inverse(mat3(model)))", "mat3(model)"),
    ("diffuse", "diffuse.frag", "normalize(Normal)", "Normal"),
    ("diffuse", "diffuse.frag", "lightPos - FragPos", "FragPos - lightPos"),
    ("diffuse", PHONG, "max(dot(normal, lightDir), 0.0)", "abs(dot(normal, lightDir))"),
    ("specular", "specular.frag", "viewPos - FragPos", "FragPos - viewPos"),
    ("specular", "specular.frag", "normalize(viewPos - FragPos)", "normalize(viewPos)"),
    ("specular", PHONG, "reflect(-lightDir", "reflect(lightDir"),
    ("specular", PHONG, "pow(cosine, shininess)", "cosine * shininess"),
    ("shininess", PHONG, "pow(cosine, shininess)", "pow(cosine, 1.01 * shininess)"),
    ("shininess", "shininess_profile.frag", "lobe < 0.5", "lobe < 0.6"),
    ("material", "material.frag", "light.ambient * material.ambient",
     "light.ambient * material.diffuse"),
    ("material", "material.frag", "material.shininess)", "32.0)"),
    ("light-struct", "material.frag", "light.specular * (spec", "light.diffuse * (spec"),
    ("light-struct", "material.frag", "light.ambient * ", ""),
    ("lighting-maps", "lighting_maps.frag", "texture(material.specular",
     "texture(material.diffuse"),
    ("lighting-maps", "lighting_maps.frag", "TexCoords).rgb;\n    highlight",
     "TexCoords.ts).rgb;\n    highlight"),
    ("directional-light", "directional_light.frag", "normalize(-light", "normalize(light"),
    ("directional-light", LIGHTS, "normalize(-light.direction);\n    return",
     "normalize(light.direction);\n    return"),
    ("point-light", LIGHTS, "(light.ambient * surface.diffuse + part)",
     "part + light.ambient * surface.diffuse"),
    ("point-light", FADING, "(distance * distance)", "distance"),
    ("point-light", "lamp.vert", "aPos, 1.0", "aPos, 0.9"),
    ("spotlight-hard", "spotlight_hard.frag", "theta > light.cutOff", "theta < light.cutOff"),
    ("spotlight-hard", "spotlight_hard.frag", "theta > light.cutOff",
     "acos(theta) < acos(light.cutOff) * 1.02"),
    ("spotlight-hard", "spotlight_hard.frag", "color = light.ambient * Color", "color = vec3(0.0)"),
    ("multiple-lights", "multiple_lights.frag", "i < POINT_LIGHTS", "i < POINT_LIGHTS - 1"),
    ("multiple-lights", "multiple_lights.frag", "points += ", "points = "),
    ("multiple-lights", "multiple_lights.frag", "+ points + spot", "+ points"),
    ("multiple-lights", SPOT, "clamp(spotRatio(light, fragPos), 0.0, 1.0)",
     "spotRatio(light, fragPos)"),
    ("phong-vs-blinn", PHONG, "normalize(lightDir + viewDir)", "0.5 * (lightDir + viewDir)"),
    ("phong-vs-blinn", "phong_vs_blinn.frag", "viewDir, blinnExponent)", "viewDir, shininess)"),
    ("hdr", "lib/tone.glsl", "light / (1.0 + light)", "light / (1.0 + dot(light, light))"),
    ("hdr", "lib/tone.glsl", "exp(-light * exposure)", "exp(-light / exposure)"),
    ("hdr", "hdr_scene.frag", "/ dot(ray, ray)", "/ length(ray)"),
    ("hdr", "hdr.frag", "reinhard(light)", "reinhard(light * exposure)"),
    ("hdr", "hdr_curves.frag", "reinhard(vec3(light))", "reinhard(vec3(light) * exposure)"),
    ("hdr", "hdr.frag", "encoded(0.25 * sum)", "0.25 * sum"),
    ("pbr", FACETS, "roughness * roughness;\n    float alpha2", "roughness;\n    float alpha2"),
    ("pbr", FACETS, "grown * grown / 8.0", "roughness * roughness / 2.0"),
    ("pbr", FACETS, "grazing2 * grazing2 * grazing", "grazing2 * grazing2"),
    ("pbr", "pbr.frag", "(1.0 - metallic) * ", ""),
    ("pbr", "pbr.frag", "radiance * normalLight", "radiance"),
    ("ambient", "finish.frag", "encoded(0.25 * sum)", "encoded(0.2 * sum)"),
    ("material", "lit.vert", "normalMatrix * aNormal", "aNormal"),
    ("specular", "lit.vert", "normalMatrix * aNormal", "mat3(model) * aNormal"),
    ("lighting-maps", "lit_textured.vert", "normalMatrix * aNormal", "mat3(model) * aNormal"),
    ("directional-light", "lit_painted.vert", "Color = aColor", "Color = aColor.bgr"),
    ("lighting-maps", "lit_textured.vert", "TexCoords = aTexCoords", "TexCoords = aTexCoords.ts"),
]  # fmt: skip


# The lessons of sections 5.1 to 5.7.1, 5.11 and 5.13.
LESSONS = {
    "colour-product", "ambient", "diffuse", "specular", "shininess", "material", "light-struct",
    "lighting-maps", "directional-light", "point-light", "spotlight-hard", "multiple-lights",
    "phong-vs-blinn", "hdr", "pbr",
}  # fmt: skip


@pytest.mark.parametrize(
    ("case_id", "shader", "right", "wrong"),
    MISTAKES,
    ids=[f"{case}-{wrong}" for case, _, _, wrong in MISTAKES],
)
def test_a_mistake_makes_its_case_fail_and_names_a_place(
    case_id: str, shader: str, right: str, wrong: str
) -> None:
    path = shader if shader.startswith("lib/") else f"{FOLDER}/{shader}"
    texts = mistaken(path, right, wrong)
    for scene in shipped()[case_id].scenes():
        placed = (o.worst for o in failures(scene, texts) if o.worst is not None)
        worst = next(placed, None)
        assert worst is not None and not worst.widths <= 1.0, scene.variant


# All lessons with a highlight that a face turned away from the lamp could have.
SHINING = [
    "specular", "material", "light-struct", "lighting-maps", "directional-light", "point-light",
    "spotlight-hard", "multiple-lights", "phong-vs-blinn", "blinn-phong", "normal-map",
    "deferred-shading", "shadow-map", "shadow-acne", "shadow-pcf", "obj-model",
]  # fmt: skip
# They include the law and show no highlight (diffuse, hdr), or light faces from straight above.
NEVER_TURNED_AWAY = {"diffuse", "hdr", "shininess"}


WITHOUT_GATE = mistaken(PHONG, "return dot(normal, lightDir) > 0.0;", "return true;")


@pytest.mark.parametrize("case_id", SHINING)
def test_without_the_gate_a_check_fails_and_says_so(case_id: str) -> None:
    for scene in judged_only(case_id).scenes():
        assert list(failures(scene, WITHOUT_GATE, only=[TURNED_AWAY])), scene.variant


@pytest.mark.parametrize("case_id", ["specular", "light-struct", "normal-map", "blinn-phong"])
def test_without_the_gate_no_check_of_another_thing_fails(case_id: str) -> None:
    # A lamp level with the surface stands on the gate's edge.
    on_the_edge = {f"{lobe}, lamp level with the surface" for lobe in ("Phong", "Blinn")}
    for scene in judged_only(case_id).scenes():
        assert failing(scene, WITHOUT_GATE) - on_the_edge == {TURNED_AWAY}, scene.variant


def test_every_lesson_that_includes_the_gate_is_tried_without_it() -> None:
    shaders = Shaders([data_folder("shaders")])
    gate = str(data_folder("shaders") / PHONG)
    used = {
        case.id: {name for p in case.passes for draw in p.draws for name in draw.shaders}
        for case in shipped().values()
    }
    gated = {
        name
        for name in set().union(*used.values())
        if (data_folder("shaders") / name).exists() and gate in dict(shaders.load(name).parts)
    }
    included = {case_id for case_id, names in used.items() if names & gated}
    assert included == {*SHINING} | NEVER_TURNED_AWAY


def test_every_lighting_lesson_is_broken_at_least_twice() -> None:
    broken = [case_id for case_id, *_ in MISTAKES]
    assert set(broken) == LESSONS <= {case.id for case in shipped().values()}
    assert min(broken.count(case_id) for case_id in LESSONS) >= 2


def test_the_matrix_for_normals_is_not_that_of_places() -> None:
    """Else mat3(model) * aNormal goes unnoticed; `stage.prop_checks` gives studio.vert figures."""
    same: dict[tuple[str, str], bool] = {}
    for case in shipped().values():
        for draw in (draw for one in case.passes for draw in one.draws):
            matrices = [np.asarray(draw.uniforms.get(n)) for n in ("model", "normalMatrix")]
            if all(matrix.ndim == 2 and matrix.dtype == float for matrix in matrices):
                key = case.id, str(draw.shaders)
                alike = np.allclose(matrices[0][:3, :3], matrices[1])
                same[key] = same.get(key, True) and alike and "studio.vert" not in key[1]
    assert same and not [key for key, alike in same.items() if alike]
