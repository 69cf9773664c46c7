"""Shaders audited on what a case gives them: `audit CASE`."""

from __future__ import annotations

from pathlib import Path

from click.testing import CliRunner

from shaderlab.cli.audit import command

SHADER = """#version 330 core
in vec2 place;
uniform float shift;
out vec4 color;
void main()
{
    float wave = sqrt(place.x + shift);
    color = vec4(vec3(fract(wave * 0.5)), 1.0);
}
"""
CASE = """from shaderlab import Case, Ramp, exact, fullscreen
case = Case(
    title="t",
    id="t",
    passes=fullscreen(
        "wave.frag",
        domain={"place": Ramp((0.25, 0.0), (0.5, 0.0), (0.0, 1.0))},
        uniforms={"shift": SHIFT},
    ),
    expect=[exact("color", 0.0)],
)
"""


def write(folder: Path, shift: float) -> Path:
    (folder / "wave.frag").write_text(SHADER)
    case = folder / "t.py"
    case.write_text(CASE.replace("SHIFT", repr(shift)))
    return case


def audited(case: Path) -> tuple[int, str]:
    result = CliRunner().invoke(command, [str(case), "-j", "0"], standalone_mode=False)
    assert result.exception is None, result.exception
    return result.return_value, result.output


def test_a_case_s_own_inputs_decide(tmp_path: Path) -> None:
    status, output = audited(write(tmp_path, 0.0))
    assert (status, output.count("\n")) == (0, 1)
    status, output = audited(write(tmp_path, -0.5))
    assert status == 1
    assert "wave.frag:7: sqrt of a negative number" in output
    assert "shift: as in the case" in output


def test_the_sizes_of_a_case_s_textures_are_known(tmp_path: Path) -> None:
    shader = SHADER.replace("float shift", "sampler2D wall").replace("sqrt(place.x + shift)", "%s")
    case = write(tmp_path, 0.0)
    case.write_text(
        case.read_text()
        .replace('{"shift": 0.0}', '{}, textures={"wall": Texture(image=np.ones((4, 4, 4)))}')
        .replace("import Case", "import Texture, Case")
        .replace("from", "import numpy as np\nfrom", 1)
    )
    for last, status in ((3, 0), (4, 1)):
        fetched = f"texelFetch(wall, ivec2(int(place.x) + {last}), 0).r"
        (tmp_path / "wave.frag").write_text(shader % fetched)
        found, output = audited(case)
        assert found == status, output
    assert "wave.frag:7: texel out of range: index 4 into 4 elements" in output
