"""Every row of the catalogue has a case, and each case checks more than that nothing crashes.

`ROWS` are the lessons that the lab is to show.
"""

from __future__ import annotations

from shaderlab.engine.expectations.driver_answers import Coverage, GlError, InactiveUniforms
from shaderlab.engine.expectations.figures import Computed
from shaderlab.engine.expectations.rejections import CompileFails, Refused
from shaderlab.model.case import Case
from tests.catalogue import shipped

ROWS = {
    1: "orange-triangle",
    2: "triangle clipping primitives interleaved-attributes vertex-array indexed-quad "
    "compile-and-link swizzle glsl-types uniform-over-time inactive-uniform uniform-types "
    "sampler-units shader-files texture-origin texture-wrap texture-filter mipmap-chain "
    "mipmap-filters texture-compression textured-quad image-file texture-mix",
    3: "translate rotate scale mvp transform-order euler-angles quaternion",
    4: "coordinate-spaces handedness look-at camera-orbit orthographic perspective viewport "
    "ten-cubes",
    5: "colour-product ambient diffuse specular shininess material light-struct lighting-maps "
    "directional-light attenuation point-light spotlight-hard spotlight multiple-lights "
    "phong-vs-blinn blinn-phong gamma shadow-map shadow-acne shadow-pcf point-shadow "
    "cascaded-shadows normal-map hdr deferred-shading pbr pbr-furnace",
    6: "depth-not-cleared stencil-functions stencil-operations stencil-outline depth-functions "
    "depth-mask depth-precision depth-linear z-fighting alpha-discard blend-equation blend-factors "
    "transparency-order",
    7: "multitexture light-map cubemap environment-map",
    8: "face-culling framebuffer-texture framebuffer-renderbuffer multiple-render-targets "
    "post-grayscale post-kernels post-inversion batched-attributes uniform-buffer batching "
    "geometry-houses geometry-explode geometry-normals reduced-resolution",
    9: "multisample-coverage msaa msaa-offscreen",
    10: "buffer-subdata buffer-map buffer-usage points-and-elements mesh-class",
    11: "window-origin ellipsoid fixed-timestep double-buffer",
    12: "obj-model",
    13: "skybox",
    14: "point-cloud",
    15: "ibl-diffuse ibl-specular energy-compensation bloom tone-curves noise "
    "distance-fields parallax order-independent fxaa taa ambient-occlusion "
    "light-volumes soft-shadows tessellation compute-shaders "
    "textured-pbr",
}

# These hold or not whatever the shaders compute: alone they would let any formula pass.
SIDE = (CompileFails, Computed, Coverage, GlError, InactiveUniforms, Refused)


def rows() -> list[str]:
    return [row for chapter in ROWS.values() for row in chapter.split()]


def judges_values(case: Case) -> bool:
    """Whether some expectation compares what a shader wrote, pixel by pixel or vertex by vertex."""
    return any(not isinstance(e, SIDE) for scene in case.scenes() for e in scene.expect)


def test_no_row_is_listed_twice() -> None:
    assert len(rows()) == len(set(rows()))


def test_every_row_has_a_case_that_judges() -> None:
    there = shipped()
    without = {row for row in rows() if row not in there or not judges_values(there[row])}
    assert without == set()


def test_every_case_is_a_row_and_stands_in_its_chapter() -> None:
    chapters = {row: number for number, chapter in ROWS.items() for row in chapter.split()}
    for case in shipped().values():
        assert case.id in chapters, f"{case.id} is no row of the catalogue"
        assert f"/ch{chapters[case.id]:02d}_" in case.file.replace("\\", "/"), case.file
