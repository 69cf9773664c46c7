"""The same shaders as piglit's shader_runner tests them: a few probes a test, one tolerance."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from benchmarks.running_programs import GAIN, constants, fragment

PLACES = ("/usr/lib/x86_64-linux-gnu/piglit/bin/shader_runner", "/usr/lib/piglit/bin/shader_runner")
PROBES = ((0.125, 0.125), (0.5, 0.5), (0.875, 0.25))


def find() -> str | None:
    """shader_runner, where piglit is installed."""
    return shutil.which("shader_runner") or next((p for p in PLACES if Path(p).exists()), None)


def write(folder: Path, count: int, size: int) -> list[Path]:
    """A .shader_test file for each program; each probes three pixels."""
    folder.mkdir(parents=True, exist_ok=True)
    return [_write(folder, index, size) for index in range(count)]


def run(runner: str, files: list[Path], at_once: bool) -> None:
    """All files in one process, or one process for each. Raises if a test fails."""
    groups = [files] if at_once else [[file] for file in files]
    environment = {**os.environ, "PIGLIT_PLATFORM": "surfaceless_egl"}
    for group in groups:
        done = subprocess.run(
            [runner, *map(str, group), "-auto", "-fbo"], env=environment, capture_output=True,
            text=True,
        )  # fmt: skip
        # Of several tests in one process only their last line tells, unless one of them fails.
        if '"result": "pass"' not in done.stdout or '"result": "fail"' in done.stdout:
            raise RuntimeError((done.stdout + done.stderr)[-2000:])


def _write(folder: Path, index: int, size: int) -> Path:
    c = constants(index)
    probes = []
    for across, up in PROBES:
        x, y = int(across * size), int(up * size)
        u, v = (x + 0.5) / size, (y + 0.5) / size
        d = ((u - float(c["x"])) ** 2 + (v - float(c["y"])) ** 2) ** 0.5
        f = 1.0 / (1.0 + float(c["linear"]) * d + float(c["quadratic"]) * d * d)
        probes.append(f"probe rgba {x} {y} {f:.7f} {f * GAIN:.7f} {u * f:.7f} 1.0")
    file = folder / f"light_{index}.shader_test"
    file.write_text(
        f"""[require]
GLSL >= 3.30
SIZE {size} {size}

[vertex shader]
#version 330 core
in vec4 piglit_vertex;
out vec2 TexCoords;
void main() {{ TexCoords = piglit_vertex.xy * 0.5 + 0.5; gl_Position = piglit_vertex; }}

[fragment shader]
{fragment(index)}
[test]
uniform float gain {GAIN}
draw rect -1 -1 2 2
"""
        + "\n".join(probes)
        + "\n"
    )
    return file
