"""What `run` prints: the table, failures, and progress on a terminal and elsewhere."""

from __future__ import annotations

import dataclasses
import io
import re

import pytest
from rich.console import Console

from shaderlab.cli.showing import MOST_CASES, Show, make_case_table
from shaderlab.model.records import Record, Run


def run_of(*records: Record) -> Run:
    driver = {"renderer": "paint [old]", "vendor": "", "version": "", "glsl": ""}
    return Run(driver=driver, versions={}, started="", seconds=1.0, records=records)


def shown(capsys: pytest.CaptureFixture[str], *records: Record) -> list[str]:
    Show().outcomes(run_of(*records))
    return [line.rstrip() for line in capsys.readouterr().out.splitlines()]


def table(lines: list[str]) -> list[str]:
    return lines[: lines.index("")]


def row(lines: list[str], name: str) -> list[str]:
    (found,) = (line.split() for line in table(lines) if f" {name} " in line)
    return found


def test_variants_that_pass_share_a_row_and_others_stand_alone(
    capsys: pytest.CaptureFixture[str], passing: Record, failing: Record
) -> None:
    more = [dataclasses.replace(passing, variant=name) for name in ("1", "2")]
    lines = shown(capsys, *more, failing)
    assert row(lines, "lamp") == ["✓", "lamp", "5.1", "2/3", "2/2", "0.50", "3/3"]
    assert row(lines, "lamp[50]")[:5] == ["✗", "lamp[50]", "5.1", "0/1", ">"]


def test_of_very_many_cases_those_are_listed_that_did_not_pass(
    capsys: pytest.CaptureFixture[str], passing: Record, failing: Record
) -> None:
    many = [dataclasses.replace(passing, id=f"lamp-{n}") for n in range(MOST_CASES)]
    assert len(table(shown(capsys, *many))) == 1 + MOST_CASES
    lines = shown(capsys, *many, failing)
    assert [line.split()[:2] for line in table(lines)[1:-1]] == [["✗", "lamp[50]"]]
    assert table(lines)[-1] == f"not listed: {MOST_CASES} that passed; the report has all"
    all_of_them = shown(capsys, *many, dataclasses.replace(passing, id="one-more"))
    assert all_of_them[0] == f"not listed: {MOST_CASES + 1} that passed; the report has all"


def test_outputs_that_no_check_reads_are_named_once_a_case(
    capsys: pytest.CaptureFixture[str], passing: Record
) -> None:
    records = [dataclasses.replace(passing, variant=v, unread=("main.a", "b.c")) for v in "12"]
    lines = shown(capsys, *records)
    assert lines.count("lamp: no check reads main.a, b.c") == 1
    assert not [line for line in shown(capsys, passing) if "no check reads" in line]


def test_a_check_that_a_driver_is_known_to_fail_is_told(
    capsys: pytest.CaptureFixture[str], passing: Record
) -> None:
    first, *others = passing.expectations
    known = dataclasses.replace(first, name="no x", message="a known departure of NVIDIA's driver")
    lines = shown(capsys, dataclasses.replace(passing, expectations=(known, *others)))
    assert "lamp, no x: a known departure of NVIDIA's driver" in lines
    assert not [line for line in shown(capsys, passing) if "lamp," in line]


def test_a_replaced_shader_and_an_interrupted_run_are_told(
    capsys: pytest.CaptureFixture[str], passing: Record
) -> None:
    run = dataclasses.replace(run_of(passing), replaced={"ch05/a.frag": "mine.frag"}, missing=3)
    Show().outcomes(run)
    out = capsys.readouterr().out
    assert "mine.frag was judged in place of ch05/a.frag" in out
    assert "1 case: 1 passed, 3 not run in" in out


def test_targets_that_refuse_are_named(capsys: pytest.CaptureFixture[str], refused: Record) -> None:
    assert row(shown(capsys, refused), "lamp")[-3:] == ["not", "glsl,", "vulkan"]


