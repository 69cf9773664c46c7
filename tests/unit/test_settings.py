"""A project's settings: found, checked, obeyed by commands; and the folders that shaders are in."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.engine.catalogue import shaders_of
from shaderlab.engine.settings import MARKS, Settings, load_settings, option_defaults
from shaderlab.errors import ShaderError, UsageError

Write = Callable[[str], Path]
FRAGMENT = "#version 330 core\nout vec4 color;\nvoid main() { color = vec4(glow()); }\n"


@pytest.fixture
def game(tmp_path: Path) -> Path:
    """A repository as games have it: shaders/ and tests/ side by side."""
    for name, text in {
        ".git/HEAD": "",
        "shaders/lib/glow.glsl": "float glow() { return 1.0; }\n",
        "shaders/glow.frag": FRAGMENT.replace("\n", '\n#include "lib/glow.glsl"\n', 1),
        "tests/deep/glow.frag": FRAGMENT.replace(
            "\n", '\n#include "../../shaders/lib/glow.glsl"\n', 1
        ),
        "engine/shaders/sun.frag": FRAGMENT,
    }.items():
        file = tmp_path / "game" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    (tmp_path / "secret.glsl").write_text("float secret;\n")
    return tmp_path / "game"


def says(game: Path, text: str) -> Settings:
    (game / "pyproject.toml").write_text(text)
    folder = game / "tests" / str(len(text))  # another folder each time: settings are read once
    folder.mkdir(exist_ok=True)
    return load_settings(folder)


@pytest.mark.parametrize("folder", ["tests", "tests/deep", "engine/tests"])
@pytest.mark.parametrize(
    "name", ["glow.frag", "shaders/glow.frag", "../shaders/glow.frag", "../../shaders/glow.frag"]
)
def test_a_case_finds_the_shaders_of_its_repository(game: Path, folder: str, name: str) -> None:
    (game / folder).mkdir(parents=True, exist_ok=True)
    if name.count("../") <= folder.count("/") + 1:
        assert "float glow()" in shaders_of(game / folder, {}).load(name).text


def test_without_a_repository_shaders_are_found_beside_the_cases_folder(game: Path) -> None:
    (game / ".git" / "HEAD").unlink()
    (game / ".git").rmdir()
    shaders = shaders_of(game / "tests", {})
    assert "float glow()" in shaders.load("../shaders/glow.frag").text
    with pytest.raises(ShaderError, match="leads out of the shader folders"):
        shaders.load("../engine/shaders/sun.frag")


@pytest.mark.parametrize("mark", MARKS)
def test_a_project_without_version_control_is_found_by_its_own_files(game: Path, mark: str) -> None:
    (game / ".git" / "HEAD").unlink()
    (game / ".git").rmdir()
    (game / mark).touch()
    shaders = shaders_of(game / "tests" / "deep", {})
    assert "float glow()" in shaders.load("glow.frag").text
    with pytest.raises(ShaderError, match="leads out of the shader folders"):
        shaders.load("../../../secret.glsl")


def test_without_any_mark_the_working_folder_is_the_root(
    game: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (game / ".git" / "HEAD").unlink()
    (game / ".git").rmdir()
    monkeypatch.chdir(game)
    shaders = shaders_of(game / "tests" / "deep", {})
    assert "float glow()" in shaders.load("glow.frag").text
    with pytest.raises(ShaderError, match="leads out of the shader folders"):
        shaders.load("../../../secret.glsl")
    monkeypatch.delenv("HOME")  # as in a container whose user is in no list
    monkeypatch.setattr("pwd.getpwuid", {}.__getitem__)
    assert load_settings(game / "shaders").root == game
    monkeypatch.setenv("HOME", str(game / "tests"))
    assert load_settings(game / "engine").root is None, "nobody's home folder is a project"


@pytest.mark.parametrize(
    "name",
    [
        "../../secret.glsl",
        "../../../etc/passwd",
        "../shaders/../../secret.glsl",
        "../../game2/a.glsl",
        "..",
        "../..",
    ],
)
def test_nothing_outside_the_project_is_read(game: Path, name: str) -> None:
    (game.parent / "game2").mkdir()
    (game.parent / "game2" / "a.glsl").write_text("float neighbour;\n")
    shaders = shaders_of(game / "tests", {})
    with pytest.raises(ShaderError, match="leads out") as caught:
        shaders.load(name, "fragment")
    assert "--include" in str(caught.value)
    (game / "tests" / "a.frag").write_text(f'#include "{name}"\n')
    with pytest.raises(ShaderError, match="leads out"):
        shaders.load("a.frag")
    os.symlink(game.parent / "secret.glsl", game / "shaders" / "link.glsl")
    with pytest.raises(ShaderError, match="symbolic link leads out"):
        shaders.load("../shaders/link.glsl", "fragment")


def test_one_file_is_replaced_by_whichever_name_it_is_called(game: Path) -> None:
    for key in ("glow.frag", "shaders/glow.frag", "../shaders/glow.frag"):
        shaders = shaders_of(game / "tests", {key: "// new\n"})
        for name in ("glow.frag", "shaders/glow.frag", "../shaders/glow.frag"):
            assert shaders.load(name).text == "// new\n"
    found = shaders_of(game / "tests", {}).names()
    assert {"glow.frag", "lib/glow.glsl", "deep/glow.frag"} <= set(found)
    assert "shaders/glow.frag" not in found


def test_the_project_says_where_its_shaders_are(game: Path) -> None:
    settings = says(game, '[tool.shaderlab]\nshaders = ["engine/shaders"]\ninclude = ["shaders"]\n')
    assert settings.root == game and settings.shaders == (game / "engine" / "shaders",)
    folders = load_settings(game / "tests").shader_folders(game / "tests")
    assert folders == (game / "tests", game / "engine" / "shaders", game / "shaders")
    shaders = shaders_of(game / "tests", {})
    assert shaders.load("sun.frag").text and shaders.load("../engine/shaders/sun.frag").text
    (game / "other.frag").write_text(FRAGMENT)
    with pytest.raises(ShaderError, match="leads out"):
        shaders.load("../other.frag")


def test_all_settings_become_options(game: Path) -> None:
    settings = says(
        game,
        '[tool.shaderlab]\ntargets = ["glsl"]\ndriver = "softpipe"\ntimeout = 5\nmemory = 0\n'
        "keep = 3\n",
    )
    assert settings.keep == 3
    options = option_defaults(settings)
    assert options["run"] == {"seconds": 5.0, "gigabytes": 0.0, "driver": "softpipe"}
    assert options["compile"] == {"compile_targets": ("glsl",), "gigabytes": 0.0}
    assert not any(option_defaults(Settings()).values())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[tool.shaderlab", "no TOML file"),
        ("#" * (4 << 20) + "\n[tool.shaderlab]", "it has more than 4 MB"),
        ("[tool]\nshaderlab = 3", "is no table"),
        ("[tool.shaderlab]\nshader = []", "no setting 'shader'\n  → did you mean shaders"),
        ("[tool.shaderlab]\nsize = 3", "→ there is: shaders, include, targets, driver, timeout"),
        ('[tool.shaderlab]\nshaders = "shaders"', "write a list of words"),
        ('[tool.shaderlab]\nshaders = ["gone"]', "there is no folder 'gone' here"),
        ('[tool.shaderlab]\ninclude = [".."]', "'..' leads out of the project"),
        ('[tool.shaderlab]\ninclude = ["/"]', "'/' leads out of the project"),
        ('[tool.shaderlab]\ntargets = ["gl"]', "no target 'gl'; did you mean glsl"),
        ("[tool.shaderlab]\ntargets = []", "name one or more of glsl"),
        ('[tool.shaderlab]\ndriver = "nvidia"', "no driver 'nvidia'; there is: llvmpipe"),
        ("[tool.shaderlab]\ntimeout = 0", "a number above 0, not 0"),
        ("[tool.shaderlab]\nmemory = true", "a number above 0, not True"),
        ("[tool.shaderlab]\nkeep = 1.5", "a whole number"),
    ],
)
def test_what_is_wrong_is_named_with_what_there_is(game: Path, text: str, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        says(game, text)
    assert message in str(caught.value) and caught.value.file == str(game / "pyproject.toml")


def test_a_table_of_other_tools_is_no_project(game: Path) -> None:
    assert says(game, '[tool.black]\nx = 1\n[project]\ndependencies = ["shaderlab"]\n') == Settings(
        root=game
    )


def test_commands_obey_the_table(game: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (game / "pyproject.toml").write_text('[tool.shaderlab]\ntargets = ["vulkan-strict"]\n')
    monkeypatch.chdir(game)
    result = CliRunner().invoke(cli, ["compile", "shaders", "-j", "0"])
    assert (
        result.exit_code == 0 and "vulkan-strict" in result.output and "opengl" not in result.output
    )
    result = CliRunner().invoke(cli, ["compile", "tests", "-j", "0", "-t", "glsl"])
    assert result.exit_code == 0 and "vulkan" not in result.output, result.output
