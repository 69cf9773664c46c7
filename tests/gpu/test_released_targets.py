"""A target is released when its last reader has been drawn; what redraws of that sample later is
made of its images, and holds the same bits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from shaderlab.engine.expectations.exact import exact
from shaderlab.engine.lab import Lab
from shaderlab.model.case import Case, Scene
from shaderlab.model.frame import Image
from shaderlab.model.passes import fullscreen
from shaderlab.model.scene import Pass, Target
from shaderlab.model.textures import Output

SHADES = """\
#version 330 core
layout(location = 0) out vec4 wide;
layout(location = 1) out vec4 codes;
layout(location = 2) out vec3 three;
void main() {
    wide = vec4(gl_FragCoord.xy / 7.0, -0.5, 1.0);
    codes = gl_FragCoord.yxyx / 40.0;
    three = wide.xyz;
    gl_FragDepth = 0.25;
}
"""
READS = """\
#version 330 core
uniform sampler2D one;
uniform sampler2D other;
out vec4 FragColor;
void main() { FragColor = texture(one, gl_FragCoord.xy / 9.0) + texture(other, vec2(0.3)); }
"""
COLORS = {"wide": "rgba16f", "codes": "srgb8_alpha8"}
LINEAR = ("linear", "linear")


def shaded(name: str, **target: object) -> Pass:
    (draw,) = fullscreen("shades.frag", domain={})[0].draws
    return Pass(name=name, target=Target(size=(6, 5), **target), draws=(draw,))


def reader(name: str, one: Output, other: Output) -> Pass:
    (draw,) = fullscreen("reads.frag", domain={}, textures={"one": one, "other": other})[0].draws
    return Pass(name=name, target=Target(size=(8, 8)), draws=(draw,))


def scene_of(folder: Path, *passes: Pass) -> Scene:
    (folder / "shades.frag").write_text(SHADES)
    (folder / "reads.frag").write_text(READS)
    expect = [exact(f"{passes[-1].name}.FragColor", 0.0)]
    file = str(folder / "t.py")
    return Case(title="t", id="t", file=file, passes=passes, expect=expect).scene("default")


def test_a_redraw_samples_what_the_released_target_held(tmp_path: Path) -> None:
    both = Output("table.wide", filter=LINEAR), Output("table.codes", filter=LINEAR)
    passes = shaded("table", colors=COLORS), reader("early", *both), reader("late", *both)
    scene = scene_of(tmp_path, *passes)
    with Lab() as lab:
        programs = lab.prepare(scene)
        with lab.backend.session(scene, programs, (8, 8)) as session:
            images = session.draw().images
            assert not session._unreleased  # type: ignore[attr-defined]

            def redrawn(name: str) -> bytes:
                written = session.written((name, 0), READS, {"FragColor": "rgba32f"})
                return written["FragColor"].tobytes()

            assert redrawn("late") == images["late", "FragColor"].values.tobytes()
            assert redrawn("early") == images["early", "FragColor"].values.tobytes()
            depthless = session.attachment("table", "wide").values
            np.testing.assert_array_equal(depthless, images["table", "wide"].values)
        # It is made of the images: where those are others, so is what a redraw samples.
        with lab.backend.session(scene, programs, (8, 8)) as session:
            drawn = session.draw().images
            wrong = {("table", "wide"): Image(drawn["table", "wide"].values + 1, "rgba16f")}
            session.images.update(wrong)  # type: ignore[attr-defined]
            assert redrawn("late") != images["late", "FragColor"].values.tobytes()


@pytest.mark.parametrize(
    ("one", "target"),
    [
        (Output("table.depth"), {"colors": COLORS, "depth": "depth24"}),
        (Output("table.wide", filter=("linear_mipmap_linear", "linear"), mipmaps=True), {}),
        (Output("table.three"), {}),
        (Output("table.wide"), {"samples": 4}),
    ],
)
def test_a_target_that_its_images_do_not_stand_for_is_kept(
    tmp_path: Path, one: Output, target: dict[str, object]
) -> None:
    passes = shaded("table", **target), reader("picture", one, Output("table.codes"))
    scene = scene_of(tmp_path, *passes)
    with Lab() as lab, lab.backend.session(scene, lab.prepare(scene), (8, 8)) as session:
        session.draw()
        assert [*session._unreleased] == ["table"]  # type: ignore[attr-defined]
