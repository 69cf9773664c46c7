"""The Markdown summary of a run, and its passes and programs on the page."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.errors import Verdict
from shaderlab.model import pictures
from shaderlab.model.records import (
    Attachment,
    Declared,
    Disagreement,
    DriverResult,
    PassRecord,
    ProgramRecord,
    Row,
    Worst,
)
from shaderlab.model.store import save
from shaderlab.report.formats.markdown import render as summary
from tests.unit.test_report_samples import (
    HOSTILE,
    Page,
    hostile,
    outcome,
    record,
    run,
    worst,
    write,
)


def test_the_summary_leads_with_the_verdict_and_names_the_worst_value() -> None:
    bad = outcome(status="fail", message="3 of 9 values lie outside", outside=3, worst=worst(0.75))
    text = summary(run(record("a"), record("b", "x", status="fail", expectations=(bad,))))
    assert text.startswith("## ❌ 1 of 2 cases did not pass\n")
    assert "| 5 Lighting | 1 | 1 |" in text
    assert "**b\\[x\\]** failed" in text
    assert "pixel (3, 5): measured 0.75, band 0.4999 … 0.5001 (12 ULP" in text


def test_an_interrupted_run_is_no_success() -> None:
    text = summary(run(record("a"), record("b"), missing=3))
    assert text.startswith(
        "## ⚠️ 2 of 2 cases passed, 3 variants not run: the run was interrupted\n"
    )


def test_the_summary_says_what_no_check_reads_and_what_was_replaced() -> None:
    text = summary(run(record("a", unread=("main.x",)), replaced={"a.frag": "mine.frag"}))
    assert "a: no check reads main.x" in text and "mine.frag was judged in place of a.frag" in text
    assert "no check reads" not in summary(run(record("a")))


def test_the_summary_of_a_good_run_is_short() -> None:
    text = summary(run(record("a"), record("b")))
    assert text.startswith("## ✅ 2 of 2 cases passed\n") and "did not pass" not in text
    assert "Nothing was run" in summary(run())


def test_hostile_strings_stay_text_in_markdown_too() -> None:
    text = summary(hostile())
    assert not re.search(r"<[a-z/!]|(?<!\\)`|(?<!\\)\]\(|\x1b|\u202e", text)
    assert "&lt;/script&gt;" in text and HOSTILE not in text


def test_the_command_writes_the_page_and_the_summary(tmp_path: Path) -> None:
    save(run(record("a", status="fail")), tmp_path)
    done = CliRunner().invoke(
        cli, ["report", str(tmp_path), "--markdown", str(tmp_path / "summary.md")]
    )
    assert done.exit_code == 0, done.output
    assert (tmp_path / "index.html").exists()
    assert (tmp_path / "summary.md").read_text().startswith("## ❌ 1 of 1 case")
    missing = CliRunner().invoke(cli, ["report", "nowhere"])
    assert missing.exit_code == 2 and "no run.json" in missing.output


def test_passes_are_a_chain_and_programs_say_what_they_declare(tmp_path: Path) -> None:
    pictures.save_png(tmp_path / "p.png", np.zeros((4, 4, 3), np.uint8))
    attachment = Attachment(name="depth", format="r32f", image="p.png")
    chain = (
        PassRecord(name="shadow", draws=(("a.vert",),) * 3, reads=(), attachments=(attachment,)),
        PassRecord(name="light", draws=(("b.frag",),), reads=("shadow.depth",), attachments=()),
    )
    declared = (
        Declared(kind="uniform", name="reach", type="float[4]", location=2),
        Declared(kind="output", name="FragColor", type="vec4", location=0, used=False),
    )
    program = ProgramRecord(
        files=("b.frag",),
        sources=(),
        verdicts=(Verdict(target="vulkan", ok=True, spirv_bytes=1234),),
        declared=declared,
    )
    words = Page(write(run(record(passes=chain, programs=(program,))), tmp_path)).words()
    assert words.index("shadow") < words.index("reads shadow.depth")
    assert "a.vert × 3" in words and "r32f" in words
    assert "reach float[4] 2" in words and "FragColor vec4 0 unused" in words
    assert "1\u202f234 bytes" in words


def test_several_drivers_stand_side_by_side(tmp_path: Path) -> None:
    results = [
        DriverResult(driver=d, renderer=f"{d} 1", id=i, variant="default", status=s, ulp=2.5)
        for d, i, s in (
            ("llvmpipe", "a", "pass"), ("softpipe", "a", "fail"),
            ("llvmpipe", "b", "pass"), ("softpipe", "b", "pass"),
        )
    ]  # fmt: skip
    found = Disagreement(
        id="a", variant="default", output="factor", drivers=("llvmpipe", "softpipe"),
        pixels=4096, differing=17, ulp=3.0, verdict="outside", outside=("softpipe",),
    )  # fmt: skip
    same = replace(found, output="other", differing=0, ulp=0.0, verdict="equal", outside=())
    made = run(record("a"), record("b"), drivers=tuple(results), disagreements=(same, found))
    page = Page(write(made, tmp_path))
    words = page.words()
    assert "2 variants on 2 drivers; 1 verdict differs; of 2 outputs compared" in words
    assert "1 outside of a band on one" in words and "other" not in words
    assert "factor llvmpipe, softpipe outside on softpipe 17 4\u202f096 3" in words
    assert "passed on llvmpipe, not all on softpipe" in words
    text = summary(made)
    assert text.startswith("## ❌ 2 of 2 cases passed, not all on softpipe")
    assert "| a | ✓ pass | ✗ fail |" in text and "**a: factor** llvmpipe \\| softpipe" in text
    assert 'href="#case-a-default"' in page.source
    alone = Page(write(run(record("a"), drivers=tuple(results[:1])), tmp_path))
    assert "side by side" not in alone.words()


def test_rows_with_a_heading_begin_with_it(tmp_path: Path) -> None:
    rows = tuple(Row(label=x, expected="≤ 1", measured="0", ok=True) for x in ("256", "512"))
    headed = outcome(name="share in the dark", rows=rows, rows_heading="share in the dark")
    words = Page(write(run(record("a", expectations=(headed,))), tmp_path)).words()
    assert "share in the dark: 256" in words and "share in the dark: 512" in words
    plain = outcome(name="share in the dark", rows=rows)
    words = Page(write(run(record("a", expectations=(plain,))), tmp_path)).words()
    assert "share in the dark: 256" not in words and " 256 " in words


def test_rows_that_no_variant_changes_are_not_labelled_by_it(tmp_path: Path) -> None:
    row = Row(label="F(7)", expected="1", measured="1", ok=True)
    for per_variant in (True, False):
        found = outcome(rows=(row,), rows_per_variant=per_variant)
        records = [record("a", variant, expectations=(found,)) for variant in ("dim", "bright")]
        page = Page(write(run(*records), tmp_path))
        assert ("<td>bright</td>" in page.source) is per_variant


@pytest.mark.parametrize(
    ("widths", "ulp", "reference", "says"),
    [
        (1.0, 0.0, 1.0, "exact closest to the edge"),  # of a clamp's band
        (0.0, 0.0, 1.0, "exact"),  # of a band of one value
        (1.0, 1.0, 1.0, "at most 100 % of the way to the edge, 1 ULP"),
        (0.0, 0.0, 9.0, "at most 0 % of the way to the edge, 0 ULP"),  # a law, no reference
    ],
)
def test_an_exact_value_is_called_so_wherever_its_band_ends(
    tmp_path: Path, widths: float, ulp: float, reference: float, says: str
) -> None:
    value = Worst(
        pixel=None, component=0, measured=(1.0,), reference=(reference,), low=(0.9,),
        high=(1.0,), widths=widths, ulp=ulp,
    )  # fmt: skip
    found = outcome(worst=value, informative=None)
    page = Page(write(run(record("a", expectations=(found,))), tmp_path))
    words = page.words().replace(" ,", ",")
    assert says in words and ("exact" in words) is says.startswith("exact")


def test_a_worst_value_that_rows_show_is_not_shown_again(tmp_path: Path) -> None:
    for shown in (True, False):
        found = outcome(worst=worst(), rows_show_worst=shown)
        words = Page(write(run(record("a", expectations=(found,))), tmp_path)).words()
        assert ("Closest to the edge" in words) is not shown


def test_report_writes_whatever_can_be_written(tmp_path: Path) -> None:
    save(run(record("a")), tmp_path)
    for name in ("index.html", "out.json"):
        (tmp_path / name).mkdir()
    outputs = ["--json", str(tmp_path / "out.json"), "--markdown", str(tmp_path / "out.md")]
    result = CliRunner().invoke(cli, ["report", str(tmp_path), *outputs])
    assert result.exit_code == 1
    assert "index.html: can't write" in result.stderr and "out.json: can't write" in result.stderr
    assert (tmp_path / "out.md").is_file()
