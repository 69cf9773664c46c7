"""The README's own example works as printed; links of the docs lead somewhere."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

from tests.meta.examples import Command, File, examples, execute, missing


@pytest.fixture
def example(repository: Path, tmp_path: Path) -> Path:
    """The folder that has the README's shader and test."""
    for each in examples(repository / "README.md"):
        if isinstance(each, File):
            (tmp_path / each.name).write_text(each.text, encoding="utf-8")
    return tmp_path


def test_the_test_fails_as_printed_and_passes(
    repository: Path, example: Path, pytester: pytest.Pytester
) -> None:
    shader, page = example / "lighting.glsl", (repository / "README.md").read_text("utf-8")
    right = shader.read_text()
    shader.write_text(right.replace("return 1.0 ", "return 1.01 "))
    done = execute("pytest test_lighting.py", example, pytester)
    assert done.returncode == 1
    block = page[page.index("10001 of 10001 values") :].partition("```")[0]
    assert not missing(tuple(f"E {line}" for line in block.splitlines()), done.stdout)
    shader.write_text(right)
    assert "1 passed" in execute("pytest test_lighting.py", example, pytester).stdout


def test_a_proof_prints_what_the_page_shows(repository: Path, example: Path) -> None:
    commands = [e for e in examples(repository / "README.md") if isinstance(e, Command)]
    (proof,) = [command for command in commands if command.line.startswith("shaderlab prove")]
    done = execute(proof.line, example)
    shown = tuple(line for line in proof.shown if line != "…")
    assert done.returncode == 1 and not missing(shown, done.stdout), done.stdout


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


def test_every_import_that_the_docs_show_works(repository: Path) -> None:
    shown = re.compile(r"from (shaderlab[\w.]*) import (?:\(([^)]*)\)|([\w, ]+))")
    for page in pages(repository):
        for module, several, names in shown.findall(page.read_text(encoding="utf-8")):
            for name in filter(None, re.split(r"[\s,]+", several or names)):
                found = hasattr(importlib.import_module(module), name)
                assert found or name == "NAME", f"{page.name}: from {module} import {name}"


def test_every_page_is_in_the_index(repository: Path) -> None:
    index = (repository / "docs" / "README.md").read_text(encoding="utf-8")
    for page in (repository / "docs").glob("*/*.md"):
        assert f"({page.parent.name}/{page.name})" in index


def pages(repository: Path) -> list[Path]:
    return [*repository.glob("*.md"), *(repository / "docs").rglob("*.md")]


def slug(heading: str) -> str:
    """A heading's anchor, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
