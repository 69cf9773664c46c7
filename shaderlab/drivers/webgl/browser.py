"""A headless browser with one page, in which a player of WebGL2's calls runs."""

from __future__ import annotations

import asyncio
import os
import resource
import shutil
import subprocess
import threading
from collections.abc import Coroutine, Iterator
from contextlib import contextmanager, suppress
from importlib.resources import files
from typing import Any, TypeVar

from shaderlab.errors import DeviceLostError, DriverError

try:
    from playwright.async_api import Error, async_playwright
except ImportError as error:
    raise DriverError(
        f"no package that drives a browser ({error})", remedy="pip install 'shaderlab[webgl]'"
    ) from error

PATIENCE = 60.0
"""Seconds that the browser has for an answer."""
_NAMES = ("chromium", "chromium-browser", "google-chrome-stable", "google-chrome", "chrome")
_FLAGS = (
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
    "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip
_INSTALL = (
    "SHADERLAB_CHROMIUM=… · Debian: apt-get install chromium · Fedora: dnf install chromium · "
    "Arch: pacman -S chromium"
)
Result = TypeVar("Result")


class Browser:
    """A running browser.

    Raises:
        DriverError: there is none, or it has no WebGL2.
    """

    def __init__(self) -> None:
        self._path = _chromium()
        # In a thread of its own: the caller may run an event loop itself, as a notebook does.
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        try:
            with _memory_unlimited():
                self._wait(self._start())
        except BaseException:
            self.close()
            raise

    _playwright: Any = None
    _browser: Any = None
    _guard: subprocess.Popen[bytes] | None = None

    def play(self, text: str) -> str:
        """What the player answers.

        Raises:
            DeviceLostError: the browser is gone, or gives no answer in time.
            DriverError: a call can't be made.
        """
        return str(self._wait(self._page.evaluate("text => player.play(text)", text)))

    def close(self) -> None:
        """End the browser, whatever state it is in."""
        with suppress(Exception):
            if self._browser is not None:
                self._run(self._browser.close(), 5.0)
        with suppress(Exception):
            if self._playwright is not None:
                self._run(self._playwright.stop(), 5.0)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
        if self._guard is not None:
            assert self._guard.stdin is not None
            self._guard.stdin.close()
            self._guard.wait()

    async def _start(self) -> None:
        self._playwright = await async_playwright().start()
        self._browser = await self._playwright.chromium.launch(
            executable_path=self._path, args=_FLAGS
        )
        session = await self._browser.new_browser_cdp_session()
        running = (await session.send("SystemInfo.getProcessInfo"))["processInfo"]
        self._guard = _guard(next(one["id"] for one in running if one["type"] == "browser"))
        self._page = await self._browser.new_page()
        player = files(__package__).joinpath("player.js").read_text(encoding="utf-8")
        await self._page.evaluate(player)
        if not await self._page.evaluate("player !== null && 'fromBase64' in Uint8Array"):
            raise DriverError(
                f"{self._path} has no WebGL2, or is older than version 140", remedy=_INSTALL
            )

    def _run(self, work: Coroutine[Any, Any, Result], seconds: float) -> Result:
        return asyncio.run_coroutine_threadsafe(
            asyncio.wait_for(work, seconds), self._loop
        ).result()

    def _wait(self, work: Coroutine[Any, Any, Result]) -> Result:
        try:
            return self._run(work, PATIENCE)
        except TimeoutError:
            raise DeviceLostError(f"the browser gave no answer in {PATIENCE:g} s") from None
        except Error as error:
            if self._browser is not None and self._browser.is_connected():
                if "crashed" not in error.message and "closed" not in error.message:
                    raise DriverError(
                        f"the browser: {error.message.partition(chr(10))[0]}"
                    ) from error
            elif self._browser is None:
                raise DriverError(
                    f"{self._path} does not start: {error.message.partition(chr(10))[0]}"
                ) from error
            raise DeviceLostError("the browser is gone") from error


def _guard(browser: int) -> subprocess.Popen[bytes]:
    """A process that kills a browser and its processes, which are a group of their own, when this
    one lets go of it or is gone. A shader that does not end would outlive both."""
    command = ("sh", "-c", 'read -r _; kill -9 "-$0" 2>/dev/null', str(browser))
    return subprocess.Popen(command, stdin=subprocess.PIPE, start_new_session=True)


def _chromium() -> str:
    """The browser's command. Raises DriverError if there is none."""
    found = os.environ.get("SHADERLAB_CHROMIUM") or next(
        filter(None, map(shutil.which, _NAMES)), None
    )
    if found is None:
        raise DriverError("no Chromium, whose WebGL2 this is", remedy=_INSTALL)
    return found


@contextmanager
def _memory_unlimited() -> Iterator[None]:
    """Processes that are started meanwhile may reserve what they like, which is more than all
    memory; a worker's own limit is a soft one."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
