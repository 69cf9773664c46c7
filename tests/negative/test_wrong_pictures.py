"""Mistakes in what is only drawn for people: the picture's own check notices each."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.catalogue import shipped
from tests.negative.broken import failures, mistaken

CH5, CH9, CH11 = "ch05_lighting", "ch09_antialiasing", "ch11_window"
PICTURE, LARGE = "the picture", "the picture is the judged one, enlarged"

# case, shader, what stands there, the mistake, what notices it
MISTAKES = [
    ("attenuation", f"{CH5}/attenuation_picture.frag", "reachOf(light, 0.01)",
     "reachOf(light, 0.02)", PICTURE),
    ("attenuation", "lib/drawing.glsl", "fwidth(value)", "0.5 * fwidth(value)", PICTURE),
    ("spotlight", f"{CH5}/spotlight_picture.frag", "0.4 + distance * distance",
     "0.4 + distance", PICTURE),
    ("gamma", f"{CH5}/gamma_picture.frag", "srgbEncode(light)", "light", PICTURE),
    ("gamma", f"{CH5}/gamma_picture.frag", "(x ^ y) * 2 + y", "(x ^ y) * 2 + x", PICTURE),
    ("deferred-shading", f"{CH5}/deferred_picture.frag", "0.5 + 0.14 *", "0.5 + 0.12 *", PICTURE),
    ("deferred-shading", f"{CH5}/deferred_picture.frag", "0.25 * sum", "0.24 * sum", PICTURE),
    ("pbr-furnace", f"{CH5}/pbr_furnace_picture.frag", "0.17 * floor", "0.18 * floor", PICTURE),
    ("msaa", f"{CH9}/msaa.frag", "0.11, 0.14, 0.22", "0.12, 0.14, 0.22", PICTURE),
    ("msaa-offscreen", f"{CH9}/mean_of_samples.frag", "at.x < half_ ?", "at.x > half_ ?",
     "one sample, and all of them"),
    ("multisample-coverage", f"{CH9}/multisample_coverage.frag", "one > 0.5", "one < 0.5",
     "the drawing"),
    ("double-buffer", f"{CH11}/double_buffer_picture.frag", "> 0.46", "> 0.43", "shown: one 0"),
    ("fixed-timestep", f"{CH11}/fixed_timestep_picture.vert", "vec2(2.08, 1.25)",
     "vec2(2.08, 1.20)", "places of dots of strip 0"),
    ("fixed-timestep", f"{CH11}/fixed_timestep_floor.frag", "height < 0.0", "height < 0.1",
     "strip 0"),
    ("window-origin", f"{CH11}/window_origin_picture.frag", "vec2(0.5)", "vec2(1.5)",
     "on show: lower"),
    ("point-cloud", "ch14_point_clouds/point_cloud.frag", "4.0 * dot", "3.0 * dot", PICTURE),
]  # fmt: skip


@pytest.mark.parametrize(
    ("case_id", "shader", "right", "wrong", "by"),
    MISTAKES,
    ids=[f"{case}-{wrong}" for case, _, _, wrong, _ in MISTAKES],
)
def test_a_falsified_picture_is_noticed(
    case_id: str, shader: str, right: str, wrong: str, by: str
) -> None:
    scene = next(shipped()[case_id].scenes())
    assert list(failures(scene, mistaken(shader, right, wrong), only=[by]))


@pytest.mark.parametrize(
    ("case_id", "left_out"),
    [("double-buffer", -1), *(("fixed-timestep", draw) for draw in (1, 3, 6, 11))],
)
def test_a_draw_that_only_the_judged_pass_shows_is_noticed(case_id: str, left_out: int) -> None:
    case = shipped()[case_id]
    draws = list(next(one.draws for one in case.passes if one.name == "picture"))
    unseen = replace(draws[left_out].state, color_mask=(False,) * 4)
    draws[left_out] = replace(draws[left_out], state=unseen)
    passes = [replace(p, draws=draws) if p.name == "picture" else p for p in case.passes]
    scene = next(replace(case, passes=tuple(passes)).scenes())
    assert list(failures(scene, changed=["picture"], only=[LARGE]))
