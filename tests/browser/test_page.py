"""The page as its readers use it: finding, following, reading, on any screen, without scripts."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from shaderlab.model.records import Place
from shaderlab.report.html import write
from tests.browser.conftest import DESKTOP
from tests.browser.samples import WORST, Sample

PHONE = {"width": 375, "height": 720}
WIDE = {"width": 1440, "height": 900}
Visit = Callable[..., Any]


def shown_cards(page: Any) -> list[str]:
    cards = page.locator("li[data-case]:visible .title")
    return [text.strip() for text in cards.all_text_contents()]


def test_a_card_leads_to_its_case(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.page)
    page.locator("a.card", has_text="Blending").click()
    assert page.locator("h1#case-blend").is_visible()
    assert page.url == lamp.case("blend").as_uri()
    page.wait_for_load_state()  # its script stands at the end
    page.keyboard.press("/")
    page.locator("#find:focus").wait_for()
    assert page.url == lamp.page.as_uri() + "#find"


def test_a_failure_leads_to_its_worst_pixel(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.page)
    page.locator(".failures a", has_text="FragColor").click()
    check = page.locator("#case-lamp-bad-fragcolor")
    check.locator("[data-part=where]").wait_for()
    assert (
        f"({WORST[0]}, {WORST[1]}), the worst" in check.locator("[data-part=where]").text_content()
    )
    assert check.locator("[data-part=zoom]").text_content() != "1×"


def test_a_variant_unfolds_and_its_pictures_become_readable(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.case("lamp"))
    variant = page.locator("details#case-lamp-good")
    assert not variant.locator(".check").first.is_visible()
    variant.locator("> summary").click()
    assert not variant.locator(".triple").is_visible()
    variant.locator(".check summary").click()
    variant.locator("canvas").first.wait_for()
    assert "inside its band" in variant.locator("[data-part=where]").text_content()


def test_passing_checks_are_one_line_each_and_the_first_failing_one_leads(
    visit: Visit, lamp: Sample
) -> None:
    page = visit(lamp.case("blend"))
    passed = page.locator("#case-blend-default-fragcolor")
    assert not passed.locator(".measures").is_visible()
    line = passed.locator("summary")
    assert line.bounding_box()["height"] < 40
    words = [text.strip() for text in line.locator("*").all_text_contents() if text.strip()]
    assert words == ["passed", "FragColor", "formula", "30 %"]
    stays_folded_on_paper(page, passed)
    page = visit(lamp.case("lamp"))
    assert page.locator("#case-lamp-bad-fragcolor .measures").is_visible()
    # It stands before the lesson, and nothing else is open.
    first = page.locator(".failure .check")
    assert first.get_attribute("id") == "case-lamp-bad-fragcolor"
    assert first.bounding_box()["y"] < min(500, page.locator(".lesson").bounding_box()["y"])
    assert page.locator(".check details[open]").count() == 1


def stays_folded_on_paper(page: Any, check: Any) -> None:
    """What is folded stays so, and what is unfolded is printed."""
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert not check.locator(".measures").is_visible()
    assert not page.locator("nav.way").is_visible() and page.locator(".lesson").is_visible()
    check.locator("summary").evaluate("e => e.parentElement.open = true")
    assert check.locator(".measures").is_visible()


def test_the_filter_finds_words_and_switches_statuses(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.page)
    assert shown_cards(page) == ["A lamp", "Blending"]
    page.keyboard.press("/")
    page.keyboard.type("blend 6.3")
    wait_until(page, lambda: page.locator("#found").text_content() == "1 of 2 shown")
    assert shown_cards(page) == ["Blending"]
    page.keyboard.press("Escape")
    finds_what_cases_say(page)
    page.locator("#find").fill("")
    page.locator("button[data-status=pass]").click()
    assert shown_cards(page) == ["A lamp"]


def test_the_filter_of_the_single_file_finds_words(visit: Visit, lamp: Sample) -> None:
    finds_what_cases_say(visit(lamp.single))


def finds_what_cases_say(page: Any) -> None:
    for words, found in {
        "become": ["Blending"],  # its lesson
        "uniform float a": ["A lamp", "Blending"],  # a shader that both use
        "fragcolor formula": ["A lamp", "Blending"],  # a check
        "nowhere to be found": [],
    }.items():
        page.locator("#find").fill(words)
        count = "" if len(found) == 2 else f"{len(found)} of 2 shown"
        wait_until(page, lambda: page.locator("#found").text_content() == count)  # noqa: B023
        assert shown_cards(page) == found


def test_chinese_titles_can_be_switched_off_and_stay_off(
    visit: Visit, lamp: Sample, tmp_path: Path
) -> None:
    titles = {"lamp": "灯", "blend": "混合"}
    records = [replace(r, place=Place(title_zh=titles[r.id])) for r in lamp.run.records]
    page = visit(write(replace(lamp.run, records=tuple(records)), tmp_path))
    chinese = page.locator("a.card .zh")
    assert chinese.all_text_contents() == ["灯", "混合"] and chinese.first.is_visible()
    switch = page.locator("#zh")
    switch.click()
    assert not chinese.first.is_visible()
    page.reload()
    assert not chinese.first.is_visible() and switch.get_attribute("aria-pressed") == "false"
    switch.click()
    assert chinese.first.is_visible()


def test_chapters_and_neighbours_are_one_click_away(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.single, "#blend")  # an id alone, as somebody writes it elsewhere
    assert_at_the_top(page, "#case-blend")
    way = page.locator("nav.way")
    assert way.bounding_box()["y"] == 0
    assert way.locator("li a").first.text_content() == "Lighting"
    page.locator("article", has=page.locator("#case-blend")).locator("a[rel=prev]").click()
    assert_at_the_top(page, "#case-lamp")
    page.locator("article", has=page.locator("#case-lamp")).locator("a[rel=next]").click()
    assert_at_the_top(page, "#case-blend")
    way.locator("a[href$=chapter-5]").click()
    assert_at_the_top(page, "#chapter-5")


def test_a_cases_page_knows_its_chapter_and_its_neighbours(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.case("lamp"))
    assert page.locator(".way [aria-current]").inner_text() == "Lighting"
    page.locator("a[rel=next]").first.click()
    assert page.url == lamp.case("blend").as_uri()
    page.locator(".way a[href$=chapter-5]").click()
    assert page.url == lamp.page.as_uri() + "#chapter-5"


def test_links_into_the_whole_report_lead_to_the_cases_page(visit: Visit, lamp: Sample) -> None:
    visit(lamp.page, "#blend").wait_for_url("**/cases/blend.html#blend")


def test_a_link_to_nothing_stays_on_the_front_page(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.page, "#case-of-another-run")
    page.wait_for_timeout(100)
    assert page.url == lamp.page.as_uri() + "#case-of-another-run"


def test_a_link_to_a_folded_check_opens_it(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.page, "#case-lamp-good-fragcolor")
    page.wait_for_url("**/cases/lamp.html#case-lamp-good-fragcolor")
    assert page.locator("#case-lamp-good-fragcolor .measures").is_visible()
    assert_at_the_top(page, "#case-lamp-good-fragcolor")


def assert_at_the_top(page: Any, selector: str) -> None:
    wait_until(page, lambda: 40 <= page.locator(selector).bounding_box()["y"] < 140)


def wait_until(page: Any, holds: Callable[[], bool], seconds: float = 20.0) -> None:
    """Ask again and again: the page's policy forbids the scripts by which a browser would wait."""
    until = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < until
        page.wait_for_timeout(20)


