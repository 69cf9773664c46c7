"""What is said where standard output can't be written, or lacks characters."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

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
