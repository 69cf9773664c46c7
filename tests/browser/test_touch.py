"""The pixel inspector under fingers, on a phone's screen."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tests.browser.samples import HEIGHT, WIDTH, Sample

CHECK = "#case-lamp-bad-fragcolor"
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}


@pytest.fixture
def phone(visit: Callable[..., Any], lamp: Sample) -> Any:
    """The page at its failing check, the pictures at the top of the screen."""
    page = visit(lamp.case("lamp"), CHECK, **PHONE)
    page.locator(f"{CHECK} canvas").first.wait_for()
    page.evaluate("dispatchEvent(new Event('wheel'))")  # the page scrolls there no longer
    page.locator(f"{CHECK} .triple").evaluate(
        "e => scrollTo(0, scrollY + e.getBoundingClientRect().top - 60)"
    )
    page.locator(f"{CHECK} [data-do=all]").evaluate("e => e.click()")
    return page


def shown(page: Any) -> Any:
    return page.locator(f"{CHECK} canvas:visible")


def test_a_pixels_numbers_are_under_the_finger(phone: Any) -> None:
    assert shown(phone).count() == 1
    box = shown(phone).bounding_box()
    x, y = 7, 5
    phone.touchscreen.tap(
        box["x"] + (x + 0.5) / WIDTH * box["width"],
        box["y"] + (HEIGHT - y - 0.5) / HEIGHT * box["height"],
    )
    assert phone.locator(f"{CHECK} [data-part=where]").text_content().startswith("Pixel (7, 5)")
    numbers = phone.locator(f"{CHECK} [data-part=table]").bounding_box()
    assert box["y"] >= 0 and numbers["y"] + numbers["height"] <= 844
    assert numbers["x"] + numbers["width"] <= 390


def test_the_pictures_take_turns(phone: Any) -> None:
    for name in ("reference", "distance", "measured"):
        phone.locator(f"{CHECK} [data-part=tabs] button", has_text=name).tap()
        assert shown(phone).count() == 1
        assert phone.locator(f"{CHECK} figure[data-picture={name}] canvas").is_visible()
        assert shown(phone).evaluate("c => c.width") > 300


def test_a_pinch_zooms_and_pins_nothing(phone: Any) -> None:
    where = phone.locator(f"{CHECK} [data-part=where]")
    before = where.text_content()
    box = shown(phone).bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    fingers = phone.context.new_cdp_session(phone)

    def touch(kind: str, *apart: float) -> None:
        points = [{"x": middle[0] + a, "y": middle[1], "id": n} for n, a in enumerate(apart)]
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    touch("touchStart", -30, 30)
    for apart in (40, 60, 90):
        touch("touchMove", -apart, apart)
    touch("touchEnd")
    zoom = phone.locator(f"{CHECK} [data-part=zoom]").text_content()
    assert float(zoom.rstrip("×")) == pytest.approx(3.0, abs=0.1)
    assert where.text_content() == before
    assert phone.evaluate("visualViewport.scale") == 1
