"""PyOpenGL, imported on EGL: it chooses its platform once, from the environment, as it is imported.

All modules of this backend take it from here.
"""

from __future__ import annotations

import functools

from shaderlab.backends.opengl import environment

with environment():
    from OpenGL import GL as GL
    from OpenGL.error import GLError as GLError, NullFunctionError as NullFunctionError
    from OpenGL.raw.GL import _errors
    from OpenGL.raw.GL.ARB import gl_spirv as gl_spirv
    from OpenGL.raw.GL.VERSION import GL_1_0 as GL_1_0, GL_1_2 as GL_1_2, GL_1_3 as GL_1_3

ERROR_CHECKER = _errors._error_checker
"""What PyOpenGL asks for errors after each call, or None in a process without such checks."""


@functools.cache
def named(word: str) -> int:
    """The number of a constant by its name as `shaderlab.model` has it: in lower case, bare.

    >>> hex(named("one_minus_src_alpha"))
    '0x303'
    """
    return int(getattr(GL, f"GL_{word.upper()}"))
