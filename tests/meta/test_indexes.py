"""The pages that are made of the code are up to date."""

from __future__ import annotations

import re
from pathlib import Path
from types import FunctionType

import pytest

import shaderlab.glslmath
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
