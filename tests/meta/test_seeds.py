"""Nothing draws random numbers without a seed that is written in the code."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

UNSEEDED = {"random", "secrets"}
# Names for files, what `mutate --seed` draws, and a comparison of the generators' states.
ALLOWED = {"files.py", "mutation", "workers/process_state.py"}


def unseeded(tree: ast.AST) -> Iterator[int]:
    """Lines with the global generators of Python or NumPy, or with a generator without a seed."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import) and any(a.name in UNSEEDED for a in node.names):
            yield node.lineno
        if isinstance(node, ast.ImportFrom) and node.module in {*UNSEEDED, "numpy.random"}:
            yield node.lineno
        if isinstance(node, ast.Call):
            found = re.fullmatch(r"(np|numpy)\.random\.(\w+)", ast.unparse(node.func))
            if found is None:
                continue
            seeded = found[2] in ("default_rng", "Generator") and (node.args or node.keywords)
            if not seeded:
                yield node.lineno


def test_every_generator_has_a_seed(repository: Path) -> None:
    wrong = []
    for folder in ("shaderlab", "cases"):
        for file in sorted((repository / folder).rglob("*.py")):
            inside = file.relative_to(repository / folder).as_posix()
            if inside not in ALLOWED and inside.split("/")[0] not in ALLOWED:
                lines = unseeded(ast.parse(file.read_text(encoding="utf-8")))
                wrong += [f"{file}:{line}" for line in lines]
    assert wrong == []


@pytest.mark.parametrize(
    ("text", "bad"),
    [
        ("import random", True),
        ("from numpy.random import rand", True),
        ("x = np.random.rand(3)", True),
        ("x = np.random.default_rng().random(3)", True),
        ("x = np.random.default_rng(3).random(3)", False),
        ("x = generator.random(3)", False),
    ],
)
def test_one_without_a_seed_would_be_noticed(text: str, bad: bool) -> None:
    assert bool(list(unseeded(ast.parse(text)))) is bad
