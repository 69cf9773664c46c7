"""Names that would move the cursor, or turn the writing round, reach no terminal."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

NAME = "a\x1b[31m\u202eb"
CASE = """from shaderlab import Case, exact, fullscreen
case = Case(title="t", passes=fullscreen("a.frag", domain={}), expect=[exact("c", 0.5)])
"""
SHADER = "#version 330 core\nout float c;\nvoid main() { c = 0.5; }\n"
CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f\u202a-\u202e\u2066-\u2069]")


@pytest.mark.parametrize(
    "words",
    [
        ("list", f"{NAME}.py"),
        ("run", "--no-pictures", "--size", "4", f"{NAME}.py"),
        ("mutate", "--no-state", "--limit", "1", f"{NAME}.py"),
        ("explain", f"{NAME}.py"),
        ("compile", f"{NAME}.vert"),
        ("audit", f"{NAME}.frag"),
        ("prove", f"{NAME}.frag"),
        ("diff", f"{NAME}.frag", "a.frag"),
        ("run", f"no{NAME}"),
        ("report", f"no{NAME}"),
    ],
    ids=lambda words: words[0],
)
def test_no_command_prints_what_hides_in_a_name(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SHADERLAB_JOBS", "0")
    Path("a.frag").write_text(SHADER)
    Path(f"{NAME}.frag").write_text(SHADER)
    Path(f"{NAME}.vert").write_text(f"#error {NAME}\n")
    Path(f"{NAME}.py").write_text(CASE)
    result = CliRunner().invoke(cli, words)
    assert result.output
    assert not CONTROL.search(result.output)
