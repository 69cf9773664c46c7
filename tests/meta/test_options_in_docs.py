"""The options that the documentation gives to a command are options that it has."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest

from shaderlab.cli import COMMANDS, cli

CALL = re.compile(r"\bshaderlab ([a-z]+)\b([^\n`#]*)")
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")


def find_unknown(text: str) -> set[tuple[str, str]]:
    """Each command with an option of a text that it does not have."""
    found = set()
    for name, rest in CALL.findall(text):
        if name in COMMANDS:
            command = cli.get_command(click.Context(cli), name)
            assert command is not None
            known = {word for one in command.params for word in (*one.opts, *one.secondary_opts)}
            found |= {(name, word) for word in OPTION.findall(rest) if word not in known}
    return found - {(name, "--help") for name in COMMANDS}


def test_every_option_in_the_docs_is_one(repository: Path) -> None:
    pages = [*repository.glob("*.md"), *repository.glob("*/*.md"), *repository.glob("docs/**/*.md")]
    wrong = {page.name: unknown for page in pages if (unknown := find_unknown(page.read_text()))}
    assert not wrong


@pytest.mark.parametrize("text", ["`shaderlab report --against x`", "$ shaderlab run a --nothing"])
def test_an_option_that_is_gone_is_found(text: str) -> None:
    assert find_unknown(text)
