"""What glslang does once a process, done while that process is still importing.

Before its first text of a version glslang makes tables of all built-in names, anew for each target:
a tenth of a second in its own code, where Python's other threads can run.
"""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Callable

from shaderlab.errors import ShaderError
from shaderlab.glsl import frontend
from shaderlab.glsl.engines import COMMAND_VARIABLE
from shaderlab.glsl.sources import Shaders

# Whatever the stage, the tables are made for all of them.
_SMALLEST = "#version 330 core\nvoid main() {}\n"
_TARGETS = ("opengl", "vulkan")


def begin() -> Callable[[], None]:
    """Start it in a thread; returns what waits for its end.

    Where no library can be loaded nothing happens: who wants to compile is told why. Nothing is
    loaded where SHADERLAB_GLSLANG names a command that compiles in its place.
    """
    if os.environ.get(COMMAND_VARIABLE):
        return lambda: None
    thread = threading.Thread(target=_compile_for_all, daemon=True)
    thread.start()
    return thread.join


def _compile_for_all() -> None:
    source = Shaders([]).from_text(_SMALLEST, "vertex", "smallest.vert")
    with contextlib.suppress(ShaderError):
        frontend.check(source)
        for target in _TARGETS:
            frontend.link([source], frontend.ENVIRONMENTS[target])
