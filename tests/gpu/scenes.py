"""Small scenes for the tests of drivers: a wave over the whole target, and meshes drawn plainly."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Draw, Mesh, Pass, Ramp, Target, exact, formula, fullscreen
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import DeviceLostError, DriverError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Expectation
from shaderlab.model.frame import Array
from shaderlab.model.records import Record

WAVE = """#version 330 core
in vec2 place;
out float level;
uniform float height;
void main() { level = height * place.x * place.y; }
"""
RIGHT = formula("level", lambda height, place: height * place.x * place.y)
ONE = "#version 330 core\nout float level;\nvoid main() { level = 1.0; }\n"
"""A fragment shader that writes 1."""


def require_driver(lab: Any) -> None:
    """Open a lab's driver; skip tests of one that this machine has not. One that is here and gives
    no answer fails them: on a busy machine a browser may take minutes to start, and has them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("shaderlab.drivers.webgl.device.PATIENCE", 300.0)
        try:
            _ = lab.backend
        except DeviceLostError:
            raise
        except DriverError as error:
            pytest.skip(str(error))


def wave(lab: SceneRunner, folder: Path, *expect: Expectation, text: str = WAVE) -> Record:
    """The record of a wave over the whole target."""
    (folder / "wave.frag").write_text(text)
    domain = {"place": Ramp((1.0, 2.0), (3.0, 0.0), (0.0, 5.0))}
    drawn = fullscreen("wave.frag", uniforms={"height": 0.3}, domain=domain)
    return lab.run(_scene(folder, drawn, expect))


def meshes(
    folder: Path,
    texts: tuple[str, str],
    mesh: Mesh,
    expect: Expectation,
    target: Target | None = None,
) -> Scene:
    """A mesh, drawn once with a vertex and a fragment shader of these texts."""
    for suffix, text in zip(("vert", "frag"), texts, strict=True):
        (folder / f"drawn.{suffix}").write_text(text)
    draw = Draw(vertex="drawn.vert", fragment="drawn.frag", mesh=mesh)
    drawn = Pass(draws=(draw,), target=target or Target())
    return _scene(folder, (drawn,), (expect,))


def _scene(folder: Path, passes: Sequence[Pass], expect: Sequence[Expectation]) -> Scene:
    from shaderlab import Case  # at the top it would make this a file that looks like a case

    case = Case(title="drawn", file=str(folder / "drawn.py"), passes=passes, expect=expect)
    return case.scene("default")


def image(lab: SceneRunner, scene: Scene, output: str) -> Array:
    """What a scene's only pass draws."""
    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
        return evaluation.drawn.images["main", output].values


def points_off_screen_are_dropped(lab: SceneRunner, folder: Path) -> None:
    """A point whose middle lies off screen is not seen; without the lab's ending it is."""
    vertex = (
        "#version 330 core\nin vec2 at;\n"
        "void main() { gl_Position = vec4(at, 0.0, 1.0); gl_PointSize = 12.0; }\n"
    )
    mesh = Mesh(attributes={"at": np.array([(1.2, 0.0)])}, primitive="points")
    scene = meshes(folder, (vertex, ONE), mesh, exact("level", 0.0))
    assert lab.run(scene).status == "pass"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("shaderlab.drivers.programs.stages.OFF_SCREEN", ())
        assert lab.run(scene).status == "fail"
