"""The examples of a page of the docs: the files that it has one save, the commands that it shows.

A fenced block with a title is a file: ```glsl title="fog.frag". One of the language `console` has
commands after "$ ", each followed by lines that it prints, in order; the page may leave lines out.
"[exit 1]" is the exit status where it is not 0.
"""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

_BLOCK = re.compile(r"^```(\w+)(?: title=\"([^\"]+)\")?\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_STATUS = re.compile(r"\[exit (\d+)\]")
# A row of the table of `shaderlab mutate`, and the line below it.
_MUTANTS = re.compile(r"^\S+( +\d+){3} +\S+ % |^mistakes in \w+ noticed: ")
_SECONDS = 600  # a machine may be busy; no command takes 30 s on a free one


@dataclass(frozen=True)
class File:
    """A file to save."""

    name: str
    text: str


@dataclass(frozen=True)
class Command:
    """A command line, the lines that it prints as the page shows them, and its exit status."""

    line: str
    shown: tuple[str, ...]
    status: int


def examples(page: Path) -> Iterator[File | Command]:
    """The files and commands of a page, in its order."""
    for language, name, text in _BLOCK.findall(page.read_text(encoding="utf-8")):
        if name:
            yield File(name, text)
        elif language == "console":
            for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
                line, *shown = part.splitlines()
                found = [m for m in map(_STATUS.fullmatch, shown) if m]
                output = (s for s in shown if s.strip() and not _STATUS.fullmatch(s))
                yield Command(line, tuple(output), int(found[0][1]) if found else 0)


def execute(
    line: str, folder: Path, pytester: pytest.Pytester | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command line in a folder, with this environment's `pytest` and `shaderlab`; a
    `shaderlab` that is the whole line runs in this process, without workers, as starting takes
    longer than most, and so does a `pytest` where there is a `pytester`."""
    words = shlex.split(line)
    with contextlib.chdir(folder), pytest.MonkeyPatch.context() as patch:
        patch.setenv("SHADERLAB_JOBS", "0")
        if words[0] == "pytest" and pytester is not None:
            ended = pytester.runpytest_inprocess(*words[1:])
            said = ended.stdout.str(), ended.stderr.str()
            return subprocess.CompletedProcess(words, int(ended.ret), *said)
        if words[0] == "shaderlab" and not {">", "|", "&&"} & set(words):
            done = CliRunner().invoke(cli, words[1:])
            return subprocess.CompletedProcess(words, done.exit_code, done.stdout, done.stderr)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        ["sh", "-c", line],
        cwd=folder,
        # Hypothesis's plugin takes longer to import than a session of the docs does.
        env={**os.environ, "PATH": path, "PYTEST_ADDOPTS": "-p no:hypothesispytest"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=_SECONDS,
    )


def missing(shown: tuple[str, ...], printed: str) -> list[str]:
    """The lines of a page that are not printed, or not in this order.

    Equal are lines that differ in spaces, times, the run's folder, the driver's version, or beyond
    the fourth digit of a long number: those depend on the machine. So are counts of mutants, but
    for none and all of them: they depend on the kinds of mistakes that there are.
    """
    lines = iter([_plain(line) for line in printed.splitlines()])
    return [line for line in shown if not any(_plain(line) == other for other in lines)]


def _plain(line: str) -> str:
    line = re.sub(r"\d{8}-\d{6}", "TIME", line)
    line = re.sub(r"llvmpipe \(.*?\)", "llvmpipe", line)
    line = re.sub(r"-?\d+\.\d{5,}", lambda number: f"{float(number[0]):.4g}", line)
    line = re.sub(r"\b\d+\.\d s\b", "SECONDS", line)
    if line.startswith(("✓", "✗")) or re.search(r"\d+\.\d$", line):
        line = re.sub(r"\d+\.\d+(?=\s+\d/\d$|$)", "SECONDS", line.rstrip())
    if _MUTANTS.search(line):
        line = re.sub(r"\b(?!100 %)[1-9]\d*(\.\d+)?\b", "N", line)
    return " ".join(line.split())
