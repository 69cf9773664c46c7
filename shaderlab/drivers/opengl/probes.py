"""What a driver claims and can't: found out by drawing, once a device."""

from __future__ import annotations

import re

import numpy as np

from shaderlab.errors import UnsupportedError

from ..attachments import COVERING
from ..programs.prepare import PreparedDraw
from .device import Device
from .pyopengl import GL

_NUMBERED = """#version 330 core
out float number;
void main() { number = float(gl_PrimitiveID) + 1.0; }
"""
_READS_NUMBER = re.compile(r"\bgl_PrimitiveID\b")


def require_inputs(device: Device, draw: PreparedDraw) -> None:
    """Raise UnsupportedError for a fragment stage that reads a built-in input which the driver does
    not give it."""
    fragment = next((s for s in draw.sources if s.stage == "fragment"), None)
    if fragment is None or "geometry" in draw.texts or not _READS_NUMBER.search(fragment.code):
        return
    if device.recorder is not None:  # the calls that are written down are the scene's
        return
    if "gl_PrimitiveID" not in device.probed:
        device.probed["gl_PrimitiveID"] = _numbers_primitives(device)
    if not device.probed["gl_PrimitiveID"]:
        raise UnsupportedError(
            "gl_PrimitiveID in a fragment stage: this driver draws nothing where it is read",
            file=fragment.path,
        )


def _numbers_primitives(device: Device) -> bool:
    """Whether a fragment stage without a geometry stage before it can read gl_PrimitiveID."""
    context = device.context
    program = context.program(vertex_shader=COVERING, fragment_shader=_NUMBERED)
    texture = context.texture((1, 1), 1, dtype="f4")
    framebuffer = context.framebuffer([texture])
    nothing = context.vertex_array(program, [])
    framebuffer.use()
    for capability in (GL.GL_SCISSOR_TEST, GL.GL_DEPTH_TEST, GL.GL_STENCIL_TEST, GL.GL_CULL_FACE,
                       GL.GL_BLEND):  # fmt: skip
        GL.glDisable(capability)
    GL.glViewport(0, 0, 1, 1)
    GL.glColorMask(True, True, True, True)
    GL.glClearBufferfv(GL.GL_COLOR, 0, np.zeros(4, np.float32))
    nothing.render(vertices=3)
    found = float(np.frombuffer(texture.read(), np.float32)[0])
    for made in (nothing, framebuffer, texture, program):
        made.release()
    return found == 1.0
