"""How each page of a run opens, and what it is on paper, in headless Chromium.

    python -m benchmarks.pages reports/latest

For the front page and each case's page: its size; the time from the first request to two frames
after the load event; the sheets of A4 that it prints on; and whether something is cut off there.
The slowest, the longest, and whatever exceeds a goal are printed; the exit status is then 1. Time
is the least of three, as a busy machine only adds to it.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FRONT_SECONDS, CASE_SECONDS = 0.5, 0.7
FRONT_BYTES = 300_000
SHEETS = 6
PAPER = {"width": 711, "height": 1040}  # A4 less its margins, in CSS pixels
SHOWN = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
CUT = """() => [...document.querySelectorAll(".formula, .figures, .passes > li, .chart")]
    .filter(e => e.offsetParent && e.scrollWidth > e.clientWidth + 1)
    .map(e => `${e.className || e.tagName}: ${e.scrollWidth} of ${e.clientWidth} px`)"""


@dataclass(frozen=True)
class Measured:
    """A page: its name, seconds to open, bytes, sheets of paper, and what is cut off there."""

    name: str
    seconds: float
    bytes: int
    sheets: int
    cut: tuple[str, ...]


def sheets(page: Any) -> int:
    """How many sheets of A4 an open page prints on."""
    pdf: bytes = page.pdf(format="A4", prefer_css_page_size=True, print_background=True)
    return len(re.findall(rb"/Type\s*/Page\b", pdf))


def cut_off(page: Any) -> tuple[str, ...]:
    """What of an open page is wider on paper than its place."""
    page.set_viewport_size(PAPER)
    page.emulate_media(media="print")
    return tuple(page.evaluate(CUT))


def measure(browser: Any, path: Path, times: int = 3) -> Measured:
    """Open a page some times, print it once."""
    seconds = []
    for _ in range(times):
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        began = time.perf_counter()
        page.goto(path.resolve().as_uri())
        page.evaluate(SHOWN)
        seconds.append(time.perf_counter() - began)
        if len(seconds) < times:
            page.close()
    found = Measured(path.stem, min(seconds), path.stat().st_size, sheets(page), cut_off(page))
    page.close()
    return found


def main() -> int:
    """Measure, print, and return the exit status."""
    from playwright.sync_api import sync_playwright

    from tests.browser.conftest import FLAGS, find_chromium

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path, help="a run's folder")
    folder: Path = parser.parse_args().run
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=find_chromium(), args=FLAGS)
        front = measure(browser, folder / "index.html")
        cases = [measure(browser, path) for path in sorted(folder.glob("cases/*.html"))]
        browser.close()
    print(f"front: {front.seconds:.2f} s, {front.bytes / 1e3:.0f} kB")
    slowest = sorted(cases, key=lambda case: -case.seconds)[:5]
    longest = sorted(cases, key=lambda case: -case.sheets)[:5]
    print(f"{len(cases)} cases, slowest:", *(f"{c.name} {c.seconds:.2f} s" for c in slowest))
    print("most sheets:", *(f"{c.name} {c.sheets}" for c in longest))
    bad = [c for c in cases if c.seconds > CASE_SECONDS or c.sheets > SHEETS or c.cut]
    for each in bad:
        print(f"{each.name}: {each.seconds:.2f} s, {each.sheets} sheets {' · '.join(each.cut)}")
    return int(bool(bad) or front.seconds > FRONT_SECONDS or front.bytes > FRONT_BYTES)


if __name__ == "__main__":
    sys.exit(main())
