"""Realistic mistakes in the cases about GLSL itself and about files: each makes its case fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from shaderlab.engine.expectations.driver_answers import InactiveUniforms
from shaderlab.engine.expectations.figures import Computed
from shaderlab.engine.expectations.rejections import CompileFails, Refused
from shaderlab.model.textures import Output
from tests.catalogue import judged_only, shipped
from tests.negative.broken import failing, first_failure, mistaken

CH2, CH11 = "ch02_basics", "ch11_window"

# case, shader, what stands there, the mistake
MISTAKES = [
    ("triangle", f"{CH2}/triangle.vert", "aPos.x, aPos.y", "aPos.y, aPos.x"),
    ("triangle", f"{CH2}/triangle.vert", "aPos.z, 1.0", "aPos.z, 0.99"),
    ("triangle", f"{CH2}/triangle.frag", "0.5, 0.2", "0.2, 0.5"),
    ("image-file", f"{CH2}/textured.frag", "image, TexCoords", "image, vec2(0, 1) - TexCoords"),
    ("image-file", f"{CH2}/textured.frag", "texture(image, TexCoords)",
     "texture(image, TexCoords).bgra"),
    ("primitives", f"{CH2}/primitives.vert", "aPos, 0.0", "aPos.yx, 0.0"),
    ("primitives", f"{CH2}/primitives.vert", "gl_PointSize = size", "gl_PointSize = size + 1.0"),
    ("primitives", f"{CH2}/primitives.frag", "float(gl_PrimitiveID)",
     "float(gl_PrimitiveID / 2)"),
    ("clipping", f"{CH2}/clipping.vert", "gl_Position = aPos", "gl_Position = vec4(aPos.xyz, 1)"),
    ("clipping", f"{CH2}/clipping.vert", "gl_Position = aPos",
     "gl_Position = vec4(clamp(aPos.xyz, -aPos.w, aPos.w), aPos.w)"),
    ("clipping", f"{CH2}/clipping.frag", "place.z / place.w", "place.z"),
    ("depth-not-cleared", "ch08_techniques/framebuffer_renderbuffer.vert", "depth, 1.0",
     "-depth, 1.0"),
    ("depth-not-cleared", "ch08_techniques/framebuffer_renderbuffer.frag", "= color",
     "= color.bgra"),
    ("compile-and-link", f"{CH2}/errata/misspelt.vert", "gl_Positon", "gl_Position"),
    ("compile-and-link", f"{CH2}/compile_and_link.vert", "0.5 + aPos", "aPos"),
    ("compile-and-link", f"{CH2}/compile_and_link.frag", "vec4(color", "vec4(color.bgr"),
    ("compile-and-link", f"{CH2}/errata/undeclared.frag", "colour", "color"),
    ("compile-and-link", f"{CH2}/errata/type_mismatch.frag", "in vec4 color", "in vec3 color"),
    ("swizzle", f"{CH2}/swizzle.frag", "someVec.xyxx", "someVec.xyyx"),
    ("swizzle", f"{CH2}/swizzle.frag", "anotherVec.yxzy", "anotherVec.xyzy"),
    ("swizzle", f"{CH2}/swizzle.frag", "written.wy", "written.yw"),
    ("glsl-types", f"{CH2}/glsl_types_int.frag", "= natural3", "= uvec3(0)"),
    ("glsl-types", f"{CH2}/glsl_types_float.frag", "= quad", "= 1.000001 * quad"),
    ("glsl-types", f"{CH2}/glsl_types_bits.frag", "31 - int", "30 - int"),
    ("inactive-uniform", f"{CH2}/inactive_uniform.frag", "strength * t", "unused * t"),
    ("inactive-uniform", f"{CH2}/inactive_uniform.frag", "strength * tint", "elsewhere() * tint"),
    ("uniform-types", f"{CH2}/uniform_types.frag", "fv[2], fv[3]", "fv[3], fv[2]"),
    ("uniform-types", f"{CH2}/uniform_types.frag", "m[1].z", "m[1].y"),
    ("uniform-types", f"{CH2}/uniform_types.frag", "uOut = u;", "uOut = u & 0xffffu;"),
    ("shader-files", f"{CH2}/shader_files.frag", "byte == 13.0", "byte == 12.0"),
    ("shader-files", f"{CH2}/shader_files.frag", "byte >= 128.0", "byte > 240.0"),
    ("shader-files", f"{CH2}/errata/files/nul.frag", "\0", " "),
    ("obj-model", "ch12_models/obj_model.vert", "normalMatrix * aNormal", "-aNormal"),
    ("obj-model", "ch12_models/obj_model.frag", "normalize(viewPos - FragPos)", "viewPos"),
    ("obj-model", "ch12_models/obj_model.frag", "TexCoords.t", "TexCoords.s"),
    ("point-cloud", "ch14_point_clouds/point_cloud.vert", "pointScale / gl_Position.w",
     "pointScale"),
    ("point-cloud", "ch14_point_clouds/point_cloud.vert", "gl_PointSize = diameter",
     "gl_PointSize = 0.5 * diameter"),
    ("point-cloud", "ch14_point_clouds/point_cloud.frag", "gl_PointCoord - 0.5", "gl_PointCoord"),
    ("sampler-units", f"{CH2}/sampler_units.frag", "base = texture(BaseMap",
     "base = texture(ReflectMap"),
    ("sampler-units", f"{CH2}/sampler_units.frag", "mix(refracted,", "mix(base,"),
    ("window-origin", f"{CH11}/window_origin.frag", "gl_FragCoord.xy", "gl_FragCoord.xy - 0.5"),
    ("window-origin", f"{CH11}/window_origin_upper.frag", "layout (origin_", "// ("),
    ("ellipsoid", f"{CH11}/ellipsoid.vert", "/ (axes * axes)", "* (axes * axes)"),
    ("ellipsoid", f"{CH11}/ellipsoid.vert", "vec4(aPos, 1.0)", "vec4(1.02 * aPos, 1.0)"),
    ("ellipsoid", f"{CH11}/ellipsoid.frag", "Local / (axes * axes)", "Local / axes"),
    ("fixed-timestep", f"{CH11}/fixed_timestep.frag", "remainder -= dt", "remainder = 0.0"),
    ("fixed-timestep", f"{CH11}/fixed_timestep.frag", "remainder >= dt", "remainder > dt"),
    ("fixed-timestep", f"{CH11}/fixed_timestep.frag", "-0.75 * speed", "-0.74 * speed"),
    ("double-buffer", f"{CH11}/double_buffer_ball.frag", "/ 0.3", "/ 0.31"),
    ("double-buffer", f"{CH11}/double_buffer_screen.frag", "gl_FragCoord.xy", "gl_FragCoord.yx"),
]  # fmt: skip
MINE = {case_id for case_id, *_ in MISTAKES}


@pytest.mark.parametrize(
    ("case_id", "shader", "right", "wrong"),
    MISTAKES,
    ids=[f"{case}-{wrong[:40]}" for case, _, _, wrong in MISTAKES],
)
def test_a_mistake_makes_its_case_fail(case_id: str, shader: str, right: str, wrong: str) -> None:
    assert first_failure(shipped()[case_id], mistaken(shader, right, wrong))


def test_every_case_is_broken_at_least_twice() -> None:
    broken = [case_id for case_id, *_ in MISTAKES]
    assert min(broken.count(case_id) for case_id in MINE) >= 2


def test_a_refusal_in_other_words_is_noticed() -> None:
    """Each expected message, with its last letter gone, is not what is said."""
    for case_id, kind in (
        ("compile-and-link", CompileFails),
        ("shader-files", Refused),
        ("obj-model", Refused),
        ("point-cloud", Refused),
    ):
        case = judged_only(case_id)
        failed = failing(next(replace(case, expect=[shortened(e) for e in case.expect]).scenes()))
        assert failed == {e.name for e in case.expect if isinstance(e, kind)}


def shortened(expectation: object) -> object:
    if isinstance(expectation, Refused):
        return replace(expectation, message=expectation.message[:-1])
    if isinstance(expectation, CompileFails):
        messages = tuple((file, line, text[:-1]) for file, line, text in expectation.messages)
        return replace(expectation, messages=messages)
    return expectation


def test_a_screen_that_reads_the_back_buffer_is_noticed() -> None:
    """With two buffers, pointed at the one that is drawn into, it shows half a frame."""
    case = judged_only("double-buffer")
    passes = []
    for made in case.passes:
        if made.name == "two seen 3":
            draw = replace(made.draws[0], textures={"front": Output("two 2 half.FragColor")})
            made = replace(made, draws=(draw,))
        passes.append(made)
    failed = failing(next(replace(case, passes=tuple(passes)).scenes()))
    assert failed == {"two buffers, refresh 3: frame 1, whole"}


def test_another_file_s_figures_are_noticed() -> None:
    for case_id in ("obj-model", "point-cloud"):
        case = judged_only(case_id)
        wrong = [
            replace(e, equals=np.add(e.equals, 1e-3)) if isinstance(e, Computed) else e
            for e in case.expect
        ]
        failed = failing(next(replace(case, expect=wrong).scenes()))
        figures = {e.name for e in case.expect if isinstance(e, Computed) and e.digits >= 6}
        assert figures and figures <= failed


def test_an_active_uniform_that_is_called_inactive_is_noticed() -> None:
    case = judged_only("inactive-uniform")
    for names in (("unused",), ("unused", "neverAsked", "tint")):
        expect = [
            replace(e, uniforms=names) if isinstance(e, InactiveUniforms) else e
            for e in case.expect
        ]
        failed = failing(next(replace(case, expect=expect).scenes()))
        assert failed == {"location −1"}
