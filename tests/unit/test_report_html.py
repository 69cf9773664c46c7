"""What the report page says, and that it counts honestly."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from shaderlab.errors import Diagnostic, Verdict
from shaderlab.model import pictures
from shaderlab.model.records import ErratumNote, Place, ProgramRecord, Record, SourceText
from shaderlab.report.pictures import in_base64
from tests.unit.test_report_samples import (
    Page,
    curve,
    outcome,
    record,
    run,
    worst,
    write,
)


def test_the_front_counts_cases_by_their_worst_variant(tmp_path: Path) -> None:
    words = Page(
        write(
            run(
                record("a", "one"),
                record(
                    "a", "two", status="fail", expectations=(outcome(status="fail", outside=3),)
                ),
                record("b"),
                record("c", status="crash", message="gone", expectations=()),
                record("d", status="unsupported", expectations=()),
            ),
            tmp_path,
        )
    ).words()
    assert "2 of 4 cases did not pass" in words
    for tally in ("1 passed", "1 failed", "1 crashed", "1 unsupported", "in 5 variants"):
        assert tally in words
    assert "Values judged 3\u202f000 3 outside their band" in words


@pytest.mark.parametrize(
    ("records", "headline"),
    [
        ((), "Nothing was run"),
        ((record(expectations=()),), "Nothing was checked"),
        ((record("a"), record("b")), "All 2 cases passed"),
        ((record("a"), record("b", status="unsupported")), "1 of 2 cases passed, the others"),
        ((record("a", status="unsupported"),), "unsupported on this driver"),
        ((record("a", status="timeout"),), "The case did not pass"),
    ],
)
def test_the_headline_never_promises_more_than_was_seen(
    tmp_path: Path, records: tuple[Record, ...], headline: str
) -> None:
    page = Page(write(run(*records), tmp_path))
    heading = page.source[page.source.index("<h1") : page.source.index("</h1>")]
    assert headline in " ".join(heading.split())
    assert ("is-pass" in heading) == headline.startswith(("All 2", "1 of 2 cases passed"))


def test_an_interrupted_run_says_so_in_its_title_and_heading(tmp_path: Path) -> None:
    words = "Interrupted: 2 cases passed, 3 variants not run"
    page = Page(write(run(record("a"), record("b"), missing=3), tmp_path))
    heading = page.source[page.source.index("<h1") : page.source.index("</h1>")]
    assert words in " ".join(heading.split()) and "is-pass" not in heading
    assert f"<title>{words}" in " ".join(page.source.split())


def test_what_no_check_reads_and_what_was_replaced_is_on_the_page(tmp_path: Path) -> None:
    changed = run(record(unread=("main.x",)), replaced={"a.frag": "mine.frag"})
    words = Page(write(changed, tmp_path)).words()
    assert "No check reads main.x , so the case passes whatever is drawn there." in words
    front = words.index("Find a title") if "Find a title" in words else len(words)
    assert words.index("mine.frag was judged in place of a.frag") < front


def test_a_failure_shows_its_worst_value_and_where_it_comes_from(tmp_path: Path) -> None:
    shader = SourceText(file="a.frag", line=1, language="glsl", text="#version 330 core\nvoid\n")
    formula = SourceText(file="f.py", line=40, language="python", text="def f(x):\n    return x")
    failed = outcome(
        status="fail", outside=7, vacuous=0.00002, worst=worst(0.75), sources=(formula, shader)
    )
    page = Page(write(run(record(status="fail", expectations=(failed,))), tmp_path))
    words = page.words()
    for seen in ("pixel (3, 5)", "0.75", "0.4999", "0.5001", "1.5, NaN", "7 outside"):
        assert seen in words, seen
    assert "<0.1 % vacuous" in words and "12 ULP" in words
    ids = set(page.attributes("id"))
    for place in ("a.frag:1", "f.py:40"):
        link = re.search(rf'href="#([^"]+)"><code>{re.escape(place)}', page.source)
        assert link and link.group(1) in ids


def test_a_check_that_passes_with_a_message_shows_it(tmp_path: Path) -> None:
    known = outcome(message="a known departure of NVIDIA's driver")
    assert known.message in Page(write(run(record(expectations=(known,))), tmp_path)).words()


def test_messages_stand_under_the_lines_they_mean(tmp_path: Path) -> None:
    source = SourceText(file="a.frag", line=1, language="glsl", text="\n\nfloat x = y;\n")
    said = Diagnostic(file="a.frag", line=3, severity="error", message="'y' : undeclared")
    program = ProgramRecord(
        files=("a.frag",),
        sources=(source,),
        verdicts=(Verdict(target="vulkan1.3", ok=False, diagnostics=(said,)),),
    )
    html = write(run(record(programs=(program,))), tmp_path).read_text()
    rows = re.findall(r'class="row" id="[^"]+"><a[^>]*>(\d+)</a>', html)
    assert rows == ["1", "2", "3"]
    assert html.index('-L3"') < html.index('class="said is-error"')
    assert "refused" in html and "1 compile target, 1 refused" in html


def test_variants_of_a_case_share_one_section_and_one_source(tmp_path: Path) -> None:
    source = SourceText(file="a.frag", line=1, language="glsl", text="void main() {}\n")
    program = ProgramRecord(files=("a.frag",), sources=(source,), verdicts=())
    page = Page(write(run(*(record("a", v, programs=(program,)) for v in "xyz")), tmp_path))
    assert sum(tag == "article" for tag, _ in page.tags) == 1
    assert page.source.count('class="listing"') == 1
    assert all(f"<b>{name}</b>" in page.source for name in "xyz")


def test_a_quoted_line_is_shown_in_its_file_only(tmp_path: Path) -> None:
    whole = SourceText(file="a.frag", line=1, language="glsl", text="void main()\n{\n    x();\n}\n")
    line = SourceText(file="a.frag", line=3, language="glsl", text="x();")
    other = SourceText(file="a.frag", line=2, language="glsl", text="x();")
    program = ProgramRecord(files=("a.frag",), sources=(whole,), verdicts=())
    check = outcome(sources=(line, other))
    html = write(run(record(programs=(program,), expectations=(check,))), tmp_path).read_text()
    assert html.count('class="listing"') == 2  # the file, and what is not in it at that line
    assert re.search(r'href="#[^"]+-L3"><code>a.frag:3', html)


def test_a_curve_that_all_variants_share_is_drawn_once(tmp_path: Path) -> None:
    same, own = curve(measured=(1.0,) * 4), curve(title="another", measured=(2.0,) * 4)
    records = record("a", "x", curves=(same,)), record("a", "y", curves=(same, own))
    page = Page(write(run(*records), tmp_path))
    charts = [a for tag, a in page.tags if tag == "figure" and a.get("class") == "chart"]
    assert len(charts) == 2
    assert "<b>another</b> y" in page.source and "<b>Light over distance</b></fig" in page.source


def test_chapters_come_in_order_with_your_own_last(tmp_path: Path) -> None:
    sections = {"own": "", "ten": "10", "five": "5.10", "early": "5.2.1", "odd": "99.1"}
    titles = {"5": "Lighting", "10": "Buffers"}
    records = (
        record(i, section=s, chapter=titles.get(s.split(".")[0], "")) for i, s in sections.items()
    )
    html = write(run(*records), tmp_path).read_text()
    order = re.findall(r'<article class="case"[^>]*aria-labelledby="case-([a-z]+)"', html)
    assert order == ["early", "five", "ten", "own", "odd"]
    words = Page(tmp_path / "report.html").words()
    assert "5 Lighting" in words and "10 Buffers" in words and "Your own" in words


def test_errata_are_listed_once_and_linked(tmp_path: Path) -> None:
    note = ErratumNote(section="6.1.1", says="it is off", truth="it compares 0", proof="row 3")
    page = Page(
        write(run(record("a", "x", errata=(note,)), record("a", "y", errata=(note,))), tmp_path)
    )
    assert "1 place, each" in page.words()
    front = page.source[page.source.index('id="errata"') : page.source.index('class="chapter"')]
    assert front.count("it compares 0") == 1 and 'href="#case-a"' in front


def test_a_course_is_a_path_with_reasons_in_two_languages(tmp_path: Path) -> None:
    note = ErratumNote(section="5.1", says="it is off", truth="it is on", proof="F(7)")
    first = {"stage": 1, "stage_title": "Lamps", "stage_title_zh": "灯", "text": "a book"}
    fog = Place(**first, order=2, title_zh="雾", assumes=("lamp",), because="light is scattered")
    sky = Place(order=3, stage=2, stage_title="Skies", stage_because="it is above", title_zh="天空")
    page = Page(
        write(
            run(
                record("sky", place=sky, section="1"),
                record("fog", place=fog, section="2"),
                record("lamp", place=Place(**first, order=1), section="3", errata=(note,)),
            ),
            tmp_path,
        )
    )
    words = page.words()
    assert re.findall(r'<article class="case"[^>]*by="case-([a-z]+)"', page.source) == [
        "lamp", "fog", "sky",
    ]  # fmt: skip
    assert "Lamps 灯" in words and "Skies next, because it is above" in words
    assert "Next: Attenuation , because light is scattered." in words
    assert "Assumes Attenuation ." in words and "Errata in a book" in words
    assert "天空" in page.source[page.source.index('id="search"') :]


def test_formulas_become_mathml_and_bad_ones_stay_readable(tmp_path: Path) -> None:
    html = write(run(record("a"), record("b", formula=r"\frac{1}{")), tmp_path).read_text()
    assert "<mfrac>" in html and "xmlns" not in html
    assert "\\frac{1}{" in html or html.count("<mfrac>") == 2


def test_a_formulas_line_may_end_at_a_wide_space_of_its_own(tmp_path: Path) -> None:
    parts = r"F = \frac{1}{d}, \qquad x = \sqrt{a \quad b} \quad y"
    page = Page(write(run(record("a", formula=parts)), tmp_path))
    assert [tag for tag, _ in page.tags].count("math") == 3
    assert [attrs["width"] for tag, attrs in page.tags if tag == "mspace"] == ["1em"]


def test_lessons_keep_paragraphs_lists_and_asterisks(tmp_path: Path) -> None:
    lesson = "First.\n\n- a\n- b `c<d`\n\nIt is D*G*F / (4*nl*nv)."
    html = write(run(record(lesson=lesson)), tmp_path).read_text()
    assert "<p>First.</p>" in html and "<li>a</li>" in html and "<code>c&lt;d</code>" in html
    assert "D*G*F / (4*nl*nv)" in html


def test_pictures_have_words_sizes_and_their_captions(tmp_path: Path) -> None:
    pictures.save_png(tmp_path / "p.png", np.zeros((3, 8, 3), np.uint8))
    shown = outcome(images={"distance": "p.png"}, captions={"distance": "half widths"})
    pictures.save_png(tmp_path / "s.png", np.ones((3, 4, 3), np.uint8))
    own = {"picture": "p.png", "small": "s.png"}
    page = Page(write(run(record(images=own, expectations=(shown,))), tmp_path))
    images = [attrs for tag, attrs in page.tags if tag == "img"]
    assert all("alt" in a and a["width"] and a["height"] for a in images)
    # The case's own picture is on the front page as well, made smaller, and only there.
    large, small = (f"data:image/png;base64,{in_base64(tmp_path / f)}" for f in own.values())
    assert [a["src"] for a in images if a["alt"] == ""] == [small]
    assert [a["src"] for a in images if a["alt"] == "Attenuation: picture"] == [large]
    assert "half widths" in page.words() and "not drawn" in page.words()


def test_an_operator_at_a_lines_start_makes_no_list(tmp_path: Path) -> None:
    html = write(run(record(lesson="Kc + Kl·d\n+ Kq·d²\n* F")), tmp_path).read_text()
    lesson = html[html.index('<div class="lesson">') : html.index("<math")]
    assert "<li>" not in lesson and "+\u00a0Kq·d²" in lesson


def test_many_failures_are_all_listed(tmp_path: Path) -> None:
    bad = [record("a", str(n), status="fail", expectations=()) for n in range(40)]
    html = write(run(*bad), tmp_path).read_text()
    front = html[html.index('id="failures"') : html.index('id="overview"')]
    assert front.count("<li>") == 40 and "and 15 more variants" in front
