"""The README's own example works as printed, with `shaderlab run` and with pytest."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.fixture
def example(repository: Path, tmp_path: Path) -> Path:
    """The README's shader and case, saved where somebody might."""
    text = (repository / "README.md").read_text(encoding="utf-8")
    blocks = dict(re.findall(r"```(glsl|python)\n(.*?)```", text, flags=re.DOTALL))
    (tmp_path / "lambert.frag").write_text(blocks["glsl"])
    (tmp_path / "lambert.py").write_text(blocks["python"])
    return tmp_path


def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", *words], cwd=folder, capture_output=True, text=True, timeout=120
    )


def test_the_example_passes(example: Path) -> None:
    done = run(example, "shaderlab", "run", "./lambert.py", "--report", "out")
    assert done.returncode == 0, done.stdout + done.stderr
    assert (example / "out" / "index.html").is_file()


def test_the_example_is_collected_by_pytest(example: Path) -> None:
    done = run(example, "pytest", ".")
    assert "1 passed" in done.stdout, done.stdout


def test_without_the_normalize_it_fails_with_a_pixel(example: Path) -> None:
    shader = example / "lambert.frag"
    shader.write_text(shader.read_text().replace("normalize(Normal)", "Normal"))
    done = run(example, "shaderlab", "run", "./lambert.py", "--report", "out")
    assert done.returncode == 1
    for word in ("worst pixel", "band", "Normal", "lambert.py:7", "lambert.frag:10"):
        assert word in done.stdout, done.stdout


def test_every_file_the_readme_points_to_exists(repository: Path) -> None:
    for page in (repository / "README.md", repository / "CONTRIBUTING.md", *(repository / "docs").rglob("*.md")):
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
            if "://" not in target:
                assert (page.parent / target).exists(), f"{page.name} points to {target}"
