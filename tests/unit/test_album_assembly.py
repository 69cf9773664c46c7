"""The SPIR-V of a program as text beside its pictures."""

from pathlib import Path

from shaderlab.glsl import Shaders, compile_program
from shaderlab.pipeline.album import Album

FRAGMENT = "#version 330 core\nout vec4 color;\nvoid main() { color = vec4(0.25); }\n"


def modules(text: str) -> dict[str, bytes]:
    source = Shaders([]).from_text(text, "fragment", "a.frag")
    return dict(compile_program([source]).spirv["opengl"])


def test_equal_modules_are_one_file_and_others_are_another(tmp_path: Path) -> None:
    quarter, half = modules(FRAGMENT), modules(FRAGMENT.replace("0.25", "0.5"))
    albums = [Album(tmp_path, "case", variant) for variant in "abc"]
    names = [a.assembly(m) for a, m in zip(albums, (quarter, quarter, half), strict=True)]
    assert names[0] == names[1] != names[2]
    text = (tmp_path / names[0]).read_text()
    assert text.startswith("; fragment\n") and "OpConstant %float 0.25" in text
    assert "OpConstant %float 0.5" in (tmp_path / names[2]).read_text()
    assert sorted(p.suffix for p in (tmp_path / "spirv").iterdir()) == [".spvasm"] * 2


def test_nothing_is_written_without_a_folder_or_modules(tmp_path: Path) -> None:
    assert Album(None, "case", "v").assembly(modules(FRAGMENT)) == ""
    assert Album(tmp_path, "case", "v").assembly({}) == ""
    assert not list(tmp_path.iterdir())
