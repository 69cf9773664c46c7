"""A full disk and a reader who has gone end no command; what was lost is told at its end."""

from __future__ import annotations

import io
import os
import sys
from pathlib import Path

import pytest

from shaderlab import cli
from shaderlab.cli import final_status, find_lost_output, open_lasting


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="devices of Linux")
def test_a_command_goes_on_when_its_output_finds_no_room(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with open("/dev/full", "w", encoding="utf-8") as full, monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", full)
        patch.setattr(sys, "stderr", io.StringIO())
        patch.setattr(sys, "argv", ["shaderlab", "--help"])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        assert ended.value.code == cli.FAILED
        said = sys.stderr.getvalue()
        assert said == "shaderlab: can't write to standard output: No space left on device\n"
        assert [final_status(status) for status in (0, None, 1, 2)] == [1, 1, 1, 2]


def test_what_can_be_written_is_and_a_reader_may_go(tmp_path: Path) -> None:
    with open(tmp_path / "a", "w", encoding="ascii") as file:
        stream = open_lasting(file)
        print("✓ all → ✗ ☼", file=stream)
        assert find_lost_output(stream) == ""
    assert (tmp_path / "a").read_text() == "+ all -> x ?\n"
    ours, theirs = os.pipe()
    os.close(ours)
    with open(theirs, "w") as pipe:
        stream = open_lasting(pipe)
        stream.write("x" * 99_999)
        assert find_lost_output(stream) == ""
