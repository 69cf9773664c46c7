"""A case of one's own: one shader, one formula, one value, and no file but its shader."""

from __future__ import annotations

from pathlib import Path

import pytest

SHADER = """\
#version 330 core
in vec3 Normal;
uniform vec3 lightDir;
uniform vec3 lightColor;
out vec4 FragColor;

void main()
{
    float diffuse = max(dot(normalize(Normal), normalize(lightDir)), 0.0);
    FragColor = vec4(diffuse * lightColor, 1.0);
}
"""
CASE = '''\
"""Lambert's law: a matte surface is as bright as the cosine between its normal and the light."""

from shaderlab import Case, Ramp, formula, fullscreen, value
from shaderlab.glslmath import dot, max, normalize, vec4


def lambert(Normal, lightDir, lightColor):
    diffuse = max(dot(normalize(Normal), normalize(lightDir)), 0.0)
    return vec4(diffuse * lightColor, 1.0)


case = Case(
    title="Lambert's law",
    passes=fullscreen(
        "lambert.frag",
        domain={"Normal": Ramp((-1.0, -1.0, 0.5), dx=(2.0, 0.0, 0.0), dy=(0.0, 2.0, 0.0))},
        uniforms={"lightDir": (3.0, 0.0, 4.0), "lightColor": (1.0, 0.5, 0.31)},
    ),
    expect=[
        formula("FragColor", lambert),
        value("FragColor", at={"Normal": (0, 0, 1)}, equals=(0.8, 0.4, 0.248, 1.0), digits=6),
    ],
)
'''


@pytest.fixture
def example(tmp_path: Path) -> Path:
    """The folder that has the case, lambert.py, and its shader, lambert.frag."""
    (tmp_path / "lambert.frag").write_text(SHADER, encoding="utf-8")
    (tmp_path / "lambert.py").write_text(CASE, encoding="utf-8")
    return tmp_path