def test_a_curves_points_are_read_by_pointer_and_keys(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.case("lamp"))
    svg = page.locator("figure.chart svg").first
    svg.scroll_into_view_if_needed()
    box = svg.bounding_box()
    svg.hover(position={"x": box["width"] * 0.44, "y": box["height"] * 0.3})
    said = page.locator(".chart-point").first
    assert said.text_content() == (
        "distance 1 · measured 0.5 · reference 0.5 · band from 0.4 · to 0.6"
    )
    svg.focus()
    page.keyboard.press("ArrowRight")
    assert said.text_content().startswith("distance 2 outside · measured 0.9")


def test_hostile_strings_do_nothing(visit: Visit, hostile_page: Path) -> None:
    (case,) = (hostile_page.parent / "cases").iterdir()
    for path in (hostile_page, case):
        page = visit(path)
        page.wait_for_timeout(200)
        assert page.locator("img[src=x], iframe, object").count() == 0
        assert page.locator("script").count() == 2  # its own, and the shared one
    assert "onerror=alert(1)" in page.locator("main").text_content()


def test_without_scripts_text_and_pictures_are_there(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.page, java_script_enabled=False)
    assert not page.locator(".controls").is_visible()
    page.locator("a.card", has_text="A lamp").click()
    assert page.locator("h1").is_visible() and page.locator(".lesson").first.is_visible()
    assert page.locator("#case-lamp-bad-fragcolor .triple img").count() == 3
    assert page.locator("#case-lamp-bad-fragcolor .triple img").first.is_visible()


def test_nothing_sticks_out_on_any_screen(visit: Visit, lamp: Sample) -> None:
    page = visit(lamp.page, "#case-lamp-bad-fragcolor", viewport=PHONE)
    page.locator("#case-lamp-bad-fragcolor canvas").first.wait_for()
    wide = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
    cut = "e => e.scrollWidth - e.clientWidth"
    for screen in (PHONE, DESKTOP, WIDE):
        page.set_viewport_size(screen)
        wait_until(page, lambda: page.evaluate("innerWidth") == screen["width"])  # noqa: B023
        assert page.evaluate(wide) <= 0
        assert page.locator("#case-lamp-bad-fragcolor .reading .scroll").evaluate(cut) <= 0
        places = [c.bounding_box() for c in page.locator("#case-lamp-bad-fragcolor canvas").all()]
        assert screen is PHONE or len({place["y"] for place in places}) == 1
