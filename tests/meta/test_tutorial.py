"""The tutorial and the pages on comparing and auditing shaders work as printed, in an empty
folder.

The tutorial's installation is what test_wheel.py and test_extras.py try.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.meta.examples import Command, examples, execute, missing


@pytest.mark.parametrize(("page", "least"), [("tutorial", 8), ("diff", 4), ("audit", 1)])
def test_each_command_prints_what_the_page_shows(
    repository: Path,
    pytester: pytest.Pytester,
    page: str,
    least: int,
) -> None:
    folder, commands = pytester.path, 0
    for example in examples(repository / "docs" / "guide" / f"{page}.md"):
        if not isinstance(example, Command):
            (folder / example.name).write_text(example.text, encoding="utf-8")
            continue
        commands += 1
        done = execute(example.line, folder, pytester)
        printed = done.stdout + done.stderr
        assert done.returncode == example.status, printed
        lines = missing(example.shown, printed)
        assert not lines, f"{example.line} prints no {lines[0]!r}, but\n{printed}"
    assert commands >= least


def test_a_line_that_is_not_printed_is_noticed() -> None:
    printed = "a  b\nreport: reports/20260102-130405/index.html\nmeasured 0.123456789\n"
    assert not missing(("a b", "report: reports/20260101-120000/index.html"), printed)
    assert not missing(("measured 0.123460000",), printed)
    assert missing(("measured 0.123", "a b"), printed) == ["measured 0.123", "a b"]
    assert missing(("measured 0.123456789", "a b"), printed) == ["a b"]
