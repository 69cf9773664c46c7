"""Real pages in a real browser: headless Chromium, driven by Playwright. No OpenGL is needed.

The browser is the system's own: `chromium` on the PATH, or what SHADERLAB_CHROMIUM names. Where
there is none, these tests are skipped and say so.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from shaderlab.report.html import write
from tests.browser import samples

NAMES = ("chromium", "chromium-browser", "google-chrome-stable", "google-chrome", "chrome")
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
DESKTOP = {"width": 1280, "height": 900}


def find_chromium() -> str | None:
    named = os.environ.get("SHADERLAB_CHROMIUM")
    return named or next(filter(None, map(shutil.which, NAMES)), None)


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """A running browser, whose first context is shared by all pages that need none of their own."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: pip install playwright"
    )
    path = find_chromium()
    if path is None:
        pytest.skip("there is no Chromium here: apt-get install chromium, or SHADERLAB_CHROMIUM=…")
    with playwright.sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=path, args=FLAGS)
        running.new_context(viewport=DESKTOP)
        yield running
        running.close()


@pytest.fixture(scope="session")
def lamp(tmp_path_factory: pytest.TempPathFactory) -> samples.Sample:
    """A run with a case of two variants, one of which fails, and its page."""
    return samples.lamp(tmp_path_factory.mktemp("lamp"))


@pytest.fixture
def visit(browser: Any) -> Iterator[Callable[..., Any]]:
    """Call it with a page's path to open it; whatever the page complains of fails the test."""
    with visiting(browser) as go:
        yield go


@contextmanager
def visiting(browser: Any) -> Iterator[Callable[..., Any]]:
    """Opens pages, and closes them in the end; what they complain of is an error then.

    What a page can't be told by itself takes a context of its own, and so another process to begin.
    """
    opened: list[Any] = []
    complaints: list[str] = []

    def go(
        path: Path, anchor: str = "", *, viewport: Any = DESKTOP, color_scheme: str | None = None,
        **options: Any,
    ) -> Any:  # fmt: skip
        context = browser.contexts[0]
        if options:
            context = browser.new_context(viewport=viewport, **options)
            opened.append(context)
        page = context.new_page()
        opened.append(page)
        if viewport is not DESKTOP:
            page.set_viewport_size(viewport)
        page.emulate_media(color_scheme=color_scheme)
        page.set_default_timeout(60_000)  # a machine may be busy
        page.on("pageerror", lambda error: complaints.append(f"error: {error}"))
        page.on("dialog", lambda dialog: complaints.append(f"dialog: {dialog.message}"))
        page.on("console", lambda said: _note_complaint(f"{said.type}: {said.text}", complaints))
        page.on("request", lambda request: _note_request(request.url, complaints))
        page.goto(path.resolve().as_uri() + anchor)
        return page

    yield go
    for one in reversed(opened):
        if one in browser.contexts[0].pages:
            one.evaluate("localStorage.clear()")
        one.close()
    assert complaints == []


def _note_complaint(said: str, complaints: list[str]) -> None:
    # That pixels are read takes its time, as a browser says, is known.
    if "ReadPixels" not in said and "willReadFrequently" not in said:
        complaints.append(said)


def _note_request(url: str, complaints: list[str]) -> None:
    # The page itself, and the pictures in it, are all that may be asked for.
    if not url.startswith(("file:", "data:image/", "blob:")):
        complaints.append(f"request: {url}")


@pytest.fixture(scope="session")
def hostile_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a run in which every string is an attack."""
    from tests.unit.test_report_samples import hostile

    return write(hostile(), tmp_path_factory.mktemp("hostile"))
