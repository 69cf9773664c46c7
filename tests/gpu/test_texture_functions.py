"""Every texture function that is not `texture` itself: what the driver samples lies in its band,
and what a similar call gives does not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Case, Ramp, Texture, formula, fullscreen, glslmath as g
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import sampling as s
from shaderlab.model.options import RunOptions

RNG = np.random.default_rng(17)
GATHER = "#extension GL_ARB_texture_gather : require\n#extension GL_ARB_gpu_shader5 : require\n"
# s and t, a level or the value to compare, and the divisor of projections.
PLACES = Ramp((0.13, -0.17, 0.1, 0.9), (1.31, 0.23, 0.7, 0.5), (0.19, 1.47, 0.9, 0.3))
OFFSETS = "const ivec2 four[4] = ivec2[4](ivec2(0), ivec2(2, 1), ivec2(-1, 0), ivec2(1, -3));\n"
FOUR = ((0, 0), (2, 1), (-1, 0), (1, -3))

# GLSL of p, its reference, and the reference of a mistake.
Row = tuple[str, Callable[..., Any], Callable[..., Any]]
PLAIN: dict[str, Row] = {
    "textureOffset": (
        "textureOffset(image, p.xy, ivec2(2, -1))",
        lambda image, p: s.textureOffset(image, p.xy, (2, -1)),
        lambda image, p: s.textureOffset(image, p.xy, (-1, 2)),
    ),
    "textureProj": (
        "textureProj(image, p)",
        lambda image, p: s.textureProj(image, p),
        lambda image, p: s.textureProj(image, p.xyz + 0.5),
    ),
    "textureProj of three": (
        "textureProj(image, p.xyw)",
        lambda image, p: s.textureProj(image, p.xyw),
        lambda image, p: s.texture(image, p.xy),
    ),
    "textureProjOffset": (
        "textureProjOffset(image, p, ivec2(1, 0))",
        lambda image, p: s.textureProjOffset(image, p, (1, 0)),
        lambda image, p: s.textureProj(image, p),
    ),
    "texelFetchOffset": (
        "texelFetchOffset(image, ivec2(gl_FragCoord.xy) / 4, 0, ivec2(1, 2))",
        lambda image, frag_coord: s.texelFetchOffset(
            image, g.ivec2(g.floor(frag_coord.xy)) / 4, 0, (1, 2)
        ),
        lambda image, frag_coord: s.texelFetch(image, g.ivec2(g.floor(frag_coord.xy)) / 4),
    ),
}
LEVELS: dict[str, Row] = {
    "textureLodOffset": (
        "textureLodOffset(image, p.xy, p.z, ivec2(1, -2))",
        lambda image, p: s.textureLodOffset(image, p.xy, p.z, (1, -2)),
        lambda image, p: s.textureLod(image, p.xy, p.z),
    ),
    "textureProjLod": (
        "textureProjLod(image, p, p.z)",
        lambda image, p: s.textureProjLod(image, p, p.z),
        lambda image, p: s.textureProjLod(image, p, p.w),
    ),
    "textureProjLodOffset": (
        "textureProjLodOffset(image, p, p.z, ivec2(-1, 1))",
        lambda image, p: s.textureProjLodOffset(image, p, p.z, (-1, 1)),
        lambda image, p: s.textureProjLodOffset(image, p, p.z, (1, -1)),
    ),
    "textureGrad": (
        "textureGrad(image, p.xy, vec2(0.31, 0.0), vec2(0.0, 0.02))",
        lambda image, p: s.textureGrad(image, p.xy, g.vec2(0.31, 0.0), g.vec2(0.0, 0.02)),
        lambda image, p: s.textureGrad(image, p.xy, g.vec2(0.03, 0.0), g.vec2(0.0, 0.02)),
    ),
    "textureGradOffset": (
        "textureGradOffset(image, p.xy, vec2(0.31, 0.0), vec2(0.0, 0.02), ivec2(1, 1))",
        lambda image, p: s.textureGradOffset(
            image, p.xy, g.vec2(0.31, 0.0), g.vec2(0.0, 0.02), (1, 1)
        ),
        lambda image, p: s.textureGrad(image, p.xy, g.vec2(0.31, 0.0), g.vec2(0.0, 0.02)),
    ),
    "textureProjGrad": (
        "textureProjGrad(image, p, vec2(0.31, 0.0), vec2(0.0, 0.02))",
        lambda image, p: s.textureProjGrad(image, p, g.vec2(0.31, 0.0), g.vec2(0.0, 0.02)),
        lambda image, p: s.textureGrad(image, p.xy, g.vec2(0.31, 0.0), g.vec2(0.0, 0.02)),
    ),
    "textureProjGradOffset": (
        "textureProjGradOffset(image, p, vec2(0.31, 0.0), vec2(0.0, 0.02), ivec2(0, 2))",
        lambda image, p: s.textureProjGradOffset(
            image, p, g.vec2(0.31, 0.0), g.vec2(0.0, 0.02), (0, 2)
        ),
        lambda image, p: s.textureProjGrad(image, p, g.vec2(0.31, 0.0), g.vec2(0.0, 0.02)),
    ),
}
GATHERS: dict[str, Row] = {
    "textureGather": (
        "textureGather(image, p.xy, 1)",
        lambda image, p: s.textureGather(image, p.xy, 1),
        lambda image, p: s.textureGather(image, p.xy, 2),
    ),
    "textureGatherOffset": (
        "textureGatherOffset(image, p.xy, ivec2(1, -1))",
        lambda image, p: s.textureGatherOffset(image, p.xy, (1, -1)),
        lambda image, p: s.textureGather(image, p.xy),
    ),
    "textureGatherOffsets": (
        "textureGatherOffsets(image, p.xy, four)",
        lambda image, p: s.textureGatherOffsets(image, p.xy, FOUR),
        lambda image, p: s.textureGatherOffsets(image, p.xy, FOUR[::-1]),
    ),
}
GROUPS = {"": PLAIN, "levels": LEVELS, "gather": GATHERS}
ROWS = [(group, name) for group, rows in GROUPS.items() for name in rows]


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=24)) as made:
        yield made


def status(lab: SceneRunner, folder: Path, shader: str, image: Texture, reference: Any) -> str:
    (folder / "t.frag").write_text(shader)
    passes = fullscreen("t.frag", domain={"p": PLACES}, textures={"image": image})
    made = Case(
        title="t",
        id="t",
        file=str(folder / "t.py"),
        passes=passes,
        expect=[formula("FragColor", reference)],
    )
    return lab.run(made.scene("default")).status


def shader_of(expression: str, head: str = "#version 330 core\n", kind: str = "2D") -> str:
    return (
        f"{head}in vec4 p;\nout vec4 FragColor;\nuniform sampler{kind} image;\n"
        f"{OFFSETS}void main() {{ FragColor = p * 0.0 + {expression}; }}\n"
    )


def noise(*shape: int) -> Any:
    return RNG.random(shape).astype(np.float32)


@pytest.mark.parametrize(("group", "name"), ROWS, ids=[name for _, name in ROWS])
def test_a_function_is_its_reference_and_no_other(
    lab: SceneRunner, tmp_path: Path, group: str, name: str
) -> None:
    expression, right, wrong = GROUPS[group][name]
    head = "#version 330 core\n" + (GATHER if group == "gather" else "")
    image = Texture(image=noise(8, 12, 4), filter=("linear", "linear"))
    if group == "levels":
        smaller = [noise(4, 6, 4), noise(2, 3, 4), noise(1, 1, 4)]
        filters = ("linear_mipmap_linear", "linear")
        image = Texture(image=noise(8, 12, 4), mipmaps=smaller, filter=filters)
    shader = shader_of(expression, head)
    assert status(lab, tmp_path, shader, image, right) == "pass"
    assert status(lab, tmp_path, shader, image, wrong) == "fail"


def test_gathers_of_a_shadow_sampler_compare(lab: SceneRunner, tmp_path: Path) -> None:
    image = Texture(image=noise(4, 4, 1), format="depth32f", compare="less")
    shader = shader_of(
        "textureGather(image, p.xy, p.z)", "#version 330 core\n" + GATHER, "2DShadow"
    )

    def gathered(image: Any, p: Any) -> Any:
        return s.textureGather(image, p.xyz)

    def other(image: Any, p: Any) -> Any:
        return 1.0 - s.textureGather(image, p.xyz)

    assert status(lab, tmp_path, shader, image, gathered) == "pass"
    assert status(lab, tmp_path, shader, image, other) == "fail"


def test_a_level_is_that_of_the_quads_derivatives(lab: SceneRunner, tmp_path: Path) -> None:
    if "softpipe" in lab.driver["renderer"]:
        pytest.skip("softpipe has no GLSL 4.00, which textureQueryLod comes with")
    image = Texture(image=noise(32, 32, 4), mipmaps=True, filter=("linear_mipmap_linear", "linear"))
    shader = shader_of("vec4(textureQueryLod(image, p.xy * 2.0), 0.0, 0.0)", "#version 400 core\n")

    def queried(image: Any, p: Any, frag_coord: Any) -> Any:
        return g.vec4(s.textureQueryLod(image, p.xy * 2.0, frag_coord), 0.0, 0.0)

    def other(image: Any, p: Any, frag_coord: Any) -> Any:
        return g.vec4(s.textureQueryLod(image, p.xy * 6.0, frag_coord), 0.0, 0.0)

    assert status(lab, tmp_path, shader, image, queried) == "pass"
    assert status(lab, tmp_path, shader, image, other) == "fail"
