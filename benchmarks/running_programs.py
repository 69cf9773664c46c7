"""Small programs for the speed of running: each a shader of its own with its reference."""

from __future__ import annotations

from pathlib import Path

FRAGMENT = """#version 330 core
in vec2 TexCoords;
uniform float gain;
out vec4 FragColor;

void main()
{{
    float d = length(TexCoords - vec2({x}, {y}));
    float f = 1.0 / (1.0 + {linear} * d + {quadratic} * d * d);
    FragColor = vec4(f, f * gain, TexCoords.x * f, 1.0);
}}
"""
CASE = '''"""Light that fades from ({x}, {y})."""

from shaderlab import Case, Target, formula, fullscreen
from shaderlab.glslmath import length, swizzle, vec2, vec4


def color(TexCoords, gain):
    """The colour at a place of the picture."""
    d = length(TexCoords - vec2({x}, {y}))
    f = 1.0 / (1.0 + {linear} * d + {quadratic} * d * d)
    return vec4(f, f * gain, swizzle(TexCoords, "x") * f, 1.0)


case = Case(
    title="Light {index}",
    passes=fullscreen(
        "light_{index}.frag", uniforms={{"gain": {gain}}}, target=Target(size=({size}, {size}))
    ),
    expect=[formula("FragColor", color)],
)
'''
GAIN = 0.75


def constants(index: int) -> dict[str, float | int]:
    """What makes program `index` another one than its neighbours."""
    return {
        "index": index,
        "x": round(0.1 + 0.0015 * index, 4),
        "y": round(0.9 - 0.0015 * index, 4),
        "linear": round(0.7 + 0.01 * index, 2),
        "quadratic": round(1.8 + 0.01 * index, 2),
        "gain": GAIN,
    }


def fragment(index: int) -> str:
    """The shader's text."""
    return FRAGMENT.format(**constants(index))


def write(folder: Path, count: int, size: int) -> list[Path]:
    """Write `count` case files, at `size`², with their shaders; returns them in order."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for index in range(count):
        (folder / f"light_{index}.frag").write_text(fragment(index))
        files.append(folder / f"light_{index}.py")
        files[-1].write_text(CASE.format(**constants(index), size=size))
    return files
