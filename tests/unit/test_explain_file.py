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
