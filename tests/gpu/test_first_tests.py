"""`shaderlab new`: a test file that passes, and fails once the shader is wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import hypothesis
import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

SHADER = """
struct Light { vec3 color; float power; };
uniform float exposure;
uniform mat4 bones[4];
float fade(float distance) { return exposure / (1.0 + distance * distance); }
vec3 lit(Light light, vec3 normal, bool on) { return on ? light.color * normal.z : vec3(0.0); }
vec3 lit(Light light, float k) { return light.color * light.power * k; }
vec3 unit(vec3 p) { return normalize(p); }
float steep(float x) { return 1.0 / x; }
vec4 texel(sampler2D map, ivec2 place) { return texelFetch(map, place % 4, 0); }
float bent(vec3 p, int bone) { return (bones[bone % 4] * vec4(p, 1.0)).x; }
float lambda(float x) { return x > 0.5 ? 1.0 : 0.0; }
bool flag(float x, out int n) { n = int(x) + 1; return x > 0.5; }
float sky(samplerCube map, vec3 direction) { return texture(map, direction).x; }
void nothing(float x) { }
float kept(float x) { if (x < 0.6) discard; return x; }
"""


def new(*arguments: str) -> Any:
    return CliRunner().invoke(cli, ["new", *arguments])


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for folder in (".git", "shaders", "tests"):
        (tmp_path / folder).mkdir()
    (tmp_path / "shaders" / "sea.glsl").write_text(SHADER)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def outcomes(file: Path) -> dict[str, bool]:
    """Which tests of a file pass."""
    names: dict[str, Any] = {"__file__": str(file), "__name__": "first"}
    before = hypothesis.settings.get_current_profile_name()
    hypothesis.settings.register_profile("first", database=None)
    hypothesis.settings.load_profile("first")
    found = {}
    try:
        exec(compile(file.read_text(), file, "exec"), names)
        for name, test in names.items():
            if name.startswith("test_"):
                try:
                    test()
                except AssertionError:
                    found[name] = False
                else:
                    found[name] = True
    finally:
        hypothesis.settings.load_profile(before)
    return found


def test_the_tests_pass_until_the_shader_is_wrong(project: Path) -> None:
    result = new("shaders/sea.glsl")
    assert result.exit_code == 0, result.output
    file = project / "tests" / "test_sea.py"
    text = file.read_text()
    assert 'sea = glsl.load("shaders/sea.glsl")' in text
    assert 'sea["lambda"](' in text and 'sea.lit["Light, float"]' in text
    assert "normal=directions(random)" in text and "np.all((y >= 0) & (y <= 1))" in text
    assert "# void nothing(float x)\n# has no test: it returns nothing" in text
    assert "# has no test: it reads samplerCube map" in text
    assert "# has no test: none of the usual laws holds at random arguments" in text
    assert max(len(line) for line in text.splitlines()) < 300
    found = outcomes(file)
    assert len(found) >= 7 and all(found.values()), found
    shader = project / "shaders" / "sea.glsl"
    shader.write_text(
        SHADER.replace("exposure / (1.0", "exposure / (0.5").replace("light.power * k", "k")
    )
    wrong = {name for name, passes in outcomes(file).items() if not passes}
    assert wrong == {"test_fade"}


def test_nothing_is_written_over(project: Path) -> None:
    file = project / "tests" / "test_sea.py"
    file.write_text("mine")
    result = new("shaders/sea.glsl")
    assert result.exit_code == 2 and "this file exists already" in result.output
    assert file.read_text() == "mine"


def test_a_shader_without_functions_gets_no_file(project: Path) -> None:
    (project / "only.frag").write_text("#version 330\nvoid main() { }\n")
    result = new("only.frag", "-o", "first.py")
    assert result.exit_code == 2 and "no function in this file can be tested" in result.output
    assert not (project / "first.py").exists()
