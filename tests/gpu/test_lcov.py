"""`run --lcov`: which lines and branches of shaders ran, for services that show coverage."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

SHADER = """#version 330 core
in float t;
out vec4 colour;
float twice(float x) {
    return 2.0 * x;
}
float unused(float x) {
    return x;
}
void main() {
    if (t < 0.25) {
        discard;
    }
    float v = t > 5.0 ? twice(t)
        : t;
    if (v > 9.0) {
        v = unused(v);
    }
    switch (int(v * 4.0)) {
        case 1: v = 0.5; break;
        case 9: v = 0.7; break;
        default: v = 0.9;
    }
    colour = vec4(v);
}
"""
CASE = """
from shaderlab import Case, across, formula, fullscreen
from shaderlab.glslmath import vec4, where

case = Case(
    title="Branches",
    passes=fullscreen("a.frag", domain={"t": across(0.0, 1.0)}),
    expect=[
        formula(
            "colour",
            lambda t: vec4(where(t < 0.5, 0.5, 0.9)),
            discards=lambda t: t < 0.25,
        )
    ],
)
"""


def test_lines_that_ran_and_branches_that_were_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.frag").write_text(SHADER)
    Path("branches.py").write_text(CASE)
    options = ["-j", "0", "--no-pictures", "--report", "report"]
    result = CliRunner().invoke(cli, ["run", "branches.py", *options, "--lcov", "out.info"])
    assert result.exit_code == 0, result.output
    rows = Path("out.info").read_text().splitlines()
    assert rows[:2] == ["TN:", "SF:a.frag"] and rows[-1] == "end_of_record"
    lines = dict(row[3:].split(",") for row in rows if row.startswith("DA:"))
    number = {line.strip(): str(n) for n, line in enumerate(SHADER.splitlines(), 1)}
    not_run = {"return 2.0 * x;", "return x;", "v = unused(v);", "case 9: v = 0.7; break;"}
    assert {n for n, count in lines.items() if count == "0"} == {number[code] for code in not_run}
    assert number["discard;"] in lines and number["void main() {"] not in lines
    taken: dict[str, list[str]] = {}
    for row in rows:
        if row.startswith("BRDA:"):
            line, _, _, count = row[5:].split(",")
            taken.setdefault(line, []).append(count)
    assert taken[number["if (t < 0.25) {"]] == ["1", "1"]
    assert taken[number["if (v > 9.0) {"]] == ["0", "1"]
    assert sorted(taken[number["switch (int(v * 4.0)) {"]]) == ["0", "1", "1"]
    assert f"LF:{len(lines)}" in rows and f"LH:{len(lines) - len(not_run)}" in rows

    # A run without it has nothing to tell.
    assert CliRunner().invoke(cli, ["run", "branches.py", *options]).exit_code == 0
    result = CliRunner().invoke(cli, ["report", "report", "--lcov", "none.info"])
    assert result.exit_code != 0 and "run with --modules" in result.output
