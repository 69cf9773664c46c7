"""The README's own example works as printed, with `shaderlab run` and with pytest."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.meta.examples import File, examples, execute


@pytest.fixture
def example(repository: Path, tmp_path: Path) -> Path:
    """The folder that has the README's shader and case."""
    for each in examples(repository / "README.md"):
        if isinstance(each, File):
            (tmp_path / each.name).write_text(each.text, encoding="utf-8")
    return tmp_path


def test_the_example_passes(example: Path) -> None:
    done = execute("shaderlab run ./lambert.py --report out", example)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (example / "out" / "index.html").is_file()


def test_the_example_is_collected_by_pytest(example: Path) -> None:
    done = execute("pytest .", example)
    assert "2 passed" in done.stdout, done.stdout


def test_without_the_normalize_it_fails_with_a_pixel(example: Path) -> None:
    shader = example / "lambert.frag"
    shader.write_text(shader.read_text().replace("normalize(Normal)", "Normal"))
    done = execute("shaderlab run ./lambert.py --report out", example)
    assert done.returncode == 1
    for word in ("worst pixel", "band", "Normal", "lambert.py:7", "lambert.frag:10"):
        assert word in done.stdout, done.stdout


def test_every_file_that_the_docs_point_to_exists(repository: Path) -> None:
    for page in pages(repository):
        for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            if "://" not in target:
                assert (page.parent / target).exists(), f"{page.name} points to {target}"


def test_every_heading_that_the_docs_point_to_exists(repository: Path) -> None:
    for page in pages(repository):
        for target, anchor in re.findall(r"\]\(([^)#:]*)#([^)]+)\)", page.read_text("utf-8")):
            other = page.parent / target if target else page
            headings = re.findall(r"^#+ (.*)$", other.read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor in map(slug, headings), f"{page.name} points to {target}#{anchor}"


def test_every_module_that_the_docs_name_exists(repository: Path) -> None:
    """Pages name them from the repository's root; the architecture from two packages, too."""
    roots = [repository, repository / "shaderlab", repository / "shaderlab" / "drivers"]
    internals = repository / "docs" / "internals"
    for page in [repository / "CONTRIBUTING.md", *internals.glob("*.md")]:
        for name in re.findall(r"`([a-z_]+(?:/[a-z_]+)*\.py)`", page.read_text(encoding="utf-8")):
            assert any((root / name).is_file() for root in roots), f"{page.name} names {name}"


def test_every_page_is_in_the_index(repository: Path) -> None:
    index = (repository / "docs" / "README.md").read_text(encoding="utf-8")
    for page in (repository / "docs").glob("*/*.md"):
        assert f"({page.parent.name}/{page.name})" in index


def pages(repository: Path) -> list[Path]:
    return [*repository.glob("*.md"), *(repository / "docs").rglob("*.md")]


def slug(heading: str) -> str:
    """A heading's anchor, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
