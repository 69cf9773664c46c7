"""axe-core finds nothing, in light and dark, on a desk and on a phone, with everything unfolded."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.browser.samples import Sample

UNFOLD = """() => {
    for (const d of document.querySelectorAll("details")) d.open = true;
}"""


def violations(page: Any, where: str = "html") -> list[str]:
    axe = pytest.importorskip(
        "axe_playwright_python", reason="axe is not installed: pip install axe-playwright-python"
    )
    page.evaluate((Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8"))
    found = page.evaluate(
        "where => axe.run(where, {resultTypes: ['violations'], preload: false})", where
    )
    return [
        f"{v['impact']} {v['id']}: {[n['html'][:120] for n in v['nodes'][:3]]}"
        for v in found["violations"]
    ]


@pytest.mark.parametrize(("scheme", "width"), [("light", 1280), ("dark", 390)])
def test_no_violation(visit: Callable[..., Any], lamp: Sample, scheme: str, width: int) -> None:
    screen = {"width": width, "height": 900}
    page = visit(
        lamp.case("lamp"), "#case-lamp-bad-fragcolor", color_scheme=scheme, viewport=screen
    )
    page.evaluate(UNFOLD)
    page.locator("#case-lamp-bad-fragcolor canvas").first.wait_for()
    # What has no role may have no label; the checker minds only while there is no text in it.
    assert page.locator("pre[aria-label]").count() >= 1
    assert page.locator("pre[aria-label]:not([role])").count() == 0
    assert violations(page) == []


@pytest.mark.parametrize(("scheme", "width"), [("dark", 1280), ("light", 390)])
def test_no_violation_of_the_front_page_but_what_is_put_there(
    visit: Callable[..., Any], lamp: Sample, scheme: str, width: int
) -> None:
    page = visit(lamp.page, color_scheme=scheme, viewport={"width": width, "height": 900})
    page.evaluate(UNFOLD)
    assert violations(page) == []
    page.evaluate("document.querySelector('h1').style.color = '#8883'")
    assert any("color-contrast" in found for found in violations(page, "h1"))
