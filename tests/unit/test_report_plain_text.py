"""How results read as text: the same lines in a shell and in pytest."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import replace
from io import StringIO
from pathlib import Path

from rich.console import Console

from shaderlab.cli.showing import make_case_table
from shaderlab.model.records import DriverResult, Record
from shaderlab.report.formats import junit, markdown
from shaderlab.report.text import (
    format_conditions,
    format_failure,
    format_label,
    format_numbers,
    format_summary,
)
from tests.unit.test_report_samples import Page, outcome, record, run, write


def test_labels() -> None:
    assert format_label("gamma", "default") == "gamma"
    assert format_label("attenuation", "50") == "attenuation[50]"


def test_float32_neighbours_read_differently() -> None:
    assert format_numbers([0.1]) == "0.1"
    assert format_numbers([1.0, 2.5]) == "(1, 2.5)"
    assert format_numbers([0.100000001490116]) != format_numbers([0.100000008940697])
    assert format_numbers([math.nan]) == "nan"


def test_only_what_failed_is_told(failing: Record, passing: Record) -> None:
    both = dataclasses.replace(failing, expectations=failing.expectations + passing.expectations)
    text = "\n".join(format_failure(both))
    assert text.count("(formula)") == 1
    assert text == "\n".join(format_failure(failing))


def test_integers_are_off_by_a_difference(failing: Record) -> None:
    (found,) = failing.expectations
    assert found.worst is not None
    band = dict.fromkeys(("reference", "low", "high"), (3.0, 4.0))
    off = dataclasses.replace(found.worst, measured=(3.0, 3e9), ulp=3e9 - 4, widths=6e9, **band)
    for worst, said in (
        (off, "2999999996 from the reference"),
        (dataclasses.replace(off, ulp=7.0), "from the exact value"),
        (dataclasses.replace(off, low=(3.0, 3.5)), "half band widths"),
    ):
        outcome = dataclasses.replace(found, worst=worst)
        lines = format_failure(dataclasses.replace(failing, expectations=(outcome,)))
        assert sum(said in line for line in lines) == 1


def test_what_an_outcome_says_is_not_announced(failing: Record) -> None:
    record = dataclasses.replace(failing, status="error", message="")
    assert "  error" in format_failure(record) and "  error: " not in format_failure(record)
    assert "  error: so" in format_failure(dataclasses.replace(record, message="so"))


def test_a_shaders_text_cannot_steer_the_terminal(passing: Record) -> None:
    evil = dataclasses.replace(passing, status="error", message="\x1b[2Jgone\x07")
    assert not any(c in line for line in format_failure(evil) for c in "\x1b\x07")


def test_a_long_table_is_cut(failing: Record) -> None:
    from shaderlab.model.records import Row

    rows = tuple(Row(label=f"r{i}", expected="1", measured="2", ok=i % 2 == 0) for i in range(60))
    outcome = dataclasses.replace(failing.expectations[0], rows=rows)
    lines = format_failure(dataclasses.replace(failing, expectations=(outcome,)))
    assert sum("expected 1, measured 2" in line for line in lines) == 12
    assert any("and 18 more" in line for line in lines)


def test_summary_counts_variants_by_outcome(passing: Record, failing: Record) -> None:
    other = dataclasses.replace(passing, id="sun")
    text = format_summary(replace(run(passing, failing, other), seconds=3.14))
    assert text == "2 cases, 3 variants: 2 passed, 1 failed in 3.1 s"


def test_every_report_counts_what_was_not_asked(tmp_path: Path) -> None:
    """Checks of OpenGL's own calls, where another API draws: the case passes without them."""
    plain, without = record("a"), record("b", not_asked=("two calls", "no error"))
    made = run(plain, without)
    said = format_summary(replace(made, seconds=1.0))
    assert said == "2 cases: 2 passed (1 of them without 2 checks of OpenGL's own calls) in 1.0 s"
    console = Console(width=120, record=True, file=StringIO())
    console.print(make_case_table(made.records))
    rows = console.export_text().splitlines()
    assert "2 skipped" in rows[2] and "skipped" not in rows[1]
    words = Page(write(made, tmp_path)).words()
    assert (
        "2 about OpenGL’s own calls skipped on this driver, in 1 case that passed without them"
        in words
    )
    assert "this driver uses another API: two calls, no error." in words
    assert (
        "2 checks of OpenGL's own calls skipped on this driver; 1 case passed"
        in markdown.render(made)
    )
    assert junit.render(made).count("<skipped") == 2
    results = [
        DriverResult(driver=d, renderer=d, id="b", variant="default", status="pass", not_asked=n)
        for d, n in (("llvmpipe", 0), ("lavapipe", 2))
    ]
    sides = markdown.render(replace(made, drivers=tuple(results)))
    assert "| ✓ pass | ✓ pass, 2 skipped |" in sides


def test_what_failed_at_another_size_is_told_to_be_so() -> None:
    """A count of pixels fails at another size whatever the shader does."""
    counted = outcome(status="fail", kind="query", message="32 samples passed, not 497 to 516")
    for size, status, told in ((16, "fail", 1), (64, "fail", 0), (16, "pass", 0), (0, "crash", 0)):
        found = record(size=size, status=status, expectations=(counted,))
        lines = list(format_conditions(run(found)))
        assert len(lines) == told, (size, status)
        assert all("judged at 16 × 16 pixels, not at 64 × 64" in line for line in lines)