def test_the_share_of_informative_values_is_told_where_it_is_not_all(
    capsys: pytest.CaptureFixture[str], passing: Record
) -> None:
    outcome = dataclasses.replace(passing.expectations[0], informative=0.995)
    some = dataclasses.replace(passing, expectations=(outcome,))
    assert row(shown(capsys, some), "lamp")[-2:] == ["99.5", "%"]
    whole = dataclasses.replace(outcome, informative=1.0)
    lines = shown(capsys, dataclasses.replace(passing, expectations=(whole,)))
    assert not any("informative" in line for line in lines)


@pytest.mark.parametrize(
    ("widths", "share"),
    [(0.0, "0 %"), (0.004, "< 1 %"), (0.375, "38 %"), (1.0, "100 %"), (2.0, "200 %")],
)
def test_how_much_of_the_band_is_used(
    capsys: pytest.CaptureFixture[str], passing: Record, failing: Record, widths: float, share: str
) -> None:
    worst = failing.expectations[0].worst
    assert worst is not None
    outcome = dataclasses.replace(
        passing.expectations[0], worst=dataclasses.replace(worst, widths=widths)
    )
    record = dataclasses.replace(passing, expectations=(outcome,))
    assert f" {share} " in " ".join(row(shown(capsys, record), "lamp"))


def test_eighty_columns_are_enough(
    capsys: pytest.CaptureFixture[str], passing: Record, failing: Record
) -> None:
    assert all(len(line) <= 80 for line in table(shown(capsys, passing, failing)))


@pytest.mark.parametrize("section", ["[b]", ":sun:", "a\\"])
def test_what_cells_hold_is_no_markup(
    capsys: pytest.CaptureFixture[str], passing: Record, section: str
) -> None:
    assert section in row(shown(capsys, dataclasses.replace(passing, section=section)), "lamp")


def test_cells_cannot_steer_the_terminal(
    capsys: pytest.CaptureFixture[str], passing: Record
) -> None:
    lines = shown(capsys, dataclasses.replace(passing, section="\x1b[2J"))
    assert not any("\x1b" in line for line in lines)


def test_elsewhere_only_failures_are_told_while_it_runs(
    capsys: pytest.CaptureFixture[str], passing: Record, failing: Record
) -> None:
    with Show().progress(2) as progress:
        for record in (passing, failing):
            progress.starts(record.id, record.variant)
            progress.ends(record)
    assert capsys.readouterr().out == "fail: lamp[50]\n"


def test_a_long_run_says_that_it_is_alive(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, passing: Record
) -> None:
    monkeypatch.setattr("shaderlab.cli.showing.HEARTBEAT", 0.0)
    with Show().progress(2) as progress:
        progress.starts("lamp", "default")
        progress.ends(passing)
        progress.starts("sun", "9")
    said = capsys.readouterr().out
    assert "0 of 2 done; running lamp\n" in said
    assert re.search(r"^1 of 2 done, about [0-9.]+ ms left; running sun\[9\]$", said, re.MULTILINE)


def test_on_a_terminal_there_is_a_live_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, passing: Record
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    with Show().progress(1) as progress:
        progress.starts("lamp", "50")
        progress.ends(passing)
    assert "lamp[50]" in capsys.readouterr().out


@pytest.mark.parametrize("width", [80, 200])
@pytest.mark.parametrize("name", ["lamp", "a-much-longer-name-" * 12])
def test_a_table_fits_its_terminal_and_cuts_no_number(
    passing: Record, failing: Record, width: int, name: str
) -> None:
    records = [dataclasses.replace(r, id=name) for r in (passing, failing)]
    console = Console(width=width, soft_wrap=True, file=io.StringIO())
    console.print(make_case_table(records))
    heading, *lines = console.file.getvalue().splitlines()  # type: ignore[attr-defined]
    assert len(lines) == 2 and all(len(line) <= width for line in (heading, *lines))
    assert [line[0] for line in lines] == ["✓", "✗"]
    assert all(name[:4] in line for line in lines)
    assert "checks" in heading and "1/1" in lines[0] and "0/1" in lines[1]
    assert "3/3" in lines[0] and "0.25" in lines[0] and "> 9999 %" in lines[1]
