"""The examples of the page about functions: they pass, each fails for a mistake, and are short."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import hypothesis
import pytest

from tests.meta.examples import File, examples

TESTS = "tests/test_shaders.py"
# The test, the shader, what stands there, the mistake.
MISTAKES = [
    ("test_attenuation", "lighting.glsl", "quadratic * d * d", "quadratic * d"),
    ("test_spotlight", "lighting.glsl", "normalize(-axis)", "normalize(axis)"),
    ("test_srgb", "color.glsl", "1.055 * pow(c", "1.05 * pow(c"),
    ("test_srgb", "color.glsl", "c <= 0.04045", "c <= 0.05"),
    ("test_noise_is_bounded", "noise.glsl", "3.0 - 2.0 * t", "3.0 - t"),
    ("test_noise_is_the_hash_on_the_lattice", "noise.glsl", "fract(p)", "fract(p + 0.1)"),
    ("test_wave", "water.vert", "2.0 * at.x + time", "2.0 * at.x - time"),
    ("test_tonemap", "color.glsl", "light / (1.0 + light)", "light / (1.0 + light.x)"),
]


@pytest.fixture(scope="module")
def files(repository: Path) -> Mapping[str, str]:
    page = repository / "docs" / "guide" / "functions.md"
    return {each.name: each.text for each in examples(page) if isinstance(each, File)}


@pytest.fixture(autouse=True)
def nothing_kept() -> None:
    hypothesis.settings.register_profile("page", database=None)


def project_of(files: Mapping[str, str], folder: Path) -> dict[str, Any]:
    """The page's tests, in a project of their own."""
    (folder / ".git").mkdir()
    for name, text in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    file = folder / TESTS
    names: dict[str, Any] = {"__file__": str(file), "__name__": "test_shaders"}
    before = hypothesis.settings.get_current_profile_name()
    hypothesis.settings.load_profile("page")
    try:
        exec(compile(files[TESTS], file, "exec"), names)
    finally:
        hypothesis.settings.load_profile(before)
    return {name: value for name, value in names.items() if name.startswith("test_")}


def test_all_pass(files: Mapping[str, str], tmp_path: Path) -> None:
    found = project_of(files, tmp_path)
    assert len(found) >= 8
    for test in found.values():
        test()


@pytest.mark.parametrize(("name", "shader", "old", "new"), MISTAKES)
def test_each_notices_a_mistake(
    files: Mapping[str, str], tmp_path: Path, name: str, shader: str, old: str, new: str
) -> None:
    shader = f"shaders/{shader}"
    assert old in files[shader]
    wrong = {**files, shader: files[shader].replace(old, new)}
    with pytest.raises(AssertionError):
        project_of(wrong, tmp_path)[name]()


def test_a_check_takes_three_lines_at_most(files: Mapping[str, str]) -> None:
    tests = [n for n in ast.parse(files[TESTS]).body if isinstance(n, ast.FunctionDef)]
    lines = {n.name: n.body[-1].end_lineno - n.body[0].lineno + 1 for n in tests}  # type: ignore[operator]
    assert {name for name, count in lines.items() if count > 3} == set()
