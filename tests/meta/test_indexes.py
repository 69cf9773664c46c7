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
    missing = {name for name in names if f"| `{name}(" not in text}
    assert missing == set() and len(names) > 60


def test_every_formula_is_held_against_something_else() -> None:
    text = pages()["docs/guide/reference.md"]
    empty = re.findall(r"^\| `(\w+).*\|\s+\|$", text, re.M)
    assert text.count("| held against |") > 20 and empty == [], (
        "say in tests/independent what these are held against"
    )


def test_every_topic_has_functions_and_a_source() -> None:
    topics = pages()["docs/guide/reference.md"].split("\n## ")[1:]
    assert len(topics) > 20
    for topic in topics:
        assert "\n| `" in topic and "\nSource" in topic, topic.partition("\n")[0]


def test_each_function_of_the_specification_has_a_reference_or_a_reason() -> None:
    names = [name for names in CHAPTER_8.values() for name in names.split()]
    assert len(names) == len(set(names)) == 161
    for name in names:
        python = SPELT.get(name, name)
        there = hasattr(shaderlab.glslmath, python) or hasattr(shaderlab.glslmath.sampling, python)
        assert there != (name in WHY_NOT), name
    assert set(WHY_NOT) <= set(names)
    table = pages()["docs/guide/glslmath.md"].partition("## All of GLSL 4.50")[2]
    assert all(f"| `{name}` |" in table for name in names)
