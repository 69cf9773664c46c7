"""A scene in the size for people: what depends on the size is drawn once more with what it reads;
all images are those of the whole scene drawn in that size."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab.drivers.passes import PassSession
from shaderlab.engine.expectations.exact import exact
from shaderlab.engine.pictures import enlarge, resized_passes
from shaderlab.engine.run import SceneRunner
from shaderlab.model.case import Case, Scene
from shaderlab.model.scene import Pass, Target, fullscreen
from shaderlab.model.state import Blend, Depth, State
from shaderlab.model.textures import Output

SHADES = """\
#version 330 core
out vec4 FragColor;
void main() { FragColor = vec4(gl_FragCoord.xy / 7.0, 0.5, 1.0); gl_FragDepth = 0.25; }
"""
READS = """\
#version 330 core
uniform sampler2D image;
out vec4 FragColor;
void main() { FragColor = texture(image, gl_FragCoord.xy / 9.0); }
"""
OWN = (4, 4)


def shades(name: str, **others: Any) -> Pass:
    state = State(blend=Blend(source="one", destination="one"), depth=Depth(func="always"))
    return Pass(
        name=name, draws=fullscreen("shades.frag", domain={}, state=state)[0].draws, **others
    )


def reads(name: str, source: str, size: tuple[int, int] | None = None, **sampling: Any) -> Pass:
    textures = {"image": Output(source, **sampling)}
    draws = fullscreen("reads.frag", domain={}, textures=textures)[0].draws
    return Pass(name=name, target=Target(size=size), draws=draws)


PASSES = (
    shades("table", target=Target(size=OWN, colors={"FragColor": "rgba16f"})),
    shades("unread", target=Target(size=OWN)),
    shades("deep", target=Target(size=OWN, depth="depth24")),
    reads("smooth", "table.FragColor", filter=("linear_mipmap_linear", "linear"), mipmaps=True),
    reads("lit", "deep.depth"),
    shades("more", onto="smooth"),
    reads("after", "more.FragColor", OWN),
)


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    (tmp_path / "shades.frag").write_text(SHADES)
    (tmp_path / "reads.frag").write_text(READS)
    expect = [exact("lit.FragColor", 0.25)]
    file = str(tmp_path / "t.py")
    return Case(title="t", id="t", file=file, passes=PASSES, expect=expect).scene("default")


def test_only_what_depends_on_the_size_is_drawn_again(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[str] = []
    run = PassSession.run_pass

    def noted(session: PassSession[Any, Any], description: Pass) -> None:
        drawn.append(description.name)
        run(session, description)

    with SceneRunner() as lab:
        programs = lab.prepare(scene)
        with lab.evaluation(scene, programs) as evaluation:
            images = evaluation.drawn.images
        with lab.backend.session(scene, programs, (32, 32)) as session:
            wanted = session.draw().images
        monkeypatch.setattr(PassSession, "run_pass", noted)
        found = enlarge(lab.backend, scene, programs, images, 32)
    assert resized_passes(scene) == ["smooth", "lit", "more", "after"]
    assert drawn == ["table", "deep", "smooth", "lit", "more", "after"]
    assert list(found) == list(wanted)
    for key, image in found.items():
        assert image.format == wanted[key].format
        assert np.array_equal(image.values, wanted[key].values), key
    assert found["lit", "FragColor"].values.shape[:2] == (32, 32)
