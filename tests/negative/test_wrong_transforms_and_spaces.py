"""Realistic mistakes in the shaders about transforms and spaces: each makes its case fail."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.catalogue import judged_only, shipped
from tests.negative.broken import failing, first_failure, mistaken, with_draws

CH3, CH4 = "ch03_transforms", "ch04_spaces"

# case, shader, what stands there, the mistake
MISTAKES = [
    # the offset in the last row instead of the last column
    ("translate", f"{CH3}/translate.vert", "translation[3] = vec4(offset, 1.0);",
     "translation[0].w = offset.x; translation[1].w = offset.y; translation[2].w = offset.z;"),
    ("translate", f"{CH3}/translate.vert", "vec4(aPos, w)", "vec4(aPos, 1.0)"),
    ("translate", f"{CH3}/translate.vert", "aNormal, 0.0", "aNormal, 1.0"),
    ("translate", f"{CH3}/studio.vert", "normalMatrix * aNormal", "aNormal.zyx"),
    ("translate", "lib/studio.glsl", "0.5 + 0.5 * n.y", "0.5 - 0.5 * n.y"),
    # degrees for radians, clockwise, an axis that is not normalised
    ("rotate", f"{CH3}/rotate.vert", "sin(angle) * crossed", "sin(radians(angle)) * crossed"),
    ("rotate", f"{CH3}/rotate.vert", "+ sin(angle)", "- sin(angle)"),
    ("rotate", f"{CH3}/rotate.vert", "normalize(axis)", "axis"),
    ("rotate", f"{CH3}/rotate.vert", "aPos + offset", "aPos + vec3(0.0, 0.0, offset.z)"),
    ("scale", f"{CH3}/scale.vert", "aNormal / factors", "aNormal * factors"),
    ("scale", f"{CH3}/scale.vert", "aNormal / factors", "aNormal"),
    ("scale", f"{CH3}/scale.vert", "vec4(offset, 1.0)", "vec4(factors * offset, 1.0)"),
    ("transform-order", f"{CH3}/transform_order.vert", "third * (second * (first",
     "first * (second * (third"),
    ("transform-order", f"{CH3}/transform_order.vert", "vec4(aPos, 1.0)", "vec4(aPos, 0.0)"),
    ("euler-angles", f"{CH3}/euler_angles.vert", "yawing * (pitching * (rolling * aPos))",
     "pitching * (yawing * (rolling * aPos))"),
    ("euler-angles", f"{CH3}/euler_angles.vert", "c, 0.0, -s, 0.0, 1.0, 0.0, s",
     "c, 0.0, s, 0.0, 1.0, 0.0, -s"),
    ("quaternion", "lib/quaternion.glsl", "vec4(-q.xyz, q.w)", "q"),
    ("quaternion", "lib/quaternion.glsl", "+ cross(p.xyz", "- cross(p.xyz"),
    ("quaternion", f"{CH3}/quaternion.vert", "Orientation = slerp(", "Orientation = mix("),
    ("quaternion", f"{CH3}/quaternion_turn.vert", "turned(aPos, q)", "turned(aPos, -q.wzyx)"),
    ("coordinate-spaces", f"{CH4}/coordinate_spaces.vert", "Clip.xyz / Clip.w",
     "Clip.xyz / Clip.z"),
    ("coordinate-spaces", f"{CH4}/coordinate_spaces.vert", "0.5 * Ndc.z + 0.5", "Ndc.z"),
    ("coordinate-spaces", f"{CH4}/coordinate_spaces.vert", "Clip.xyz, Ndc, Window",
     "Ndc, Clip.xyz, Window"),
    ("handedness", f"{CH4}/handedness_depth.frag", "-reach", "reach"),
    ("handedness", f"{CH4}/handedness_depth.frag", "+ reach", "- reach"),
    ("handedness", f"{CH4}/handedness.vert", "1.0, 1.0, -1.0", "-1.0, 1.0, 1.0"),
    ("look-at", "lib/look_at.glsl", "normalize(cross(forward, up))", "cross(forward, up)"),
    ("look-at", "lib/look_at.glsl", "cross(forward, up)", "cross(up, forward)"),
    ("look-at", "lib/look_at.glsl", "dot(forward, eye), 1.0", "-dot(forward, eye), 1.0"),
    ("camera-orbit", f"{CH4}/camera_orbit.vert", "radius * sin(angle), height",
     "-radius * sin(angle), height"),
    ("camera-orbit", f"{CH4}/camera_orbit.vert", "vec3(0.0, 0.4, 0.0)", "vec3(0.0, 0.0, 0.0)"),
    ("orthographic", f"{CH4}/orthographic.vert", "-2.0 / (far", "2.0 / (far"),
    ("orthographic", f"{CH4}/orthographic.vert", "-(right + left)", "(right + left)"),
    ("perspective", f"{CH4}/perspective.vert", "tan(fovy / 2.0)", "tan(fovy)"),
    ("perspective", f"{CH4}/perspective.vert", "focal / aspect", "focal * aspect"),
    ("perspective", f"{CH4}/perspective.vert", "2.0 * far * near", "far * near"),
    ("viewport", f"{CH4}/viewport.vert", "viewport.xy + half_", "viewport.xy"),
    ("viewport", f"{CH4}/viewport.vert", "0.5 * (depthRange.x + depthRange.y)", "depthRange.x"),
    ("viewport", f"{CH4}/viewport.frag", "vec2(0.5, -0.5)", "vec2(0.5, 0.5)"),
    ("ten-cubes", f"{CH4}/ten_cubes.vert", "view * (model *", "model * (view *"),
    ("ten-cubes", f"{CH4}/ten_cubes.vert", "TexCoords = aTexCoords", "TexCoords = aTexCoords.ts"),
    ("ten-cubes", f"{CH4}/ten_cubes.frag", "TexCoords).rgb", "TexCoords).bgr"),
]  # fmt: skip

MINE = {
    "translate", "rotate", "scale", "transform-order", "euler-angles", "quaternion",
    "coordinate-spaces", "handedness", "look-at", "camera-orbit", "orthographic", "perspective",
    "viewport", "ten-cubes",
}  # fmt: skip


@pytest.mark.parametrize(
    ("case_id", "shader", "right", "wrong"),
    MISTAKES,
    ids=[f"{case}-{wrong[:40]}" for case, _, _, wrong in MISTAKES],
)
def test_a_mistake_makes_its_case_fail(case_id: str, shader: str, right: str, wrong: str) -> None:
    found = first_failure(shipped()[case_id], mistaken(shader, right, wrong), placed=True)
    assert found is not None
    assert found.worst is None or not found.worst.widths <= 1.0


def test_a_texel_taken_twice_shows_in_the_picture() -> None:
    mistake = mistaken(f"{CH3}/soften.frag", "vec2(-0.5, 0.5)", "vec2(-0.5, -0.5)")
    assert failing(next(shipped()["translate"].scenes()), mistake) == {"four texels a pixel"}


def test_every_case_is_broken_at_least_twice() -> None:
    broken = [case_id for case_id, *_ in MISTAKES]
    assert set(broken) == MINE
    assert min(broken.count(case_id) for case_id in MINE) >= 2


def test_depth_testing_is_what_sorts_the_boxes() -> None:
    """Without it the last box drawn wins, and both the rays and the other order disagree."""
    case = judged_only("ten-cubes")
    undepthed = with_draws(case, lambda _, d: replace(d, state=replace(d.state, depth=None)))
    failed = failing(next(undepthed.scenes()))
    assert "the box that a ray meets" in failed
    assert sum("order of drawing" in name for name in failed) == 2  # of colours, and of boxes
