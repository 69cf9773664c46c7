"""The table of cases looks, to the byte, as Rich's own table of the same rows."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from shaderlab.cli import rows
from shaderlab.cli.rows import CaseTable
from shaderlab.records import Outcome, Record, Worst

NAMES = st.text("ab-é長 []", min_size=1, max_size=12) | st.sampled_from(
    ["lamp", ":sun:", "a\\", "two\nlines", "\x1b[2J", "[red]", "a\tb"]
)


@st.composite
def records(draw: st.DrawFn) -> Record:
    widths = draw(st.sampled_from([0.0, 0.004, 0.37, 1.0, 250.0, float("nan")]))
    worst = Worst(
        pixel=None, component=0, measured=(), reference=(), low=(), high=(), ulp=0.0, widths=widths
    )
    outcome = Outcome(name="o", kind="formula", status="pass", worst=worst)
    verdicts = st.sampled_from(["ok", "refused"])
    return Record(
        id=draw(NAMES),
        variant=draw(st.sampled_from(["default", "50", "b"])),
        title="",
        section=draw(st.sampled_from(["", "5.1", "2.3.4, 2.3.5"])),
        lesson="",
        formula="",
        file="",
        status=draw(st.sampled_from(["pass", "pass", "fail", "crash", "unsupported"])),
        seconds=draw(st.sampled_from([0.0, 1.25, 1234.5])),
        compile=draw(st.dictionaries(st.sampled_from(["glsl", "opengl", "vulkan"]), verdicts)),
        expectations=draw(st.sampled_from([(), (outcome,), (outcome,) * 12])),
    )


def printed(table: object, width: int, colours: bool) -> str:
    system = "truecolor" if colours else None
    text = io.StringIO()
    console = Console(
        file=text, width=width, color_system=system, force_terminal=colours, highlight=False,
        soft_wrap=True, legacy_windows=False,
    )  # fmt: skip
    console.print(table)
    return text.getvalue()


@given(st.lists(records(), max_size=5), st.sampled_from([20, 60, 80, 120]), st.booleans())
def test_it_is_printed_as_rich_prints_it(some: list[Record], width: int, colours: bool) -> None:
    by_rich = rows._table(list(rows._rows(some)))
    assert printed(CaseTable(some), width, colours) == printed(by_rich, width, colours)


@pytest.mark.parametrize(
    ("name", "width", "laid_out"),
    [("lamp", 80, 0), ("lamp[50]", 80, 0), ("lamp", 30, 2), (":sun:", 80, 2), ("a\\", 80, 2)],
)
def test_rich_lays_out_only_what_needs_it(
    monkeypatch: pytest.MonkeyPatch, passing: Record, name: str, width: int, laid_out: int
) -> None:
    seen: list[int] = []
    before = rows._table

    def table(some: object, *widths: object) -> object:
        seen.append(len(list(some)))  # type: ignore[call-overload]
        return before(some, *widths)  # type: ignore[arg-type]

    monkeypatch.setattr(rows, "_table", table)
    text = printed(CaseTable([passing, replace(passing, id=name, file="b.py")]), width, False)
    assert seen == [laid_out] and text.count("✓") == 2


def test_brackets_in_a_section_are_no_markup(passing: Record) -> None:
    for width in (40, 80):
        text = printed(CaseTable([replace(passing, section="[b]")]), width, False)
        assert "[b]" in text
