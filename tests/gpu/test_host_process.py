"""A process that uses OpenGL itself, as a notebook does, is left as it was by a lab in it.

Each test has a process of its own: Mesa and PyOpenGL read their settings once.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCENE = """
from shaderlab import Case, Target, exact, formula, fullscreen, gl_call, gl_error
from shaderlab import Draw, Mesh, Pass
from shaderlab.drivers import open_backend
from shaderlab.compiler import Shaders
from shaderlab.engine.run import SceneRunner

def judged(**given):
    case = Case(title="t", file=str(FOLDER / "t.py"), **given)
    with SceneRunner() as lab:
        record = lab.run(case.scene("default"))
    assert record.status == "pass", record
    return record

def draws():
    judged(passes=fullscreen("one.frag"), expect=[exact("color", 1.0)])
"""
CHECKS_STAY = """
from OpenGL import GL
draws()
judged(
    passes=fullscreen("one.frag"),
    expect=[
        gl_call("glEnable", 0xDEAD, raises="invalid_enum"),
        gl_call("glCompileShader", 0, raises="invalid_value"),
    ],
)
mesh = Mesh(attributes={"p": [[0.0, 0.0]]})
draw = Draw(vertex="p.vert", fragment="one.frag", mesh=mesh, vertex_array=False)
judged(
    passes=(Pass(draws=(draw,)),),
    expect=[gl_error("invalid_operation")],
)
backend = open_backend()
wrong = Shaders([]).from_text("#version 330 core\\nvoid main() { x; }", "fragment", "x.frag")
assert not backend.driver_verdict([wrong]).ok
try:
    GL.glEnable(0xDEAD)
except GL.GLError as error:
    assert error.err == GL.GL_INVALID_ENUM
else:
    raise AssertionError("PyOpenGL no longer checks")
backend.close()
"""


def run(folder: Path, text: str, **environment: str) -> None:
    """Run some Python in a new process, with the files of a scene in `folder`."""
    (folder / "one.frag").write_text(
        "#version 330 core\nout vec4 color;\nvoid main() { color = vec4(1.0); }\n"
    )
    (folder / "p.vert").write_text(
        "#version 330 core\nin vec2 p;\nvoid main() { gl_Position = vec4(p, 0.0, 1.0); }\n"
    )
    program = f"import os, pathlib\nFOLDER = pathlib.Path({str(folder)!r})\n{SCENE}{text}"
    done = subprocess.run(
        [sys.executable, "-c", program], env={**os.environ, **environment},
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("driver", ["llvmpipe", "softpipe"])
def test_the_environment_is_left_as_it_was(tmp_path: Path, driver: str) -> None:
    run(
        tmp_path,
        "before = dict(os.environ)\ndraws()\n"
        "assert dict(os.environ) == before\n"
        f"assert {driver!r} in open_backend().info['renderer']\n"
        "assert dict(os.environ) == before",
        SHADERLAB_DRIVER=driver, GALLIUM_DRIVER="no_such_driver", LIBGL_ALWAYS_SOFTWARE="0",
    )  # fmt: skip


def test_checks_of_pyopengl_stay_on(tmp_path: Path) -> None:
    run(tmp_path, CHECKS_STAY, PYOPENGL_PLATFORM="egl")


def test_checks_stay_on_where_the_lab_imports_pyopengl_first(tmp_path: Path) -> None:
    run(tmp_path, "draws()\n" + CHECKS_STAY)


def test_a_prepared_process_has_no_checks(tmp_path: Path) -> None:
    run(
        tmp_path,
        "from shaderlab.drivers import prepare_process\n"
        "prepare_process('softpipe')\n"
        "assert os.environ['GALLIUM_DRIVER'] == 'softpipe'\n"
        "draws()\n"
        "from OpenGL import GL\n"
        "backend = open_backend()\n"
        "GL.glEnable(0xDEAD)\n"
        "assert GL.glGetError() == GL.GL_INVALID_ENUM\n",
    )
