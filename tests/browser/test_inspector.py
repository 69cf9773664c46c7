"""The pixel inspector shows the very numbers of the record's arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from tests.browser.conftest import visiting
from tests.browser.samples import BROKEN, HEIGHT, WIDTH, WORST, Sample

CHECK = "#case-lamp-bad-fragcolor"
COLUMNS = ("measured", "exact", "low", "high")


@pytest.fixture(scope="module")
def page(browser: Any, lamp: Sample) -> Iterator[Any]:
    """A page that tests share which only move the pointer."""
    with visiting(browser) as visit:
        yield inspected(visit, lamp)


@pytest.fixture
def fresh(visit: Callable[..., Any], lamp: Sample) -> Any:
    """A page as it is opened."""
    return inspected(visit, lamp)


def inspected(visit: Callable[..., Any], lamp: Sample) -> Any:
    """The page at its failing check, the inspector running."""
    found = visit(lamp.case("lamp"))
    found.locator(CHECK).scroll_into_view_if_needed()
    found.locator(f"{CHECK} canvas").first.wait_for()
    return found


def canvas(page: Any, number: int = 0) -> Any:
    return page.locator(f"{CHECK} canvas").nth(number)


def hover(page: Any, x: int, y: int, number: int = 0) -> None:
    box = canvas(page, number).bounding_box()
    at = {"x": (x + 0.5) / WIDTH * box["width"], "y": (HEIGHT - y - 0.5) / HEIGHT * box["height"]}
    canvas(page, number).hover(position=at)


def where(page: Any) -> str:
    return str(page.locator(f"{CHECK} [data-part=where]").text_content())


def cells(page: Any) -> list[list[str]]:
    rows = page.locator(f"{CHECK} [data-part=numbers] tr").all()
    return [row.locator("th, td").all_text_contents() for row in rows]


def texel(page: Any, x: float, y: float, number: int = 0) -> tuple[int, ...]:
    """The colour at a place of a canvas, in fractions of its size from the upper left."""
    script = """(c, [x, y]) => {
        const copy = new OffscreenCanvas(1, 1).getContext("2d", {willReadFrequently: true});
        copy.drawImage(c, -Math.floor(x * c.width), -Math.floor(y * c.height));
        return [...copy.getImageData(0, 0, 1, 1).data];
    }"""
    return tuple(canvas(page, number).evaluate(script, [x, y]))


def figure(value: float) -> str:
    return "NaN" if np.isnan(value) else f"{value:.9g}".replace("-", "−")


@pytest.mark.parametrize("picture", [0, 2])
def test_hovering_reads_the_records_numbers(page: Any, lamp: Sample, picture: int) -> None:
    for x, y in ((1, 1), (7, 5), (18, 10), WORST, BROKEN):
        hover(page, x, y, picture)
        assert where(page).startswith(f"Pixel ({x}, {y})")
        arrays = [np.float32(lamp.arrays[k][y, x]).astype(float) for k in COLUMNS]
        expected = [[figure(array[c]) for array in arrays] for c in range(4)]
        assert [row[1:5] for row in cells(page)] == expected
        outside = [bool(o) for o in lamp.arrays["outside"][y, x]]
        assert [row[6] == "outside" for row in cells(page)] == outside


def test_the_ulp_distance_is_that_of_float32(page: Any, lamp: Sample) -> None:
    hover(page, 7, 5)
    for c, row in enumerate(cells(page)):
        measured, exact = (np.float32(lamp.arrays[k][5, 7, c]) for k in ("measured", "exact"))
        ulp = abs(float(measured) - float(exact)) / float(np.spacing(exact))
        assert row[5] == (f"{ulp:.0f}" if ulp else "< 1")


def test_what_was_not_drawn_says_so(page: Any) -> None:
    hover(page, 0, 6)
    assert "not drawn" in where(page) and cells(page) == []


def test_a_failure_opens_at_its_worst_pixel_which_pointer_and_arrow_keys_move(fresh: Any) -> None:
    assert where(fresh) == f"Pixel ({WORST[0]}, {WORST[1]}), the worst: outside its band"
    hover(fresh, 3, 3)
    assert where(fresh).startswith("Pixel (3, 3)")
    fresh.mouse.move(2, 2)
    assert where(fresh).startswith(f"Pixel ({WORST[0]}, {WORST[1]})")
    fresh.locator(f"{CHECK} .triple").focus()
    for key, expected in (
        ("ArrowRight", (14, 4)), ("ArrowUp", (14, 5)), ("Shift+ArrowLeft", (6, 5)),
        ("Shift+ArrowDown", (6, 0)), ("ArrowDown", (6, 0)), ("w", WORST),
    ):  # fmt: skip
        fresh.keyboard.press(key)
        assert where(fresh).startswith(f"Pixel ({expected[0]}, {expected[1]})"), key
    assert "the worst" in fresh.locator(f"{CHECK} [data-part=spoken]").text_content()


def test_a_tap_on_a_phone_pins_the_pixel(visit: Callable[..., Any], lamp: Sample) -> None:
    phone = visit(
        lamp.case("lamp"),
        CHECK,
        viewport={"width": 390, "height": 844},
        has_touch=True,
        is_mobile=True,
    )
    phone.locator(f"{CHECK} [data-do=all]").tap()
    canvas(phone).scroll_into_view_if_needed()
    box = canvas(phone).bounding_box()
    assert box["width"] > 300
    x, y = 7, 5
    phone.touchscreen.tap(
        box["x"] + (x + 0.5) / WIDTH * box["width"],
        box["y"] + (HEIGHT - y - 0.5) / HEIGHT * box["height"],
    )
    assert where(phone).startswith(f"Pixel ({x}, {y})")


def test_zoom_keeps_texels_crisp_and_channels_and_exposure_change_them(
    fresh: Any, lamp: Sample
) -> None:
    fresh.locator(f"{CHECK} [data-do=worst]").click()
    assert fresh.locator(f"{CHECK} [data-part=zoom]").text_content() != "1×"
    x, y = WORST
    rgb = tuple(int(np.rint(v * 255)) for v in lamp.arrays["exact"][y, x, :3])
    # Just inside the frame around the pixel in the middle: one colour, not a mixture.
    zoom = float(fresh.locator(f"{CHECK} [data-part=zoom]").text_content().rstrip("×"))
    quarter = 0.25 * zoom / WIDTH
    for dx in (-quarter, 0, quarter):
        assert texel(fresh, 0.5 + dx, 0.5, 1)[:3] == rgb
    fresh.locator(f"{CHECK} [data-do=all]").click()
    assert fresh.locator(f"{CHECK} [data-part=zoom]").text_content() == "1×"
    change_channels_and_exposure(fresh)


def change_channels_and_exposure(fresh: Any) -> None:
    """They change what is drawn, and nothing else."""
    at = (7.5 / WIDTH, (HEIGHT - 5.5) / HEIGHT)
    plain = texel(fresh, *at)
    slider = fresh.locator(f"{CHECK} [data-part=exposure]")
    slider.fill("3")
    brighter = texel(fresh, *at)
    assert all(b >= a for a, b in zip(plain, brighter, strict=True)) and brighter != plain
    slider.fill("0")
    assert texel(fresh, *at) == plain
    fresh.locator(f"{CHECK} [data-part=channels] button", has_text="g").click()
    assert texel(fresh, *at) != plain


def test_a_nan_is_marked(page: Any) -> None:
    at = ((BROKEN[0] + 0.5) / WIDTH, (HEIGHT - BROKEN[1] - 0.5) / HEIGHT)
    assert texel(page, *at)[:3] == (255, 0, 255)
