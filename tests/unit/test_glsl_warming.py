"""What glslang does once a process is done early, and never in the way."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

# Processor time of this thread: the warming thread's own does not count.
TIMED = """
import sys, time
from shaderlab.glsl import Shaders, compile_program, engines, warming
if sys.argv[1] == "warm":
    warming.begin()()
source = Shaders([]).from_text(
    "#version 330 core\\nout vec4 c;\\nvoid main() { c = vec4(1.0); }\\n", "fragment", "f"
)
engine = engines.choose("library")
started = time.thread_time()
assert compile_program([source], engine=engine).ok
print(time.thread_time() - started)
"""
BROKEN = """
from shaderlab.glsl import library, warming
from shaderlab.errors import ShaderError
def missing(*_):
    raise ShaderError("not installed")
library.find = missing
warming.begin()()
print("went on")
"""
NOTHING = """
import sys, threading
from shaderlab.glsl import library, warming
warming.begin()()
print(library.glslang.cache_info().currsize)
"""


def said(code: str, *arguments: str, **variables: str) -> str:
    """What a fresh interpreter prints, which must say nothing else."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True, text=True, check=True, env={**os.environ, **variables},
    )  # fmt: skip
    assert done.stderr == ""
    return done.stdout.strip()


def test_the_first_program_no_longer_waits_for_built_in_names() -> None:
    cold, warm = (min(float(said(TIMED, how)) for _ in range(2)) for how in ("cold", "warm"))
    assert warm < 0.5 * cold


def test_a_compiler_that_is_missing_is_for_others_to_report() -> None:
    assert said(BROKEN) == "went on"


@pytest.mark.parametrize(("command", "loaded"), [("", "1"), ("glslangValidator", "0")])
def test_nothing_is_loaded_where_a_command_compiles(command: str, loaded: str) -> None:
    assert said(NOTHING, SHADERLAB_GLSLANG=command) == loaded
