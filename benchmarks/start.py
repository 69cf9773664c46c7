"""How soon a command is there: `python -m benchmarks.start [--rounds N]`.

Whole processes from the shell, by turns: a script written by hand that draws one picture with
moderngl, reads it and compares it with NumPy, and the lab's commands. Shown are the seconds by the
clock and of the processors, workers included, the least of all rounds, and both as a multiple of
the script's. Everything was compiled before.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.running_by_hand import VERTEX

REPOSITORY = Path(__file__).resolve().parent.parent
BY_HAND = f"""
import moderngl, numpy as np

context = moderngl.create_context(standalone=True, require=330, backend="egl")
texture = context.texture((256, 256), 4, dtype="f4")
context.framebuffer([texture]).use()
program = context.program(vertex_shader='''{VERTEX}''', fragment_shader='''#version 330 core
in vec2 TexCoords;
out vec4 color;
uniform vec3 terms;
void main()
{{
    float d = 50.0 * TexCoords.x;
    color = vec4(vec3(1.0 / (terms.x + terms.y * d + terms.z * d * d)), 1.0);
}}
''')
program["terms"].value = (1.0, 0.09, 0.032)
context.vertex_array(program, []).render(vertices=3)
measured = np.empty((256, 256, 4), np.float32)
texture.read_into(measured)
d = 50.0 * (np.arange(256) + 0.5) / 256
expected = 1.0 / (1.0 + 0.09 * d + 0.032 * d * d)
assert np.allclose(measured[..., 0], expected, rtol=1e-5)
"""
LAB = (sys.executable, "-m", "shaderlab")
ONE = "attenuation[50]"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    rounds: int = parser.parse_args().rounds
    with tempfile.TemporaryDirectory() as folder:
        ways: dict[str, Sequence[str]] = {
            "a script by hand": (sys.executable, "-c", BY_HAND),
            "shaderlab --help": (*LAB, "--help"),
            "shaderlab list": (*LAB, "list"),
            f"shaderlab run '{ONE}' --no-pictures": (*LAB, "run", ONE, "--no-pictures"),
            f"shaderlab run '{ONE}'": (*LAB, "run", ONE),
            f"shaderlab run '{ONE}' -j 0": (*LAB, "run", ONE, "-j", "0"),
        }
        for command in ways.values():
            spent(command, folder)  # what is compiled is kept
        least = {name: [float("inf"), float("inf")] for name in ways}
        for _ in range(rounds):
            for name, command in ways.items():
                least[name] = [*map(min, least[name], spent(command, folder))]
    floor = least["a script by hand"]
    print(f"{'':<44} {'clock, s':>9} {'×':>6} {'processors, s':>14} {'×':>6}")
    for name, (clock, processors) in least.items():
        times = f"{clock:>9.2f} {clock / floor[0]:>6.2f}"
        print(f"{name:<44} {times} {processors:>14.2f} {processors / floor[1]:>6.2f}")


def spent(command: Sequence[str], folder: str) -> tuple[float, float]:
    """Seconds by the clock and of the processors that a command takes, with all it has started."""
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    before, began = os.times(), time.perf_counter()
    subprocess.run(command, cwd=folder, env=environment, capture_output=True, check=True)
    clock, after = time.perf_counter() - began, os.times()
    user = after.children_user - before.children_user
    return clock, user + after.children_system - before.children_system


if __name__ == "__main__":
    main()
