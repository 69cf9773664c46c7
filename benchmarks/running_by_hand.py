"""The same work as a script of one's own would do it with moderngl and NumPy.

Written as well as we can: one context, one target, reading into one array, all pixels compared at
once. Two ways of judging: with a tolerance that somebody chose, and (`--bands`) with the same
references as the lab, as bands. It has no messages, no isolation and no report.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import moderngl
import numpy as np

VERTEX = """#version 330 core
out vec2 TexCoords;
void main()
{
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;
    TexCoords = corner;
    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}
"""
ROWS = 16384


def main(folder: Path, count: int, size: int, bands: bool) -> int:
    """Run `count` programs of `folder` at `size`²; returns how many do not hold."""
    from running_programs import GAIN

    context = moderngl.create_context(standalone=True, require=330, backend="egl")
    texture = context.texture((size, size), 4, dtype="f4")
    target = context.framebuffer([texture])
    target.use()
    measured = np.empty((size, size, 4), np.float32)
    centre = ((np.arange(size) + 0.5) / size).astype(np.float32)
    places = np.stack(np.meshgrid(centre, centre), axis=-1)
    wrong = 0
    for index in range(count):
        program = context.program(
            vertex_shader=VERTEX, fragment_shader=(folder / f"light_{index}.frag").read_text()
        )
        program["gain"].value = GAIN
        context.vertex_array(program, []).render(vertices=3)
        texture.read_into(measured)
        holds = by_bands(folder, index) if bands else by_tolerance(index)
        wrong += not holds(places, measured)
    return wrong


def by_tolerance(index: int) -> Any:
    """A judge of program `index` that knows its formula and a tolerance."""
    from running_programs import GAIN, constants

    c = constants(index)

    def holds(places: Any, measured: Any) -> bool:
        u, v = (places[..., axis].astype(np.float64) for axis in (0, 1))
        d = np.sqrt((u - c["x"]) ** 2 + (v - c["y"]) ** 2)
        f = 1.0 / (1.0 + c["linear"] * d + c["quadratic"] * d * d)
        expected = np.stack([f, f * GAIN, u * f, np.ones_like(f)], axis=-1)
        return bool(np.all(np.abs(measured - expected) <= 1e-5 * np.abs(expected) + 1e-7))

    return holds


def by_bands(folder: Path, index: int) -> Any:
    """A judge of program `index` by the case's own reference, as a band."""
    from running_programs import GAIN

    from shaderlab.bands import Band, Rules
    from shaderlab.engine.catalogue import load_case

    color = load_case(folder / f"light_{index}.py").expect[0].reference  # type: ignore[union-attr]
    rules = Rules()
    gain = np.array([GAIN], np.float32)

    def holds(places: Any, measured: Any) -> bool:
        places, measured, fine = places.reshape(-1, 2), measured.reshape(-1, 4), True
        for start in range(0, len(places), ROWS):
            some, got = places[start : start + ROWS], measured[start : start + ROWS]
            band = color(Band.exact(some, rules), Band.exact(gain, rules))
            fine &= bool(band.contains(got).all())
        return fine

    return holds


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent))
    words = [word for word in sys.argv[1:] if not word.startswith("--")]
    raise SystemExit(main(Path(words[0]), int(words[1]), int(words[2]), "--bands" in sys.argv))
