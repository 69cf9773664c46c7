"""Calls of OpenGL that several lessons make before the one that they are about."""

from __future__ import annotations

from shaderlab.expectations.gl_call import Object, call

_COLOR = ("GL_FRAMEBUFFER", "GL_COLOR_ATTACHMENT0", "GL_RENDERBUFFER")

ONE_PIXEL = (
    call("glBindFramebuffer", "GL_FRAMEBUFFER", Object("framebuffer", "pixel")),
    call("glBindRenderbuffer", "GL_RENDERBUFFER", Object("renderbuffer", "pixel")),
    call("glRenderbufferStorage", "GL_RENDERBUFFER", "GL_RGBA8", 1, 1),
    call("glFramebufferRenderbuffer", *_COLOR, Object("renderbuffer", "pixel")),
    call("glViewport", 0, 0, 1, 1),
)
"""A framebuffer of one pixel, to be drawn into and read."""
