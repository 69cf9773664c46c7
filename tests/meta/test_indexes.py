"""The pages that are made of the code are up to date."""

from __future__ import annotations

import re
from pathlib import Path
from types import FunctionType

import pytest

import shaderlab.glslmath
import shaderlab.glslmath.sampling
from tests.meta.builtins import CHAPTER_8, SPELT, WHY_NOT
from tests.meta.indexes import pages


@pytest.mark.parametrize("path", pages())
def test_a_page_is_what_the_code_makes_of_it(repository: Path, path: str) -> None:
    found = (repository / path).read_text(encoding="utf-8")
    assert found == pages()[path], "run `python -m tests.meta.indexes`"


def test_every_function_of_glsl_is_on_its_page() -> None:
    text = pages()["docs/guide/glslmath.md"]
    names = [n for n, value in vars(shaderlab.glslmath).items() if isinstance(value, FunctionType)]
    missing = {name for name in names if f"- `{name}(" not in text}
    assert missing == set() and len(names) > 60


def test_every_formula_is_checked_against_something_else() -> None:
    topics = pages()["docs/guide/reference.md"].split("\n## ")[1:]
    assert len(topics) > 20
    for topic in topics:
        names = re.findall(r"^- `(\w+)\(", topic, re.M)
        (checks,) = re.findall(r"^Checked against: (.*)$", topic, re.M)
        without = {name for name in names if "(`" in checks and f"`{name}`" not in checks}
        without |= set(names) if checks == "." else set()
        assert names and not without, "say in tests/independent what these are checked against"
        assert "\nSource" in topic


def test_each_function_of_the_specification_has_a_reference_or_a_reason() -> None:
    names = [name for names in CHAPTER_8.values() for name in names.split()]
    assert len(names) == len(set(names)) == 161
    for name in names:
        python = SPELT.get(name, name)
        there = hasattr(shaderlab.glslmath, python) or hasattr(shaderlab.glslmath.sampling, python)
        assert there != (name in WHY_NOT), name
    assert set(WHY_NOT) <= set(names)
    page = pages()["docs/guide/glslmath.md"]
    assert all(f"`{name}`" in page or f"- `{name}(" in page for name in names)
