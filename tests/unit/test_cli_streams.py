"""What is said where the system refuses what every command needs."""

from __future__ import annotations

import os
import resource
import subprocess
import sys

import pytest
from click.testing import CliRunner

from shaderlab.cli import USAGE, cli

LAB = [sys.executable, "-m", "shaderlab", "--help"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="devices of Linux")
def test_output_that_finds_no_room_is_a_failure() -> None:
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(LAB, stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert done.stderr == "shaderlab: can't write to standard output: No space left on device\n"


def test_a_terminal_without_a_character_gets_another() -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(LAB, capture_output=True, env=environment)
    assert done.returncode == 0 and done.stdout.isascii()


def test_a_reader_may_go() -> None:
    ours, theirs = os.pipe()
    os.close(ours)
    done = subprocess.run(LAB, stdout=theirs, stderr=subprocess.PIPE)
    os.close(theirs)
    assert done.returncode == 1 and b"Traceback" not in done.stderr


@pytest.mark.parametrize(("limit", "least", "option"), [("NOFILE", 32, "-n"), ("AS", 10**8, "-v")])
def test_a_limit_that_is_too_low_is_said_before_anything_is_done(
    monkeypatch: pytest.MonkeyPatch, limit: str, least: int, option: str
) -> None:
    number = getattr(resource, f"RLIMIT_{limit}")
    monkeypatch.setattr(
        resource, "getrlimit", lambda n: (least - 1 if n == number else resource.RLIM_INFINITY, 0)
    )
    done = CliRunner().invoke(cli, ["list"])
    assert done.exit_code == USAGE
    assert f"allows {least - 1:,} " in done.stderr and f"`ulimit {option}`" in done.stderr
