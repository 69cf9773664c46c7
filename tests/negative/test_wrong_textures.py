"""Realistic mistakes with textures: in shaders, and in how a texture is sampled or made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from shaderlab import Case, CubeTexture, Texture
from tests.catalogue import judged_only, shipped
from tests.negative.broken import failing, failures, first_failure, mistaken, with_draws

CH2, CH7, CH13 = "ch02_basics", "ch07_maps", "ch13_skybox"

# case, shader, what stands there, the mistake
MISTAKES = [
    ("texture-origin", f"{CH2}/textured.frag", "image, TexCoords", "image, TexCoords.ts"),
    ("texture-origin", f"{CH2}/textured.frag", "image, TexCoords",
     "image, vec2(TexCoords.s, 1.0 - TexCoords.t)"),
    ("texture-wrap", f"{CH2}/textured.frag", "image, TexCoords", "image, fract(TexCoords)"),
    ("texture-wrap", f"{CH2}/textured.frag", "image, TexCoords",
     "image, clamp(TexCoords, 0.0, 1.0)"),
    ("texture-filter", f"{CH2}/textured.frag", "image, TexCoords", "image, TexCoords + 0.1"),
    ("texture-filter", f"{CH2}/textured.frag", "texture(image, TexCoords)",
     "texelFetch(image, ivec2(TexCoords * vec2(textureSize(image, 0))), 0)"),
    ("mipmap-chain", f"{CH2}/mipmap_chain.frag", "gl_FragCoord.xy), level",
     "gl_FragCoord.yx), level"),
    ("mipmap-chain", f"{CH2}/mipmap_chain.frag", "textureSize(image, level)",
     "textureSize(image, 0)"),
    ("mipmap-filters", f"{CH2}/mipmapped.frag", "lod)", "lod + 0.5)"),
    ("mipmap-filters", f"{CH2}/mipmapped.frag", "lod)", "floor(lod))"),
    ("texture-compression", f"{CH2}/texture_compression.frag", "gl_FragCoord.xy",
     "gl_FragCoord.yx"),
    ("texture-compression", f"{CH2}/texture_compression.frag", "image, ivec2(gl_FragCoord.xy), 0)",
     "image, ivec2(gl_FragCoord.xy), 0).bgra"),
    ("textured-quad", f"{CH2}/textured_quad.frag", "* vec4(ourColor, 1.0)",
     "+ vec4(ourColor, 1.0)"),
    ("textured-quad", f"{CH2}/textured_quad.frag", "TexCoord) *", "TexCoord.ts) *"),
    ("textured-quad", f"{CH2}/textured_quad.vert", "ourColor = aColor", "ourColor = aColor.bgr"),
    ("multitexture", f"{CH7}/multitexture.frag", "mask, MaskCoords", "mask, TexCoords"),
    ("multitexture", f"{CH7}/multitexture.frag", "texture(plaster,", "texture(bricks,"),
    ("multitexture", f"{CH7}/multitexture.frag", "MaskCoords).r", "MaskCoords).a"),
    ("light-map", f"{CH7}/light_map.frag", "lightMap, LightCoords", "lightMap, TexCoords"),
    ("light-map", f"{CH7}/light_map.frag", "color * light", "color + light"),
    ("cubemap", "lib/cube_face.glsl", "? -direction.z : direction.z",
     "? direction.z : -direction.z"),
    ("cubemap", "lib/cube_face.glsl", "direction.y > 0.0 ? 2.0 : 3.0",
     "direction.y > 0.0 ? 3.0 : 2.0"),
    ("cubemap", "lib/cube_face.glsl", "place / largest", "place / length(direction)"),
    ("cubemap", f"{CH7}/cubemap.frag", "faces, direction, 0.0", "faces, -direction, 0.0"),
    ("environment-map", f"{CH7}/environment_map.frag", "FragPos - cameraPos",
     "cameraPos - FragPos"),
    ("environment-map", f"{CH7}/environment_map.frag", "refract(ray, normal, ratio)",
     "refract(ray, normal, 1.0 / ratio)"),
    ("environment-map", f"{CH7}/environment_map.frag", "sky, mirrored,", "sky, normal,"),
    ("skybox", f"{CH13}/skybox.vert", "mat4(mat3(view))", "view"),
    ("skybox", f"{CH13}/skybox.vert", ".xyww", ""),
    ("skybox", f"{CH13}/skybox.frag", "skybox, TexCoords", "skybox, -TexCoords"),
]  # fmt: skip


def failed(case: Case) -> set[str]:
    return failing(next(case.scenes()))


@pytest.mark.parametrize(
    ("case_id", "shader", "right", "wrong"),
    MISTAKES,
    ids=[f"{case}-{wrong[:40]}" for case, _, _, wrong in MISTAKES],
)
def test_a_mistake_makes_its_case_fail(case_id: str, shader: str, right: str, wrong: str) -> None:
    assert first_failure(shipped()[case_id], mistaken(shader, right, wrong))


def test_every_case_is_broken_at_least_twice() -> None:
    broken = [case_id for case_id, *_ in MISTAKES]
    assert min(broken.count(case_id) for case_id in broken) >= 2


def with_textures(case: Case, change: Callable[[Any], Any]) -> Case:
    """The case with every texture changed, as a careless program would set it."""

    def of_draw(draw: Any) -> Any:
        return replace(draw, textures={n: change(t) for n, t in draw.textures.items()})

    return with_draws(case, lambda _, draw: of_draw(draw))


def test_printed_figures_tell_the_wrap_modes_and_the_border() -> None:
    """References read the texture's own modes, so it is the figures that tell a wrong one."""

    def repeated(texture: Texture) -> Texture:
        return replace(texture, wrap=("repeat",) * len(texture.wrap))

    def blackened(texture: Texture) -> Texture:
        return replace(texture, border=(0.0,) * 4)

    case = judged_only("texture-wrap")
    found = failed(with_textures(case, repeated))
    assert {"MIRRORED_REPEAT: 1.25 is 0.75", "LINEAR towards a border of 1, at −0.05"} <= found
    assert "LINEAR towards a border of 1, at 1.05" in failed(with_textures(case, blackened))


def test_printed_figures_tell_the_filters() -> None:
    def coarse(texture: Texture) -> Texture:
        return replace(texture, filter=("nearest", "nearest"))

    found = failed(with_textures(judged_only("texture-filter"), coarse))
    assert "LINEAR between two texels is their mean" in found

    def stepping(texture: Texture) -> Texture:
        return replace(texture, filter=("nearest_mipmap_nearest", "nearest"))

    found = failed(with_textures(judged_only("mipmap-filters"), stepping))
    assert "NEAREST_MIPMAP_LINEAR at level 1.25" in found


def test_an_image_upside_down() -> None:
    def turned(texture: Texture) -> Texture:
        image = texture.image() if callable(texture.image) else texture.image
        return replace(texture, image=image[::-1])  # type: ignore[index]

    found = failed(with_textures(judged_only("texture-origin"), turned))
    assert "the first row in memory is the lowest" in found


@pytest.mark.parametrize(
    ("case_id", "by"),
    [("cubemap", "the texel's face is the table's"), ("skybox", "a texel towards −x")],
)
def test_faces_in_another_order(case_id: str, by: str) -> None:
    """−X before +X: what a direction leads to by the table is in another face."""

    def swapped(texture: Any) -> Any:
        if not isinstance(texture, CubeTexture):
            return texture
        faces = list(texture.faces)
        return replace(texture, faces=[faces[1], faces[0], *faces[2:]])

    case = with_textures(shipped()[case_id], swapped)
    assert list(failures(next(case.scenes()), only=[by]))
