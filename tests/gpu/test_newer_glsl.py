"""A shader of a newer GLSL than the driver's is no mistake of the shader."""

from __future__ import annotations

from dataclasses import replace

import pytest

from shaderlab.compiler.sources import Shaders
from shaderlab.drivers.opengl.device import Device
from shaderlab.drivers.opengl.drawing import require_glsl
from shaderlab.drivers.programs.prepare import Preparer
from shaderlab.errors import UnsupportedError
from shaderlab.model.scene import fullscreen

TEXT = "#version 400 core\nout vec4 FragColor;\nvoid main() { FragColor = vec4(1.0); }\n"


def device(glsl: str) -> Device:
    return Device(None, {"glsl": glsl})


@pytest.mark.parametrize(
    ("said", "number"), [("3.30", 330), ("4.50", 450), ("4.60 NVIDIA", 460), ("?", 330)]
)
def test_what_a_driver_says_of_its_glsl(said: str, number: int) -> None:
    assert device(said).glsl == number


def test_a_newer_shader_is_unsupported() -> None:
    draw = fullscreen("new.frag", domain={})[0].draws[0]
    prepared = Preparer(Shaders([], overrides={"new.frag": TEXT})).prepare(draw)
    require_glsl(device("4.00"), prepared)
    with pytest.raises(UnsupportedError, match="#version 400: this driver takes GLSL up to 330"):
        require_glsl(device("3.30"), prepared)
    older = replace(prepared, sources=())
    require_glsl(device("3.30"), older)
