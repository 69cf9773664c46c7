"""`explain` of a shader file without a case: on inputs that are made up."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli.explain import command
from shaderlab.errors import UsageError

SHADER = """#version 330 core
uniform float far; // range: 100..1000
out vec4 FragColor;
void main()
{
    float sum = far + 0.1;
    float small = sum - far;
    FragColor = vec4(small);
}
"""


@pytest.fixture
def shader(tmp_path: Path) -> Path:
    file = tmp_path / "a.frag"
    file.write_text(SHADER)
    return file


def explained(shader: Path, *options: str) -> tuple[str, dict[str, Any]]:
    target = shader.with_suffix(".json")
    words = [str(shader), "-j", "0", "--json", str(target), *options]
    result = CliRunner().invoke(command, words, standalone_mode=False)
    if result.exception is not None:
        raise result.exception
    return result.output, json.loads(target.read_text())


def test_each_line_is_explained_on_inputs_within_their_ranges(shader: Path) -> None:
    output, data = explained(shader)
    assert [(step["line"], step["name"]) for step in data["steps"]] == [
        (6, "sum"), (7, "small"), (8, "FragColor"),
    ]  # fmt: skip
    assert 100.0 <= data["inputs"]["far"][0] <= 1000.0
    assert output.startswith("with far = ")
    assert "ULP lost at" in output and "a.frag:7: small" in output


def test_ranges_are_given(shader: Path) -> None:
    _, data = explained(shader, "--range", "far=3:4")
    assert 3.0 <= data["inputs"]["far"][0] <= 4.0
    with pytest.raises(UsageError, match="does not read 'near'"):
        explained(shader, "--range", "near=3:4")


def test_members_of_blocks_without_a_name_are_stored_too(tmp_path: Path) -> None:
    file = tmp_path / "a.vert"
    file.write_text(
        "#version 430\nin vec4 at;\nbuffer Sums { float sum; vec2 seen[4]; };\n"
        "void main() {\n    gl_Position = at * 0.3;\n    sum = at.x / 3.0;\n"
        "    seen[gl_VertexID & 3].y = at.y;\n}\n"
    )
    _, data = explained(file)
    names = [(step["line"], step["name"].partition("[")[0]) for step in data["steps"]]
    assert names == [(5, "gl_Position"), (6, "sum"), (7, "seen")]


def test_a_shader_of_integers_has_nothing_to_explain(tmp_path: Path) -> None:
    file = tmp_path / "a.frag"
    file.write_text("#version 330 core\nin vec2 a;\nout uvec2 b;\nvoid main() { b = uvec2(3u); }\n")
    output, data = explained(file)
    assert data["steps"] == [] and "it stores nothing that is rounded" in output
