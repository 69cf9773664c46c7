"""Case files that do their worst, and the command line that has to bear them."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

CASE = """
from shaderlab import Case, Target, exact, fullscreen
{before}
case = Case(
    title="T", passes=fullscreen("{name}.frag"{target}),
    expect=[exact("FragColor", (1.0, 0.5, 0.25, 1.0))],
)
{after}
"""
SHADER = """#version 330 core
in vec2 TexCoords;
out vec4 FragColor;
void main()
{{
    float x = TexCoords.x;
    {body}
    FragColor = vec4(1.0, 0.5, 0.25, x < 9.0 ? 1.0 : x);
}}
"""
# Mesa ends a single loop of its own accord after 65535 rounds; loops inside one another go on.
ENDLESS = "while (x < 2.0) while (x < 2.0) while (x < 2.0) while (x < 2.0) x = fract(x * 1.5 + .1);"
# A worker ends itself by an alarm where its parent does not do it; the lab takes both for a time
# limit. So a hang takes no longer than this, and no limit has to be short for what does not hang.
ALARM = "signal.setitimer(signal.ITIMER_REAL, 0.3)"
HANG = f"{ALARM}; __import__('time').sleep(600)"
IN_DRAW = """
import os, signal
from types import FunctionType
from shaderlab.drivers.opengl.drawing import Drawing

def act():
    {act}

def shot(self, key, draw, target):
    Drawing.issue.acts.get(draw.draw.fragment, bool)()
    Drawing.issue.right(self, key, draw, target)

issue = Drawing.issue
if not hasattr(issue, "acts"):
    issue.acts, issue.right = {{}}, FunctionType(issue.__code__, issue.__globals__)
    issue.__code__ = shot.__code__
issue.acts["{name}.frag"] = act
"""
# The function is the same one as before: a worker in which it is another one would be replaced.


def write(
    folder: Path, name: str, *, body: str = "", before: str = "", after: str = "", target: str = ""
) -> Path:
    """A case file `name`.py with its shader; returns it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.frag").write_text(SHADER.format(body=body))
    file = folder / f"{name}.py"
    file.write_text(CASE.format(name=name, before=before, after=after, target=target))
    return file


def write_wave(folder: Path, name: str) -> Path:
    """A case that is right everywhere, beside whose colour a sine is drawn, which every driver
    computes in its own way; returns it."""
    file = write(folder, name, body="wave = sin(9.0 * x);")
    shader = folder / f"{name}.frag"
    shader.write_text(shader.read_text().replace("void main", "out float wave;\nvoid main"))
    return file


def in_draw(name: str, act: str) -> str:
    """Python for a case file: `act` happens in the middle of this case's draw."""
    return IN_DRAW.format(name=name, act=act)


def command(*args: str | Path) -> list[str]:
    return [sys.executable, "-m", "shaderlab", "run", *map(str, args)]


def shaderlab(*args: str | Path, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the command to its end, in this process; its workers are others. It writes to no
    terminal."""
    words = ["run", *map(str, args)]
    with contextlib.chdir(cwd), pytest.MonkeyPatch.context() as patch:
        patch.delenv("SHADERLAB_JOBS", raising=False)
        for name, value in environment.items():
            patch.setenv(name, value)
        done = CliRunner().invoke(cli, words, catch_exceptions=False)
    return subprocess.CompletedProcess(words, done.exit_code, done.stdout, done.stderr)


def restore_interrupts() -> None:
    """Let a child be interrupted (`preexec_fn`): under nohup, in CI or behind a shell it would
    inherit that SIGINT is ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def surroundings(**environment: str) -> dict[str, str]:
    """The environment for a child: this checkout's package, and what else is given."""
    root = str(Path(__file__).resolve().parents[2])
    kept = {name: value for name, value in os.environ.items() if name != "SHADERLAB_JOBS"}
    return {**kept, "PYTHONPATH": root, **environment}


def results(file: Path) -> dict[str, dict[str, Any]]:
    """The cases of a `--json` file, by id."""
    data = json.loads(file.read_text(encoding="utf-8"))
    return {case["id"]: case for case in data["cases"]}


def kept(folder: Path) -> list[dict[str, Any]]:
    """The records in a run's journal; raises if a line is no JSON."""
    lines = (folder / "records.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines[1:]]
