"""`warm_up` does in a thread what glslang does once a process."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

# Processor time of this thread, without that of the one that warms up.
TIMED = """
import sys, time
from shaderlab.compiler import Shaders, compile_program, engines
if sys.argv[1] == "warm":
    engines.warm_up()()
source = Shaders([]).from_text(
    "#version 330 core\\nout vec4 c;\\nvoid main() { c = vec4(1.0); }\\n", "fragment", "f"
)
engine = engines.choose("library")
started = time.thread_time()
assert compile_program([source], engine=engine).ok
print(time.thread_time() - started)
"""
BROKEN = """
from shaderlab.compiler import engines, library
from shaderlab.errors import ShaderError
def missing(*_):
    raise ShaderError("not installed")
library.find = missing
engines.warm_up()()
print("went on")
"""
NOTHING = """
import sys, threading
from shaderlab.compiler import engines, library
engines.warm_up()()
print(library.glslang.cache_info().currsize)
"""


def said(code: str, *arguments: str, **variables: str) -> str:
    """What a fresh interpreter prints; it must not write to standard error."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True, text=True, check=True, env={**os.environ, **variables},
    )  # fmt: skip
    assert done.stderr == ""
    return done.stdout.strip()


def test_the_first_program_need_not_wait_for_tables_of_built_in_names() -> None:
    cold, warm = (min(float(said(TIMED, how)) for _ in range(2)) for how in ("cold", "warm"))
    assert warm < 0.5 * cold


def test_a_missing_library_is_no_error_yet() -> None:
    assert said(BROKEN) == "went on"


@pytest.mark.parametrize(("command", "loaded"), [("", "1"), ("glslangValidator", "0")])
def test_no_library_is_loaded_if_a_command_compiles(command: str, loaded: str) -> None:
    assert said(NOTHING, SHADERLAB_GLSLANG=command) == loaded
